"""X.509: a certificate authority of our own and what it issues (RFC 5280; ECDSA on P-256). No file is touched here."""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address

from cryptography import x509
from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

VALID = timedelta(days=90)  # ours: long enough for a study, short enough to be renewed
AUTHORITY_VALID = timedelta(days=730)  # ours: what was carried to another machine is renewed without meeting the others again
BACKDATED = timedelta(days=1)  # the other machine's clock may be behind
LOCAL_HOSTS = ("localhost", "127.0.0.1")
SIGNATURE = ec.ECDSA(hashes.SHA256())  # of everything that is signed with a certificate's key
_NAME = "remote operation tower authority"


@dataclass(frozen=True, slots=True)
class Pair:
    """A private key and its certificate."""

    key: ec.EllipticCurvePrivateKey
    certificate: x509.Certificate

    @property
    def key_pem(self) -> bytes:
        plain = serialization.NoEncryption()
        return self.key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, plain)

    @property
    def certificate_pem(self) -> bytes:
        return self.certificate.public_bytes(serialization.Encoding.PEM)


def read_certificate(pem: bytes) -> x509.Certificate:
    """Whatever stands in it: anybody can have written it. Raises ValueError when it, its names or its times cannot be read."""
    try:
        certificate = x509.load_pem_x509_certificate(pem)
        for part in ("subject", "issuer", "not_valid_before_utc", "not_valid_after_utc"):  # are read when they are asked for first
            getattr(certificate, part)
    except (x509.InvalidVersion, TypeError) as error:  # a strange version; a name that is no text
        raise ValueError(str(error)) from None
    return certificate


def read_pair(key_pem: bytes, certificate_pem: bytes) -> Pair:
    """Raises ValueError when either cannot be read or they do not belong together."""
    key = serialization.load_pem_private_key(key_pem, password=None)
    certificate = read_certificate(certificate_pem)
    if not isinstance(key, ec.EllipticCurvePrivateKey) or key.public_key() != certificate.public_key():
        raise ValueError("the key does not belong to the certificate")
    return Pair(key, certificate)


def new_authority() -> Pair:
    key = ec.generate_private_key(ec.SECP256R1())
    certificate = (
        _builder(_NAME, _name(_NAME), key, datetime.now(UTC) + AUTHORITY_VALID)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(_certificate_signing(), critical=True)
        .sign(key, hashes.SHA256())
    )
    return Pair(key, certificate)


def issue(common_name: str, hosts: tuple[str, ...], authority: Pair, valid: timedelta = VALID) -> Pair:
    """A certificate for whoever listens or dials under this name.

    hosts  names and addresses under which it is dialled, besides this machine itself
    valid  from now on; never longer than the authority itself
    """
    key = ec.generate_private_key(ec.SECP256R1())
    both = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]  # either side may dial
    ends = min(datetime.now(UTC) + valid, authority.certificate.not_valid_after_utc)
    names = x509.SubjectAlternativeName([_general_name(host) for host in dict.fromkeys((*LOCAL_HOSTS, *hosts))])
    certificate = (
        _builder(common_name, authority.certificate.subject, key, ends)
        .add_extension(names, critical=False)
        .add_extension(x509.ExtendedKeyUsage(both), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(authority.key.public_key()), critical=False)
        .sign(authority.key, hashes.SHA256())
    )
    return Pair(key, certificate)


def common_name(certificate: x509.Certificate) -> str:
    names = [str(each.value) for each in certificate.subject.get_attributes_for_oid(NameOID.COMMON_NAME)]
    return names[0] if names else ""


def hosts_of(certificate: x509.Certificate) -> tuple[str, ...]:
    """Names and addresses that the certificate is valid for."""
    try:
        names = certificate.extensions.get_extension_for_class(x509.SubjectAlternativeName).value
    except x509.ExtensionNotFound:
        return ()
    return tuple(str(each.value) for each in names)


def is_issued_by(certificate: x509.Certificate, authority: x509.Certificate) -> bool:
    """Whatever stands in the certificate: anybody can have written it."""
    try:
        certificate.verify_directly_issued_by(authority)
    except (InvalidSignature, UnsupportedAlgorithm, ValueError, TypeError):
        return False
    return True


def is_signed_by(certificate: x509.Certificate, signature_hex: str, signed: bytes) -> bool:
    """Whether these bytes were signed with the certificate's key. Whatever stands in either: anybody can have written them."""
    try:
        key = certificate.public_key()
        if not isinstance(key, ec.EllipticCurvePublicKey):
            return False
        key.verify(bytes.fromhex(signature_hex), signed, SIGNATURE)
    except (InvalidSignature, UnsupportedAlgorithm, ValueError):
        return False
    return True


def life_of(certificate: x509.Certificate) -> timedelta:
    """For how long it was issued."""
    return certificate.not_valid_after_utc - certificate.not_valid_before_utc - BACKDATED


def _builder(subject: str, issuer: x509.Name, key: ec.EllipticCurvePrivateKey, ends: datetime) -> x509.CertificateBuilder:
    return (
        x509.CertificateBuilder()
        .subject_name(_name(subject))
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(datetime.now(UTC) - BACKDATED)
        .not_valid_after(ends)
    )


def _name(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _general_name(host: str) -> x509.GeneralName:
    """Raises ValueError for what is neither a name nor an address."""
    bare = host.removeprefix("[").removesuffix("]")
    try:
        return x509.IPAddress(ip_address(bare))
    except ValueError:
        return x509.DNSName(host)


def _certificate_signing() -> x509.KeyUsage:
    return x509.KeyUsage(
        digital_signature=True,
        content_commitment=False,
        key_encipherment=False,
        data_encipherment=False,
        key_agreement=False,
        key_cert_sign=True,
        crl_sign=True,
        encipher_only=False,
        decipher_only=False,
    )
