"""What ends a program beside the configuration: certificates, the link, being asked to stop. The text of an error names its fix.

Raised by `wire.certificates` and `wire.link`, which load cryptography and Zenoh; here, so that whoever only tells them
(`wire.process`) loads neither: a program without a link, as that of the wheel's forces, starts sooner.
"""


class CertificateError(Exception):
    """Certificates are missing or cannot be used."""


class LinkError(Exception):
    """The link cannot be opened."""


class Stopped(Exception):
    """The program was asked to stop while it waited for its hub."""
