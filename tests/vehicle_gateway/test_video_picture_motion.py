"""Does the picture move when the car does: never a false word over real pictures, and a frozen one is noticed through its noise."""

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import av
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.wire.test_rear_view import STATE
from vehicle_gateway.video.camera import CameraLoop
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.picture import Bytes, Picture, planar_frame, plane
from vehicle_gateway.video.picture_motion import (
    CHANGED_CELLS,
    LOOK_NS,
    STILL_M,
    STILL_NS,
    PictureMotion,
    cells,
    is_due,
    judge,
)
from vehicle_gateway.video.render.camera import Scene, SimulatedCamera
from vehicle_gateway.video.sender import Wishes
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.messages.automation import RoadMap, RoadSegment
from wire.messages.base import Indicators
from wire.messages.sensing import Pose, WorldState
from wire.messages.vehicle import CameraCalibration, VehicleDescription, VehicleState
from wire.road import Road
from wire.scenario import Scenario, Start

DASH_CAM = Path(__file__).resolve().parents[3] / "shared/data/udacity_lanelines/solidWhiteRight.mp4"
CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LOOK_S = LOOK_NS / 1e9
WIDE, HIGH = 640, 360
ROAD_M = 130.0
STRAIGHT = (RoadSegment(length_m=ROAD_M),)
BEND = (RoadSegment(length_m=20.0), RoadSegment(length_m=ROAD_M - 20.0, curvature_1_m=0.02))


@cache
def painted(segments: tuple[RoadSegment, ...]) -> tuple[Road, Scene]:
    """An empty road: nobody walks, nothing stands in the way."""
    road = Road(
        RoadMap(
            name="t",
            start=(0.0, 0.0),
            start_heading_rad=0.3,
            segments=segments,
            lane_width_m=3.5,
            sidewalk_width_m=2.5,
            drives_on="right",
            speed_limit_m_s=8.3,
            goal_station_m=ROAD_M - 5.0,
        )
    )
    return road, Scene(Scenario(name="t", map="t.toml", seed=5, time_limit_s=60.0, start=Start(station_m=0.0)), road)


def small(camera: CameraCalibration) -> CameraCalibration:
    focal_px = camera.focal_length_px * WIDE / camera.width_px
    return replace(camera, width_px=WIDE, height_px=HIGH, frame_rate_hz=20.0, focal_length_px=focal_px)


@cache
def camera_on(segments: tuple[RoadSegment, ...], number: int) -> SimulatedCamera:
    return SimulatedCamera(small(CAR.cameras[number]), CAR, painted(segments)[1])


@cache
def picture_at(segments: tuple[RoadSegment, ...], station_m: float, number: int = 0) -> Bytes:
    """(HIGH, WIDE) luma in the own lane."""
    x, y, heading = painted(segments)[0].to_world(station_m, -1.75)
    world = WorldState(
        stamp_ns=0,
        car=Pose(x_m=x, y_m=y, heading_rad=heading),
        speed_m_s=0.0,
        road_wheel_angle_rad=0.0,
        pitch_rad=0.0,
        roll_rad=0.0,
        indicators=Indicators.OFF,
        hazard=False,
        brake_lights=False,
        people=(),
    )
    planes = np.zeros((HIGH * 3 // 2, WIDE), np.uint8)
    camera_on(segments, number).render_planar(world, planes)
    return planes[:HIGH]


NOISE = np.random.default_rng(1).standard_normal((960 + 64, WIDE + 640), np.float32) * 4.0  # levels


def noisy(luma: Bytes, number: int) -> Bytes:
    """Of another place in the noise for each number."""
    down, along = number * 7 % 64, number * 13 % 320
    noise = NOISE[down : down + luma.shape[0], along : along + luma.shape[1]]
    return np.clip(luma + noise, 0, 255).astype(np.uint8)


def dimmed(luma: Bytes, light: float) -> Bytes:
    return (16 + (luma.astype(np.float32) - 16).clip(0) * light).astype(np.uint8)


class Watch:
    """Looks at pictures as the camera's loop does, at every fifth of a second."""

    def __init__(self) -> None:
        self.state, self.now_ns, self.looks = PictureMotion(), LOOK_NS, 0

    def see(self, luma: Bytes, speed_m_s: float | None) -> bool:
        self.now_ns += LOOK_NS
        self.looks += 1
        if is_due(self.state, speed_m_s, self.now_ns):
            self.state = judge(self.state, cells(noisy(luma, self.looks)), speed_m_s, self.now_ns)
        return self.state.still


@cache
def lived(light: float = 1.0) -> PictureMotion:
    """After 20 m of driving."""
    watch = Watch()
    for station_m in np.arange(5.0, 25.0, 0.8):
        assert not watch.see(dimmed(picture_at(STRAIGHT, round(float(station_m), 3)), light), 4.0)
    return watch.state


def after_driving(light: float = 1.0) -> Watch:
    watch = Watch()
    watch.state, watch.now_ns = lived(light), lived(light).looked_ns
    return watch


@pytest.mark.parametrize(
    ("segments", "number", "speed_m_s", "from_m", "to_m"),
    [
        (STRAIGHT, 0, 0.4, 5.0, 7.0),
        (STRAIGHT, 0, 1.5, 5.0, 15.0),
        (STRAIGHT, 0, 4.0, 5.0, 37.0),
        (STRAIGHT, 0, 8.3, 5.0, 80.0),
        (STRAIGHT, 0, -1.4, 15.0, 5.0),
        (BEND, 0, 4.0, 5.0, 37.0),
        (STRAIGHT, 1, 4.0, 5.0, 37.0),
        (STRAIGHT, 2, 8.3, 5.0, 80.0),
        (STRAIGHT, 3, 1.5, 5.0, 15.0),
    ],
)
@pytest.mark.parametrize("light", [1.0, 0.08])
def test_a_drive_along_an_empty_road_is_never_called_still(
    segments: tuple[RoadSegment, ...], number: int, speed_m_s: float, from_m: float, to_m: float, light: float
) -> None:
    watch = Watch()
    for station_m in np.arange(from_m, to_m, speed_m_s * LOOK_S):
        assert not watch.see(dimmed(picture_at(segments, round(float(station_m), 3), number), light), speed_m_s)


@pytest.mark.parametrize("speed_m_s", [0.5, 1.5, 4.0, 8.3, -1.4])
@pytest.mark.parametrize("light", [1.0, 0.25])
def test_a_frozen_road_behind_fresh_noise_is_noticed_after_five_metres_and_a_second(speed_m_s: float, light: float) -> None:
    watch = after_driving(light)
    frozen = dimmed(picture_at(STRAIGHT, 25.0), light)
    watch.see(frozen, speed_m_s)
    looks = next(number for number in range(1, 200) if watch.see(frozen, speed_m_s))
    assert looks == pytest.approx(max(np.ceil(STILL_M / abs(speed_m_s) / LOOK_S), STILL_NS / LOOK_NS), abs=1)


def test_it_stays_still_while_the_car_stands_until_the_picture_moves_again() -> None:
    watch = after_driving()
    frozen = picture_at(STRAIGHT, 25.0)
    assert [watch.see(frozen, 4.0) for _ in range(20)][-1]
    assert all(watch.see(frozen, 0.0) for _ in range(50))
    assert watch.see(np.clip(frozen + np.float32(9.0), 0, 255).astype(np.uint8), 0.0)  # a lighter picture is the same road
    assert not watch.see(picture_at(STRAIGHT, 41.0), 0.0)
    assert watch.state.times == 1


@pytest.mark.parametrize("speed_m_s", [0.0, 0.29, -0.29, None])
def test_a_car_that_stands_or_does_not_know_its_speed_has_no_still_picture(speed_m_s: float | None) -> None:
    watch = after_driving()
    assert not any(watch.see(picture_at(STRAIGHT, 25.0), speed_m_s) for _ in range(300))


def test_nothing_is_said_where_nothing_can_be_seen() -> None:
    watch = after_driving()
    night = dimmed(picture_at(STRAIGHT, 25.0), 0.02)
    assert not any(watch.see(night, 4.0) for _ in range(100))


def test_what_never_moved_does_not_count_a_bonnet_or_writing_in_a_dark_picture() -> None:
    """A quarter of the picture has strong edges that never moved; the rest goes dark."""
    writing = np.kron(np.random.default_rng(3).integers(20, 200, (HIGH // 40, WIDE // 10)), np.ones((10, 10))).astype(np.uint8)

    def with_writing(luma: Bytes) -> Bytes:
        marked = luma.copy()
        marked[-len(writing) :] = writing
        return marked

    watch = Watch()
    for station_m in np.arange(5.0, 25.0, 0.8):
        assert not watch.see(with_writing(picture_at(STRAIGHT, round(float(station_m), 3))), 4.0)
    dark = with_writing(dimmed(picture_at(STRAIGHT, 25.0), 0.02))
    assert not any(watch.see(dark, 4.0) for _ in range(100))


def test_a_camera_that_never_moved_since_the_start_is_not_judged() -> None:
    watch = Watch()
    assert not any(watch.see(picture_at(STRAIGHT, 25.0), 4.0) for _ in range(100))


@settings(max_examples=60)
@given(st.lists(st.tuples(st.booleans(), st.sampled_from([0.0, 0.2, 1.0, 5.0, 8.3]), st.integers(1, 30)), max_size=12))
def test_whatever_happens_no_picture_is_still_within_five_metres_and_a_second_of_its_last_change(
    story: list[tuple[bool, float, int]],
) -> None:
    """Two pictures of one road; the distance that counts is that of its looks, each for half a second at most."""
    pair = (cells(picture_at(STRAIGHT, 24.2)), cells(picture_at(STRAIGHT, 30.0)))
    watch, shown, known, since_m, since_s = after_driving(), 0, 0, 0.0, 0.0
    for changes, speed_m_s, looks in story:
        shown = 1 - shown if changes else shown
        for _ in range(looks):
            watch.now_ns += LOOK_NS
            gap_s = min((watch.now_ns - watch.state.looked_ns) / 1e9, 0.5)
            if is_due(watch.state, speed_m_s, watch.now_ns):
                watch.state = judge(watch.state, pair[shown], speed_m_s, watch.now_ns)
                moved_s = gap_s if speed_m_s > 0.3 else 0.0
                since_m, since_s = (0.0, 0.0) if shown != known else (since_m + moved_s * speed_m_s, since_s + moved_s)
                known = shown
            assert not watch.state.still or (since_m > STILL_M - 1e-6 and since_s > STILL_NS / 1e9 - 1e-6)


def clip() -> Iterator[Bytes]:
    with av.open(str(DASH_CAM)) as container:
        for frame in container.decode(video=0):
            yield plane(frame, 0).copy()


@pytest.mark.skipif(not DASH_CAM.is_file(), reason=f"{DASH_CAM} is not there")
def test_a_real_motorway_is_never_called_still_and_its_last_picture_behind_noise_is() -> None:
    pictures = list(clip())[::5]  # 25 a second
    for light in (1.0, 0.25, 0.1):
        watch = Watch()
        assert not any(watch.see(dimmed(picture, light), 25.0) for picture in pictures)
    watch = Watch()
    for picture in pictures:
        watch.see(picture, 25.0)
    assert [watch.see(pictures[-1], 25.0) for _ in range(6)][-1]


@pytest.mark.skipif(not DASH_CAM.is_file(), reason=f"{DASH_CAM} is not there")
def test_a_25th_of_a_second_on_a_real_motorway_changes_six_times_as_many_cells_as_are_asked_for():
    pictures = list(clip())
    pairs = list(zip(pictures[::20], pictures[1::20], strict=False))
    assert min(changed(before, after) for before, after in pairs) > 6 * CHANGED_CELLS
    looks = zip(pictures[::20], pictures[5::20], strict=False)
    assert min(changed(dimmed(before, 0.5), dimmed(after, 0.5)) for before, after in looks) > 6 * CHANGED_CELLS


@pytest.mark.parametrize("number", range(4))
def test_a_tenth_of_a_metre_changes_four_times_as_many_cells_as_are_asked_for(number: int) -> None:
    for station_m in (5.0, 21.0, 37.0, 61.8):
        before, after = (picture_at(STRAIGHT, at_m, number) for at_m in (station_m, round(station_m + 0.1, 3)))
        assert changed(before, after) > 4 * CHANGED_CELLS


@pytest.mark.parametrize(("rows", "columns", "levels"), [(720, 1280, 10.0), (HIGH, WIDE, 5.0)])
def test_white_noise_on_the_same_picture_changes_fewer_than_half_of_the_cells_that_are_asked_for(
    rows: int, columns: int, levels: float
) -> None:
    scale = rows // HIGH
    picture = np.kron(picture_at(STRAIGHT, 25.0), np.ones((scale, scale), np.uint8))
    draw = np.random.default_rng(2)
    for _ in range(3):
        two = [np.clip(picture + draw.normal(0.0, levels, (rows, columns)), 0, 255).astype(np.uint8) for _ in range(2)]
        assert changed(*two) < CHANGED_CELLS / 2


def changed(before: Bytes, after: Bytes) -> int:
    """Cells, by the definition alone."""
    difference = cells(after).astype(float) - cells(before)
    return int(((abs(difference) >= 5) & (abs(difference - np.median(difference)) >= 5)).sum())


class Camera:
    kind, is_camera, skipped, losses = "v4l2", True, 0, 0


def loop_on(source: object, speed_m_s: float | None) -> CameraLoop:
    camera = small(CAR.cameras[0])
    return CameraLoop(
        camera,
        source,  # type: ignore[arg-type]
        Encoder(camera, VideoSettings()),
        Clock(),
        lambda *_: None,
        speed_m_s=lambda now_ns: speed_m_s,
    )


def driven(loop: CameraLoop, stations_m: list[float], first_ns: int) -> int:
    """A picture of each station, five a second, fresh noise and stamps; when the last one was taken."""
    now_ns = first_ns
    for number, station_m in enumerate(stations_m):
        now_ns = first_ns + number * LOOK_NS
        planes = np.full((HIGH * 3 // 2, WIDE), 128, np.uint8)
        planes[:HIGH] = noisy(picture_at(STRAIGHT, station_m), now_ns // LOOK_NS)
        loop.step(Picture(planar_frame(planes), now_ns), now_ns)
    return now_ns


def test_a_still_picture_keeps_its_old_stamp_is_not_live_and_is_told_in_the_health() -> None:
    loop = loop_on(Camera(), 4.0)
    moving = [5.0 + 0.8 * number for number in range(10)]
    last_ns = driven(loop, moving, LOOK_NS)
    assert loop.status(last_ns, 1).newest_capture_ns == last_ns
    still_ns = driven(loop, [12.2] * 20, last_ns + LOOK_NS)
    status = loop.status(still_ns, 1)
    assert last_ns + 1.0e9 < status.newest_capture_ns < last_ns + 2.0e9
    assert not status.live
    assert loop.health("vehicle-gateway video", still_ns).dropped == {"picture stood still while the car moved": 1}
    again_ns = driven(loop, [40.0, 40.8], still_ns + LOOK_NS)
    assert loop.status(again_ns, 1).newest_capture_ns == again_ns


def test_a_file_is_not_compared_with_the_car() -> None:
    source = Camera()
    source.is_camera = False
    loop = loop_on(source, 4.0)
    last_ns = driven(loop, [5.0, 5.8, 6.6] + [7.4] * 20, LOOK_NS)
    assert loop.status(last_ns, 1).newest_capture_ns == last_ns


def test_the_speed_is_the_cars_own_and_unknown_when_its_feedback_is_old() -> None:
    heard: dict[str, Callable[[VehicleState, int], None]] = {}
    wishes = Wishes(SimpleNamespace(on=heard.__setitem__), lambda _: None)  # type: ignore[arg-type]
    assert wishes.speed_m_s(0) is None
    heard["vehicle_state"](replace(STATE, feedback_age_ms=50.0), 1_000_000_000)
    assert wishes.speed_m_s(1_150_000_000) == STATE.speed_m_s
    assert wishes.speed_m_s(1_150_000_001) is None
    heard["vehicle_state"](replace(STATE, feedback_age_ms=1e9), 2_000_000_000)
    assert wishes.speed_m_s(2_000_000_000) is None
