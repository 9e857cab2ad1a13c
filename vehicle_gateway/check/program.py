"""`vehicle-gateway check-config`: read the configuration as every program would, look up what it names, show the findings.

It starts nothing and opens neither link nor bus. The other rooms' sections are found through the packaging entry points
that each room declares: the car's side imports none of them.
"""

import sys
from datetime import UTC, datetime
from os import W_OK, access
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.can.settings import DRIVE_BY_WIRE
from vehicle_gateway.can.vehicles import car_bus_of
from vehicle_gateway.check.facts import Facts, Finding, Surroundings, Verdict
from vehicle_gateway.check.table import check, is_consistent
from vehicle_gateway.memory import default_file
from vehicle_gateway.settings import VehicleGatewaySettings, limits_with_map
from vehicle_gateway.video.sources import choose_sources
from wire import certificates
from wire.configuration import ConfigurationError, read_sections
from wire.messages.vehicle import VehicleDescription
from wire.rooms import settings_of_rooms
from wire.scenario import find_map, find_scenario, read_map, read_scenario
from wire.settings import WireSettings
from wire.topics import Role

INCONSISTENT = 1
ROLES = (Role.VEHICLE_HUB, Role.VIDEO, Role.RECORDER, Role.AUTONOMY)  # what runs in a real car
NETWORK = Path("/sys/class/net")
STYLES = {Verdict.OK: "green", Verdict.WARNING: "yellow", Verdict.ERROR: "bold red"}


def run(config: Path) -> int:
    """0 when the configuration is consistent, 1 when not. Every finding is shown, the bad ones with their fix."""
    console = Console(highlight=False, width=None if sys.stdout.isatty() else 160)
    sections, findings = read_every_section(config)
    if all(found.verdict is Verdict.OK for found in findings):
        findings += check(facts_of(config, sections))
    console.print(table_of(findings))
    counts = {verdict: sum(found.verdict is verdict for found in findings) for verdict in Verdict}
    consistent = is_consistent(findings)
    console.print(
        f"{config}: {'consistent' if consistent else 'NOT consistent'}: {counts[Verdict.OK]} ok, "
        f"{counts[Verdict.WARNING]} to look at, {counts[Verdict.ERROR]} wrong",
        style="green" if consistent else "bold red",
    )
    return 0 if consistent else INCONSISTENT


def read_every_section(config: Path) -> tuple[dict[str, Any], tuple[Finding, ...]]:
    """Each room's section as its programs read it, and a finding for each."""
    kinds: dict[str, type[Any]] = {"wire": WireSettings, "vehicle": VehicleDescription, **settings_of_rooms()}
    sections: dict[str, Any] = {}
    findings: list[Finding] = []
    for room, kind in kinds.items():
        try:
            sections |= read_sections(config, {room: kind})
            findings.append(Finding(f"[{room}]", Verdict.OK, "every key is known and in its range", ""))
        except ConfigurationError as error:
            findings.append(Finding(f"[{room}]", Verdict.ERROR, str(error), "correct this key"))
    if {"vehicle_gateway", "vehicle"} <= set(sections):
        findings.append(_dbc(sections["vehicle_gateway"], sections["vehicle"]))
    return sections, tuple(findings)


def _dbc(gateway: VehicleGatewaySettings, vehicle: VehicleDescription) -> Finding:
    name = gateway.can.dbc or f"config/{gateway.can.vehicle}.dbc"
    try:
        car_bus_of(gateway.can, vehicle)
    except ConfigurationError as error:
        fix = "take config/drive_by_wire.dbc as the pattern: same names, your places"
        return Finding("DBC", Verdict.ERROR, str(error), fix if gateway.can.vehicle == DRIVE_BY_WIRE else "correct this key")
    return Finding("DBC", Verdict.OK, f"{name}: every message and signal we speak", "")


def facts_of(config: Path, sections: dict[str, Any]) -> Facts:
    """The decoded sections and what stands around them. The sections are whole: `read_every_section` found nothing wrong."""
    wire: WireSettings = sections["wire"]
    gateway: VehicleGatewaySettings = sections["vehicle_gateway"]
    tower = sections["tower"]
    return Facts(
        wire=wire,
        vehicle=sections["vehicle"],
        gateway=gateway,
        device=str(tower.cockpit.device),
        screen_ms=tower.window.scan_out_delay_ms + tower.window.scan_out_bound_ms,
        layouts=read_layouts(gateway.can.dbc),
        around=_look_around(config, wire, sections["vehicle"], gateway, sections["autonomy"].map),
    )


def _look_around(
    config: Path, wire: WireSettings, vehicle: VehicleDescription, gateway: VehicleGatewaySettings, map_name: str
) -> Surroundings:
    folder = certificates.folder_of(wire.link.certificates)
    scenario = gateway.simulation.scenario
    memory = Path(gateway.memory) if gateway.memory else default_file(wire.link.vehicle_id)
    gateway_map_problem = _problem(lambda: limits_with_map(gateway, config))
    return Surroundings(
        can_interfaces=frozenset(path.name for path in NETWORK.glob("*")) - {"lo"},
        certificates_folder=folder.is_dir(),
        certificates_problem=_problem(lambda: _roles_can_join(folder, wire.link.vehicle_id)),
        certificates_days=_days(folder),
        map_problem=_problem(lambda: read_map(find_map(map_name, config))),
        gateway_map=None if gateway_map_problem else limits_with_map(gateway, config).map,
        gateway_map_problem=gateway_map_problem,
        scenario_problem=_problem(lambda: read_scenario(find_scenario(scenario))) if scenario else "",
        source_problem=_problem(lambda: choose_sources(gateway.video, vehicle)),
        memory_problem=_unwritable(memory),
    )


def _roles_can_join(folder: Path, vehicle_id: str) -> None:
    for role in ROLES:
        certificates.check(folder, role, vehicle_id)


def _days(folder: Path) -> float:
    try:
        return (certificates.earliest_end(folder) - datetime.now(UTC)).total_seconds() / 86400.0
    except certificates.CertificateError:
        return 0.0


def _problem(look: Any) -> str:
    """What is wrong with what `look` reads; "" when nothing is."""
    try:
        look()
    except (ConfigurationError, certificates.CertificateError) as error:
        return str(error)
    return ""


def _unwritable(file: Path) -> str:
    """Why a file could not be kept there; its folder is made when the gateway starts."""
    place = next(each for each in file.expanduser().absolute().parents if each.exists())
    return "" if access(place, W_OK) else f"{place}: this user may not write there"


def table_of(findings: tuple[Finding, ...]) -> Table:
    table = Table(box=None, pad_edge=False)
    for column in ("check", "", "compared"):
        table.add_column(column, overflow="fold")
    for name, verdict, compared, fix in findings:
        text = Text(compared)
        if fix:
            text.append(f"\n-> {fix}", STYLES[verdict])
        table.add_row(Text(name), Text(verdict, STYLES[verdict]), text)
    return table
