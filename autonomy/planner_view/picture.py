"""A View as a picture: the street around the car from above, and below it what the colours mean."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autonomy.planner_view.layers import Person, View, Way, circle
from autonomy.planner_view.legend import HIGH_PX as LEGEND_PX
from autonomy.planner_view.legend import draw_legend
from autonomy.planner_view.pens import ACROSS, BOLD, BROKEN, CAR, CAR_LINE, DOTTED, GRAPH, PAPER, ROAD, THICK, THIN, UNSEEN, WALL
from autonomy.planner_view.sheet import HEAVY, Pixels, Sheet
from autonomy.planning.crossings.scenario import World
from autonomy.planning.horizon import STEP_S, Floats
from wire.planner_colours import INK, PERSON

WIDE_PX, HIGH_PX = 1600, 760  # of the street; even, as films want it
SHOWN_M = 32.0  # of the street, left to right
AHEAD_M = 8.0  # of the rear axle is the middle of the picture
BAR_M = 5.0


@dataclass(frozen=True, slots=True)
class Camera:
    """Looks down."""

    centre_m: Floats
    turned_rad: float  # direction of the map that is to the right
    zoom_px_m: float = WIDE_PX / SHOWN_M

    def pixels(self, points_m: Floats) -> Floats:
        c, s = np.cos(self.turned_rad), np.sin(self.turned_rad)
        away = (points_m - self.centre_m) * self.zoom_px_m
        right, up = away[..., 0] * c + away[..., 1] * s, away[..., 1] * c - away[..., 0] * s
        return np.stack((WIDE_PX / 2 + right, HIGH_PX / 2 - up), axis=-1)


def camera_over(world: World) -> Callable[[View], Camera]:
    """Follows the car along the road; to the right is where the road leads from end to end."""
    road = world.road
    far = np.array(road.to_world(world.crossing.goal_m)[:2]) - road.to_world(0.0)[:2]
    turned = float(np.arctan2(far[1], far[0]))
    return lambda view: Camera(np.array(road.to_world(view.station_m + AHEAD_M)[:2]), turned)


def picture(view: View, camera: Camera, title: str) -> Pixels:
    """(HIGH_PX + LEGEND_PX, WIDE_PX, 3) BGR"""
    sheet = Sheet(WIDE_PX, HIGH_PX + LEGEND_PX, PAPER)
    draw_street(sheet, camera, view)
    draw_people(sheet, camera, view)
    draw_swept(sheet, camera, view)
    for way in view.ways:
        draw_way(sheet, camera, way)
    draw_car(sheet, camera, view)
    draw_names(sheet, camera, view)
    draw_scale(sheet, camera)
    draw_legend(sheet, HIGH_PX, view, title)
    return sheet.pixels


def draw_street(sheet: Sheet, camera: Camera, view: View) -> None:
    street = view.street
    left, right = camera.pixels(street.left_m), camera.pixels(street.right_m)
    sheet.fill(np.concatenate((left, right[::-1])), ROAD)
    for edge in view.graph_m:
        sheet.stroke(camera.pixels(edge), 1.0, GRAPH, 0.55)
    for side in (left, right):
        sheet.stroke(side, THIN, INK)
    sheet.dashes(camera.pixels(street.goal_m), THICK, INK, *ACROSS)
    for wall in street.walls_m:
        sheet.stroke(camera.pixels(wall), 2 * THICK, WALL)


def draw_people(sheet: Sheet, camera: Camera, view: View) -> None:
    for place in view.unseen_m:
        sheet.stroke(camera.pixels(circle(place, 0.3)), THIN, UNSEEN, closed=True)
    for person in view.people:
        draw_person(sheet, camera, person)


def draw_person(sheet: Sheet, camera: Camera, person: Person) -> None:
    here = camera.pixels(circle(person.means_m[0], person.radius_m))
    if person.stands:
        sheet.fill(here, WALL)
        return
    for ring in person.two_sigma_m[::-1]:
        sheet.fill(camera.pixels(ring), PERSON, 0.10)
        sheet.stroke(camera.pixels(ring), 1.0, PERSON, 0.55, closed=True)
    sheet.stroke(camera.pixels(person.means_m), THIN, PERSON, 0.9)
    for mean in person.means_m[:: round(1.0 / STEP_S)][1:]:
        sheet.fill(camera.pixels(circle(mean, 0.06)), PERSON)
    sheet.fill(here, PERSON)
    sheet.stroke(here, THIN, PAPER, closed=True)


def draw_swept(sheet: Sheet, camera: Camera, view: View) -> None:
    chosen = next(way.colour for way in view.ways if way.chosen)
    for corners in view.swept_m:
        sheet.fill(camera.pixels(corners), chosen, 0.04)
        sheet.stroke(camera.pixels(corners), 1.0, chosen, 0.5, closed=True)


def draw_way(sheet: Sheet, camera: Camera, way: Way) -> None:
    """Guidance dotted; what was made of it solid, broken when it may not be driven, thick when it is."""
    if way.guidance_m is not None:
        sheet.dashes(camera.pixels(way.guidance_m), THICK, way.colour, *DOTTED, 0.75)
    found = camera.pixels(way.trajectory_m)
    if way.chosen:
        sheet.stroke(found, BOLD + THICK, PAPER)
        sheet.stroke(found, BOLD, way.colour)
    elif way.feasible:
        sheet.stroke(found, THICK, way.colour)
    elif len(found):
        sheet.dashes(found, THICK, way.colour, *BROKEN)


def draw_car(sheet: Sheet, camera: Camera, view: View) -> None:
    corners = camera.pixels(view.car_m)
    sheet.fill(corners, CAR, 0.35)
    sheet.stroke(corners, THICK, CAR_LINE, closed=True)
    nose = view.car_m[:2].mean(axis=0)
    middle = view.car_m.mean(axis=0)
    arrow = np.array((view.car_m[0] * 0.8 + view.car_m[1] * 0.2, nose, view.car_m[0] * 0.2 + view.car_m[1] * 0.8))
    arrow = arrow + (middle - nose) * np.array((0.45, 0.15, 0.45))[:, None]
    sheet.stroke(camera.pixels(arrow), THICK, CAR_LINE)


def draw_names(sheet: Sheet, camera: Camera, view: View) -> None:
    for person in view.people:
        x, y = camera.pixels(person.means_m[0])
        sheet.words(person.label, x, y + 7, 18, PAPER, HEAVY, 0.5)


def draw_scale(sheet: Sheet, camera: Camera) -> None:
    long_px = BAR_M * camera.zoom_px_m
    right, y = WIDE_PX - 36.0, HIGH_PX - 30.0
    bar = np.array(((right - long_px, y), (right, y)))
    around = np.array(((-14, -42), (14, -42), (14, 16), (-14, 16)))
    sheet.fill(bar[[0, 1, 1, 0]] + around, PAPER, 0.85)
    sheet.stroke(bar, THICK, INK)
    for end in bar:
        sheet.stroke(np.array((end - (0, 8), end + (0, 8))), THICK, INK)
    sheet.words(f"{BAR_M:g} m", right - long_px / 2, y - 14, 22, INK, HEAVY, 0.5)
