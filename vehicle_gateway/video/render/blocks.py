"""Boxes that hide what is behind them: buildings with their roofs, and hedges. Footprints, panels, roofs, drawing.

Gables up to FLAT_FROM_M, flat roofs above. Not modelled: eaves seen from below, chimneys, what is inside.
"""

from dataclasses import dataclass
from itertools import accumulate
from math import atan2

import cv2
import numpy as np

from vehicle_gateway.simulation.site import building_corners
from vehicle_gateway.video.render.brush import SHIFT, Colour, fill_in_space, fixed, line_in_space, shaded
from vehicle_gateway.video.render.facades import STYLES, Style, facade, hedge, plaster, sunlight
from vehicle_gateway.video.render.panels import Job, Panel, Panels
from vehicle_gateway.video.render.projection import NEAR_M, Corners, Floats, Picture, View
from vehicle_gateway.video.render.scenery import HEDGE_DEPTH_M, HEDGE_HEIGHT_M, HEDGE_LONGEST_M, HEDGE_SHORTEST_M, Hedge, Scenery
from wire.road import Road
from wire.scenario import Building, Scenario

FLAT_FROM_M = 10.5
ROOF_SLOPE = 0.78  # rise over run: 38 degrees
EAVE_M = 0.4
GUTTER_M = 0.14
HEDGE_TEXTURE_M = HEDGE_LONGEST_M + HEDGE_SHORTEST_M  # no piece is longer
HEDGE_TOPS_WITHIN_M = 40.0  # the top of a hedge farther away is a line too thin to draw


@dataclass(frozen=True, slots=True)
class Face:
    """A flat polygon with an outer side: seen from outside its corners run counter-clockwise."""

    corners_m: Floats  # (N, 3) map frame
    colour: Colour
    outward: tuple[float, float, float]  # its normal, not of unit length

    @classmethod
    def of(cls, corners_m: Floats, colour: Colour) -> "Face":
        x, y, z = np.cross(corners_m[1] - corners_m[0], corners_m[2] - corners_m[0]).tolist()
        return cls(corners_m, colour, (x, y, z))


@dataclass(frozen=True, slots=True)
class Block:
    footprint_m: Floats  # (4, 2) counter-clockwise
    faces: tuple[Face, ...]
    eaves: tuple[tuple[Face, ...], ...]  # of each group the first says whether all of it is drawn
    edges: tuple[Face, ...]  # only their first two corners are drawn, as a line that smooths the outline
    top_matters_within_m: float  # farther away nothing of the faces is large enough to draw


class Blocks:
    def __init__(self, scenario: Scenario, road: Road, scenery: Scenery) -> None:
        random = np.random.default_rng(scenario.seed + 1)
        self._blocks: list[Block] = []
        panels: list[tuple[int, Panel]] = []
        order, stucco = random.permutation(len(STYLES)), plaster(random)
        for i, house in enumerate(scenario.buildings):
            block, walls = _building(house, road, STYLES[order[i % len(STYLES)]], stucco, random)
            panels += [(len(self._blocks), wall) for wall in walls]
            self._blocks.append(block)
        leaves = [hedge(HEDGE_TEXTURE_M, HEDGE_HEIGHT_M, light, random) for light in (0.75, 1.05)]
        for piece in scenery.hedges:
            block, walls = _hedge(piece, road, leaves)
            panels += [(len(self._blocks), wall) for wall in walls]
            self._blocks.append(block)
        self._panels = Panels(panels)
        drawn = [[*(face for group in block.eaves for face in group), *block.faces, *block.edges] for block in self._blocks]
        self._first_face = [0, *accumulate(len(faces) for faces in drawn)]
        self._roofs = _Roofs([face for faces in drawn for face in faces])
        self.footprints_m = np.array([block.footprint_m for block in self._blocks]).reshape(-1, 4, 2)

    def look(self, view: View) -> dict[int, list[Job]]:
        """What may be seen of each block: its walls, farthest first. Call before `draw_roof`."""
        self._roofs.look(view)
        return self._panels.look(view)

    def has_roof(self, view: View, number: int) -> bool:
        """Whether a block shows more than its walls."""
        block = self._blocks[number]
        x, y = (block.footprint_m[0] - view.position_m[:2]).tolist()
        return bool(x * x + y * y < block.top_matters_within_m**2)

    def draw_roof(self, canvas: Picture, view: View, number: int) -> None:
        """What is not wall: eaves, gables, slopes, the outline. After the block's walls."""
        block, first = self._blocks[number], self._first_face[number]
        at = first
        for group in block.eaves:
            if self._roofs.faces(at):
                for face in range(at, at + len(group)):
                    self._roofs.fill(canvas, view, face)
            at += len(group)
        for face in range(at, at + len(block.faces)):
            self._roofs.fill(canvas, view, face)
        at += len(block.faces)
        for edge in range(at, at + len(block.edges)):
            self._roofs.line(canvas, view, edge)


class _Roofs:
    """Many faces, transformed in one go."""

    def __init__(self, faces: list[Face]) -> None:
        self._colours = [face.colour for face in faces]
        self._ends = np.cumsum([0, *(len(face.corners_m) for face in faces)]).tolist()
        self._corners = np.concatenate([np.zeros((0, 3)), *(face.corners_m for face in faces)])
        self._anchors = np.array([face.corners_m[0] for face in faces]).reshape(-1, 3)
        self._outward = np.array([face.outward for face in faces]).reshape(-1, 3)
        self._facing: list[bool] = []
        self._in_front: list[bool] = []
        self._camera: Floats = np.zeros((0, 3))
        self._pixels: Corners = np.zeros((0, 2), np.int32)

    def look(self, view: View) -> None:
        height = ((view.position_m - self._anchors) * self._outward).sum(axis=1)
        self._facing = (height > 0).tolist()
        self._camera = view.to_camera(self._corners)
        behind = np.concatenate(([0], np.cumsum(self._camera[:, 2] < NEAR_M)))[self._ends]
        self._in_front = (np.diff(behind) == 0).tolist()
        self._pixels = fixed(view.to_pixels(np.maximum(self._camera, (-np.inf, -np.inf, NEAR_M))))

    def faces(self, number: int) -> bool:
        """Whether the camera is on its outer side."""
        return self._facing[number]

    def fill(self, canvas: Picture, view: View, number: int) -> None:
        if not self._facing[number]:
            return
        corners = slice(self._ends[number], self._ends[number + 1])
        if self._in_front[number]:
            cv2.fillConvexPoly(canvas, self._pixels[corners], self._colours[number], cv2.LINE_AA, SHIFT)
        else:
            fill_in_space(canvas, view, self._camera[corners], self._colours[number])

    def line(self, canvas: Picture, view: View, number: int) -> None:
        """Between the first two corners."""
        if self._facing[number]:
            first = self._ends[number]
            line_in_space(canvas, view, self._camera[first : first + 2], self._colours[number])


def _walls(corners_m: Floats) -> list[tuple[Floats, Floats, float]]:
    """(left, right, direction of the outward normal) of the four sides of a counter-clockwise footprint."""
    sides = []
    for a, b in zip(corners_m, np.roll(corners_m, -1, axis=0), strict=True):
        sides.append((a, b, atan2(-(b - a)[0], (b - a)[1])))
    return sides


def _building(house: Building, road: Road, style: Style, stucco: Floats, random: np.random.Generator) -> tuple[Block, list[Panel]]:
    """Its corners come as building_corners gives them: sides 0 and 2 run along the road, 1 and 3 across."""
    corners = np.array(building_corners(house, road))
    street = 2 if house.offset_m >= 0 else 0
    panels = []
    for i, (left, right, outward) in enumerate(_walls(corners)):
        length = float(np.hypot(*(right - left)))
        texture = facade(style, length, house.height_m, sunlight(outward), i == street, stucco, random)
        panels.append(Panel((left[0], left[1]), (right[0], right[1]), house.height_m, texture, texture.shape[1]))
    if house.height_m < FLAT_FROM_M:
        return Block(corners, *_gable(corners, house.height_m, style), (), 1e4), panels
    top = np.concatenate((corners, np.full((4, 1), house.height_m)), axis=1)
    down = np.array([0.0, 0.0, -1.0])
    edges = tuple(
        Face.of(np.stack((b, a, a + down)), shaded(style.wall, 0.8)) for a, b in zip(top, np.roll(top, -1, axis=0), strict=True)
    )
    return Block(corners, (), (), edges, 1e4), panels


def _gable(corners_m: Floats, height_m: float, style: Style) -> tuple[tuple[Face, ...], tuple[tuple[Face, ...], ...]]:
    """Two slopes whose ridge runs along the road (parallel to sides 0 and 2) and the triangles at its ends; their eaves."""
    a, b, c, d = corners_m  # a to b and c to d run along the road
    depth = float(np.hypot(*(c - b)))
    rise = ROOF_SLOPE * depth / 2
    ridge_b, ridge_a = (b + c) / 2, (a + d) / 2
    along = (b - a) / np.hypot(*(b - a)) * EAVE_M
    across = (c - b) / depth * EAVE_M
    low, high = height_m - ROOF_SLOPE * EAVE_M, height_m + rise

    def at(place: Floats, z: float) -> list[float]:
        return [float(place[0]), float(place[1]), z]

    slopes = [
        np.array(
            [
                at(p - across * s + e * along, low),
                at(q - across * s - e * along, low),
                at(top_q - e * along, high),
                at(top_p + e * along, high),
            ]
        )
        for p, q, top_p, top_q, s, e in ((a, b, ridge_a, ridge_b, 1, -1), (c, d, ridge_b, ridge_a, -1, 1))
    ]
    ends = [
        np.array([at(b, height_m), at(c, height_m), at(ridge_b, high)]),
        np.array([at(d, height_m), at(a, height_m), at(ridge_a, high)]),
    ]
    outward = [atan2(-(q - p)[0], (q - p)[1]) for p, q in ((b, c), (d, a))]
    lights = [0.72 + 0.3 * sunlight(atan2(-(q - p)[0], (q - p)[1])) for p, q in ((a, b), (c, d))]
    eaves = tuple(
        _eave([at(p - across * s, low), at(q - across * s, low)], [at(p, low), at(q, low)], style)
        for p, q, s in ((a, b, 1), (c, d, -1))
    )
    triangles = tuple(Face.of(end, shaded(style.wall, 0.97 * sunlight(way))) for end, way in zip(ends, outward, strict=True))
    faces = triangles + tuple(Face.of(slope, shaded(style.roof, light)) for slope, light in zip(slopes, lights, strict=True))
    return faces, eaves


def _eave(outer_m: list[list[float]], wall_m: list[list[float]], style: Style) -> tuple[Face, ...]:
    """The gutter along the outer edge, and the boards below that reach back to the wall; corners left to right from outside."""
    (left, right), (inner_left, inner_right) = outer_m, wall_m
    lift = [0.0, 0.0, GUTTER_M]
    gutter = np.array([left, right, right, left]) + np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], lift, lift])
    boards = np.array([left, inner_left, inner_right, right])
    return Face.of(gutter, (96.0, 94.0, 90.0)), Face.of(boards, shaded(style.wall, 0.45))


def _hedge(piece: Hedge, road: Road, leaves: list[Picture]) -> tuple[Block, list[Panel]]:
    """Sides: 0 away from or towards the road (left), 1 at its start, 2 the right one, 3 at its end."""
    corners = _hedge_corners(road, piece)
    hidden = (0 if piece.offset_m > 0 else 2, 1 if not piece.starts_run else -1, 3 if not piece.ends_run else -1)
    panels = []
    for i, (left, right, outward) in enumerate(_walls(corners)):
        if i not in hidden:
            lit = leaves[1] if sunlight(outward) > 0.8 else leaves[0]
            columns = max(16, min(lit.shape[1], round(float(np.hypot(*(right - left))) / HEDGE_TEXTURE_M * lit.shape[1])))
            panels.append(Panel((left[0], left[1]), (right[0], right[1]), HEDGE_HEIGHT_M, lit, columns))
    top = np.concatenate((corners, np.full((4, 1), HEDGE_HEIGHT_M)), axis=1)
    return Block(corners, (Face.of(top, (66.0, 128.0, 94.0)),), (), (), HEDGE_TOPS_WITHIN_M), panels


def _hedge_corners(road: Road, piece: Hedge) -> Floats:
    beyond = piece.offset_m + (HEDGE_DEPTH_M if piece.offset_m > 0 else -HEDGE_DEPTH_M)
    right, left = min(piece.offset_m, beyond), max(piece.offset_m, beyond)
    return np.array(
        [
            road.to_world(s, o)[:2]
            for s, o in ((piece.last_m, left), (piece.first_m, left), (piece.first_m, right), (piece.last_m, right))
        ]
    )
