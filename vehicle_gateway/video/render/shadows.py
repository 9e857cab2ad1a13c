"""Shadows of everything that stands still, laid onto the sheet once: of buildings, hedges, trees, lamps, cones, barriers.

The sun is far and does not move. Shadows of people are drawn with them (render.people).
"""

from math import tan

import cv2
import numpy as np

from vehicle_gateway.simulation.site import StaticObject, building_corners, object_corners
from vehicle_gateway.video.render.projection import Floats, Picture
from vehicle_gateway.video.render.road_frame import RoadFrame
from vehicle_gateway.video.render.scenery import LAMP_HEIGHT_M, SUN_ELEVATION_RAD, Scenery, Tree, sun_direction
from vehicle_gateway.video.render.sheet import Sheet
from wire.road import Road
from wire.scenario import Scenario

FULL_SHADE = 108  # of 255 taken away in the middle of a shadow: the rest is light of the sky
CONTACT_M = 0.06  # by so much a contact shadow is larger than what stands on it
_POST_M = np.array([[-0.07, -0.07], [0.07, -0.07], [0.07, 0.07], [-0.07, 0.07]])
_LONGEST_EDGE_M = 1.5  # straight edges in the map are bent on the sheet: cut into pieces of this length


def shadow_offset_m(height_m: float) -> tuple[float, float]:
    """How far, in the map frame, the shadow of a point at this height falls from its foot."""
    x, y, _ = sun_direction()
    reach = height_m / tan(SUN_ELEVATION_RAD) / float(np.hypot(x, y))
    return -x * reach, -y * reach


def cast(
    texture: Picture, sheet: Sheet, road: Road, scenario: Scenario, scenery: Scenery, objects: tuple[StaticObject, ...], seed: int
) -> None:
    """Darken the painted sheet in place."""
    shade = np.zeros((sheet.rows, sheet.columns), np.uint8)
    frame = RoadFrame(road)
    random = np.random.default_rng(seed)
    far = [_swept(np.array(building_corners(house, road)), house.height_m) for house in scenario.buildings]
    far += [polygon for tree in scenery.trees for polygon in _tree(tree, random)]
    far += [_swept(_POST_M + (lamp.x_m, lamp.y_m), LAMP_HEIGHT_M) for lamp in scenery.lamps]
    _draw(shade, sheet, frame, far)
    shade = np.asarray(cv2.blur(shade, (9, 5)), dtype=np.uint8)
    _draw(shade, sheet, frame, [polygon for thing in objects for polygon in _thing(thing)])
    shade = np.asarray(cv2.blur(shade, (5, 3)), dtype=np.uint8)
    _fade_out(shade, sheet)
    light = np.asarray(cv2.LUT(shade, np.round(255 - np.arange(256) * (FULL_SHADE / 255)).astype(np.uint8)))
    blue = np.asarray(cv2.LUT(shade, np.round(255 - np.arange(256) * (FULL_SHADE * 0.86 / 255)).astype(np.uint8)))
    cv2.multiply(texture, cv2.merge([blue, light, light, np.full_like(light, 255)]), dst=texture, scale=1 / 255)


def _fade_out(shade: Picture, sheet: Sheet) -> None:
    """No shadow in the sheet's outermost columns: they stand for everything beyond."""
    for columns in (slice(0, 80), slice(sheet.columns - 80, sheet.columns)):
        near = sheet.offsets_m()[columns]
        keep = np.clip((sheet.offsets_m()[-1] - 0.5 - np.abs(near)) / 3.0, 0, 1)
        shade[:, columns] = (shade[:, columns] * keep).astype(np.uint8)


def _thing(thing: StaticObject) -> list[Floats]:
    corners = np.array(object_corners(thing))
    if thing.kind != "cone":
        return [_swept(corners, thing.height_m)]
    middle = corners.mean(axis=0)
    tip = np.array([[0.02, 0.0], [0.0, 0.02], [-0.02, 0.0]]) + middle + shadow_offset_m(thing.height_m)
    body = _hull(np.concatenate((middle + (corners - middle) * 0.6, tip)))
    return [body, middle + (corners - middle) * (1 + 2 * CONTACT_M / thing.length_m)]


def _tree(tree: Tree, random: np.random.Generator) -> list[Floats]:
    """A crown's shadow is a heap of discs around where its middle falls, and the trunk's a stroke towards it."""
    foot = np.array([tree.x_m, tree.y_m])
    middle = foot + shadow_offset_m(tree.height_m * 0.6)
    turn = np.linspace(0, 2 * np.pi, 9, endpoint=False)
    disc = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    heap = [
        middle + random.normal(0.0, tree.height_m * 0.11, 2) + disc * tree.height_m * random.uniform(0.08, 0.16) for _ in range(9)
    ]
    return [*heap, _hull(np.concatenate((foot + _POST_M, middle + _POST_M)))]


def _swept(corners_m: Floats, height_m: float) -> Floats:
    """The area between a footprint and its roof's shadow."""
    return _hull(np.concatenate((corners_m, corners_m + shadow_offset_m(height_m))))


def _hull(points_m: Floats) -> Floats:
    base = points_m.mean(axis=0)  # single precision is enough around it
    hull: Floats = cv2.convexHull((points_m - base).astype(np.float32))[:, 0].astype(np.float64) + base
    return hull


def _draw(shade: Picture, sheet: Sheet, frame: RoadFrame, polygons_m: list[Floats]) -> None:
    if not polygons_m:
        return
    outlines = [np.concatenate([_edge(a, b) for a, b in zip(p, np.roll(p, -1, axis=0), strict=True)]) for p in polygons_m]
    every = np.concatenate(outlines)
    station, offset = frame.to_road(every[:, 0], every[:, 1])
    texels = np.round(sheet.texels(station, offset) * 16).astype(np.int32)
    ends = np.cumsum([len(outline) for outline in outlines])
    for first, last in zip([0, *ends[:-1]], ends, strict=True):
        if np.ptp(station[first:last]) < 80.0:  # what bends around the road's far end would be smeared along it
            cv2.fillPoly(shade, [texels[first:last]], 255, cv2.LINE_AA, 4)


def _edge(a: Floats, b: Floats) -> Floats:
    pieces = max(1, int(((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2) ** 0.5 / _LONGEST_EDGE_M))
    return a + (b - a) * (np.arange(pieces) / pieces)[:, None]
