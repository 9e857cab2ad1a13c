"""Scenario files (TOML): a map, and what the map does not know - site, people, buildings' look, start, seed, time-out.

The automation is given the map file alone; the scenario is read by the simulated world and by the renderer (as a camera
sees it). Stations and offsets are those of wire.road.Road.
"""

from pathlib import Path
from typing import Annotated

from msgspec import Meta

from wire.configuration import ConfigurationError, read_toml, shipped
from wire.messages.automation import RoadMap
from wire.messages.base import Count, Length, Message, Name

Offset = Annotated[float, Meta(ge=-100.0, le=100.0)]
Station = Annotated[float, Meta(ge=-200.0, le=10000.0)]


class Start(Message):
    station_m: Station
    speed_m_s: Annotated[float, Meta(ge=0.0, le=20.0)] = 0.0


class Site(Message):
    """A construction site that closes the own lane: a barrier at each end, cones along the side of the centre line."""

    station_m: Station
    length_m: Annotated[float, Meta(gt=1.0, le=200.0)]
    cone_spacing_m: Annotated[float, Meta(ge=1.0, le=20.0)] = 3.0
    taper_m: Annotated[float, Meta(ge=0.0, le=30.0)] = 8.0  # cones run from the kerb to the centre line over this length


class Building(Message):
    station_m: Station  # of its middle
    offset_m: Offset  # of its wall towards the road; the building lies beyond it
    length_m: Annotated[float, Meta(gt=1.0, le=200.0)]
    depth_m: Annotated[float, Meta(gt=1.0, le=100.0)] = 10.0
    height_m: Annotated[float, Meta(gt=1.0, le=100.0)] = 9.0


class Person(Message):
    """Walks from way point to way point (station_m, offset_m) at a constant speed, then back if `returns`, else stays."""

    way: Annotated[tuple[tuple[Station, Offset], ...], Meta(min_length=1, max_length=50)]
    speed_m_s: Annotated[float, Meta(ge=0.0, le=4.0)] = 1.3
    starts_when_car_within_m: Length = 1e5  # of its first way point; it waits there until then
    returns: bool = False


class Scenario(Message):
    name: Name
    map: Name  # file name of the map, beside this file or in config/maps
    seed: Count
    time_limit_s: Annotated[float, Meta(gt=1.0, le=3600.0)]  # of driving; afterwards the drive has failed
    start: Start
    site: Site | None = None
    buildings: tuple[Building, ...] = ()
    people: tuple[Person, ...] = ()


def find_scenario(name: str) -> Path:
    """The file that a scenario setting or option names: a path, or a name in config/scenarios with or without ".toml".

    Raises ConfigurationError that lists what there is; "" is the setting of a car that is real.
    """
    known = ", ".join(sorted(path.stem for path in shipped("scenarios").glob("*.toml")))
    if not name:
        raise ConfigurationError(f"no scenario: this configuration is of a car that is not simulated; shipped scenarios: {known}")
    for place in (Path(name), shipped("scenarios", name), shipped("scenarios", f"{name}.toml")):
        if place.is_file():
            return place.resolve()
    raise ConfigurationError(f"scenario {name!r}: no such file; shipped scenarios: {known}")


def find_map(name: str, config: Path, key: str = "autonomy.map") -> Path:
    """The map file that this key of the configuration names: absolute, beside the configuration, in its maps/ folder, or shipped.

    Raises ConfigurationError that lists where it was looked for.
    """
    places = (config.parent / name, config.parent / "maps" / name, shipped("maps", name))  # an absolute name wins each
    for place in places:
        if place.is_file():
            return place
    looked = ", ".join(str(place) for place in dict.fromkeys(places))
    raise ConfigurationError(f"{config}: {key} = {name!r}: no such map; looked at {looked}")


def read_map(path: Path) -> RoadMap:
    """A map file. Raises ConfigurationError that names file, key and allowed range."""
    return read_toml(path, RoadMap)


def read_scenario(path: Path) -> tuple[Scenario, Path]:
    """A scenario file and the path of the map it names. Raises ConfigurationError."""
    scenario = read_toml(path, Scenario)
    places = (path.parent / scenario.map, path.parent.parent / "maps" / scenario.map, shipped("maps", scenario.map))
    for place in places:
        if place.is_file():
            return scenario, place
    raise ConfigurationError(f"{path}: map = {scenario.map!r} not found; looked at {', '.join(map(str, places))}")
