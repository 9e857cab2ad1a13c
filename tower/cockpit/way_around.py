"""The way around what blocks the own lane: through the oncoming lane and back, as a smooth line across the road. Pure.

Stations and sides are those of the rear axle; side_m as in `tower.cockpit.surroundings`. Each change of lane is a half cosine.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import cos, pi
from typing import Annotated

from msgspec import Meta

from tower.cockpit.surroundings import Standing
from wire.messages.base import Message

Metres = Annotated[float, Meta(ge=0.0, le=100.0)]


class WaySettings(Message):
    change_m: Metres = 14.0  # length of a change of lane, where there is room
    change_min_m: Metres = 9.0  # a sharper one is beyond the steering: radius 5 m at 3.5 m across
    full_before_m: Metres = 2.0  # rear axle wholly in the oncoming lane this far before the first thing
    back_after_m: Metres = 3.0  # rear axle this far behind the last thing when the way back begins (overhang 0.9 m)
    back_length_m: Metres = 13.0  # so that the car is back 16 m after the last thing: its length and 5 m, and more
    across_m: Metres = 1.2  # farther than this from the middle of its lane, and not going around anything: the car has to go back
    margin_m: Metres = 0.5  # what comes closer than this to the car in the middle of its lane blocks
    gap_m: Metres = 45.0  # things farther apart are passed one after the other, with the own lane between them


@dataclass(frozen=True, slots=True, kw_only=True)
class WayAround:
    """Stations: the change begins, is full, the way back begins, is done."""

    begin_m: float
    full_m: float
    back_m: float
    home_m: float
    from_side_m: float  # where the change begins


def side_at(way: WayAround | None, station_m: float, own_m: float, other_m: float) -> float:
    """Where the path lies at a station. own_m, other_m: sides of the two lanes' middles."""
    if way is None:
        return own_m
    if station_m < way.full_m:
        return _eased(way.from_side_m, other_m, (station_m - way.begin_m) / (way.full_m - way.begin_m))
    return _eased(other_m, own_m, (station_m - way.back_m) / (way.home_m - way.back_m))


def blockers(standing: Sequence[Standing], own_m: float, half_width_m: float, settings: WaySettings) -> list[Standing]:
    """What leaves no room for the car in the middle of the own lane, in the order of stations."""
    return sorted(thing for thing in standing if abs(thing.side_m - own_m) < half_width_m + settings.margin_m + thing.radius_m)


def updated(
    way: WayAround | None,
    standing: Sequence[Standing],
    station_m: float,
    side_m: float,
    own_m: float,
    half_width_m: float,
    settings: WaySettings,
) -> WayAround | None:
    """The way after another look. What has begun is kept; the way back waits for the last blocker that is known.

    station_m, side_m  of the rear axle
    """
    if way is not None and station_m >= way.home_m:
        way = None
    group = _group(blockers(standing, own_m, half_width_m, settings), way, station_m, settings)
    if not group:
        return way if way is not None else _home(standing, station_m, side_m, own_m, half_width_m, settings)
    last_m = max(thing.station_m + min(thing.radius_m, 0.5) for thing in group)
    if way is None or station_m < way.begin_m:
        return _planned(group[0].station_m, last_m, station_m, side_m, settings, way)
    if station_m <= way.back_m or last_m <= way.back_m - settings.back_after_m:
        back = max(last_m + settings.back_after_m, station_m)
        return replace(way, back_m=back, home_m=back + settings.back_length_m) if station_m <= way.back_m else way
    return _planned(group[0].station_m, last_m, station_m, side_m, settings)  # one more, seen on the way back


def _group(things: list[Standing], way: WayAround | None, station_m: float, settings: WaySettings) -> list[Standing]:
    """The next blockers that belong together: of a way that has begun also those beside and behind."""
    started = way is not None and station_m >= way.begin_m
    from_m = (way.begin_m if way is not None and station_m <= way.back_m else station_m) if started else station_m
    ahead = [thing for thing in things if thing.station_m > from_m]
    group = ahead[:1]
    for thing in ahead[1:]:
        if thing.station_m - group[-1].station_m > settings.gap_m:
            break
        group.append(thing)
    return group


def _planned(
    first_m: float, last_m: float, station_m: float, side_m: float, settings: WaySettings, before: WayAround | None = None
) -> WayAround:
    """before: a way that has not begun. Where the change begins at the car, it begins on the car's side, not on the lane's."""
    full = first_m - settings.full_before_m
    begin = max(full - settings.change_m, station_m)
    full = max(full, begin + settings.change_min_m)
    back = max(last_m + settings.back_after_m, full)
    from_side = before.from_side_m if before is not None and begin > station_m else side_m
    return WayAround(begin_m=begin, full_m=full, back_m=back, home_m=back + settings.back_length_m, from_side_m=from_side)


def _home(
    standing: Sequence[Standing], station_m: float, side_m: float, own_m: float, half_width_m: float, settings: WaySettings
) -> WayAround | None:
    """The way back alone, for a car that finds itself across the road: behind all that stands between it and its lane."""
    if abs(side_m - own_m) < settings.across_m:
        return None
    room = half_width_m + settings.margin_m
    low, high = sorted((side_m, own_m - room if own_m < side_m else own_m + room))
    between = [
        thing.station_m
        for thing in standing
        if 0 < thing.station_m - station_m < settings.back_length_m and low < thing.side_m < high
    ]
    back = max(between) + settings.back_after_m if between else station_m
    return WayAround(begin_m=station_m, full_m=station_m, back_m=back, home_m=back + settings.back_length_m, from_side_m=side_m)


def _eased(at_zero: float, at_one: float, share: float) -> float:
    within = min(max(share, 0.0), 1.0)
    return at_zero + (at_one - at_zero) * (1.0 - cos(pi * within)) / 2
