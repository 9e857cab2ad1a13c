"""`tower certificates`: make the local authority and its certificates, hand them to another machine, take them there, revoke."""

from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path

from rich.console import Console

from wire import bundle, certificates
from wire.authority import VALID
from wire.configuration import read_sections
from wire.revocation import Revocations
from wire.settings import WireSettings


def _place(config: Path, folder: str) -> Path:
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    return certificates.folder_of(folder or wire.link.certificates)


def make(config: Path, folder: str, renew: bool, hosts: tuple[str, ...], valid: timedelta | None) -> int:
    """Make what is missing (or everything, with `renew`). Raises CertificateError when the folder cannot be written.

    hosts  names and addresses under which this machine is dialled from another
    valid  for how long; None: as long as those that are there
    """
    place = _place(config, folder)
    if hosts and certificates.is_imported(place):
        raise certificates.CertificateError(
            f"{place}: imported, nothing can be issued here; export with --host where the authority is"
        )
    if renew:
        certificates.make(place, hosts, valid or VALID)
    made = certificates.ensure(place, hosts, valid) or renew
    until = certificates.earliest_end(place)
    _say(f"{_word(made, place)} certificates in {place}, valid until {until:%Y-%m-%d %H:%M} UTC")
    return 0


def _word(made: bool, place: Path) -> str:
    return "made" if made else "imported" if certificates.is_imported(place) else "found"


@dataclass(frozen=True, slots=True)
class Wanted:
    """For whom a bundle is: see `wire.bundle.export`."""

    vehicle_id: str = ""
    hosts: tuple[str, ...] = ()
    with_simulation: bool = False
    supervisor: bool = False
    person: str = ""
    valid: timedelta = VALID


def export(config: Path, folder: str, file: Path, wanted: Wanted) -> int:
    """A bundle for another machine. Raises CertificateError."""
    place = _place(config, folder)
    certificates.ensure(place)
    made = bundle.export(
        place, wanted.vehicle_id, wanted.hosts, wanted.with_simulation, wanted.supervisor, wanted.person, wanted.valid
    )
    bundle.write(made, file)
    _say(f"{file}: certificates for {_whose(wanted.vehicle_id)}, valid until {bundle.ends(made):%Y-%m-%d}")
    _say(f"It may be dialled as {', '.join(bundle.hosts(made))}.")
    _say(f"It holds private keys: carry it over safely, run there: tower certificates import {file.name} - and delete it.")
    return 0


def take(config: Path, folder: str, file: Path, replace: bool) -> int:
    """A bundle's certificates into the folder, or a list of what is revoked. Raises CertificateError."""
    place = _place(config, folder)
    if bundle.is_list(file):
        taken_list = certificates.take_revocations(place, bundle.read_list(file, place))
        _say(f"{'took' if taken_list else 'knew already'}: {_revoked(certificates.revocations_of(place))}")
        return 0
    taken = bundle.read(file)
    bundle.install(taken, place, replace)
    _say(f"imported certificates for {_whose(taken.vehicle_id)} into {place}, valid until {bundle.ends(taken):%Y-%m-%d}")
    return 0


def revoke(config: Path, folder: str, name: str) -> int:
    """Everything issued under this name is worth nothing from now on. Raises CertificateError."""
    place = _place(config, folder)
    known = certificates.revoke(place, name)
    _say(f"revoked: {name}; the next certificate of that name is {known.current(name)}")
    _say("Bring the list to the other machines: tower certificates revoked --export FILE, and import it there.")
    _say("A car's gateway takes the lease from its holder within two seconds; hubs refuse the certificate from their next start.")
    return 0


def show_revoked(config: Path, folder: str, file: Path | None) -> int:
    """What is revoked; into a file for other machines. Raises CertificateError."""
    known = certificates.revocations_of(_place(config, folder))
    _say(_revoked(known))
    if file is not None:
        bundle.write_list(known, file)
    return 0


def _revoked(known: Revocations) -> str:
    names = [f"{name} (now {known.current(name)})" for name in sorted(known.generations)]
    return f"list {known.number}, revoked: {', '.join(names)}" if names else "nothing is revoked"


def _say(text: str) -> None:
    Console(highlight=False, soft_wrap=True).print(text)


def _whose(vehicle_id: str) -> str:
    return f"vehicle {vehicle_id}" if vehicle_id else "a tower"
