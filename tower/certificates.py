"""`tower certificates`: make the local authority and its certificates, hand them to another machine, take them there."""

from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from wire import bundle, certificates
from wire.configuration import read_sections
from wire.settings import WireSettings


def _place(config: Path, folder: str) -> Path:
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    return certificates.folder_of(folder or wire.link.certificates)


def make(config: Path, folder: str, renew: bool, hosts: tuple[str, ...]) -> int:
    """Make what is missing (or everything, with `renew`). Raises CertificateError when the folder cannot be written.

    hosts  names and addresses under which this machine is dialled from another
    """
    place = _place(config, folder)
    if hosts and certificates.is_imported(place):
        raise certificates.CertificateError(
            f"{place}: imported, nothing can be issued here; export with --host where the authority is"
        )
    if renew:
        certificates.make(place, hosts)
    made = certificates.ensure(place, hosts) or renew
    until = certificates.earliest_end(place)
    Console(highlight=False, soft_wrap=True).print(f"{_word(made, place)} certificates in {place}, valid until {until:%Y-%m-%d}")
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


def export(config: Path, folder: str, file: Path, wanted: Wanted) -> int:
    """A bundle for another machine. Raises CertificateError."""
    place = _place(config, folder)
    certificates.ensure(place)
    made = bundle.export(place, wanted.vehicle_id, wanted.hosts, wanted.with_simulation, wanted.supervisor)
    bundle.write(made, file)
    say = Console(highlight=False, soft_wrap=True).print
    say(f"{file}: certificates for {_whose(wanted.vehicle_id)}, valid until {bundle.ends(made):%Y-%m-%d}")
    say(f"It may be dialled as {', '.join(bundle.hosts(made))}.")
    say(f"It holds private keys: carry it over safely, run there: tower certificates import {file.name} - and delete it.")
    return 0


def take(config: Path, folder: str, file: Path, replace: bool) -> int:
    """A bundle's certificates into the folder. Raises CertificateError."""
    place = _place(config, folder)
    taken = bundle.read(file)
    bundle.install(taken, place, replace)
    say = Console(highlight=False, soft_wrap=True).print
    say(f"imported certificates for {_whose(taken.vehicle_id)} into {place}, valid until {bundle.ends(taken):%Y-%m-%d}")
    return 0


def _whose(vehicle_id: str) -> str:
    return f"vehicle {vehicle_id}" if vehicle_id else "a tower"
