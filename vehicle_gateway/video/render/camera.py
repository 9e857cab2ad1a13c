"""The simulated camera: one picture of one state of the world.

Draws sky, ground, then everything that stands, far to near, then the car's own bonnet. Deterministic: the same scenario and
the same state give the same picture, bit for bit. Never reads a clock or a file. Not modelled: lens distortion, motion blur,
exposure, rain, night, other traffic, what the mirrors show.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from vehicle_gateway.simulation.site import StaticObject, site_objects
from vehicle_gateway.video.render.blocks import Blocks
from vehicle_gateway.video.render.bonnet import Bonnet
from vehicle_gateway.video.render.brush import SHIFT, fixed
from vehicle_gateway.video.render.cutouts import Cutout, barrier_cutout, sign_cutout
from vehicle_gateway.video.render.ground import Ground, Hidden
from vehicle_gateway.video.render.order import CELL_PX, Cover, Wall, far_to_near, seen, slots
from vehicle_gateway.video.render.paving import pave
from vehicle_gateway.video.render.people import Figure, dress, figures
from vehicle_gateway.video.render.perspective import Box
from vehicle_gateway.video.render.projection import Floats, Numbers, Picture, View, view_of
from vehicle_gateway.video.render.road_frame import RoadFrame
from vehicle_gateway.video.render.scenery import AFTER_M, BEFORE_M, plant
from vehicle_gateway.video.render.shadows import cast
from vehicle_gateway.video.render.sheet import Reduced, Sheet
from vehicle_gateway.video.render.sky import Sky
from vehicle_gateway.video.render.street import Cones, Lamps
from vehicle_gateway.video.render.trees import Trees
from wire.messages.sensing import WorldState
from wire.messages.vehicle import CameraCalibration, VehicleDescription
from wire.road import Road
from wire.scenario import Scenario

SIGN_BEFORE_SITE_M, SIGN_BEHIND_KERB_M = 22.0, 0.6
# half width, shadow included, and height: generous, only to ask whether a wall covers the thing
LAMP_SIZE_M, CONE_SIZE_M, CUTOUT_SIZE_M, PERSON_SIZE_M = (2.0, 6.6), (0.4, 0.9), (2.0, 2.6), (2.2, 2.1)
VERGE_M = 0.5  # of fine ground beyond the sidewalk


class Scene:
    """All that stands and lies in one scenario, painted once (about a second, some 400 MB) for all cameras of a car.

    Its parts remember the view they were looked at last: cameras that share a scene must not render at the same time.
    """

    def __init__(self, scenario: Scenario, road: Road) -> None:
        scenery = plant(scenario, road)
        objects = site_objects(scenario, road)
        sheet = Sheet(-BEFORE_M, road.length_m + AFTER_M, road.half_width_m + road.map.sidewalk_width_m + VERGE_M)
        texture = pave(sheet, road, scenario.seed)
        cast(texture, sheet, road, scenario, scenery, objects, scenario.seed)
        self.road = road
        self.ground = Ground(sheet, Reduced(texture), RoadFrame(road))
        self.sky = Sky(scenario.seed)
        self.blocks = Blocks(scenario, road, scenery)
        self.trees = Trees(scenery.trees, scenario.seed)
        self.lamps = Lamps(scenery.lamps)
        self.cones = Cones([thing for thing in objects if thing.kind == "cone"])
        self.cutouts = _cutouts(objects, scenario, road)
        self.cutouts_m = np.array([(cutout.x_m, cutout.y_m, 0.0) for cutout in self.cutouts]).reshape(-1, 3)
        self.looks = dress(max(1, len(scenario.people)), scenario.seed)


class SimulatedCamera:
    """Set up once, then `render` per picture. Not safe for two threads at once."""

    def __init__(self, calibration: CameraCalibration, vehicle: VehicleDescription, scene: Scene) -> None:
        cv2.setNumThreads(1)  # the encoder needs the other core, and pictures this small gain nothing from more
        self._calibration = calibration
        self._road, self._ground, self._sky, self._blocks = scene.road, scene.ground, scene.sky, scene.blocks
        self._trees, self._lamps, self._cones = scene.trees, scene.lamps, scene.cones
        self._cutouts, self._cutouts_m, self._looks = scene.cutouts, scene.cutouts_m, scene.looks
        self._bonnet = Bonnet(calibration, vehicle)
        self._bonnet_from = self._bonnet.solid_from(CELL_PX)
        self._canvas: Picture = np.zeros((calibration.height_px, calibration.width_px, 4), np.uint8)

    def render(self, world: WorldState) -> Picture:
        """(height, width, 3) BGR."""
        return np.asarray(cv2.cvtColor(self._draw(world), cv2.COLOR_BGRA2BGR), np.uint8)

    def render_planar(self, world: WorldState, out: Picture) -> None:
        """Into `out`, (height * 3 / 2, width): planar YUV 4:2:0, BT.601, limited range. One pass less than by way of BGR."""
        cv2.cvtColor(self._draw(world), cv2.COLOR_BGRA2YUV_I420, dst=out)

    def _draw(self, world: WorldState) -> Picture:
        """The canvas, drawn for the state as it is; nothing is remembered between."""
        view = view_of(self._calibration, world.car, world.pitch_rad, world.roll_rad)
        station = self._road.to_road(world.car.x_m, world.car.y_m).station_m
        items = self._items(view, world)
        shown, cover = seen([item.box for item in items], [item.covers_px for item in items], view.width_px, view.height_px)
        self._backdrop(view, station, cover)
        for item, is_shown in zip(items, shown, strict=True):
            if is_shown:
                item.draw()
        self._bonnet.draw(self._canvas)
        return self._canvas

    def _backdrop(self, view: View, station_m: float, cover: Cover) -> None:
        """Sky down to the horizon, ground from there on; where a lean tilts the horizon, first one and then the other."""
        left, right = _horizon_rows(view)
        end = self._bonnet.hides_from_row
        top, bottom = _clamped(round(min(left, right)), end), _clamped(round(max(left, right)), end)
        self._ground.draw(self._canvas, view, station_m, (top, end), Hidden(CELL_PX, np.array(cover.ground_gap), self._bonnet_from))
        tilted = self._canvas[top:bottom].copy()
        self._sky.draw(self._canvas, view, bottom, cover.sky_to)
        if bottom > top:
            below = np.array([[0, left], [view.width_px, right], [view.width_px, 1e5], [0, 1e5]]) - (0, top)
            mask = np.zeros(tilted.shape[:2], np.uint8)
            cv2.fillPoly(mask, [fixed(below)], (255,), cv2.LINE_8, SHIFT)
            cv2.copyTo(tilted, mask, self._canvas[top:bottom])

    def _items(self, view: View, world: WorldState) -> list["_Item"]:
        """Everything upright, far to near."""
        eye = view.position_m[:2]
        jobs = self._blocks.look(view)
        blocks = far_to_near(self._blocks.footprints_m, list(jobs), eye)
        small, places = self._small(view, world)
        before = slots(blocks, self._blocks.footprints_m, places, eye)
        order = np.lexsort((-np.hypot(*(places - eye).T), before)).tolist()
        slot_of = before.tolist()
        items, at = [], 0
        for slot in range(len(blocks) + 1):
            while at < len(order) and slot_of[order[at]] == slot:
                items.append(small[order[at]])
                at += 1
            if slot < len(blocks):
                items += [_Item(partial(job.draw, self._canvas), job.box, job.covers_px) for job in jobs[blocks[slot]]]
                if self._blocks.has_roof(view, blocks[slot]):
                    items.append(_Item(partial(self._blocks.draw_roof, self._canvas, view, blocks[slot])))
        return items

    def _small(self, view: View, world: WorldState) -> tuple[list["_Item"], Floats]:
        """Everything that stands on one spot, and those spots (N, 2)."""
        canvas = self._canvas
        trees, lamps, cones = self._trees.look(view), _ahead(view, self._lamps.feet_m), _ahead(view, self._cones.feet_m)
        self._lamps.look(view, lamps)
        self._cones.look(view, cones)
        people_m = np.array([(person.x_m, person.y_m, 0.0) for person in world.people]).reshape(-1, 3)
        people, cutouts = _ahead(view, people_m), _ahead(view, self._cutouts_m, -CUTOUT_SIZE_M[0])
        groups = (
            (lamps, self._lamps.feet_m, LAMP_SIZE_M),
            (cones, self._cones.feet_m, CONE_SIZE_M),
            (cutouts, self._cutouts_m, CUTOUT_SIZE_M),
            (people, people_m, PERSON_SIZE_M),
        )
        feet = np.concatenate([places[numbers] for numbers, places, _ in groups])
        sizes = np.concatenate([np.broadcast_to(size, (len(numbers), 2)) for numbers, _, size in groups])
        draws = [partial(self._lamps.draw, canvas, i) for i in lamps.tolist()]
        draws += [partial(self._cones.draw, canvas, i) for i in cones.tolist()]
        draws += [partial(self._cutouts[i].draw, canvas, view, world.stamp_ns) for i in cutouts.tolist()]
        draws += [partial(figure.draw, canvas) for figure in self._figures(view, world, people)]
        items = [_Item(partial(self._trees.draw, canvas, i), self._trees.box(i)) for i in trees.tolist()]
        items += [_Item(draw, box) for draw, box in zip(draws, _boxes(view, feet, sizes), strict=True)]
        return items, np.concatenate((self._trees.feet_m[trees], feet))[:, :2]

    def _figures(self, view: View, world: WorldState, numbers: Numbers) -> list[Figure]:
        named = numbers.tolist()
        return figures(view, [world.people[i] for i in named], [self._looks[i % len(self._looks)] for i in named])


@dataclass(slots=True)  # not frozen: made a hundred times a picture, and a frozen one takes three times as long to make
class _Item:
    draw: Callable[[], None]
    box: Box | None = None  # where it lies, when it is worth asking whether walls cover it
    covers_px: Wall | None = None


def _cutouts(objects: tuple[StaticObject, ...], scenario: Scenario, road: Road) -> list[Cutout]:
    """Barriers, and the sign ahead of them on the own side."""
    cutouts = [barrier_cutout(thing, road.own_side < 0) for thing in objects if thing.kind == "barrier"]
    if scenario.site is not None:
        station = scenario.site.station_m - scenario.site.taper_m - SIGN_BEFORE_SITE_M
        cutouts.append(sign_cutout(*road.to_world(station, road.own_side * (road.half_width_m + SIGN_BEHIND_KERB_M))))
    return cutouts


def _ahead(view: View, places_m: Floats, nearest_m: float = 0.1) -> Numbers:
    """Numbers of the places (N, 3) in front of the camera and not far outside its angle of view."""
    camera = view.to_camera(places_m)
    wide = np.maximum(camera[:, 2], 0.0) * (view.width_px / 2 / view.focal_px) + 2.5
    return np.flatnonzero((camera[:, 2] > nearest_m) & (np.abs(camera[:, 0]) < wide))


def _boxes(view: View, feet_m: Floats, sizes_m: Floats) -> list[Box | None]:
    """Where things of a half width and a height (N, 2) lie in the picture, generously; None for one beside the camera."""
    camera = view.to_camera(feet_m)
    depth = camera[:, 2]
    beside = depth < sizes_m[:, 0]
    scale = view.focal_px / np.where(beside, 1.0, depth - 0.5 * sizes_m[:, 0])  # at its near side
    u, v = view.to_pixels(np.where(beside[:, None], (0.0, 0.0, 1.0), camera)).T
    wide, tall = sizes_m[:, 0] * scale, sizes_m[:, 1] * scale
    corners = np.stack((np.clip(u - wide, 0, view.width_px), v - tall, np.clip(u + wide, 0, view.width_px), v), axis=1)
    return [
        None if near else (x0, y0, x1 + 1, y1)
        for near, (x0, y0, x1, y1) in zip(beside.tolist(), corners.astype(np.int64).tolist(), strict=True)
    ]


def _horizon_rows(view: View) -> tuple[float, float]:
    """Row of the horizon at the left and at the right edge of the picture."""
    right, down, forward = (float(axis[2]) for axis in view.axes)
    cx, cy = view.centre_px
    rows = [cy - view.focal_px * (forward + right * u / view.focal_px) / min(down, -1e-6) for u in (-cx, cx)]
    return rows[0], rows[1]


def _clamped(row: float, most: int) -> int:
    return int(min(max(row, 0), most))
