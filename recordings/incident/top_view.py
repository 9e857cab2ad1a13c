"""What the car knew at one moment, from above, heading up: road, objects, plan, stopping corridor, place of a request. Pure.

All of it is what the car believed (`scene`, `road_map`), not what was there.
"""

from math import cos, pi, sin

from recordings.incident import svg
from wire.messages.automation import RoadMap, Scene, TakeoverRequest
from wire.messages.vehicle import VehicleDescription
from wire.road import Road

AHEAD_M, BEHIND_M, BESIDE_M = 45.0, 10.0, 13.0
SCALE = 8.0  # pixels of the drawing per metre
LENGTH_M, WIDTH_M, OVERHANG_M = 4.5, 1.8, 0.9  # of a car that did not describe itself
STATION_STEP_M = 1.0
MANY = ("cone", "barrier")  # told by their colour: names would cover each other


class View:
    """From the map frame to the drawing: rear axle at its place, heading up, left of the car on the left."""

    def __init__(self, scene: Scene) -> None:
        self._x, self._y = scene.x_m, scene.y_m
        self._cos, self._sin = cos(scene.heading_rad), sin(scene.heading_rad)

    def __call__(self, x_m: float, y_m: float) -> svg.Point:
        dx, dy = x_m - self._x, y_m - self._y
        return self.ahead(dx * self._cos + dy * self._sin, -dx * self._sin + dy * self._cos)

    def ahead(self, forward_m: float, left_m: float) -> svg.Point:
        return (BESIDE_M - left_m) * SCALE, (AHEAD_M - forward_m) * SCALE


def draw(scene: Scene, road: RoadMap | None, vehicle: VehicleDescription | None, request: TakeoverRequest | None) -> str:
    view = View(scene)
    parts = [
        _road(view, scene, Road(road)) if road else "",
        svg.path((view(*point) for point in scene.stopping_corridor), class_="corridor", stroke_width=_width(vehicle) * SCALE),
        svg.path((view(*point) for point in scene.plan), class_="plan"),
        *(_object(view, scene, number) for number in range(len(scene.objects))),
        _place(view, request) if request else "",
        _car(view, vehicle),
        _scale(),
    ]
    size = f"0 0 {2 * BESIDE_M * SCALE:.0f} {(AHEAD_M + BEHIND_M) * SCALE:.0f}"
    return svg.tag("svg", "".join(parts), class_="top-view", viewBox=size, role="img")


def _width(vehicle: VehicleDescription | None) -> float:
    return vehicle.width_m if vehicle else WIDTH_M


def _road(view: View, scene: Scene, road: Road) -> str:
    near = road.to_road(scene.x_m, scene.y_m, scene.station_m)
    steps = range(round((AHEAD_M + BEHIND_M + 20.0) / STATION_STEP_M))
    stations = [near.station_m - BEHIND_M - 10.0 + number * STATION_STEP_M for number in steps]

    def along(offset_m: float) -> list[svg.Point]:
        return [view(*road.to_world(station, offset_m)[:2]) for station in stations]

    half = road.half_width_m
    return (
        svg.polygon([*along(half), *reversed(along(-half))], class_="road")
        + svg.path(along(half), class_="kerb")
        + svg.path(along(-half), class_="kerb")
        + svg.path(along(0.0), class_="centre")
    )


def _object(view: View, scene: Scene, number: int) -> str:
    one = scene.objects[number]
    x, y = view(one.x_m, one.y_m)
    radius = max(one.radius_m, 0.2) * SCALE
    said = f"{one.kind} {one.number}, deviation {one.deviation_m:.2f} m, known for {one.age_s:.1f} s"
    moving = [(x, y), view(one.x_m + one.velocity_x_m_s, one.y_m + one.velocity_y_m_s)]  # where it is in a second
    return (
        svg.tag("circle", cx=x, cy=y, r=radius + one.deviation_m * SCALE, class_="doubt")
        + svg.tag("circle", svg.tag("title", said), cx=x, cy=y, r=radius, class_=f"object {one.kind}")
        + ("" if one.static else svg.path(moving, class_="moving"))
        + ("" if one.kind in MANY else svg.text(x + radius + 3, y + 4, one.kind, class_="object-name"))
    )


def _place(view: View, request: TakeoverRequest) -> str:
    x, y = view(*request.place)
    r = 6.0
    cross = [(x, y - r), (x + r, y), (x, y + r), (x - r, y)]
    return svg.polygon(cross, class_="place") + svg.text(x + 9, y + 4, "request", class_="object-name")


def _car(view: View, vehicle: VehicleDescription | None) -> str:
    length, width = (vehicle.length_m, vehicle.width_m) if vehicle else (LENGTH_M, WIDTH_M)
    behind = vehicle.rear_overhang_m if vehicle else OVERHANG_M
    x, y = view.ahead(length - behind, width / 2)
    nose = [view.ahead(length - behind - 0.9, side * width / 2 * 0.8) for side in (1, -1)] + [view.ahead(length - behind - 0.2, 0)]
    return svg.box(x, y, width * SCALE, length * SCALE, "the car", class_="car", rx=4) + svg.polygon(nose, class_="nose")


def _scale() -> str:
    bottom, left = (AHEAD_M + BEHIND_M) * SCALE - 8, 8.0
    drawn = svg.line(left, bottom, left + 10 * SCALE, bottom, class_="scale")
    return drawn + svg.text(left, bottom - 5, "10 m", class_="object-name")


def heading_words(scene: Scene) -> str:
    """Compass direction of the car in the map frame (y is north)."""
    names = ("E", "NE", "N", "NW", "W", "SW", "S", "SE")
    return names[round(scene.heading_rad / (pi / 4)) % 8]
