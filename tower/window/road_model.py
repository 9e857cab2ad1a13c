"""Sights -> RoadView: what is drawn on the road in the picture. Pure.

The path is shown while the operator's wheel counts or is about to; the way of a stop by itself while he drives, and while the
car takes it; the place of a request as long as it is open; what the planner weighs, where one tells, while the car drives.
Nothing is drawn over a frozen picture: it is no longer the road.
"""

from math import cos, pi, sin

from tower.window.course import XY, Motion, Pose, Strip, in_car_frame, moved, predicted, stopping_distance_m, strip
from tower.window.looks import known_mode
from tower.window.picture_age import PictureState, age_ns, picture_state
from tower.window.picture_layout import FRONT
from tower.window.projection import camera_named
from tower.window.sights import Sights
from tower.window.stop_way import way_held, way_of_corridor
from tower.window.views import LineKind, PlannedLine, RoadView
from wire.messages.automation import PlannedWay, PredictedPerson, Scene, WayPoints
from wire.messages.base import Gear
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import Mode, VehicleDescription, VehicleState

STOP_BRAKING_M_S2, STOP_JERK_M_S3 = 2.5, 5.0  # the car's own firm stop (vehicle_gateway.safe_stop): what a dead link comes to
LOOK_AHEAD_S = 3.0  # ours: how far the path goes on beyond the stopping line
_SHORTEST_M, _LONGEST_M = 7.0, 45.0
_LOOP_MAX_S = 1.0  # beyond it the car has stopped by itself
_SCENE_APART_MAX_S = 1.0
_SHORTEST_STOP_M = 0.3  # a car that hardly moves shows no way it would hold
_CORNERS = 16  # of a ring
HELD = "held"
_STOPS_ALONG = (Mode.REMOTE, Mode.HANDING_BACK, Mode.SAFE_STOP)
_CAR_DRIVES = (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED)
_STEERED = (Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK)


def road_view(sights: Sights) -> RoadView | None:
    """None: nothing is drawn on the road."""
    camera = camera_named(sights.description, FRONT)
    mode = known_mode(sights.status, sights.now_ns)
    state = picture_state(sights.picture, sights.now_ns, sights.clock_offset_ns)
    if camera is None or sights.picture is None or mode is None or state is PictureState.FROZEN:
        return None
    path = _path(sights, mode)
    corridor, blind_end = _stop_way(sights) if mode in _STOPS_ALONG else (None, None)
    place = _place(sights)
    planned = _planned(sights) if mode in _CAR_DRIVES else ()
    if path is None and corridor is None and place is None and not planned:
        return None
    until_stop, whole, stop_m = path if path is not None else (None, None, 0.0)
    return RoadView(
        camera=camera,
        until_stop=until_stop,
        whole=whole,
        stop_text=f"stop {stop_m:.0f} m" if path is not None else "",
        driving=mode is not Mode.HANDING_OVER,
        corridor=corridor,
        stopping=mode is Mode.SAFE_STOP,
        blind_end=blind_end,
        place=place,
        place_text=_distance_text(sights, place),
        planned=planned,
    )


def _distance_text(sights: Sights, place: tuple[float, float] | None) -> str:
    """From the front bumper."""
    car = sights.description
    if place is None or car is None:
        return ""
    return f"{max(place[0] - (car.length_m - car.rear_overhang_m), 0.0):.0f} m"


def loop_s(sights: Sights) -> float:
    """Capture to a command's effect: as the car measured it last, else the picture's age and half a round trip."""
    measured = [sample.loop_ms for sample in sights.history[-2:] if sample.loop_ms is not None]
    if measured:
        return min(max(measured) / 1000, _LOOP_MAX_S)
    age, operator = age_ns(sights.picture, sights.now_ns, sights.clock_offset_ns), sights.fresh_operator
    uplink_s = operator.round_trip_ms / 2000 if operator is not None else 0.0
    return min((age or 0) / 1e9 + uplink_s, _LOOP_MAX_S)


def _path(sights: Sights, mode: Mode) -> tuple[Strip, Strip, float] | None:
    state, operator, car = sights.fresh_state, sights.fresh_operator, sights.description
    if mode not in _STEERED or state is None or operator is None or car is None or state.gear is Gear.REVERSE:
        return None
    return None if sights.picture is None else _strips(sights, state, operator, car, sights.picture.capture_ns)


def _strips(
    sights: Sights, state: VehicleState, operator: OperatorStatus, car: VehicleDescription, capture_ns: int
) -> tuple[Strip, Strip, float]:
    now = Motion(state.stamp_ns, state.speed_m_s, state.road_wheel_angle_rad)
    begin = predicted(sights.motions or (now,), capture_ns, loop_s(sights), car.wheelbase_m)
    stop_m = stopping_distance_m(state.speed_m_s, min(STOP_BRAKING_M_S2, car.braking_max_m_s2), STOP_JERK_M_S3)
    end_m = min(max(stop_m + abs(state.speed_m_s) * LOOK_AHEAD_S, _SHORTEST_M), _LONGEST_M)
    angle = operator.road_wheel_angle_rad
    return strip(begin, 0.0, stop_m, angle, car), strip(begin, 0.0, end_m, angle, car), stop_m


def _pose_at_capture(sights: Sights, scene: Scene) -> Pose:
    """The car in the map frame when the picture was taken: the scene's pose, carried on or back by its own motion."""
    capture_ns = sights.picture.capture_ns if sights.picture is not None else scene.stamp_ns
    apart_s = min(max((capture_ns - scene.stamp_ns) / 1e9, -_SCENE_APART_MAX_S), _SCENE_APART_MAX_S)
    curvature = scene.yaw_rate_rad_s / scene.speed_m_s if abs(scene.speed_m_s) > 0.5 else 0.0
    return moved(Pose(scene.x_m, scene.y_m, scene.heading_rad), scene.speed_m_s * apart_s, curvature)


def _stop_way(sights: Sights) -> tuple[Strip | None, tuple[XY, XY] | None]:
    """Where the car stops by itself, or would; beyond walking pace backwards it never drives, and there it holds the wheels."""
    scene, car, state, status = sights.fresh_scene, sights.description, sights.fresh_state, sights.status
    if car is None or status is None:
        return None, None
    way = status.message.stop_way
    middle = _middle(sights, scene) if scene is not None and way.along != HELD else []
    if middle:
        return way_of_corridor(middle, way, car)
    if state is None or way.stop_m < _SHORTEST_STOP_M or state.speed_m_s < 0.0:
        return None, None
    return way_held(way, state.road_wheel_angle_rad, car)


def _middle(sights: Sights, scene: Scene) -> list[XY]:
    at = _pose_at_capture(sights, scene)
    return [in_car_frame(point, at.x_m, at.y_m, at.heading_rad) for point in scene.stopping_corridor]


def _place(sights: Sights) -> tuple[float, float] | None:
    """Of the open request, metres ahead and left of the rear axle."""
    request = sights.status.message.request if sights.status is not None else None
    scene = sights.fresh_scene
    if request is None or scene is None:
        return None
    at = _pose_at_capture(sights, scene)
    return in_car_frame(request.place, at.x_m, at.y_m, at.heading_rad)


def _planned(sights: Sights) -> tuple[PlannedLine, ...]:
    """People and where they are expected; each guidance class, what was made of it, and the chosen one."""
    scene, planner = sights.fresh_scene, sights.fresh_planner
    if scene is None or planner is None:
        return ()
    at = _pose_at_capture(sights, scene)
    lines = [_line(points, kind, way, at) for way in planner.ways for points, kind in _drawn(way) if len(points) > 1]
    lines += [each for person in planner.people for each in _expected(person, at)]
    return tuple(sorted(lines, key=lambda line: list(LineKind).index(line.kind)))


def _drawn(way: PlannedWay) -> tuple[tuple[WayPoints, LineKind], ...]:
    if way.chosen:
        return (way.guidance, LineKind.GUIDANCE), (way.trajectory, LineKind.CHOSEN)
    return (way.guidance, LineKind.GUIDANCE), (way.trajectory, LineKind.TRAJECTORY if way.feasible else LineKind.NOT_FEASIBLE)


def _expected(person: PredictedPerson, at: Pose) -> list[PlannedLine]:
    """Its circle now; of who walks where it goes, and a ring two deviations around its place at every second."""
    now, later = person.places[0], person.places[1:]
    around = [ring(now.x_m, now.y_m, person.radius_m, person.radius_m, 0.0)]
    around += [ring(each.x_m, each.y_m, 2.0 * each.long_m, 2.0 * each.wide_m, each.axis_rad) for each in later]
    shapes = [(points, LineKind.UNCERTAINTY) for points in around]
    if later:
        shapes.append((tuple((each.x_m, each.y_m) for each in person.places), LineKind.PERSON))
    return [
        PlannedLine(points=tuple(in_car_frame(point, at.x_m, at.y_m, at.heading_rad) for point in points), kind=kind, colour=None)
        for points, kind in shapes
    ]


def ring(x_m: float, y_m: float, long_m: float, wide_m: float, axis_rad: float) -> WayPoints:
    """A closed line around a place, half axes and the direction of the longer one."""
    along, across = cos(axis_rad), sin(axis_rad)
    turns = [2.0 * pi * k / _CORNERS for k in range(_CORNERS)]
    corners = [(long_m * cos(turn), wide_m * sin(turn)) for turn in [*turns, turns[0]]]
    return tuple((x_m + u * along - v * across, y_m + u * across + v * along) for u, v in corners)


def _line(points: WayPoints, kind: LineKind, way: PlannedWay, at: Pose) -> PlannedLine:
    seen = tuple(in_car_frame(point, at.x_m, at.y_m, at.heading_rad) for point in points)
    return PlannedLine(points=seen, kind=kind, colour=way.colour if way.identity >= 0 else None)
