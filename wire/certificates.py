"""The folder of certificates: a local authority and one certificate per role, or what was imported from another machine.

`tower certificates` makes them, by itself when there are none. The private key of the authority stays beside them where they
were made: whoever holds that folder may join, and may issue more. Keys are readable by their owner only. An imported folder
(`wire.bundle`) holds no such key and is never changed here. A key that others can read is refused (`wire.private_file`).
"""

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path
from tempfile import TemporaryDirectory

from cryptography import x509

from wire.authority import (
    VALID,
    Pair,
    common_name,
    hosts_of,
    is_issued_by,
    issue,
    life_of,
    new_authority,
    read_certificate,
    read_pair,
)
from wire.failures import CertificateError as CertificateError
from wire.messages.base import encode
from wire.private_file import refusal
from wire.revocation import NOTHING, Revocations, read_revocations, with_revoked
from wire.topics import CAR, Role, certificate_names, role_of

AUTHORITY = "authority"
REVOKED = "revoked.json"
RENEW_BEFORE = timedelta(days=1)  # ours: of what lives long; of what lives shorter than four days a quarter
MAKE = "make them with: tower certificates"
IMPORT = "import a bundle with: tower certificates import FILE"


def default_folder() -> Path:
    """The user's own certificates (XDG data directory)."""
    base = os.environ.get("XDG_DATA_HOME") or str(Path.home() / ".local" / "share")
    return Path(base) / "remote-operation-tower" / "certificates"


def folder_of(setting: str) -> Path:
    return Path(setting).expanduser() if setting else default_folder()


def missing(folder: Path) -> tuple[str, ...]:
    """File names that a complete folder of an authority would hold and this one does not."""
    names = [f"{name}.{end}" for name in (AUTHORITY, *Role) for end in ("pem", "key")]
    return tuple(name for name in names if not (folder / name).is_file())


def is_imported(folder: Path) -> bool:
    """Whether the folder came from another machine: it knows an authority and does not hold its key."""
    return (folder / f"{AUTHORITY}.pem").is_file() and not (folder / f"{AUTHORITY}.key").is_file()


def earliest_end(folder: Path) -> datetime:
    """When the first of the certificates that are there expires. Raises CertificateError for a damaged file."""
    files = [folder / f"{name}.pem" for name in (AUTHORITY, *Role)]
    return min((_load(file).not_valid_after_utc for file in files if file.is_file()), default=datetime.now(UTC))


def check(folder: Path, role: Role, vehicle_id: str) -> None:
    """Raises CertificateError unless this role can join with what is in the folder, now and for this vehicle."""
    fix = IMPORT if is_imported(folder) else MAKE
    for name in (f"{AUTHORITY}.pem", f"{role}.pem", f"{role}.key"):
        if not (folder / name).is_file():
            raise CertificateError(f"{folder / name}: no such certificate; {fix}")
    _refuse_exposed(folder, role, AUTHORITY)
    authority, own = _load(folder / f"{AUTHORITY}.pem"), _load(folder / f"{role}.pem")
    now = datetime.now(UTC)
    names = certificate_names(role, vehicle_id)
    name = common_name(own).partition("~")[0]
    fits = name in names or (role not in CAR and role_of(name) is role)  # a person's own
    problems = (
        (not is_issued_by(own, authority), "was issued by another authority than authority.pem beside it"),
        (now > own.not_valid_after_utc, f"expired on {own.not_valid_after_utc:%Y-%m-%d}"),
        (
            now > authority.not_valid_after_utc,
            f"is worth nothing: its authority expired on {authority.not_valid_after_utc:%Y-%m-%d}",
        ),
        (now < own.not_valid_before_utc, f"is valid from {own.not_valid_before_utc:%Y-%m-%d} on: is this machine's clock right?"),
        (revocations_of(folder).is_revoked(common_name(own)), "was revoked"),
        (not fits, f"was issued for {common_name(own)}, not for {names[-1]}: see [wire.link] vehicle_id"),
    )
    for wrong, words in problems:
        if wrong:
            raise CertificateError(f"{folder / role}.pem {words}; {fix if fix is IMPORT else fix + ' --renew'}")


def unnamed(folder: Path, role: Role, hosts: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the hosts for which the role's certificate is not valid: whoever dials them would refuse it."""
    named = hosts_of(_load(folder / f"{role}.pem"))
    return tuple(host for host in hosts if host.strip("[]") not in named)


def ensure(folder: Path, hosts: tuple[str, ...] = (), valid: timedelta | None = None) -> bool:
    """Make what is needed if the folder is empty, incomplete or close to expiry. True when something was made.

    hosts  names and addresses under which this machine is dialled from another, besides those it has already
    valid  for how long, if it is to be another time than before
    What was imported stays as it is. The authority stays the same as long as it lasts.
    """
    if is_imported(folder):
        return False
    known = _hosts(folder)
    wanted = tuple(dict.fromkeys((*known, *hosts)))
    before = _life(folder)
    life = valid or before
    lasts = not missing(folder) and earliest_end(folder) > datetime.now(UTC) + min(RENEW_BEFORE, life / 4)
    if lasts and wanted == known and abs(life - before) < timedelta(seconds=2):
        return False
    authority = _lasting_authority(folder, life)
    _fill(folder, authority or new_authority(), wanted, life)
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


def make(folder: Path, hosts: tuple[str, ...] = (), valid: timedelta = VALID) -> None:
    """A new authority and a certificate for every role: whatever the old one issued is worth nothing to these.

    Raises CertificateError when the folder cannot be written or was imported.
    """
    if is_imported(folder):
        raise CertificateError(f"{folder}: imported, nothing can be issued here; renew where the authority is, and {IMPORT}")
    _fill(folder, new_authority(), tuple(dict.fromkeys((*_hosts(folder), *hosts))), valid)


def revocations_of(folder: Path) -> Revocations:
    """What is revoked, as far as it was told here. Raises CertificateError when the list is not of the folder's authority."""
    file = folder / REVOKED
    try:
        return read_revocations(file.read_bytes(), _load(folder / f"{AUTHORITY}.pem"))
    except FileNotFoundError:
        return NOTHING
    except (OSError, ValueError) as error:
        raise CertificateError(f"{file}: {error}; export the list again where the authority is, and import it") from None


def revoke(folder: Path, name: str) -> Revocations:
    """Everything that was issued under this name is worth nothing where the list comes to. Raises CertificateError.

    name  with the car's id or the person's: video.car-1, tower-hub.ann. Here the name's next certificate is made at once.
    """
    authority, known = authority_of(folder), revocations_of(folder)
    name = name.partition("~")[0]
    if role_of(name) is None:
        raise CertificateError(f"{name}: no name of a certificate; they begin with one of: {', '.join(Role)}")
    revoked = with_revoked(known, name, authority)
    write_revocations(folder, revoked)
    own = folder / f"{name}.pem"
    if own.is_file() and revoked.is_revoked(common_name(_load(own))):
        issued = issue(revoked.current(name), _hosts(folder), authority, life_of(_load(own)))
        write_pem(folder, name, issued.key_pem, issued.certificate_pem)
    return revoked


def write_revocations(folder: Path, revoked: Revocations) -> None:
    """Whole or not at all: a running gateway may look at any moment. Raises CertificateError."""
    new = folder / f"{REVOKED}.new"
    try:
        new.write_bytes(encode(revoked))
        new.replace(folder / REVOKED)
    except OSError as error:
        raise _unwritable(folder, error) from None


def take_revocations(folder: Path, revoked: Revocations) -> bool:
    """A list from elsewhere, unless this folder knows a newer one. Whether it was taken."""
    if revoked.number <= revocations_of(folder).number:
        return False
    write_revocations(folder, revoked)
    return True


def authority_of(folder: Path) -> Pair:
    """Raises CertificateError when this folder holds no authority."""
    if is_imported(folder):
        raise CertificateError(f"{folder}: imported, nothing can be issued here; export on the machine that holds the authority")
    _refuse_exposed(folder, AUTHORITY)
    try:
        return read_pair((folder / f"{AUTHORITY}.key").read_bytes(), (folder / f"{AUTHORITY}.pem").read_bytes())
    except FileNotFoundError:
        raise CertificateError(f"{folder}: no certificates there; {MAKE}") from None
    except (ValueError, OSError) as error:
        raise CertificateError(f"{folder / AUTHORITY}.key: damaged or unreadable: {error}; {MAKE} --renew") from None


def pair_of(folder: Path, role: Role) -> Pair:
    """A role's own key and certificate. Raises CertificateError when they cannot be used."""
    _refuse_exposed(folder, role)
    try:
        return read_pair((folder / f"{role}.key").read_bytes(), (folder / f"{role}.pem").read_bytes())
    except (ValueError, OSError) as error:
        fix = IMPORT if is_imported(folder) else MAKE
        raise CertificateError(f"{folder / role}.key: damaged or unreadable: {error}; {fix}") from None


def write_pem(folder: Path, name: str, key_pem: bytes | None, certificate_pem: bytes) -> None:
    """NAME.pem, and NAME.key for its owner's eyes only. Raises OSError."""
    if key_pem is not None:
        key_file = folder / f"{name}.key"
        key_file.touch(mode=0o600)
        key_file.chmod(0o600)
        key_file.write_bytes(key_pem)
    (folder / f"{name}.pem").write_bytes(certificate_pem)


def _refuse_exposed(folder: Path, *names: str) -> None:
    """Raises CertificateError when one of these keys is there and not its owner's alone."""
    for file in (folder / f"{name}.key" for name in names):
        problem = refusal(file) if file.is_file() else ""
        if problem:
            raise CertificateError(problem)


def _load(file: Path) -> x509.Certificate:
    try:
        return read_certificate(file.read_bytes())
    except (ValueError, OSError):
        raise CertificateError(f"{file}: damaged or unreadable; make new ones with: tower certificates --renew") from None


def _hosts(folder: Path) -> tuple[str, ...]:
    """What the certificates that are there are valid for; () when there are none, or none that can be read."""
    try:
        return hosts_of(_load(folder / f"{Role.TOWER_HUB}.pem"))
    except CertificateError:
        return ()


def _life(folder: Path) -> timedelta:
    """For how long what is there was made; the usual time when there is none."""
    try:
        return life_of(_load(folder / f"{Role.TOWER_HUB}.pem"))
    except CertificateError:
        return VALID


def _lasting_authority(folder: Path, valid: timedelta) -> Pair | None:
    """The authority of the folder while it outlives what it would issue; None when a new one is due."""
    try:
        authority = authority_of(folder)
    except CertificateError:
        return None
    lasts = authority.certificate.not_valid_after_utc > datetime.now(UTC) + valid
    return authority if lasts else None


def _fill(folder: Path, authority: Pair, hosts: tuple[str, ...], valid: timedelta) -> None:
    revoked = _known_revocations(folder, authority)
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        write_pem(folder, AUTHORITY, authority.key_pem, authority.certificate_pem)
        if revoked == NOTHING:
            (folder / REVOKED).unlink(missing_ok=True)  # another authority's: all that one issued is worth nothing
        for role in Role:
            issued = issue(revoked.current(role), hosts, authority, valid)
            write_pem(folder, role, issued.key_pem, issued.certificate_pem)
    except OSError as error:
        raise _unwritable(folder, error) from None
    except ValueError as error:
        raise CertificateError(f"--host {' '.join(hosts)}: neither names nor addresses: {error}") from None


def _known_revocations(folder: Path, authority: Pair) -> Revocations:
    """Those of this authority; another's list says nothing about what it issues."""
    try:
        return read_revocations((folder / REVOKED).read_bytes(), authority.certificate)
    except (OSError, ValueError):
        return NOTHING


def _unwritable(folder: Path, error: OSError) -> CertificateError:
    return CertificateError(
        f"{folder}: cannot write certificates: {error.strerror}; choose another folder with [wire.link] certificates"
    )
