"""`tower certificates`: make the local authority and a certificate for each role, and say where they are."""

from pathlib import Path

from rich.console import Console

from wire import certificates
from wire.configuration import read_sections
from wire.settings import WireSettings


def run(config: Path, folder: str, renew: bool) -> int:
    """Make what is missing (or everything, with `renew`). Raises CertificateError when the folder cannot be written."""
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    place = certificates.folder_of(folder or wire.link.certificates)
    made = renew or certificates.ensure(place)
    if renew:
        certificates.make(place)
    until = certificates.earliest_end(place)
    Console().print(f"{'made' if made else 'found'} certificates in {place}, valid until {until:%Y-%m-%d}", highlight=False)
    return 0
