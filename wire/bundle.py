"""Certificates for another machine, as one file: what that site needs and no more, never the authority's key.

Issued for the purpose: a car's certificates carry its vehicle id (`wire.topics.certificate_names`), so that one car cannot
speak for another. The file holds private keys: whoever has it can join as that site.
"""

from datetime import UTC, datetime, timedelta
from hashlib import sha256
from pathlib import Path
from typing import Annotated

import msgspec
from msgspec import Meta

from wire.authority import VALID, common_name, hosts_of, is_issued_by, issue, read_certificate, read_pair
from wire.certificates import (
    AUTHORITY,
    REVOKED,
    CertificateError,
    authority_of,
    is_imported,
    revocations_of,
    take_revocations,
    write_pem,
)
from wire.messages.base import UNDECODABLE, Message, decoder, encode
from wire.private_file import refusal
from wire.revocation import NOTHING, Revocations, check_revocations, read_revocations
from wire.topics import CAR, TOWER, Role, certificate_names, owner_of

_SIMULATION = frozenset({Role.SIMULATE, Role.TOWER_SCRIPT})  # a real site needs neither
_SUPERVISION = frozenset({Role.TOWER_SUPERVISOR})  # only where the supervisor himself sits
_PERSONAL = frozenset({Role.TOWER_HUB, Role.TOWER_SUPERVISOR})
_AGAIN = "export it again, and carry it over whole"
_BUNDLE_MAX_BYTES = 1_000_000  # ours: a car's is 12 kB

Pem = Annotated[str, Meta(max_length=10_000)]


class Issued(Message):
    key: Pem
    certificate: Pem


class Bundle(Message):
    """The file, as JSON."""

    vehicle_id: Annotated[str, Meta(pattern=r"^[a-z0-9-]{0,40}$")]  # "" for a tower
    authority: Pem  # its certificate
    roles: dict[Role, Issued]
    revoked: Revocations = NOTHING  # what the authority has revoked until now
    digest: str  # SHA-256 of the rest, in hexadecimal: a file that was cut or changed on the way is noticed


def export(
    folder: Path,
    vehicle_id: str,
    hosts: tuple[str, ...],
    with_simulation: bool,
    supervisor: bool = False,
    person: str = "",
    valid: timedelta = VALID,
) -> Bundle:
    """New certificates for another machine. Raises CertificateError when this folder holds no authority.

    vehicle_id       of the car they are for; "" for a tower
    hosts            names and addresses under which the other site dials that machine
    with_simulation  also for the simulated world, or for the scripted operator
    supervisor       for a tower: also the supervisor's own
    person           for a tower: whose own the certificates of cockpit and supervisor are; "": of whoever sits there
    """
    authority, revoked = authority_of(folder), revocations_of(folder)
    wanted = (CAR if vehicle_id else TOWER) - (frozenset() if with_simulation else _SIMULATION)
    wanted -= frozenset() if supervisor else _SUPERVISION
    try:
        names = {role: revoked.current(_name(role, vehicle_id, person)) for role in sorted(wanted)}
        pairs = {role: issue(name, hosts, authority, valid) for role, name in names.items()}
    except ValueError as error:
        raise CertificateError(f"--host {' '.join(hosts)}: neither names nor addresses: {error}") from None
    roles = {role: Issued(key=pair.key_pem.decode(), certificate=pair.certificate_pem.decode()) for role, pair in pairs.items()}
    bare = Bundle(vehicle_id=vehicle_id, authority=authority.certificate_pem.decode(), roles=roles, revoked=revoked, digest="")
    return msgspec.structs.replace(bare, digest=_digest(bare))


def write(bundle: Bundle, file: Path) -> None:
    """For its owner's eyes only. Raises CertificateError when it cannot be written."""
    try:
        file.touch(mode=0o600)
        file.chmod(0o600)
        file.write_bytes(msgspec.json.format(encode(bundle), indent=1))
    except OSError as error:
        raise CertificateError(f"{file}: cannot be written: {error.strerror}; name another file") from None


def read(file: Path) -> Bundle:
    """A bundle that nobody else could read, whole, of one authority, and valid now. Raises CertificateError."""
    try:
        problem = refusal(file)
        if problem:
            raise CertificateError(problem)
        with file.open("rb") as stream:
            data = stream.read(_BUNDLE_MAX_BYTES)
        bundle = decoder(Bundle).decode(data)
    except FileNotFoundError:
        raise CertificateError(f"{file}: no such file; make it with: tower certificates export {file.name}") from None
    except OSError as error:
        raise CertificateError(f"{file}: cannot be read: {error.strerror}") from None
    except UNDECODABLE:
        raise CertificateError(f"{file}: damaged, or no bundle of certificates; {_AGAIN}") from None
    if bundle.digest != _digest(bundle):
        raise CertificateError(f"{file}: damaged or changed on the way; {_AGAIN}")
    _check(bundle, file)
    return bundle


def is_list(file: Path) -> bool:
    """Whether the file is a list of revoked certificates rather than a bundle."""
    try:
        return "generations" in msgspec.json.decode(file.read_bytes()[:_BUNDLE_MAX_BYTES], type=dict)
    except (OSError, msgspec.DecodeError, *UNDECODABLE):
        return False


def read_list(file: Path, folder: Path) -> Revocations:
    """A list of the folder's own authority. Raises CertificateError."""
    try:
        return read_revocations(file.read_bytes(), read_certificate((folder / f"{AUTHORITY}.pem").read_bytes()))
    except FileNotFoundError:
        raise CertificateError(f"{folder}: no certificates there; import a bundle first") from None
    except (OSError, ValueError) as error:
        raise CertificateError(f"{file}: {error}") from None


def write_list(revoked: Revocations, file: Path) -> None:
    """No secret: anybody may read what is revoked. Raises CertificateError when it cannot be written."""
    try:
        file.write_bytes(encode(revoked))
    except OSError as error:
        raise CertificateError(f"{file}: cannot be written: {error.strerror}; name another file") from None


def install(bundle: Bundle, folder: Path, replace: bool) -> None:
    """Write the bundle's certificates into a folder. Raises CertificateError.

    replace  also when the folder has certificates of another authority, or an authority of its own: they are removed
    """
    before = folder / f"{AUTHORITY}.pem"
    foreign = before.is_file() and (before.read_bytes() != bundle.authority.encode() or not is_imported(folder))
    if foreign and not replace:
        raise CertificateError(
            f"{folder}: holds certificates of another authority or the authority itself; "
            "add --replace to remove them, or choose another folder with --folder"
        )
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        if foreign:
            _clear(folder)
        for role, issued in bundle.roles.items():
            write_pem(folder, role, issued.key.encode(), issued.certificate.encode())
        write_pem(folder, AUTHORITY, None, bundle.authority.encode())
        take_revocations(folder, bundle.revoked)
    except OSError as error:
        raise CertificateError(f"{folder}: cannot be written: {error.strerror}; choose another folder with --folder") from None


def hosts(bundle: Bundle) -> tuple[str, ...]:
    """Under which names and addresses this site may be dialled."""
    hub = Role.VEHICLE_HUB if bundle.vehicle_id else Role.TOWER_HUB
    return hosts_of(read_certificate(bundle.roles[hub].certificate.encode()))


def ends(bundle: Bundle) -> datetime:
    """When the first of its certificates expires, the authority's among them."""
    texts = (bundle.authority, *(each.certificate for each in bundle.roles.values()))
    return min(read_certificate(text.encode()).not_valid_after_utc for text in texts)


def _name(role: Role, vehicle_id: str, person: str) -> str:
    """The common name of a role's certificate, without its generation."""
    return f"{role}.{person}" if person and role in _PERSONAL else certificate_names(role, vehicle_id)[-1]


def _digest(bundle: Bundle) -> str:
    return sha256(encode(msgspec.structs.replace(bundle, digest=""))).hexdigest()


def _check(bundle: Bundle, file: Path) -> None:
    """What no accident leaves behind: a bundle put together by hand."""
    hub = Role.VEHICLE_HUB if bundle.vehicle_id else Role.TOWER_HUB
    if hub not in bundle.roles:
        raise CertificateError(f"{file}: no certificate for {hub}; {_AGAIN}")
    try:
        authority = read_certificate(bundle.authority.encode())
        check_revocations(bundle.revoked, authority)
        pairs = {role: read_pair(each.key.encode(), each.certificate.encode()) for role, each in bundle.roles.items()}
    except ValueError as error:
        raise CertificateError(f"{file}: {error}; {_AGAIN}") from None
    for role, pair in pairs.items():
        if not is_issued_by(pair.certificate, authority):
            raise CertificateError(f"{file}: {role} was issued by another authority than the bundle's; {_AGAIN}")
        name = common_name(pair.certificate)
        if name.partition("~")[0] != _name(role, bundle.vehicle_id, owner_of(name) if role in _PERSONAL else ""):
            raise CertificateError(f"{file}: {role} was issued for {name}; {_AGAIN}")
    if ends(bundle) < datetime.now(UTC):
        raise CertificateError(f"{file}: expired on {ends(bundle):%Y-%m-%d}; {_AGAIN}")


def _clear(folder: Path) -> None:
    for name in (AUTHORITY, *Role):
        for end in ("pem", "key"):
            (folder / f"{name}.{end}").unlink(missing_ok=True)
    (folder / REVOKED).unlink(missing_ok=True)
