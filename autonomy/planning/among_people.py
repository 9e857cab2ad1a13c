"""The topology planner on the car's own lane: what it is asked about, and what its answer means for control. Pure.

It decides where in the lane, and when, people are passed. What stands is the braking planner's: the goal, a closed lane, whoever
stands in the way, bends, an open take-over request. Its ceiling caps the planned speeds place by place and the tracker's command,
so that nothing the one knows is lost on the other; its stops for people who walk count only where they have become firm. The
oncoming lane is no road here. It drives while the car is in its lane and nobody is asked to take over; else, or when it has found
no way for a while, the braking planner drives alone. From beside the lane no way in it can be found, and to a wheel that swings
round people nobody can align his own.

Beyond the 4 s that tracks are predicted for, people go on as they went, to the horizon's end, along the street if they follow it
(`along_street.py`): whoever is not predicted there would be free room. Their deviation grows as in the published planner,
0.3 m/s dt sqrt(k): at 10 Hz a plan need not reckon with what somebody might decide in seven seconds, or it would never go.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from math import cos, hypot, inf, pi, sin, tan

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.localization.ekf import Pose
from autonomy.perception.prediction import OnRoad, on_road
from autonomy.perception.tracking import Track
from autonomy.planning.along_street import along_street
from autonomy.planning.braking_planner import Plan, PlanningSettings, Situation
from autonomy.planning.horizon import HORIZON_S, PLAN_PERIOD_S, STEP_S, STEPS, CarState, Floats, Predictions, Trajectory
from autonomy.planning.mpc.guess import later
from autonomy.planning.reference_path import ReferencePath, lane_path
from autonomy.planning.route import own_lane
from autonomy.planning.speed_limits import StopPoint, ceiling
from autonomy.planning.topology import Around
from wire.road import Road

BEHIND_M, BEYOND_M = 10.0, 60.0  # of the road: neither the car's rear nor the horizon leaves the path
SPREAD_M_S = 0.3  # source: see above
NEAR_LANE_M = 1.0  # who comes no nearer to the lane within the horizon is left out
BACK_M, SPARE_M = 15.0, 0.05  # a car beside its lane is back in it after so much; and has so much more room than it needs
OUT_M = 0.25  # no farther beside it
ROLLED_M = 4.0  # that a car rolls on with its wheels as they stand: it is in its lane when it is so then as well
NEAR_M, NEAR_RAD, NEAR_M_S = 0.15, 0.05, 0.3  # of where the last plan expected the car: three deviations of what is measured
NEAR_WHEELS_RAD = 0.05  # half a second at the rate that plans reckon with: the wheels are not where that says
PASSED_M = 3.0  # behind the rear bumper
PEOPLE_MAX = 24  # the nearest; the work grows with them


def lane_of(road: Road) -> ReferencePath:
    """The own lane as a path with its room."""
    lane = own_lane(road)
    return lane_path(road, lambda _: lane.middle_m, -BEHIND_M, road.length_m + BEYOND_M, lane.low_m, lane.high_m)


def around(
    made: Plan,
    situation: Situation,
    pose: Pose,
    angle_rad: float,
    path: ReferencePath,
    settings: PlanningSettings,
    before: Trajectory | None = None,
    passed_s: float = PLAN_PERIOD_S,
) -> Around | None:
    """What the topology planner is asked for the plan that the braking planner `made`; None: it is not its turn, too far beside.

    before  what was taken `passed_s` ago, None when it was not its turn: a car that is about where that says is taken to be
            there. Else the noise of every measurement would be a new way, and the wheels would follow it.
    """
    car = car_on(path, *_expected(before, passed_s, pose, angle_rad))
    if not is_in_lane(car, situation.shape, path, was=before is not None):
        return None
    wanted = ceiling_of(made, situation.road, settings)(situation.station_m)
    room = with_room_for(car, situation.shape, path)
    return Around(car=car, path=room, predictions=along_street(predicted(made, situation), path), speed_m_s=wanted)


def _expected(before: Trajectory | None, passed_s: float, pose: Pose, angle_rad: float) -> tuple[Pose, float]:
    """Pose and road wheel angle by the last plan; as measured where they are not near."""
    if before is None or not before.feasible:
        return pose, angle_rad
    x, y, heading, speed, angle, _ = map(float, later(before, passed_s).states[0])
    away_m = hypot(x - pose.x_m, y - pose.y_m)
    gaps = (
        (away_m, NEAR_M),
        (heading - pose.heading_rad, NEAR_RAD),
        (speed - pose.speed_m_s, NEAR_M_S),
        (angle - angle_rad, NEAR_WHEELS_RAD),
    )
    if any(abs(gap) >= most for gap, most in gaps):
        return pose, angle_rad
    return replace(pose, x_m=x, y_m=y, heading_rad=heading, speed_m_s=speed), angle


def car_on(path: ReferencePath, pose: Pose, angle_rad: float) -> CarState:
    """With its foot on the path, which is a line with few bends: the nearest knot leads there."""
    knots = np.stack((path.x_coefficients[:, 3], path.y_coefficients[:, 3]), axis=1)
    station = float(path.knots_m[int(np.hypot(*(knots - (pose.x_m, pose.y_m)).T).argmin())])
    for _ in range(4):
        x, y, heading = path.at(station)
        station += (pose.x_m - x) * cos(heading) + (pose.y_m - y) * sin(heading)
    return CarState(
        x_m=pose.x_m,
        y_m=pose.y_m,
        heading_rad=pose.heading_rad,
        speed_m_s=max(pose.speed_m_s, 0.0),  # the measured one is noisy at standstill
        road_wheel_angle_rad=angle_rad,
        station_m=station,
    )


def is_in_lane(car: CarState, shape: CarShape, path: ReferencePath, was: bool) -> bool:
    """Near enough to its lane for a way in it to be found; was: it has been until now."""
    if was:
        return max(_beside(car, shape, path)) <= OUT_M
    return max(*_beside(car, shape, path), *_beside(rolled(car, shape, ROLLED_M), shape, path)) <= 0.0


def rolled(car: CarState, shape: CarShape, distance_m: float) -> CarState:
    """So much farther with its wheels as they stand."""
    turn = distance_m * tan(car.road_wheel_angle_rad) / shape.wheelbase_m
    chord_m = distance_m * float(np.sinc(turn / (2.0 * pi)))
    x, y = car.x_m + chord_m * cos(car.heading_rad + turn / 2.0), car.y_m + chord_m * sin(car.heading_rad + turn / 2.0)
    return replace(car, x_m=x, y_m=y, heading_rad=car.heading_rad + turn, station_m=car.station_m + distance_m)


def with_room_for(car: CarState, shape: CarShape, path: ReferencePath) -> ReferencePath:
    """The path with room for a car that stands partly beside its lane: as much as it needs now, less and less ahead.

    A planner that may not be where it is finds no way, and the car would stand there for good. A car that is all in its lane
    gets nothing: it would gain a little each time it points outwards.
    """
    beside = _beside(car, shape, path)
    if max(beside) <= 0.0:
        return path
    ahead_m = path.knots_m - (car.station_m + shape.front_m)
    share = np.clip(1.0 - ahead_m / BACK_M, 0.0, 1.0)
    left, right = (share * (out_m + SPARE_M if out_m > 0.0 else 0.0) for out_m in beside)
    return replace(path, room_left_m=path.room_left_m + left, room_right_m=path.room_right_m + right)


def _beside(car: CarState, shape: CarShape, path: ReferencePath) -> tuple[float, float]:
    """How far the car's corners reach over the left and the right edge of its lane; negative: so far within."""
    offsets = list(_offsets(car, shape, path))
    left, right = (float(np.interp(car.station_m, path.knots_m, room)) for room in (path.room_left_m, path.room_right_m))
    return max(offsets) - left, -min(offsets) - right


def _offsets(car: CarState, shape: CarShape, path: ReferencePath) -> Iterator[float]:
    """Of its corners from the path, left positive."""
    for ahead in (-shape.rear_m, shape.front_m):
        at_x, at_y, heading = path.at(car.station_m + ahead)
        for aside in (-shape.half_width_m, shape.half_width_m):
            x = car.x_m + ahead * cos(car.heading_rad) - aside * sin(car.heading_rad) - at_x
            y = car.y_m + ahead * sin(car.heading_rad) + aside * cos(car.heading_rad) - at_y
            yield y * cos(heading) - x * sin(heading)


def predicted(made: Plan, situation: Situation) -> Predictions:
    """Everybody and everything that may come into the lane before the car has to stop anyway, the nearest first."""
    things = sorted(_relevant(made, situation), key=lambda thing: abs(thing.station_m - situation.station_m))[:PEOPLE_MAX]
    return predictions_of([thing.track for thing in things], situation.now_ns)


def predictions_of(tracks: Sequence[Track], now_ns: int) -> Predictions:
    count, stages = len(tracks), np.arange(STEPS + 1)
    ages = np.array([(now_ns - track.stamp_ns) * 1e-9 for track in tracks])
    moving = np.array([not track.static for track in tracks], float)
    times = ages[None] + stages[:, None] * STEP_S  # (K, n)
    velocities = _pairs((track.velocity_x_m_s, track.velocity_y_m_s) for track in tracks) * moving[:, None]
    places = _pairs((track.x_m, track.y_m) for track in tracks)
    variances = np.array([track.position_variance for track in tracks]) + (SPREAD_M_S * STEP_S) ** 2 * stages[:, None] * moving
    return Predictions(
        numbers=tuple(track.number for track in tracks),
        positions_m=places + times[..., None] * velocities,
        covariances_m2=variances[..., None, None] * np.eye(2),
        radii_m=np.array([track.radius_m for track in tracks], float).reshape(count),
    )


def _pairs(values: Iterable[tuple[float, float]]) -> Floats:
    return np.array(list(values), float).reshape(-1, 2)


def _relevant(made: Plan, situation: Situation) -> Iterator[OnRoad]:
    road, shape, lane = situation.road, situation.shape, own_lane(situation.road)
    rear = situation.station_m - shape.rear_m - PASSED_M
    reach = situation.station_m + shape.front_m + road.map.speed_limit_m_s * HORIZON_S
    closed = min((stop.station_m + shape.front_m for stop in made.stops if stop.cause == "static"), default=inf)
    for track in situation.tracks:
        if track.static and track.number in made.waited_for:
            continue  # there is a stop for them
        thing = on_road(track, road, situation.station_m)
        ahead_s = 0.0 if track.static else HORIZON_S
        low, high = sorted((thing.offset_m, thing.offset_m + ahead_s * thing.offset_rate_m_s))
        first, last = sorted((thing.station_m, thing.station_m + ahead_s * thing.station_rate_m_s))
        aside = track.radius_m + NEAR_LANE_M
        near = high > lane.low_m - aside and low < lane.high_m + aside
        if near and last > rear and first < min(reach, closed):
            yield thing


def counting(made: Plan, settings: PlanningSettings) -> list[StopPoint]:
    """The stops that hold whatever way is taken: for what stands, and for people whom only firm braking still avoids."""
    return [stop for stop in made.stops if stop.cause != "person" or stop.deceleration_m_s2 > settings.moderate_m_s2]


def ceiling_of(made: Plan, road: Road, settings: PlanningSettings) -> Callable[[float], float]:
    """Speed by station: what stands allows, and people whom only firm braking still avoids."""
    stops = counting(made, settings)
    limit, comfort = road.map.speed_limit_m_s, settings.comfort_m_s2
    return lambda station_m: ceiling(station_m, limit, comfort, stops, made.caps).speed_m_s


def capped(trajectory: Trajectory, made: Plan, road: Road, settings: PlanningSettings) -> Trajectory:
    """The trajectory with no speed above the ceiling at its place."""
    states, near, allowed = trajectory.states.copy(), made.station_m, ceiling_of(made, road, settings)
    for state in states:
        near = road.to_road(float(state[0]), float(state[1]), near).station_m
        state[3] = min(state[3], allowed(near))
    return replace(trajectory, states=states)
