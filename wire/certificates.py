"""A local certificate authority and one certificate per role: what `tower certificates` makes, by itself when there are none.

The private key of the authority stays beside them: whoever holds the folder may join. Keys are readable by their owner only.
"""

import os
from datetime import UTC, datetime, timedelta
from ipaddress import ip_address
from pathlib import Path
from tempfile import TemporaryDirectory

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from wire.topics import Role

AUTHORITY = "authority"
VALID_DAYS = 90  # ours: long enough for a study, short enough to be renewed


class CertificateError(Exception):
    """Certificates are missing or cannot be used; the text names the fix."""


def default_folder() -> Path:
    """The user's own certificates (XDG data directory)."""
    base = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(base) / "remote-operation-tower" / "certificates"


def folder_of(setting: str) -> Path:
    return Path(setting).expanduser() if setting else default_folder()


def missing(folder: Path) -> tuple[str, ...]:
    """File names that a complete folder would hold and this one does not."""
    names = [f"{name}.{end}" for name in (AUTHORITY, *Role) for end in ("pem", "key")]
    return tuple(name for name in names if not (folder / name).is_file())


def earliest_end(folder: Path) -> datetime:
    """When the first of the certificates expires. Raises CertificateError for a damaged file."""
    return min(_load(folder / f"{name}.pem").not_valid_after_utc for name in (AUTHORITY, *Role))


def _load(file: Path) -> x509.Certificate:
    try:
        return x509.load_pem_x509_certificate(file.read_bytes())
    except (ValueError, OSError):
        raise CertificateError(f"{file}: damaged or unreadable; make new ones with: tower certificates --renew") from None


def ensure(folder: Path) -> bool:
    """Make what is needed if the folder is empty, incomplete or within a day of expiry. True when something was made."""
    if not missing(folder) and earliest_end(folder) > datetime.now(UTC) + timedelta(days=1):
        return False
    make(folder)
    return True


def make_if_none(folder: Path) -> bool:
    """Make everything in a folder that is empty or not there; leave any other as it is. True when something was made.

    Several programs may start at once: the folder appears whole, and the first one wins.
    """
    if folder.is_dir() and any(folder.iterdir()):
        return False
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with TemporaryDirectory(prefix=f".{folder.name}-", dir=folder.parent) as place:
            made = Path(place) / folder.name
            make(made)
            os.rename(made, folder)  # onto nothing or an empty folder; onto another's certificates it fails
    except OSError as error:
        if folder.is_dir() and not missing(folder):
            return False
        raise _unwritable(folder, error) from None
    return True


def make(folder: Path) -> None:
    """A new authority and a certificate for every role. Raises CertificateError when the folder cannot be written."""
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        authority_key, authority = _authority()
        _write(folder, AUTHORITY, authority_key, authority)
        for role in Role:
            _write(folder, role, *_issue(role, authority_key, authority))
    except OSError as error:
        raise _unwritable(folder, error) from None


def _unwritable(folder: Path, error: OSError) -> CertificateError:
    return CertificateError(
        f"{folder}: cannot write certificates: {error.strerror}; choose another folder with [wire.link] certificates"
    )


def _write(folder: Path, name: str, key: ec.EllipticCurvePrivateKey, certificate: x509.Certificate) -> None:
    key_file = folder / f"{name}.key"
    key_file.touch(mode=0o600)
    key_file.chmod(0o600)
    key_file.write_bytes(
        key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption())
    )
    (folder / f"{name}.pem").write_bytes(certificate.public_bytes(serialization.Encoding.PEM))


def _builder(subject: str, issuer: x509.Name, key: ec.EllipticCurvePrivateKey) -> x509.CertificateBuilder:
    now = datetime.now(UTC)
    return (
        x509.CertificateBuilder()
        .subject_name(_name(subject))
        .issuer_name(issuer)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - timedelta(hours=1))
        .not_valid_after(now + timedelta(days=VALID_DAYS))
    )


def _name(common_name: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, common_name)])


def _authority() -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
    key = ec.generate_private_key(ec.SECP256R1())
    name = _name("remote operation tower authority")
    certificate = (
        _builder("remote operation tower authority", name, key)
        .add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(_certificate_signing(), critical=True)
        .sign(key, hashes.SHA256())
    )
    return key, certificate


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


def _issue(
    role: Role, authority_key: ec.EllipticCurvePrivateKey, authority: x509.Certificate
) -> tuple[ec.EllipticCurvePrivateKey, x509.Certificate]:
    key = ec.generate_private_key(ec.SECP256R1())
    both = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]  # either side may dial
    hosts = x509.SubjectAlternativeName([x509.DNSName("localhost"), x509.IPAddress(ip_address("127.0.0.1"))])
    certificate = (
        _builder(role, authority.subject, key)
        .add_extension(hosts, critical=False)
        .add_extension(x509.ExtendedKeyUsage(both), critical=False)
        .add_extension(x509.AuthorityKeyIdentifier.from_issuer_public_key(authority_key.public_key()), critical=False)
        .sign(authority_key, hashes.SHA256())
    )
    return key, certificate
