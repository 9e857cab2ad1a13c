"""What the scripted operator sees: never newer than the picture; and how it judges what is around."""

from math import cos, sin

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import gateway_status, vehicle_description
from tower.cockpit.delayed_view import DelayedView
from tower.cockpit.devices import View
from tower.cockpit.path_following import Pose, reckoned
from tower.cockpit.picture import Picture, watched
from tower.cockpit.surroundings import Standing
from tower.cockpit.way_around import WaySettings, blockers, side_at, updated
from wire.latest import Received
from wire.messages.operating import WindowStatus
from wire.messages.vehicle import CameraCalibration

MS = 1_000_000
STATUS = gateway_status(lease_holder="o", lease_epoch=3)


def camera(name: str, required: bool) -> CameraCalibration:
    return CameraCalibration(
        name=name,
        required=required,
        width_px=640,
        height_px=360,
        frame_rate_hz=30.0,
        focal_length_px=400.0,
        x_m=0.0,
        y_m=0.0,
        z_m=1.0,
        yaw_rad=0.0,
        pitch_rad=0.0,
    )


CAR = vehicle_description(
    cameras=(camera("front", True), camera("left", True), camera("rear", False)),
)


def window(frozen: bool = False, **captures: int) -> WindowStatus:
    return WindowStatus(stamp_ns=0, sequence=0, displayed_capture_ns=captures, frozen=frozen, shown=(), frames_dropped=0)


@given(stamps=st.lists(st.integers(0, 5000), min_size=1, max_size=50), at=st.integers(0, 5000))
def test_nothing_newer_than_the_picture_is_ever_seen_and_nothing_older_than_needed(stamps: list[int], at: int) -> None:
    view, stamps = DelayedView(), sorted(stamps)
    for stamp in stamps:
        view.note(View(gateway_status=Received(msgspec.structs.replace(STATUS, stamp_ns=stamp * MS), 1)))
    seen = view.status_at(at * MS)
    expected = [stamp for stamp in stamps if stamp <= at and stamp >= stamps[-1] - 3000]
    assert (seen.stamp_ns // MS if seen is not None else None) == (max(expected) if expected else None)


def test_the_picture_is_the_oldest_of_the_required_cameras_as_it_was_one_reaction_ago() -> None:
    picture = Picture()
    for frame in range(30):
        shown = window(front=1000 * MS + frame * 33 * MS, left=990 * MS + frame * 33 * MS, rear=1)
        picture = watched(picture, shown, CAR, frame * 33 * MS)
    assert picture.perceived_ns(29 * 33 * MS, 200 * MS) == (990 + 22 * 33) * MS


def test_a_picture_is_still_after_300_ms_frozen_when_the_window_says_so_and_missing_with_a_required_camera() -> None:
    picture = watched(Picture(), window(front=5, left=6), CAR, 0)
    assert watched(picture, window(front=5, left=6), CAR, 300 * MS).is_live(300 * MS)
    assert not watched(picture, window(front=5, left=7), CAR, 301 * MS).is_live(301 * MS)
    assert not watched(picture, window(True, front=9, left=9), CAR, MS).is_live(MS)
    assert not watched(picture, window(front=9), CAR, MS).is_live(MS)
    assert not watched(Picture(), None, CAR, MS).is_live(MS)


def test_a_picture_is_steady_after_a_second_without_a_gap_of_more_than_150_ms() -> None:
    picture, steady_at = Picture(), []
    for now_ms in range(0, 5000, 10):
        if now_ms % 30 == 0 and not 2000 < now_ms < 2200:  # a gap of 210 ms
            picture = watched(picture, window(front=now_ms * MS, left=now_ms * MS), CAR, now_ms * MS)
        if picture.is_steady(now_ms * MS):
            steady_at.append(now_ms)
    assert steady_at[0] == 1000
    assert 1980 + 150 in steady_at and not any(2140 <= at <= 3180 for at in steady_at) and 3250 in steady_at


def test_dead_reckoning_of_a_steady_circle_agrees_with_geometry() -> None:
    angle, speed = 0.2, 5.0
    pose = reckoned(Pose(0.0, 0.0, 0.0), speed, 0.0, [(0.0, angle), (3.0, angle)], 1.5, 2.7)
    radius = 2.7 / 0.20271  # tan 0.2
    turned = speed * 1.5 / radius
    assert abs(pose.x_m - radius * sin(turned)) < 0.02 and abs(pose.y_m - radius * (1 - cos(turned))) < 0.02
    assert abs(pose.heading_rad - turned) < 1e-3


def test_dead_reckoning_uses_what_was_steered_when_it_was_steered() -> None:
    straight_then_left = [(0.0, 0.3), (0.5, 0.3), (0.52, 0.0), (2.0, 0.0)]
    pose = reckoned(Pose(0.0, 0.0, 0.0), 4.0, 0.0, straight_then_left, 1.5, 2.7)
    expected = 4.0 * 0.30934 / 2.7 * 0.5  # tan 0.3, for the last half second only
    assert abs(pose.heading_rad - expected) < 0.05


OWN_M, HALF_M, WAY = -1.75, 0.88, WaySettings()


@given(first=st.floats(20, 60), length=st.floats(0, 30), start=st.floats(0, 10))
def test_beside_everything_that_blocks_the_way_lies_in_the_oncoming_lane_and_it_changes_smoothly(
    first: float, length: float, start: float
) -> None:
    things = [Standing(first, -1.0, 0.3), Standing(first + length, -1.75, 0.3)]
    way = updated(None, things, start, OWN_M, OWN_M, HALF_M, WAY)
    assert way is not None and way.begin_m >= start
    path = [side_at(way, station / 4, OWN_M, -OWN_M) for station in range(600)]
    assert all(side == -OWN_M for station, side in enumerate(path) if first <= station / 4 <= first + length + 0.9)
    assert max(abs(b - a) for a, b in zip(path, path[1:], strict=False)) <= 3.5 * 3.1416 / 2 / 9.0 / 4 + 1e-9
    assert path[0] == path[-1] == OWN_M
    assert way.begin_m <= max(first - 14.0, start) and way.home_m >= first + length + 4.5 + 5.0


def test_what_stands_on_the_sidewalk_or_at_the_far_kerb_blocks_nothing() -> None:
    assert blockers([Standing(10, -4.6, 0.3), Standing(10, 3.2, 0.3)], OWN_M, HALF_M, WAY) == []


@given(jitter=st.lists(st.floats(-0.05, 0.05), max_size=20))
def test_a_car_that_stands_beside_what_blocks_goes_on_in_the_oncoming_lane_however_its_place_trembles(jitter: list[float]) -> None:
    barrier = Standing(168.0, -0.66, 0.4)
    way = None
    for error in [0.0, *jitter]:
        station = 161.4 + error
        way = updated(way, [barrier], station, 1.73, OWN_M, HALF_M, WAY)
        assert all(abs(side_at(way, station + ahead, OWN_M, -OWN_M) - 1.74) < 0.02 for ahead in (0.0, 2.6, 5.0, 8.0))


def test_a_car_across_the_road_goes_home_behind_the_cones_that_line_the_site() -> None:
    cones = [Standing(100.0 + k, -0.1, 0.2) for k in (-6, -3, 2, 5)]  # at the edge of the own lane: they block nothing in it
    assert blockers(cones, OWN_M, HALF_M, WAY) == []
    way = updated(None, cones, 100.0, 1.75, OWN_M, HALF_M, WAY)
    assert way is not None and way.back_m == 108.0
    assert all(side_at(way, 100.0 + ahead, OWN_M, -OWN_M) == 1.75 for ahead in range(8))
    assert side_at(way, way.home_m, OWN_M, -OWN_M) == OWN_M
    at_once = updated(None, [], 100.0, 1.75, OWN_M, HALF_M, WAY)
    assert at_once is not None and at_once.back_m == 100.0
    assert updated(None, [], 100.0, -1.0, OWN_M, HALF_M, WAY) is None


def test_the_way_back_waits_for_what_is_seen_late_and_begins_anew_when_something_stands_beyond_it() -> None:
    way = updated(None, [Standing(40, -1.75, 0.3)], 20.0, OWN_M, OWN_M, HALF_M, WAY)
    later = updated(way, [Standing(40, -1.75, 0.3), Standing(55, -1.75, 0.3)], 38.0, 1.75, OWN_M, HALF_M, WAY)
    assert later is not None and later.back_m >= 58.0 and later.begin_m == way.begin_m if way is not None else False
    again = updated(later, [Standing(55, -1.75, 0.3), Standing(80, -1.75, 0.3)], 62.0, 1.0, OWN_M, HALF_M, WAY)
    assert again is not None and again.from_side_m == 1.0 and again.back_m >= 83.0
    assert updated(again, [], 200.0, OWN_M, OWN_M, HALF_M, WAY) is None
