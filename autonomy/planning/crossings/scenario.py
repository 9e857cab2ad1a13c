"""Crossing files (TOML): a road, its width, and who crosses it while the car comes along. Fixed before any planner was tuned.

Everything that is drawn by chance is drawn from the seed alone, before the car moves: two planners with the same seed meet the
same people, who then react to what the car does (people.py). Stations and offsets are those of wire.road.Road.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
from msgspec import Meta
from numpy.typing import NDArray

from autonomy.planning.crossings.replayed import Tracks, read_tracks
from autonomy.planning.crossings.street import laps
from autonomy.planning.horizon import Floats
from wire.configuration import ConfigurationError, is_file, read_toml, shipped
from wire.messages.automation import RoadMap, RoadSegment
from wire.messages.base import Count, Message, Name
from wire.road import Road

Metres = Annotated[float, Meta(ge=0.0, le=500.0)]
Offset = Annotated[float, Meta(ge=-50.0, le=50.0)]
Piece = Annotated[float, Meta(gt=0.5, le=500.0)]
Curvature = Annotated[float, Meta(ge=-0.2, le=0.2)]  # 1/m, left positive
WalkingSpeed = Annotated[float, Meta(gt=0.0, le=8.0)]


class Crossers(Message):
    """People from either side to the other, beginning when the car is under way."""

    count: Annotated[int, Meta(ge=0, le=40)]
    from_m: Metres = 10.0  # stations where they cross
    to_m: Metres = 32.0
    outside_m: tuple[Metres, Metres] = (1.0, 6.0)  # how far beside the road they start
    speed_m_s: tuple[WalkingSpeed, WalkingSpeed] = (1.14, 1.66)  # reference, motion-planner.md: the paper's speeds
    meets_s: Annotated[float, Meta(ge=0.0, le=20.0)] | None = None  # then each starts where it reaches the line within so many
    # seconds of a car that drives at its wanted speed from the start; None: outside_m, and many have crossed when the car comes
    early_s: Annotated[float, Meta(ge=0.0, le=20.0)] = 0.0  # with meets_s: so much before the rear axle would be there
    beyond_walls_m: tuple[Metres, Metres] | None = None  # with meets_s: each comes past the far end of one of the occluders, on
    # its side and so far beyond it, instead of anywhere between from_m and to_m
    slant_rad: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.2  # deviation of their way from straight across
    reacts: bool = True  # to each other and to the car; else they walk on whatever comes


class Rider(Message):
    """A cyclist who follows the street at this offset, whatever comes; against the car when the speed is negative."""

    station_m: Metres
    offset_m: Offset
    speed_m_s: Annotated[float, Meta(ge=-8.0, le=8.0)]


class Thing(Message):
    """Stands, and is seen: a parked car's corner, a skip."""

    station_m: Metres
    offset_m: Offset
    radius_m: Annotated[float, Meta(gt=0.05, le=3.0)] = 0.8


class Occluder(Message):
    """A wall of this length along the road that nobody sees through: who is behind it is not predicted."""

    station_m: Metres
    offset_m: Offset
    length_m: Annotated[float, Meta(gt=0.1, le=50.0)]


class Crossing(Message):
    name: Name
    pieces_m: Annotated[tuple[tuple[Piece, Curvature], ...], Meta(max_length=100)]  # of the road, one after the other
    half_width_m: Annotated[float, Meta(ge=2.0, le=6.0)]  # from the line to either edge
    goal_m: Metres
    speed_m_s: Annotated[float, Meta(gt=0.1, le=8.3)] = 2.0  # wanted; the local planner's fastest is the most
    time_limit_s: Annotated[float, Meta(gt=1.0, le=600.0)] = 40.0
    crossers: Crossers = Crossers(count=0)
    riders: tuple[Rider, ...] = ()
    things: tuple[Thing, ...] = ()
    occluders: tuple[Occluder, ...] = ()
    tracks: Annotated[str, Meta(max_length=1000)] = ""  # a CSV of recorded people, beside this file or a path: frame, id, x_m, y_m
    tracks_hz: Annotated[float, Meta(gt=0.1, le=120.0)] = 2.5  # of its frames; ETH and UCY have 2.5
    first_seed: Count = 0  # seeds of reported runs begin here; tuning and training use others


@dataclass(frozen=True, slots=True, kw_only=True)
class World:
    """A crossing with a seed: where everybody starts. Arrays over n people; map frame."""

    crossing: Crossing
    road: Road
    positions_m: Floats  # (n, 2)
    goals_m: Floats  # (n, 2); of riders only the first: people.py moves it on along the street
    speeds_m_s: Floats  # (n,) each one's own
    radii_m: Floats  # (n,)
    reacts: NDArray[np.bool_]  # (n,)
    things_m: Floats  # (m, 2)
    thing_radii_m: Floats  # (m,)
    tracks: Tracks | None


PERSON_RADIUS_M, RIDER_RADIUS_M = 0.3, 0.6
BEYOND_M = 6.0  # people walk on so far beside the road
LOOKED_ON_M = 60.0  # beyond the goal: no planner's horizon is longer
RIDE_AHEAD_S = 1.0  # a rider aims so far ahead: with twice the time that people.py lets a velocity take, a bend carries nobody off
RIDE_AHEAD_M = 1.0  # at least


def find_crossing(name: str) -> Path:
    """A path, or a name in config/crossings. Raises ConfigurationError that lists what there is."""
    for place in (Path(name), shipped("crossings", name), shipped("crossings", f"{name}.toml")):
        if is_file(place):
            return place.resolve()
    folder = shipped("crossings")
    known = ", ".join(sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.toml")))
    raise ConfigurationError(f"crossing {name!r}: no such file; shipped crossings: {known}")


def read_crossing(path: Path) -> tuple[Crossing, Tracks | None]:
    """A crossing file and its recorded people. Raises ConfigurationError that names file, key and fix."""
    crossing = read_toml(path, Crossing)
    for flaw in _flaws(crossing):
        raise ConfigurationError(f"{path}: {flaw}")
    tracks = _tracks_file(path, crossing)
    return crossing, None if tracks is None else read_tracks(tracks, crossing.tracks_hz)


def files_of(path: Path) -> list[Path]:
    """The file of a crossing, and that of its recorded people."""
    tracks = _tracks_file(path, read_toml(path, Crossing))
    return [path] if tracks is None else [path, tracks]


def _tracks_file(path: Path, crossing: Crossing) -> Path | None:
    if not crossing.tracks:
        return None
    beside = path.parent / crossing.tracks
    return beside if is_file(beside) else Path(crossing.tracks)


def _flaws(crossing: Crossing) -> Iterator[str]:
    """What no key alone can say, each with its fix."""
    wanted = crossing.crossers
    ranges = {
        "from_m, to_m": (wanted.from_m, wanted.to_m),
        "outside_m": wanted.outside_m,
        "speed_m_s": wanted.speed_m_s,
        "beyond_walls_m": wanted.beyond_walls_m or (0.0, 0.0),
    }
    for name, (low, high) in ranges.items():
        if low > high:
            yield f"crossers.{name}: from {low:g} to {high:g}; the smaller one goes first"
    if wanted.beyond_walls_m is not None and (wanted.meets_s is None or not crossing.occluders):
        yield "crossers.beyond_walls_m: wants crossers.meets_s and a wall; add them: meets_s = 1.0, [[occluders]]"
    length = sum(piece for piece, _ in crossing.pieces_m)
    if not 0.0 < crossing.goal_m <= length:
        yield f"goal_m = {crossing.goal_m:g} is no place of the road; name one from 0 to {length:g} m, its length"
        return
    half = crossing.half_width_m
    for wall in crossing.occluders:
        if abs(wall.offset_m) < half:
            yield f"occluders.offset_m = {wall.offset_m:g} stands on the road; name {half:g} m and more to either side"
    lap = laps(Road(_map_of(crossing)), crossing.half_width_m, min(length, crossing.goal_m + LOOKED_ON_M))
    if lap is not None:
        yield f"pieces_m: the street lies on itself at {lap[0]:g} and {lap[1]:g} m; let it turn by less than a full turn"


def world_of(crossing: Crossing, seed: int, tracks: Tracks | None = None) -> World:
    """Everybody at the start. The same seed gives the same people."""
    road, random = Road(_map_of(crossing)), np.random.default_rng(seed)
    starts, goals, speeds = _crossers(crossing, road, random)
    riders = [road.to_world(rider.station_m, rider.offset_m)[:2] for rider in crossing.riders]
    ends = [ride_goal_m(road, rider, *start) for rider, start in zip(crossing.riders, riders, strict=True)]
    crossing_count = len(starts)
    return World(
        crossing=crossing,
        road=road,
        positions_m=np.array([*starts, *riders], float).reshape(-1, 2),
        goals_m=np.array([*goals, *ends], float).reshape(-1, 2),
        speeds_m_s=np.array([*speeds, *(abs(rider.speed_m_s) for rider in crossing.riders)], float),
        radii_m=np.array([PERSON_RADIUS_M] * crossing_count + [RIDER_RADIUS_M] * len(riders)),
        reacts=np.array([crossing.crossers.reacts] * crossing_count + [False] * len(riders), bool),
        things_m=np.array([road.to_world(thing.station_m, thing.offset_m)[:2] for thing in crossing.things], float).reshape(-1, 2),
        thing_radii_m=np.array([thing.radius_m for thing in crossing.things], float),
        tracks=tracks,
    )


def ride_goal_m(road: Road, rider: Rider, x_m: float, y_m: float) -> tuple[float, float]:
    """Where a rider who is there is bound for: a little ahead on his own line along the street, also beyond its ends."""
    ahead = max(RIDE_AHEAD_S * abs(rider.speed_m_s), RIDE_AHEAD_M)
    station = road.to_road(x_m, y_m).station_m
    return road.to_world(station + (ahead if rider.speed_m_s > 0 else -ahead), rider.offset_m)[:2]


def _map_of(crossing: Crossing) -> RoadMap:
    """The line is the middle of what may be driven on: a street that is the car's alone but for who walks there."""
    return RoadMap(
        name=crossing.name,
        start=(0.0, 0.0),
        start_heading_rad=0.0,
        segments=tuple(RoadSegment(length_m=length, curvature_1_m=curvature) for length, curvature in crossing.pieces_m),
        lane_width_m=crossing.half_width_m,
        sidewalk_width_m=2.0,
        speed_limit_m_s=max(crossing.speed_m_s, 1.0),
        drives_on="right",
        goal_station_m=crossing.goal_m,
    )


def _crossers(
    crossing: Crossing, road: Road, random: np.random.Generator
) -> tuple[list[tuple[float, float]], list[tuple[float, float]], list[float]]:
    wanted = crossing.crossers
    make = _beside if wanted.meets_s is None else _meeting if wanted.beyond_walls_m is None else _stepping_out
    made = [make(crossing, road, random) for _ in range(wanted.count)]
    return [start for start, _, _ in made], [goal for _, goal, _ in made], [speed for _, _, speed in made]


Crosser = tuple[tuple[float, float], tuple[float, float], float]  # start, goal, speed


def _beside(crossing: Crossing, road: Road, random: np.random.Generator) -> Crosser:
    wanted = crossing.crossers
    station, side = random.uniform(wanted.from_m, wanted.to_m), random.choice((-1.0, 1.0))
    edge = crossing.half_width_m + random.uniform(*wanted.outside_m)
    beyond = crossing.half_width_m + BEYOND_M
    along = np.tan(random.normal(0.0, wanted.slant_rad)) * (edge + beyond)
    start = road.to_world(station, side * edge)[:2]
    goal = road.to_world(station + float(np.clip(along, -15.0, 15.0)), -side * beyond)[:2]
    return start, goal, random.uniform(*wanted.speed_m_s)


def _meeting(crossing: Crossing, road: Road, random: np.random.Generator) -> Crosser:
    """Straight through a place on the line, there when the car would be."""
    wanted = crossing.crossers
    station, side = random.uniform(wanted.from_m, wanted.to_m), random.choice((-1.0, 1.0))
    return _through(crossing, road, random, station, side)


def _stepping_out(crossing: Crossing, road: Road, random: np.random.Generator) -> Crosser:
    """The same past the far end of a wall: hidden until the car has nearly come to that end."""
    wall = crossing.occluders[random.integers(len(crossing.occluders))]
    station = wall.station_m + wall.length_m / 2 + random.uniform(*(crossing.crossers.beyond_walls_m or (0.0, 0.0)))
    return _through(crossing, road, random, station, -float(np.sign(wall.offset_m)))


def _through(crossing: Crossing, road: Road, random: np.random.Generator, station: float, side: float) -> Crosser:
    """From the right with side 1, from the left with -1."""
    wanted = crossing.crossers
    walking = random.uniform(*wanted.speed_m_s)
    after_s = station / crossing.speed_m_s + random.uniform(-1.0, 1.0) * (wanted.meets_s or 0.0) - wanted.early_s
    x, y, heading = road.to_world(station)
    way = heading + side * np.pi / 2 + np.clip(random.normal(0.0, wanted.slant_rad), -1.0, 1.0)
    from_m = max(walking * after_s, crossing.half_width_m + 0.5)  # nobody starts on the road
    to_m = crossing.half_width_m + BEYOND_M
    start, goal = ((x + float(m * np.cos(way)), y + float(m * np.sin(way))) for m in (-from_m, to_m))
    return start, goal, walking
