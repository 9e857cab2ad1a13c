"""Channels of doubt: each turns one kind of trouble into a level from 0 (none) to 1 (certain) and a sentence. Pure.

planner       no way on: static things close the own lane, or a person has been standing in it for long
map           the world stands where the map says the lane is free
localization  error ellipse, rejected fixes
perception    age of the object list; innovations out of proportion, which alone never ask for a person

Only what is relevant to the way ahead counts in full: what is far off raises caution at most. The levels are set by
reason, not yet calibrated on recorded drives. Error ellipse: Autoware's monitor of it warns at 1.2 m, fails at 1.5 m.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import exp, prod
from typing import Annotated

from msgspec import Meta

from autonomy.car_shape import CarShape
from autonomy.localization.ekf import Estimate
from autonomy.perception.prediction import OnRoad
from autonomy.perception.tracking import TrackList
from autonomy.planning.braking_planner import Plan
from autonomy.planning.route import Lane
from wire.messages.base import Message

Positive = Annotated[float, Meta(gt=0.0, le=1000.0)]
CAUTION_AT_MOST = 0.7  # what is not relevant yet, or not enough alone


class ChannelSettings(Message):
    ripens_s: Positive = 0.5  # a static track is believed to 63 % after this time
    lane_share: Positive = 0.5  # things that stretch over this share of the lane's width contradict the map in full
    person_patience_s: Positive = 20.0  # a person standing in the lane is waited for; longer is a blockade
    person_ramp_s: Positive = 5.0  # from there to certainty
    deviation_from_m: Positive = 0.6
    deviation_to_m: Positive = 1.5
    rejected_from: Positive = 5.0  # GNSS positions in a row, 10 Hz
    rejected_to: Positive = 20.0
    age_from_s: Positive = 0.25  # of the object list
    age_to_s: Positive = 0.5
    innovation_from: Positive = 8.0  # running mean of the normalised innovation squared; 2 is nominal
    innovation_to: Positive = 20.0


@dataclass(frozen=True, slots=True)
class Level:
    channel: str
    level: float
    text: str  # "" when there is nothing to say


def ramp(value: float, start: float, end: float) -> float:
    return min(max((value - start) / (end - start), 0.0), 1.0)


def planner_level(plan: Plan, shape: CarShape, relevant_m: float, waited_s: float, settings: ChannelSettings) -> Level:
    """relevant_m: from the bumper. waited_s: how long the car has stood for a person, or without a way."""
    blocked = plan.blocked
    if blocked is None or blocked.kind == "person":
        level = ramp(waited_s, settings.person_patience_s, settings.person_patience_s + settings.person_ramp_s)
        what = "No way among the people has been found" if blocked is None else "A person has been standing in the lane"
        return Level("planner", level, f"{what} for {waited_s:.0f} s" if level > 0 else "")
    ahead = max(blocked.station_m - plan.station_m - shape.front_m, 0.0)
    group = [thing for thing in plan.in_lane if thing.track.number in blocked.numbers]
    level = _any_is_real([thing.track.probability * _ripe(thing, settings) for thing in group])
    text = f"The lane is closed {ahead:.0f} m ahead: {_count(len(group))}; the oncoming lane is not allowed"
    return Level("planner", _relevant(level, ahead, relevant_m), text)


def map_level(plan: Plan, lane: Lane, shape: CarShape, relevant_m: float, settings: ChannelSettings) -> Level:
    """How surely static things that the map does not know stand in the lane, and how much of its width they contest."""
    if not plan.in_lane:
        return Level("map", 0.0, "")
    ahead = max(plan.in_lane[0].station_m - plan.in_lane[0].track.radius_m - plan.station_m - shape.front_m, 0.0)
    near = [thing for thing in plan.in_lane if thing.station_m - plan.station_m - shape.front_m <= relevant_m]
    wide = min(_stretch(near or plan.in_lane, lane) / settings.lane_share, 1.0)
    level = wide * _any_is_real([thing.track.probability for thing in near or plan.in_lane])
    text = f"The map shows a free lane where {_count(len(plan.in_lane))} stand, from {ahead:.0f} m ahead"
    return Level("map", _relevant(level, ahead, relevant_m), text)


def localization_level(estimate: Estimate, settings: ChannelSettings) -> Level:
    wide = ramp(estimate.deviation_m, settings.deviation_from_m, settings.deviation_to_m)
    rejected = ramp(estimate.rejected_in_a_row, settings.rejected_from, settings.rejected_to)
    if wide >= rejected:
        text = f"The position is uncertain: one standard deviation is {estimate.deviation_m:.1f} m"
    else:
        text = f"Satellite positions contradict the wheels and the gyro ({estimate.rejected_in_a_row} in a row)"
    level = max(wide, rejected)
    return Level("localization", level, text if level > 0 else "")


def perception_level(tracks: TrackList, age_s: float, settings: ChannelSettings) -> Level:
    old = ramp(age_s, settings.age_from_s, settings.age_to_s)
    odd = CAUTION_AT_MOST * ramp(tracks.innovation, settings.innovation_from, settings.innovation_to)
    if old >= odd:
        return Level("perception", old, f"The object list is {age_s:.1f} s old" if old > 0 else "")
    return Level("perception", odd, "Things move differently from what was predicted")


def _ripe(thing: OnRoad, settings: ChannelSettings) -> float:
    return 1.0 - exp(-thing.track.age_s / settings.ripens_s)


def _any_is_real(probabilities: Sequence[float]) -> float:
    return 1.0 - prod(1.0 - p for p in probabilities)


def _relevant(level: float, ahead_m: float, relevant_m: float) -> float:
    return level if ahead_m <= relevant_m else min(level, CAUTION_AT_MOST)


def _stretch(things: Sequence[OnRoad], lane: Lane) -> float:
    """Share of the lane's width between the outermost sides of the things."""
    low = min(max(thing.offset_m - thing.track.radius_m, lane.low_m) for thing in things)
    high = max(min(thing.offset_m + thing.track.radius_m, lane.high_m) for thing in things)
    return (high - low) / (lane.high_m - lane.low_m)


def _count(number: int) -> str:
    return "1 static object" if number == 1 else f"{number} static objects"
