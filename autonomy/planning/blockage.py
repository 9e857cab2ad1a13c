"""Whether static things leave room to pass inside the own lane; if not, where the lane is closed. Pure.

The oncoming lane is forbidden to the automation, so a closed own lane is no problem it may solve. Moving things and
waiting persons are not its business: one waits for them (`braking_planner`).
"""

from collections.abc import Sequence
from dataclasses import dataclass

from autonomy.perception.prediction import OnRoad
from autonomy.planning.route import Lane

GROUP_GAP_M = 8.0  # static things in the lane closer together than this belong to one site
ROOM_STEP_M = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Blockage:
    station_m: float  # near edge of its first object
    kind: str  # static, person
    numbers: tuple[int, ...]  # of the tracks
    place: tuple[float, float]  # of its first object, map frame


def in_lane(things: Sequence[OnRoad], lane: Lane, from_station_m: float, to_station_m: float) -> list[OnRoad]:
    """Static things that stand in the lane between two stations, nearest first."""
    found = [
        thing
        for thing in things
        if lane.contains(thing.offset_m, thing.track.radius_m)
        and from_station_m <= thing.station_m + thing.track.radius_m
        and thing.station_m <= to_station_m
    ]
    return sorted(found, key=lambda thing: thing.station_m - thing.track.radius_m)


def lateral_room(things: Sequence[OnRoad], lane: Lane, half_width_m: float, margin_m: float) -> float | None:
    """The smallest shift from the lane's middle (left positive) that passes all `things`; None: no room in the lane."""
    reach = (lane.high_m - lane.low_m) / 2 - half_width_m - margin_m / 2  # half the margin towards the lane's own edge
    steps = int(max(reach, 0.0) / ROOM_STEP_M)
    for step in range(steps + 1):
        for shift in (step * ROOM_STEP_M, -step * ROOM_STEP_M):
            middle = lane.middle_m + shift
            if all(abs(thing.offset_m - middle) >= thing.track.radius_m + half_width_m + margin_m for thing in things):
                return shift
    return None


def closed_by(things: Sequence[OnRoad], lane: Lane, half_width_m: float, margin_m: float) -> Blockage | None:
    """`things` stand in the lane, nearest first. The first group of them that leaves no room, None when all do."""
    for group in _groups(things):
        if lateral_room(group, lane, half_width_m, margin_m) is None:
            first = group[0]
            return Blockage(
                station_m=first.station_m - first.track.radius_m,
                kind="static",
                numbers=tuple(thing.track.number for thing in group),
                place=(first.track.x_m, first.track.y_m),
            )
    return None


def _groups(things: Sequence[OnRoad]) -> list[list[OnRoad]]:
    groups: list[list[OnRoad]] = []
    reach = float("-inf")
    for thing in things:
        if thing.station_m - thing.track.radius_m - reach > GROUP_GAP_M:
            groups.append([])
        groups[-1].append(thing)
        reach = max(reach, thing.station_m + thing.track.radius_m)
    return groups
