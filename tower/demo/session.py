"""The configuration of one session, made from the base configuration: free ports, a bus of its own, a shifted tower clock."""

import secrets
import time
from pathlib import Path
from typing import Any

import tomli_w

from haptics.settings import HapticsSettings
from tower.settings import TowerSettings
from wire import certificates
from wire.configuration import ConfigurationError, read_sections, read_tables
from wire.messages.vehicle import VehicleDescription
from wire.ports import free_udp_ports
from wire.scenario import find_map, find_scenario, read_map, read_scenario
from wire.settings import WireSettings

HOUR_NS = 3_600_000_000_000


def choose(base: Path, scenario: str, front_camera: str) -> dict[str, Any]:
    """The base configuration with what the command line chose. Raises ConfigurationError before anything is written.

    scenario      a path or a name; "" keeps the base's
    front_camera  a video file to play as the front camera; "" keeps the base's source
    """
    tables = read_tables(base)
    if _get(tables, "vehicle_gateway", "simulation").get("scenario") == "":
        raise ConfigurationError(
            f"{base}: [vehicle_gateway.simulation] scenario is empty: this is a car that is really there, and the demo drives a "
            f"simulated one; leave --config out, or drive this car: tower drive --config {base}"
        )
    read_sections(base, {"wire": WireSettings, "vehicle": VehicleDescription, "tower": TowerSettings, "haptics": HapticsSettings})
    found = find_scenario(scenario or str(_get(tables, "vehicle_gateway", "simulation").get("scenario", "closed_road.toml")))
    _, road_map = read_scenario(found)
    _get(tables, "vehicle_gateway", "simulation")["scenario"] = str(found)
    _get(tables, "autonomy")["map"] = str(road_map.resolve())
    gateway = _get(tables, "vehicle_gateway")
    if gateway.get("map"):
        gateway["map"] = str(_zones(str(gateway["map"]), base, road_map).resolve())
    if front_camera:
        _get(tables, "vehicle_gateway", "video", "sources")["front"] = f"file:{_existing(front_camera)}"
    return tables


def write_session(tables: dict[str, Any], folder: Path) -> Path:
    """`folder`/session.toml: the chosen configuration with what must be this session's own. Makes missing certificates."""
    car_port, tower_port, can_port, actuator_port = free_udp_ports(4)
    link = _get(tables, "wire", "link")
    place = certificates.folder_of(link.get("certificates", ""))
    if certificates.is_imported(place):  # for one site of two machines; here both are needed
        place = place.with_name(f"{place.name}-demo")
    certificates.ensure(place)
    link.update(car_hub=f"127.0.0.1:{car_port}", tower_hub=f"127.0.0.1:{tower_port}", certificates=str(place.resolve()))
    link.update(connect=[], listen=[], fleet=[])  # all on this machine
    _get(tables, "wire", "clock").update(tower_offset_ns=HOUR_NS + secrets.randbelow(HOUR_NS), slowed_since_ns=time.monotonic_ns())
    _get(tables, "wire", "session").update(folder=str(folder), name=folder.name)
    _get(tables, "vehicle_gateway")["memory"] = str(folder / "gateway-memory.json")
    _get(tables, "vehicle_gateway", "can").update(channel=_own_group(), port=can_port, actuator_port=actuator_port)
    written = folder / "session.toml"
    written.write_bytes(tomli_w.dumps(tables).encode())
    return written


def _zones(named: str, base: Path, road_map: Path) -> Path:
    """The gateway's own map, which may have zones of its own, where it is of the street that is driven; else that street's."""
    own = find_map(named, base, "vehicle_gateway.map")
    return own if _street(own) == _street(road_map) else road_map


def _street(path: Path) -> tuple[object, ...]:
    road = read_map(path)
    return road.start, road.start_heading_rad, road.segments, road.lane_width_m, road.sidewalk_width_m, road.drives_on


def _existing(clip: str) -> Path:
    path = Path(clip)
    if not path.is_file():
        raise ConfigurationError(f"--front-camera {clip}: no such file")
    return path.resolve()


def _own_group() -> str:
    """A multicast group of this session (administratively scoped, RFC 2365)."""
    return f"239.{192 + secrets.randbelow(64)}.{secrets.randbelow(256)}.{1 + secrets.randbelow(254)}"


def _get(tables: dict[str, Any], *names: str) -> dict[str, Any]:
    """The table at a path, made when absent."""
    for name in names:
        inner = tables.setdefault(name, {})
        if not isinstance(inner, dict):
            raise ConfigurationError(f"[{'.'.join(names)}]: {name} = {inner!r} stands where a section belongs")
        tables = inner
    return tables
