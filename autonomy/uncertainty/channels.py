"""Channels of doubt: each turns one kind of trouble into a level from 0 (none) to 1 (certain) and a sentence. Pure.

planner       no way on: static things close the own lane, a person has been standing in it for long, or for a while no way has
              been found among the people: caution soon, a request only when it lasts
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
from autonomy.uncertainty.waiting import Waiting
from wire.messages.base import Message

Positive = Annotated[float, Meta(gt=0.0, le=1000.0)]
CAUTION_AT_MOST = 0.7  # what is not relevant yet, or not enough alone
NO_WAY = "No way among the people has been found"
CAUTION = 0.6  # above where a channel counts as clear, below where it asks


class ChannelSettings(Message):
    ripens_s: Positive = 0.5  # a static track is believed to 63 % after this time
    lane_share: Positive = 0.5  # things that stretch over this share of the lane's width contradict the map in full
    person_patience_s: Positive = 20.0  # a person standing in the lane is waited for; longer is a blockade
    person_ramp_s: Positive = 5.0  # from there to certainty
    no_way_caution_s: Positive = 1.0  # without a way among the people: half a second after the last one ceased to be followed
    no_way_patience_s: Positive = (
        15.0  # longer is a blockade, standing or not; crowds of eight who never cease to cross took 17 s at most
    )
    no_way_ramp_s: Positive = 5.0
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


def planner_level(
    plan: Plan, shape: CarShape, relevant_m: float, waiting: Waiting, now_ns: int, settings: ChannelSettings
) -> Level:
    """The worst of what keeps it from getting on. relevant_m: from the bumper."""
    keeping = (
        _closed(plan, shape, relevant_m, settings),
        _standing(plan, waiting.stood_s(now_ns), settings),
        _no_way(waiting.lost_s, settings),
    )
    return max(keeping, key=lambda each: each.level)


def _closed(plan: Plan, shape: CarShape, relevant_m: float, settings: ChannelSettings) -> Level:
    blocked = plan.blocked
    if blocked is None or blocked.kind == "person":
        return Level("planner", 0.0, "")
    ahead = max(blocked.station_m - plan.station_m - shape.front_m, 0.0)
    group = [thing for thing in plan.in_lane if thing.track.number in blocked.numbers]
    level = _any_is_real([thing.track.probability * _ripe(thing, settings) for thing in group])
    text = f"The lane is closed {ahead:.0f} m ahead: {_count(len(group))}; the oncoming lane is not allowed"
    return Level("planner", _relevant(level, ahead, relevant_m), text)


def _standing(plan: Plan, stood_s: float, settings: ChannelSettings) -> Level:
    level = ramp(stood_s, settings.person_patience_s, settings.person_patience_s + settings.person_ramp_s)
    person = plan.blocked is not None and plan.blocked.kind == "person"
    what = "A person has been standing in the lane" if person else NO_WAY
    return Level("planner", level, f"{what} for {stood_s:.0f} s" if level > 0 else "")


def _no_way(lost_s: float, settings: ChannelSettings) -> Level:
    if lost_s < settings.no_way_caution_s:
        return Level("planner", 0.0, "")
    asks = ramp(lost_s, settings.no_way_patience_s, settings.no_way_patience_s + settings.no_way_ramp_s)
    return Level("planner", max(CAUTION, asks), f"{NO_WAY} for {lost_s:.0f} s")


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
