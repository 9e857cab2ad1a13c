"""The way the car can stop along: from where it is, as it turns now, checked against road edges and static things. Pure.

Both lanes are road here: the corridor has to hold while an operator drives in the oncoming lane. Its points are places of
the rear axle at which the whole car stands free; it ends before the first place at which it would not. It says nothing
about moving things.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, exp, hypot, sin, tan
from typing import NamedTuple

from autonomy.car_shape import CarShape
from autonomy.localization.ekf import Pose
from autonomy.planning.route import curvature_at_1_m
from wire.messages.automation import STOPPING_CORRIDOR_M
from wire.messages.base import Point
from wire.road import Road, wrap_angle

STEP_M = 1.0
CURVATURE_MAX_1_M = 0.15  # 0.38 rad at the road wheels of the simulated car
SIDE_M = 0.15  # free between the car and the road's edge or a thing
AHEAD_M = 0.7  # free between the bumper and a thing
JOIN_M = 0.8  # closer to the middle of a lane than this: that lane is what is followed
GENTLE_STOP_M_S2 = 1.5  # a corridor long enough for this needs no sharper one


@dataclass(frozen=True, slots=True)
class Law:
    """How a corridor goes on from the present curvature."""

    blend_m: float  # the present curvature fades over this length
    turn_1_m: float  # curvature per rad of angle to the road
    pull_1_m2: float  # curvature per metre beside the line that is followed


AS_DRIVEN = Law(4.0, 0.25, 0.02)  # damping 0.88, back on the line after about 14 m
SHARPER = Law(1.5, 0.5, 0.06)  # where the gentle one meets an edge or a thing too soon: damping 1.0


class Circle(NamedTuple):
    x_m: float
    y_m: float
    radius_m: float


@dataclass(frozen=True, slots=True)
class _Place:
    x_m: float
    y_m: float
    heading_rad: float


def stopping_corridor(
    pose: Pose, road_wheel_angle_rad: float, road: Road, shape: CarShape, things: Sequence[Circle], near_station_m: float
) -> tuple[Point, ...]:
    """Points of the rear axle's path in the map frame, from the car on, STEP_M apart; () when the car has no free place.

    The way as it is driven now; when that leaves no gentle stop, the longest of a few that turn sharper. A car in a lane
    never leaves it here; one between the lanes may come to rest in either.
    """
    bend = tan(road_wheel_angle_rad) / shape.wheelbase_m
    near = [thing for thing in things if hypot(thing.x_m - pose.x_m, thing.y_m - pose.y_m) < STOPPING_CORRIDOR_M + 8.0]
    followed = _line_followed(road.to_road(pose.x_m, pose.y_m, near_station_m).offset_m, road, shape)
    enough = pose.speed_m_s**2 / (2 * GENTLE_STOP_M_S2) + pose.speed_m_s + 3.0
    half_lane = road.map.lane_width_m / 2
    between = () if abs(followed) == half_lane else ((SHARPER, half_lane), (SHARPER, -half_lane))
    longest: tuple[Point, ...] = ()
    for law, line in ((AS_DRIVEN, followed), (SHARPER, followed), *between):
        points = _checked_path(pose, bend, law, line, road, shape, near, near_station_m)
        if len(points) > len(longest):
            longest = points
        if (len(longest) - 1) * STEP_M >= enough:
            break
    return longest


def _checked_path(
    pose: Pose, bend: float, law: Law, line_m: float, road: Road, shape: CarShape, things: Sequence[Circle], near_station_m: float
) -> tuple[Point, ...]:
    """One path up to the last place at which the whole car stands free."""
    place = _Place(pose.x_m, pose.y_m, pose.heading_rad)
    points: list[Point] = []
    for i in range(int(STOPPING_CORRIDOR_M / STEP_M) + 1):
        at = road.to_road(place.x_m, place.y_m, near_station_m)
        angle = wrap_angle(place.heading_rad - at.heading_rad)
        if not _free(place, at.offset_m, angle, road, shape, things):
            break
        points.append((place.x_m, place.y_m))
        share = exp(-i * STEP_M / law.blend_m)
        home = curvature_at_1_m(road, at.station_m, at.offset_m) - law.turn_1_m * angle - law.pull_1_m2 * (at.offset_m - line_m)
        place = _onward(place, share * bend + (1 - share) * min(max(home, -CURVATURE_MAX_1_M), CURVATURE_MAX_1_M))
    return tuple(points)


def _line_followed(offset_m: float, road: Road, shape: CarShape) -> float:
    """The offset the car keeps to: the middle of a lane when it is near one, else where it is, inside the road."""
    half_lane = road.map.lane_width_m / 2
    middle = half_lane if offset_m > 0 else -half_lane
    reach = road.half_width_m - shape.half_width_m - SIDE_M
    return middle if abs(offset_m - middle) < JOIN_M else min(max(offset_m, -reach), reach)


def _onward(place: _Place, curvature_1_m: float) -> _Place:
    middle = place.heading_rad + curvature_1_m * STEP_M / 2
    return _Place(place.x_m + STEP_M * cos(middle), place.y_m + STEP_M * sin(middle), place.heading_rad + curvature_1_m * STEP_M)


def _free(place: _Place, offset_m: float, angle_rad: float, road: Road, shape: CarShape, things: Sequence[Circle]) -> bool:
    """Whether the whole car stands on the road and clear of every thing."""
    edge = road.half_width_m - SIDE_M
    side = shape.half_width_m * cos(angle_rad)
    for along in (shape.front_m, -shape.rear_m):
        if abs(offset_m + along * sin(angle_rad)) + side > edge:
            return False
    c, s = cos(place.heading_rad), sin(place.heading_rad)
    for thing in things:
        dx, dy = thing.x_m - place.x_m, thing.y_m - place.y_m
        ahead, left = c * dx + s * dy, -s * dx + c * dy
        outside = max(ahead - shape.front_m - AHEAD_M, -shape.rear_m - ahead, 0.0)
        beside = max(abs(left) - shape.half_width_m - SIDE_M, 0.0)
        if hypot(outside, beside) < thing.radius_m:
            return False
    return True
