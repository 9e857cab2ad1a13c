"""What is drawn on the road, when, and where in the picture."""

from typing import Any

import numpy as np
import pygame
import pytest
from msgspec.structs import replace

from tests.messages import gateway_status, operator_status
from tower.window.course import Motion
from tower.window.drive_log import DriveLog
from tower.window.hud import Hud
from tower.window.layout import layout
from tower.window.looks import AMBER, VERMILION
from tower.window.picture_age import PictureSeen
from tower.window.picture_layout import Box
from tower.window.road_model import loop_s, road_view
from tower.window.sights import Sights
from tower.window.view_model import view_model
from tower.window.views import LineKind
from vehicle_gateway.safe_stop import StopLimits
from vehicle_gateway.video.render.projection import project
from wire.configuration import read_sections, shipped
from wire.latest import Received
from wire.messages.automation import PlannedWay, PlannerView, PredictedPerson, PredictedPlace, Reason, Scene, TakeoverRequest
from wire.messages.base import Gear
from wire.messages.operating import OperatorStatus
from wire.messages.sensing import Pose as MapPose
from wire.messages.vehicle import Actuation, GatewayStatus, Mode, StopWay, VehicleDescription, VehicleState
from wire.planner_colours import CLASSES

CAR = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
NOW = 50_000_000_000_000
MS = 1_000_000
FRONT_M = CAR.length_m - CAR.rear_overhang_m


class Grey:
    """A picture without anything in it."""

    capture_ns, decoded_ns, shape = 1, 2, (1280, 720)

    def pixels(self, part: Box | None, size: tuple[int, int]) -> np.ndarray:
        return np.full((size[1], size[0], 4), 96, np.uint8)


REQUEST = TakeoverRequest(number=1, raised_ns=1, budget_s=15.0, place=(130.0, 40.0), reasons=(Reason(channel="a", text="b"),))


def status(mode: Mode, request: TakeoverRequest | None = None) -> GatewayStatus:
    return gateway_status(
        stamp_ns=1, mode=mode, mode_since_ns=1, lease_holder="Anna", lease_epoch=3, request=request, budget_remaining_s=9.0
    )


def state(speed_m_s: float, gear: Gear = Gear.DRIVE) -> VehicleState:
    none = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    return VehicleState(
        stamp_ns=NOW,
        boot_id="b",
        sequence=1,
        speed_m_s=speed_m_s,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=gear,
        requested=none,
        applied=none,
        rules=(),
        speed_cap_m_s=8.0,
        loop_age_ms=100.0,
        command_age_ms=3.0,
    )


def operator(angle_rad: float = 0.0) -> OperatorStatus:
    return operator_status(
        dead_man=True,
        wheel_phase="active",
        steering_wheel_angle_rad=angle_rad * 14,
        road_wheel_angle_rad=angle_rad,
        clock_bound_ns=MS,
        round_trip_ms=40.0,
    )


def scene(speed_m_s: float, stamp_ns: int, corridor: tuple[tuple[float, float], ...] = ()) -> Scene:
    """The car at (100, 40), heading east."""
    return Scene(
        stamp_ns=stamp_ns,
        x_m=100.0,
        y_m=40.0,
        heading_rad=0.0,
        speed_m_s=speed_m_s,
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=50.0,
        offset_m=0.0,
        objects=(),
        plan=(),
        stopping_corridor=corridor,
    )


def sights(said: GatewayStatus, speed_m_s: float = 4.0, angle_rad: float = 0.0, **changes: Any) -> Sights:
    """A picture 80 ms old, a round trip of 40 ms: a command takes effect 100 ms after the capture."""
    capture_ns = NOW - 80 * MS
    known: dict[str, Any] = {
        "now_ns": NOW,
        "status": Received(said, NOW),
        "state": Received(state(speed_m_s), NOW),
        "operator": Received(operator(angle_rad), NOW),
        "scene": Received(scene(speed_m_s, capture_ns), NOW),
        "description": CAR,
        "pictures": {"front": PictureSeen(capture_ns, NOW - 20 * MS)},
        "motions": tuple(Motion(capture_ns + k * 20 * MS, speed_m_s, 0.0) for k in range(4)),
        "log": DriveLog(),
    }
    return Sights(**(known | changes))


@pytest.mark.parametrize("mode", list(Mode))
def test_the_path_is_drawn_while_the_operators_wheel_counts_or_is_about_to(mode: Mode) -> None:
    view = road_view(sights(status(mode)))
    shown = view is not None and view.until_stop is not None
    assert shown is (mode in (Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK))
    assert view is None or view.driving is (mode is not Mode.HANDING_OVER)


def test_the_path_begins_where_a_command_given_now_takes_effect_and_the_stopping_line_follows() -> None:
    """4 m/s for 100 ms are 0.4 m; 4 m/s at 2.5 m/s2 within 5 m/s3 are 4.1 m (2.0 s of braking, added up in small steps)."""
    view = road_view(sights(status(Mode.REMOTE)))
    assert view is not None and view.until_stop is not None and view.whole is not None
    assert view.until_stop.right[0][0] == pytest.approx(FRONT_M + 0.4, abs=1e-6)
    assert view.until_stop.right[-1][0] == pytest.approx(FRONT_M + 0.4 + 4.174, abs=0.01)
    assert view.stop_text == "stop 4 m"
    assert view.whole.right[-1][0] == pytest.approx(view.until_stop.right[-1][0] + 3.0 * 4.0, abs=1e-6)


def test_the_braking_assumed_is_the_cars_own_firm_stop() -> None:
    assert (StopLimits().braking_m_s2, StopLimits().jerk_m_s3) == (2.5, 5.0)


def test_the_path_bends_to_the_side_of_the_wheel() -> None:
    left, right = road_view(sights(status(Mode.REMOTE), angle_rad=0.2)), road_view(sights(status(Mode.REMOTE), angle_rad=-0.2))
    assert left is not None and right is not None and left.whole is not None and right.whole is not None
    assert left.whole.left[-1][1] > 3.0
    assert right.whole.right[-1][1] == pytest.approx(-left.whole.left[-1][1])


def test_no_path_without_a_picture_that_moves_without_calibration_or_backwards() -> None:
    driving = status(Mode.REMOTE)
    frozen = PictureSeen(NOW - 400 * MS, NOW - 300 * MS)
    assert road_view(sights(driving, pictures={"front": frozen})) is None
    assert road_view(sights(driving, pictures={})) is None
    assert road_view(sights(driving, description=None)) is None
    assert road_view(sights(driving, description=replace(CAR, cameras=()))) is None
    assert road_view(sights(driving, state=Received(state(-1.0, Gear.REVERSE), NOW))) is None
    assert road_view(sights(driving, state=Received(state(4.0), NOW - 400 * MS))) is None


def test_without_a_measured_loop_the_picture_and_half_a_round_trip_count() -> None:
    assert loop_s(sights(status(Mode.REMOTE))) == pytest.approx(0.100)


def test_the_place_of_a_request_is_seen_from_where_the_picture_was_taken() -> None:
    """The scene is 200 ms older than the picture: the car has come 0.8 m closer."""
    older = Received(scene(4.0, NOW - 280 * MS), NOW)
    view = road_view(sights(status(Mode.TAKEOVER_REQUESTED, REQUEST), scene=older))
    assert view is not None
    assert view.place == pytest.approx((29.2, 0.0))
    assert view.place_text == "26 m"  # from the bumper


def test_a_car_that_stops_by_itself_shows_its_corridor() -> None:
    said = scene(4.0, NOW - 80 * MS, ((104.0, 40.0), (108.0, 40.0)))
    view = road_view(sights(status(Mode.SAFE_STOP), scene=Received(said, NOW)))
    assert view is not None and view.corridor is not None and view.until_stop is None
    assert np.allclose(view.corridor.left, [(4.0, CAR.width_m / 2), (8.0, CAR.width_m / 2)])
    assert road_view(sights(status(Mode.SAFE_STOP))) is None


def test_an_operator_who_drives_sees_where_the_car_would_stop_by_itself_were_all_silent_now() -> None:
    """A corridor of 40 m of which 20 are free; the axle would stand after 10 m, the bumper 3.6 m farther."""
    said = scene(4.0, NOW - 80 * MS, tuple((100.0 + x, 40.0) for x in range(41)))
    status_said = replace(status(Mode.REMOTE), stop_way=StopWay(along="corridor", free_m=20.0, stop_m=10.0))
    view = road_view(sights(status_said, scene=Received(said, NOW)))
    assert view is not None and view.corridor is not None and not view.stopping
    assert view.corridor.left[-1] == pytest.approx((20.0, CAR.width_m / 2))
    assert view.blind_end == (pytest.approx((10.0 + FRONT_M, CAR.width_m / 2)), pytest.approx((10.0 + FRONT_M, -CAR.width_m / 2)))


def test_a_stop_that_would_not_end_within_the_corridor_has_no_line_across_it() -> None:
    said = scene(4.0, NOW - 80 * MS, tuple((100.0 + x, 40.0) for x in range(8)))
    status_said = replace(status(Mode.REMOTE), stop_way=StopWay(along="corridor", free_m=7.0, stop_m=9.0))
    view = road_view(sights(status_said, scene=Received(said, NOW)))
    assert view is not None and view.corridor is not None and view.blind_end is None


@pytest.mark.parametrize("along", ["held", ""])
@pytest.mark.parametrize("mode", [Mode.REMOTE, Mode.HANDING_BACK, Mode.SAFE_STOP])
def test_without_a_corridor_the_way_of_the_blind_stop_is_that_of_the_wheels_as_they_are(mode: Mode, along: str) -> None:
    """Straight wheels: 6 m on. Wheels to the left: the end lies to the left."""
    said = replace(status(mode), stop_way=StopWay(along=along, free_m=0.0, stop_m=6.0))
    view = road_view(sights(said))
    assert view is not None and view.blind_end is not None and view.corridor is not None
    assert view.blind_end[0] == pytest.approx((6.0 + FRONT_M, CAR.width_m / 2))
    assert view.stopping is (mode is Mode.SAFE_STOP)
    turned = replace(state(4.0), road_wheel_angle_rad=0.2)
    left = road_view(sights(said, state=Received(turned, NOW)))
    assert left is not None and left.blind_end is not None
    assert left.blind_end[0][1] > view.blind_end[0][1] + 0.5


def test_a_car_that_stands_or_goes_backwards_shows_no_way_it_would_hold() -> None:
    standing = replace(status(Mode.SAFE_STOP), stop_way=StopWay(along="held", stop_m=0.2))
    assert road_view(sights(standing)) is None
    backwards = replace(status(Mode.SAFE_STOP), stop_way=StopWay(along="held", stop_m=2.0))
    assert road_view(sights(backwards, state=Received(state(-1.0, Gear.REVERSE), NOW))) is None


def is_vermilion(pixels: np.ndarray, row: int, column: int) -> bool:
    return bool((np.abs(pixels[row - 2 : row + 3, column].astype(int) - VERMILION).max(axis=-1) < 12).any())


def test_the_line_of_the_blind_stop_stands_across_the_road_where_the_bumper_would() -> None:
    said = scene(8.0, NOW - 80 * MS, tuple((100.0 + x, 40.0) for x in range(41)))
    status_said = replace(status(Mode.REMOTE), stop_way=StopWay(along="corridor", free_m=30.0, stop_m=11.0))
    seen = sights(status_said, speed_m_s=8.0, scene=Received(said, NOW))
    pixels = drawn(seen)
    for left_m in (-0.6, 0.0, 0.6):
        assert is_vermilion(pixels, *pixel_of(11.0 + FRONT_M, left_m, (1280, 720)))
        assert not is_vermilion(pixels, *pixel_of(8.0 + FRONT_M, left_m, (1280, 720)))


def drawn(seen: Sights, size: tuple[int, int] = (1280, 720)) -> np.ndarray:
    surface = pygame.Surface(size)
    Hud().draw(surface, {"front": Grey()}, view_model(seen))
    return pygame.surfarray.array3d(surface).swapaxes(0, 1)


def pixel_of(x_m: float, y_m: float, size: tuple[int, int]) -> tuple[int, int]:
    """Row and column by the simulated camera's own projection."""
    point = project(CAR.cameras[0], MapPose(x_m=0.0, y_m=0.0, heading_rad=0.0), 0.0, 0.0, np.array([[x_m, y_m, 0.0]]))[0][0]
    front = layout(*size, {camera.name: (camera.width_px, camera.height_px) for camera in CAR.cameras}).pictures["front"]
    return round(front.y + point[1] * front.h / 720), round(front.x + point[0] * front.w / 1280)


def is_amber(pixels: np.ndarray, row: int, column: int) -> bool:
    return bool((np.abs(pixels[row - 2 : row + 3, column].astype(int) - AMBER).max(axis=-1) < 12).any())


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080)])
def test_the_stopping_line_stands_across_the_road_where_the_car_could_stand(size: tuple[int, int]) -> None:
    pixels = drawn(sights(status(Mode.REMOTE), speed_m_s=8.0), size)
    view = road_view(sights(status(Mode.REMOTE), speed_m_s=8.0))
    assert view is not None and view.until_stop is not None
    stop_m = view.until_stop.right[-1][0]
    for left_m in (-0.7, 0.0, 0.7):
        assert is_amber(pixels, *pixel_of(stop_m, left_m, size))
    for off_m in (-4.0, 4.0):
        assert not is_amber(pixels, *pixel_of(stop_m - off_m, 0.0, size))
    between = pixels[pixel_of((stop_m + 6.0) / 2, 0.0, size)]
    assert between[2] > between[0] + 20  # tinted blue, and still the road
    assert tuple(pixels[pixel_of(stop_m, 2.5, size)]) == (96, 96, 96)


def test_the_place_of_a_request_is_marked_in_the_picture() -> None:
    pixels = drawn(sights(status(Mode.TAKEOVER_REQUESTED, REQUEST)))
    row, column = pixel_of(30.0, 0.0, (1280, 720))
    assert is_amber(pixels, row - 10, column)


def way(identity: int, aside_m: float, *, feasible: bool = True, chosen: bool = False) -> PlannedWay:
    """From the car at (100, 40) east, 36 places a metre apart, that far to the left; its guidance half a metre farther."""
    points, farther = (tuple((100.0 + k, 40.0 + left_m) for k in range(36)) for left_m in (aside_m, aside_m + 0.5))
    guidance = farther if identity >= 0 else ()
    return PlannedWay(
        identity=identity, colour=max(identity, 0), guidance=guidance, trajectory=points, feasible=feasible, chosen=chosen
    )


PLANNED = PlannerView(stamp_ns=NOW, ways=(way(1, 1.5), way(2, -1.5, chosen=True), way(3, 4.0, feasible=False), way(-1, 0.0)))


@pytest.mark.parametrize("mode", list(Mode))
def test_what_the_planner_weighs_is_drawn_while_the_car_drives(mode: Mode) -> None:
    view = road_view(sights(status(mode), planner=Received(PLANNED, NOW)))
    shown = view is not None and len(view.planned) > 0
    assert shown is (mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED))


def test_the_chosen_one_lies_on_top_and_what_is_not_feasible_under_what_is() -> None:
    view = road_view(sights(status(Mode.AUTONOMOUS), planner=Received(PLANNED, NOW)))
    assert view is not None
    kinds = [(line.kind, line.colour) for line in view.planned]
    assert kinds == [
        (LineKind.GUIDANCE, 1),
        (LineKind.GUIDANCE, 2),
        (LineKind.GUIDANCE, 3),
        (LineKind.NOT_FEASIBLE, 3),
        (LineKind.TRAJECTORY, 1),
        (LineKind.TRAJECTORY, None),
        (LineKind.CHOSEN, 2),
    ]
    assert view.planned[-1].points[10] == pytest.approx((10.0, -1.5))
    assert road_view(sights(status(Mode.AUTONOMOUS), planner=Received(PLANNED, NOW - 1_001 * MS))) is None  # an old one
    assert road_view(sights(status(Mode.AUTONOMOUS), planner=Received(PLANNED, NOW), scene=None)) is None
    assert road_view(sights(status(Mode.AUTONOMOUS))) is None


def place_at(x_m: float, y_m: float, long_m: float = 0.0, wide_m: float = 0.0, axis_rad: float = 0.0) -> PredictedPlace:
    return PredictedPlace(x_m=100.0 + x_m, y_m=40.0 + y_m, long_m=long_m, wide_m=wide_m, axis_rad=axis_rad)


def test_people_stand_on_the_road_with_where_they_are_expected_and_how_surely() -> None:
    walks = PredictedPerson(number=4, radius_m=0.3, places=(place_at(14.0, -2.0), place_at(14.0, -1.0, 0.5, 0.2, np.pi / 2)))
    thing = PredictedPerson(number=9, radius_m=0.4, places=(place_at(20.0, 2.0),))
    there = sights(status(Mode.AUTONOMOUS), planner=Received(PlannerView(stamp_ns=NOW, ways=(), people=(walks, thing)), NOW))
    view = road_view(there)
    assert view is not None
    assert [line.kind for line in view.planned] == [LineKind.UNCERTAINTY] * 3 + [LineKind.PERSON]
    assert np.array(view.planned[-1].points) == pytest.approx(np.array(((14.0, -2.0), (14.0, -1.0))))
    now, later, stands = (np.array(line.points) for line in view.planned[:3])
    assert np.hypot(*(now - (14.0, -2.0)).T) == pytest.approx(0.3)
    assert np.hypot(*(stands - (20.0, 2.0)).T) == pytest.approx(0.4)
    assert np.abs(later - (14.0, -1.0)).max(axis=0) == pytest.approx((0.4, 1.0))  # two deviations, the longer to the left
    assert later[0] == pytest.approx(later[-1])
    row, column = pixel_of(14.0, 0.0, (1280, 720))  # the ring's left end
    assert (drawn(there)[row - 2 : row + 3, column - 2 : column + 3] > 200).all(axis=-1).any()


def test_planned_ways_lie_on_the_road_in_their_classes_colours() -> None:
    pixels = drawn(sights(status(Mode.AUTONOMOUS), planner=Received(PLANNED, NOW)))

    def has(x_m: float, y_m: float, colour: tuple[int, int, int]) -> bool:
        row, column = pixel_of(x_m, y_m, (1280, 720))
        return bool((np.abs(pixels[row, column - 2 : column + 3].astype(int) - colour).max(axis=-1) < 40).any())

    for x_m in (12.0, 16.0, 20.0):
        assert has(x_m, -1.5, CLASSES[2]) and not has(x_m, -1.5, CLASSES[1])
        assert has(x_m, 1.5, CLASSES[1])
        assert has(x_m + 0.5, 4.0, CLASSES[3]) and not has(x_m + 1.5, 4.0, CLASSES[3])  # broken
    assert has(12.0, -0.75, (96, 96, 96))  # between them the road
