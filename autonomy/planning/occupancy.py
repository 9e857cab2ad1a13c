"""When a person or moving thing will be in the car's way, judged from where it goes, not only from where it is. Pure.

Whoever walks along the sidewalk is not in the way; whoever turns towards the lane is, from the moment the turn is more
than the noise of the velocity. It reads no gaze and no gesture.
"""

from dataclasses import dataclass
from math import inf, sqrt

from autonomy.perception.prediction import HORIZON_S, OnRoad, deviation_after

WALKS_M_S = 0.3  # sideways: slower is swaying, not walking
SURE = 2.2  # standard deviations of the velocity above which it counts as walking: noise 1 % of the time
BESIDE_M = 0.3  # on the carriageway and so near the way: in it
LEAVES_M_S = 0.2  # sideways, away: clears the way


@dataclass(frozen=True, slots=True, kw_only=True)
class Occupancy:
    """A stay in the way, seconds from now and stations of the road."""

    from_s: float
    until_s: float  # inf: no end in sight
    near_station_m: float  # the thing's side towards a car that comes from lower stations
    far_station_m: float


def occupancy(thing: OnRoad, low_m: float, high_m: float, road_half_width_m: float) -> Occupancy | None:
    """The stay of `thing` between two offsets within the prediction's horizon; None when it stays out."""
    radius = thing.track.radius_m
    right, left = low_m - radius - thing.offset_m, thing.offset_m - high_m - radius
    gap = max(right, left)  # > 0: outside
    closing = thing.offset_rate_m_s if right > left else -thing.offset_rate_m_s
    if gap <= 0.0:
        return _stay(thing, 0.0, _time_to_leave(thing, right, left))
    noise = sqrt(thing.track.velocity_variance)
    if closing > max(WALKS_M_S, SURE * noise):
        nearer = max(gap - 0.5 * deviation_after(thing.track, min(gap / closing, HORIZON_S)), 0.0)
        from_s = nearer / (closing + noise)  # whoever has just set off is faster than the filter says
        if from_s > HORIZON_S:
            return None
        return _stay(thing, from_s, (gap + high_m - low_m + 2 * radius) / closing)
    on_carriageway = abs(thing.offset_m) < road_half_width_m
    if on_carriageway and gap < BESIDE_M and closing > -LEAVES_M_S:
        return _stay(thing, 0.0, inf)
    return None


def _time_to_leave(thing: OnRoad, right: float, left: float) -> float:
    """right, left: how far inside the two edges, as negative numbers."""
    rate = thing.offset_rate_m_s
    if abs(rate) < WALKS_M_S:
        return inf
    return -left / rate if rate > 0 else right / rate


def _stay(thing: OnRoad, from_s: float, until_s: float) -> Occupancy:
    """The stations it covers while in the way; a stay with no end is followed for as long as the prediction reaches."""
    first = thing.station_after(from_s)
    last = thing.station_after(min(until_s, HORIZON_S) if thing.station_rate_m_s < 0 else from_s)
    radius = thing.track.radius_m
    return Occupancy(
        from_s=from_s, until_s=until_s, near_station_m=min(first, last) - radius, far_station_m=max(first, last) + radius
    )
