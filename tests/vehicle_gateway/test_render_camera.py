"""Whole pictures: what is found in them lies where plain pinhole formulas put it, and odd places are survived."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import cos, pi, sin

import cv2
import msgspec
import numpy as np
import pytest

from tests.messages import vehicle_description
from vehicle_gateway.simulation.site import object_corners, site_objects
from vehicle_gateway.video.render.camera import Scene as PaintedScene
from vehicle_gateway.video.render.camera import SimulatedCamera
from vehicle_gateway.video.render.paving import DASH_M, GAP_M
from vehicle_gateway.video.render.projection import project
from wire.messages.automation import RoadMap, RoadSegment
from wire.messages.base import Indicators
from wire.messages.sensing import MovingPerson, Pose, WorldState
from wire.messages.vehicle import CameraCalibration
from wire.road import Road
from wire.scenario import Building, Scenario, Site, Start

FRONT = CameraCalibration(
    name="front",
    required=True,
    width_px=1280,
    height_px=720,
    frame_rate_hz=30.0,
    focal_length_px=760.0,
    x_m=1.7,
    y_m=0.0,
    z_m=1.35,
    yaw_rad=0.0,
    pitch_rad=0.06,
)
SMALL = msgspec.structs.replace(FRONT, width_px=640, height_px=360, focal_length_px=380.0)
TURNED = msgspec.structs.replace(FRONT, yaw_rad=-0.25, y_m=0.3, pitch_rad=0.1)
CAR = vehicle_description()
STRAIGHT, BEND = (RoadSegment(length_m=60.0),), (RoadSegment(length_m=15.0), RoadSegment(length_m=45.0, curvature_1_m=0.0222))
SITE = Site(station_m=20.0, length_m=12.0, cone_spacing_m=5.0, taper_m=10.0)
PAST_SITE_M = 36.0  # a station from which nothing of the site is ahead


@dataclass(frozen=True)
class Scene:
    calibration: CameraCalibration = FRONT
    segments: tuple[RoadSegment, ...] = STRAIGHT
    drives_on: str = "right"
    site: Site | None = SITE
    buildings: tuple[Building, ...] = ()
    seed: int = 7

    @property
    def road(self) -> Road:
        return Road(
            RoadMap(
                name="t",
                start=(5.0, -3.0),
                start_heading_rad=0.4,
                segments=self.segments,
                lane_width_m=3.5,
                sidewalk_width_m=2.5,
                drives_on=self.drives_on,
                speed_limit_m_s=7.0,
                goal_station_m=50.0,
            )
        )

    @property
    def scenario(self) -> Scenario:
        return Scenario(
            name="t",
            map="t.toml",
            seed=self.seed,
            time_limit_s=60.0,
            start=Start(station_m=0.0),
            site=self.site,
            buildings=self.buildings,
        )


@lru_cache(maxsize=12)
def camera_of(scene: Scene) -> SimulatedCamera:
    return SimulatedCamera(scene.calibration, CAR, PaintedScene(scene.scenario, scene.road))


def pose_at(road: Road, station: float, offset: float, turn: float = 0.0) -> Pose:
    x, y, heading = road.to_world(station, offset)
    return Pose(x_m=x, y_m=y, heading_rad=heading + turn)


def world(pose: Pose, people: tuple[MovingPerson, ...] = (), pitch: float = 0.0, roll: float = 0.0) -> WorldState:
    return WorldState(
        stamp_ns=0,
        car=pose,
        speed_m_s=5.0,
        road_wheel_angle_rad=0.0,
        pitch_rad=pitch,
        roll_rad=roll,
        indicators=Indicators.OFF,
        hazard=False,
        brake_lights=False,
        people=people,
    )


def person_at(x: float, y: float, heading: float = 0.0) -> MovingPerson:
    return MovingPerson(x_m=x, y_m=y, heading_rad=heading, speed_m_s=1.3, phase=0.2)


def pinhole(camera: CameraCalibration, pose: Pose, x: float, y: float, z: float) -> tuple[float, float, float]:
    """u, v, depth of a point of the map frame for a level car."""
    dx, dy = x - pose.x_m, y - pose.y_m
    ahead = dx * cos(pose.heading_rad) + dy * sin(pose.heading_rad) - camera.x_m
    left = dy * cos(pose.heading_rad) - dx * sin(pose.heading_rad) - camera.y_m
    c, s = cos(camera.yaw_rad), sin(camera.yaw_rad)
    ahead, left = ahead * c + left * s, left * c - ahead * s
    up = z - camera.z_m
    c, s = cos(camera.pitch_rad), sin(camera.pitch_rad)
    depth, above = ahead * c - up * s, up * c + ahead * s
    return (
        camera.width_px / 2 - camera.focal_length_px * left / depth,
        camera.height_px / 2 - camera.focal_length_px * above / depth,
        depth,
    )


SCENES = (
    Scene(),
    Scene(segments=BEND),
    Scene(segments=BEND, drives_on="left"),
    Scene(calibration=SMALL),
    Scene(calibration=TURNED),
)
NAMES = ("straight", "bend", "mirrored", "640x360", "turned")


# --- cones

Box = tuple[float, float, float, float]  # left, top, right, bottom in pixels


def cone_boxes(scene: Scene, pose: Pose) -> Iterator[tuple[Box, bool]]:
    """Left, top, right, bottom of every cone in the picture; and whether nothing else red or orange is near it."""
    boxes = []
    for thing in site_objects(scene.scenario, scene.road):
        corners = [pinhole(scene.calibration, pose, x, y, 0.0) for x, y in object_corners(thing)]
        top = pinhole(scene.calibration, pose, thing.x_m, thing.y_m, thing.height_m + (0.9 if thing.kind == "barrier" else 0.0))
        if min(depth for _, _, depth in corners) > 1.0:
            u, v = [corner[0] for corner in corners], [corner[1] for corner in corners]
            boxes.append((thing.kind, (min(u), top[1], max(u), max(v))))
    for i, (kind, box) in enumerate(boxes):
        inside = box[0] > 8 and box[2] < scene.calibration.width_px - 8 and box[3] < scene.calibration.height_px * 0.78
        alone = all(
            k == i or box[2] + 8 < other[0] or other[2] + 8 < box[0] or box[3] + 8 < other[1] or other[3] + 8 < box[1]
            for k, (_, other) in enumerate(boxes)
        )
        if kind == "cone" and inside:
            yield box, alone


def orange_box(picture: np.ndarray, around: Box) -> Box:
    """Extent of what is orange or red within 7 pixels of a box; an edge pixel that is half covered counts half."""
    x0, y0 = round(around[0]) - 7, round(around[1]) - 7
    part = picture[max(0, y0) : round(around[3]) + 7, max(0, x0) : round(around[2]) + 7].astype(int)
    rows, columns = np.nonzero(part[..., 2] - np.maximum(part[..., 0], part[..., 1]) > 45)
    return columns.min() + max(0, x0), rows.min() + max(0, y0), columns.max() + 1 + max(0, x0), rows.max() + 1 + max(0, y0)


@pytest.mark.parametrize("scene", SCENES, ids=NAMES)
def test_cones_stand_where_the_pinhole_model_puts_them(scene: Scene) -> None:
    found = 0
    for station, offset in ((-2.0, 2.5), (2.0, 0.5), (5.0, 3.0), (8.0, 1.0), (12.0, 1.75), (15.0, 4.0), (18.0, 2.5)):
        pose = pose_at(scene.road, station, -scene.road.own_side * offset)
        picture = camera_of(scene).render(world(pose))
        for expected, alone in cone_boxes(scene, pose):
            if alone:
                assert orange_box(picture, expected) == pytest.approx(expected, abs=2.0)
                found += 1
    assert found >= 2


def test_a_site_behind_the_car_draws_nothing_orange() -> None:
    scene = Scene()
    picture = camera_of(scene).render(world(pose_at(scene.road, PAST_SITE_M, -1.75))).astype(int)
    assert not ((picture[..., 2] > 200) & (picture[..., 1] < 130) & (picture[..., 0] < 70)).any()


# --- lane markings


def sampled(grey: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Between the middles of the four pixels around; the middle of the first pixel is (0.5, 0.5)."""
    x, y = u - 0.5, v - 0.5
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    a, b = x - i, y - j
    low, high = grey[j, i] * (1 - a) + grey[j, i + 1] * a, grey[j + 1, i] * (1 - a) + grey[j + 1, i + 1] * a
    return np.asarray(low * (1 - b) + high * b)


def beside_the_line(grey: np.ndarray, at: tuple[float, float], along: tuple[float, float], half_px: float) -> float:
    """How far, in pixels and square to the line, the middle of the bright run lies from where it should."""
    length = float(np.hypot(*along))
    steps = np.arange(-half_px, half_px + 0.01, 0.2)
    profile = sampled(grey, at[0] - along[1] / length * steps, at[1] + along[0] / length * steps)
    asphalt = float(np.median(profile))  # the line is a third of the way walked
    painted = np.flatnonzero(profile > asphalt + 0.35 * (profile.max() - asphalt))  # also where the paint is worn
    return float(steps[painted[0]] + steps[painted[-1]]) / 2


@pytest.mark.parametrize("scene", SCENES, ids=NAMES)
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_edge_lines_lie_where_the_pinhole_model_puts_them(scene: Scene, side: float) -> None:
    road, camera = scene.road, scene.calibration
    pose = pose_at(road, PAST_SITE_M, road.own_lane_offset_m)
    grey = camera_of(scene).render(world(pose)).astype(float).mean(axis=2)
    found = 0
    for station in np.arange(PAST_SITE_M + 5.0, PAST_SITE_M + 24.0, 0.5):
        (u, v, depth), (u_on, v_on, _), (u_out, v_out, _) = (
            pinhole(camera, pose, *road.to_world(float(station) + more, side * offset)[:2], 0.0)
            for more, offset in ((0.0, 3.21), (0.05, 3.21), (0.0, 3.39))
        )  # the kerb's light stone begins at 3.5
        along = (u_on - u, v_on - v)
        half = abs((u_out - u) * along[1] - (v_out - v) * along[0]) / float(np.hypot(*along))
        if depth > 1.0 and half > 2.5 and 30 < u < camera.width_px - 30 and v < camera.height_px * 0.75:
            assert beside_the_line(grey, (u, v), along, half) == pytest.approx(0.0, abs=min(2.0, half - 0.4))
            found += 1
    assert found >= 1 or camera.yaw_rad != 0.0


@pytest.mark.parametrize("scene", SCENES[:2], ids=NAMES[:2])
def test_a_dash_of_the_centre_line_begins_and_ends_where_the_pinhole_model_puts_it(scene: Scene) -> None:
    road = scene.road
    pose = pose_at(road, PAST_SITE_M + 1.0, road.own_lane_offset_m)
    picture = camera_of(scene).render(world(pose)).astype(float).mean(axis=2)
    for first in (5 * (DASH_M + GAP_M), 6 * (DASH_M + GAP_M)):
        stations = np.arange(first - 1.0, first + DASH_M + 1.0, 0.02)
        pixels = [pinhole(scene.calibration, pose, *road.to_world(float(s))[:2], 0.0)[:2] for s in stations]
        light = np.array([picture[int(v), int(u)] for u, v in pixels])
        lit = np.flatnonzero(light > (light.min() + light.max()) / 2)
        for found, expected in ((lit[0], first), (lit[-1], first + DASH_M)):
            true_v = pinhole(scene.calibration, pose, *road.to_world(expected)[:2], 0.0)[1]
            assert pixels[found][1] == pytest.approx(true_v, abs=2.0)


def test_the_edge_of_a_line_is_smooth_not_a_step() -> None:
    scene = Scene()
    pose = pose_at(scene.road, PAST_SITE_M, -1.75)
    picture = camera_of(scene).render(world(pose)).astype(float).mean(axis=2)
    between = 0
    for station in (45.0, 47.0, 49.0, 51.0, 53.0):
        u, v, _ = pinhole(FRONT, pose, *scene.road.to_world(station, -3.21)[:2], 0.0)
        row = picture[int(v), int(u) - 20 : int(u) + 20]
        dark, bright = np.percentile(row, 30), row.max()
        between += int(((row > dark + 0.2 * (bright - dark)) & (row < dark + 0.8 * (bright - dark))).sum())
    assert between >= 8  # of ten edges


def test_what_is_far_does_not_flicker_when_the_car_moves_five_centimetres() -> None:
    """From 25 to 110 m ahead joints, cracks and line ends are finer than a pixel: read without prefiltering they jump."""
    scene = Scene()
    rows = np.arange(323, 356)
    metres_per_px = FRONT.z_m / (rows + 0.5 - (360 - 760 * np.tan(0.06)))  # of road across, in a row
    across = (np.arange(1280) + 0.5 - 640) * metres_per_px[:, None]
    on_road = (across > -1.6) & (across < 5.0)  # the car stands at -1.75 m
    steps = []
    before = None
    for i in range(12):
        picture = camera_of(scene).render(world(pose_at(scene.road, PAST_SITE_M + 0.05 * i, -1.75)))[rows].astype(float)
        if before is not None:
            steps.append(np.abs(picture - before).max(axis=2)[on_road])
        before = picture
    assert np.mean(steps) < 1.5
    assert np.percentile(steps, 99) < 14.0


# --- people and walls


def test_a_person_crossing_changes_the_picture_exactly_where_the_person_is() -> None:
    scene = Scene()
    pose = pose_at(scene.road, PAST_SITE_M, -1.75)
    x, y, _ = scene.road.to_world(50.0, -1.0)
    empty = camera_of(scene).render(world(pose)).astype(int)
    crossed = camera_of(scene).render(world(pose, (person_at(x, y, 1.9),))).astype(int)
    rows, columns = np.nonzero(np.abs(crossed - empty).max(axis=2) > 60)
    u, foot, _ = pinhole(FRONT, pose, x, y, 0.0)
    _, head, _ = pinhole(FRONT, pose, x, y, 1.75)
    tall = foot - head
    assert rows.max() == pytest.approx(foot, abs=0.06 * tall + 2) and rows.min() == pytest.approx(head, abs=0.1 * tall)
    assert columns.min() > u - 0.5 * tall and columns.max() < u + 0.5 * tall


def test_people_computed_together_look_as_each_does_alone() -> None:
    scene = Scene()
    pose = pose_at(scene.road, PAST_SITE_M, -1.75)
    near, far = (person_at(*scene.road.to_world(station, offset)[:2], 1.9) for station, offset in ((46.0, -2.0), (58.0, 3.0)))
    empty, first, second, both = (camera_of(scene).render(world(pose, people)) for people in ((), (near,), (far,), (near, far)))
    changed = [(picture != empty).any(axis=2) for picture in (first, second)]
    assert changed[0].any() and changed[1].any() and not (changed[0] & changed[1]).any()
    assert np.array_equal(both, np.where(changed[1][..., None], second, first))


def test_a_person_behind_the_car_is_not_in_the_picture() -> None:
    scene = Scene()
    pose = pose_at(scene.road, PAST_SITE_M, -1.75)
    x, y, heading = scene.road.to_world(28.0, -1.75)
    with_person = camera_of(scene).render(world(pose, (person_at(x, y, heading),)))
    assert np.array_equal(with_person, camera_of(scene).render(world(pose)))


HOUSE = Building(station_m=30.0, offset_m=8.0, length_m=20.0, depth_m=8.0, height_m=12.0)


def test_a_house_hides_who_stands_behind_it_and_not_who_stands_before_it() -> None:
    scene = Scene(buildings=(HOUSE,))
    pose = pose_at(scene.road, 10.0, 1.75)
    empty = camera_of(scene).render(world(pose))
    behind, before = ((person_at(*scene.road.to_world(33.0, offset)[:2]),) for offset in (12.0, 5.0))
    assert np.array_equal(camera_of(scene).render(world(pose, behind)), empty)
    assert not np.array_equal(camera_of(scene).render(world(pose, before)), empty)


def test_a_wall_that_passes_the_camera_fills_its_side_of_the_picture_to_the_edge() -> None:
    scene = Scene(buildings=(HOUSE,))
    pose = pose_at(scene.road, 26.0, 5.0)  # the wall runs past the camera, three metres to its left
    picture = camera_of(scene).render(world(pose)).astype(int)
    column = picture[:250, 4]
    assert (column[:, 0] < column[:, 2] + 60).all()  # no blue of the sky
    _, foot, _ = pinhole(FRONT, pose, *scene.road.to_world(33.0, 8.0)[:2], 0.0)
    assert foot < 720


# --- the whole


def test_the_same_state_gives_the_same_picture_also_from_a_second_camera() -> None:
    scene = Scene()
    state = world(pose_at(scene.road, 12.0, -1.75), (person_at(*scene.road.to_world(22.0, 4.8)[:2]),))
    once, twice = camera_of(scene).render(state), camera_of(scene).render(state)
    other = SimulatedCamera(scene.calibration, CAR, PaintedScene(scene.scenario, scene.road)).render(state)
    assert np.array_equal(once, twice) and np.array_equal(once, other)


def test_nothing_of_the_picture_before_remains() -> None:
    """Parts that walls will cover are not painted: were one left uncovered, the picture before would show through."""
    camera = camera_of(Scene(buildings=(HOUSE,)))
    road = Scene().road
    white = world(pose_at(road, 30.0, 7.99, pi / 2))  # all wall
    for station, offset, turn, roll in (
        (2.0, -1.75, 0.0, 0.0),
        (8.0, 1.75, 0.1, 0.05),
        (20.0, 2.0, 0.3, -0.06),
        (27.0, 5.0, 0.0, 0.04),
    ):
        state = world(pose_at(road, station, offset, turn), roll=roll)
        first = camera.render(state)
        camera.render(white)
        assert np.array_equal(camera.render(state), first)


def test_another_seed_gives_another_street() -> None:
    state = world(pose_at(Scene().road, 12.0, -1.75))
    assert not np.array_equal(camera_of(Scene()).render(state), camera_of(Scene(seed=8)).render(state))


def test_a_moved_car_changes_the_picture() -> None:
    scene = Scene()
    here, there = (camera_of(scene).render(world(pose_at(scene.road, station, -1.75))) for station in (12.0, 12.05))
    assert (here != there).any(axis=2).mean() > 0.1


def test_the_planar_picture_is_the_same_picture() -> None:
    scene = Scene(calibration=SMALL)
    planar = np.zeros((540, 640), np.uint8)
    state = world(pose_at(scene.road, 12.0, -1.75))
    picture = camera_of(scene).render(state)
    camera_of(scene).render_planar(state, planar)
    back = cv2.cvtColor(planar, cv2.COLOR_YUV2BGR_I420)
    assert np.abs(back.astype(int) - picture).mean() < 3.0  # colour at half the resolution


def test_a_car_that_leans_and_dips_sees_the_lines_where_the_projection_puts_them() -> None:
    scene = Scene()
    pose, pitch, roll = pose_at(scene.road, PAST_SITE_M, 0.0), 0.02, 0.05
    grey = camera_of(scene).render(world(pose, pitch=pitch, roll=roll)).astype(float).mean(axis=2)
    for station in (43.0, 46.0, 49.0, 52.0):
        places = [
            (*scene.road.to_world(station + more, offset)[:2], 0.0)
            for side in (-1.0, 1.0)
            for more, offset in ((0.0, side * 3.21), (0.05, side * 3.21), (0.0, side * 3.39))
        ]
        pixels, _ = project(FRONT, pose, pitch, roll, places)  # held against plain formulas in test_render_projection
        for at, on, out in (pixels[:3], pixels[3:]):
            along = (float(on[0] - at[0]), float(on[1] - at[1]))
            half = abs((out[0] - at[0]) * along[1] - (out[1] - at[1]) * along[0]) / float(np.hypot(*along))
            assert beside_the_line(grey, (float(at[0]), float(at[1])), along, half) == pytest.approx(0.0, abs=min(2.0, half - 0.4))


ODD_PLACES = {
    "off the road": (20.0, 30.0, 1.0),
    "inside a house": (30.0, 12.0, 0.3),
    "against a wall": (30.0, 7.9, pi / 2),
    "across the road": (20.0, 0.0, pi / 2),
    "backwards": (20.0, 1.75, pi),
    "at the end": (60.0, -1.75, 0.0),
    "beyond the end": (185.0, -1.75, 0.0),
    "far away": (5000.0, 800.0, 2.0),
    "before the start": (-35.0, -1.75, 0.0),
}


@pytest.mark.parametrize("place", ODD_PLACES.values(), ids=ODD_PLACES.keys())
def test_wherever_the_car_gets_to_there_is_a_picture(place: tuple[float, float, float]) -> None:
    scene = Scene(buildings=(HOUSE,))
    picture = camera_of(scene).render(world(pose_at(scene.road, *place), pitch=0.03, roll=-0.04))
    assert picture.shape == (720, 1280, 3) and picture.std() > 3.0


@pytest.mark.parametrize("ahead", [-0.3, 0.0, 0.1, 0.3, 0.6, 1.0])
def test_a_person_right_before_the_camera_is_survived(ahead: float) -> None:
    scene = Scene()
    pose = pose_at(scene.road, PAST_SITE_M, -1.75)
    reach = FRONT.x_m + ahead
    person = person_at(pose.x_m + reach * cos(pose.heading_rad), pose.y_m + reach * sin(pose.heading_rad), 1.0)
    picture = camera_of(scene).render(world(pose, (person,)))
    changed = (picture != camera_of(scene).render(world(pose))).any(axis=2).mean()
    assert changed > 0.05 if ahead >= 0.3 else changed < 0.9


def test_cones_and_barrier_between_bumper_and_camera_are_survived() -> None:
    scene = Scene()
    for station in np.arange(10.0, 33.0, 0.7):
        picture = camera_of(scene).render(world(pose_at(scene.road, float(station), -1.0)))
        assert picture.std() > 3.0


def test_two_cameras_that_share_a_scene_see_what_each_would_see_alone() -> None:
    scene = Scene()
    left = msgspec.structs.replace(SMALL, name="left", yaw_rad=1.1)
    state = world(pose_at(scene.road, 12.0, -1.75))
    painted = PaintedScene(scene.scenario, scene.road)
    both = [SimulatedCamera(calibration, CAR, painted) for calibration in (SMALL, left)]
    together = [camera.render(state) for camera in (*both, both[0])]
    alone = SimulatedCamera(left, CAR, PaintedScene(scene.scenario, scene.road)).render(state)
    assert np.array_equal(together[1], alone)
    assert np.array_equal(together[0], together[2])
