"""How much of the way that a stop would take is free, looked at by the gateway itself in every cycle. Pure.

The automation's corridor was checked against standing things, once; here it is checked against every tracked object: standing
ones when a scene comes, moving ones in every cycle, moved on by their velocity and grown by what is not known of them. Without
a corridor the way is the curvature that would be held. What is not known is never called free.
"""

from collections.abc import Iterable, Sequence
from math import cos, dist, hypot, sin

from vehicle_gateway.corridor import CORRIDOR_AGE_MAX_NS, Corridor, Odometry, Shift, nearest
from vehicle_gateway.sweep import Circle, Points, in_reach, line_of
from wire.messages.automation import STOPPING_CORRIDOR_M, Scene
from wire.messages.base import Length, Message, Name, Position, Speed, TimeNs
from wire.messages.vehicle import VehicleDescription

GROWTH_M_S = 0.5  # ours: a person who walks on otherwise than a second ago is half a metre elsewhere
NEAR_M = 60.0  # a way of 30 m, the car at its end, and what comes towards it within a second
STEP_M = 1.0  # of the way with held curvature


class Thing(Message):
    """A tracked object, odometry frame, as it was when it was seen."""

    x_m: Position
    y_m: Position
    velocity_x_m_s: Speed
    velocity_y_m_s: Speed
    radius_m: Length
    deviation_m: Length


class Surroundings(Message):
    moving: tuple[Thing, ...] = ()
    standing: tuple[Thing, ...] = ()
    seen_ns: TimeNs = 0  # 0: never


class Way(Message):
    """The way that a stop would take now."""

    along: Name = ""  # corridor; held: the wheels as they are; "": the same, and nothing is known of it
    free_m: Length = 0.0  # of the rear axle, from the car on


CORRIDOR, HELD, UNKNOWN = "corridor", "held", ""


def keep_surroundings(scene: Scene, shift: Shift) -> Surroundings:
    """The objects of the scene that a stop from here could meet. shift: of this scene, written out here for its many objects."""
    moving: list[Thing] = []
    standing: list[Thing] = []
    map_x, map_y, x0, y0, c, s = shift
    for seen in scene.objects:
        dx, dy, vx, vy = seen.x_m - map_x, seen.y_m - map_y, seen.velocity_x_m_s, seen.velocity_y_m_s
        if hypot(dx, dy) > NEAR_M + seen.radius_m:
            continue
        thing = Thing(
            x_m=x0 + dx * c - dy * s,
            y_m=y0 + dx * s + dy * c,
            velocity_x_m_s=vx * c - vy * s,
            velocity_y_m_s=vx * s + vy * c,
            radius_m=seen.radius_m,
            deviation_m=seen.deviation_m,
        )
        (standing if seen.static else moving).append(thing)
    return Surroundings(moving=tuple(moving), standing=tuple(standing), seen_ns=scene.stamp_ns)


def moved_on(things: Iterable[Thing], age_s: float) -> list[Circle]:
    """Where moving things may be now; age_s  since they were seen."""
    age_s = max(age_s, 0.0)
    return [
        (
            thing.x_m + thing.velocity_x_m_s * age_s,
            thing.y_m + thing.velocity_y_m_s * age_s,
            thing.radius_m + thing.deviation_m + GROWTH_M_S * age_s,
        )
        for thing in things
    ]


def as_they_stand(things: Iterable[Thing]) -> list[Circle]:
    """Standing things: their estimate settles, it does not grow; the automation keeps a distance of its own besides."""
    return [(thing.x_m, thing.y_m, thing.radius_m) for thing in things]


def free_points(points: Points, begin: int, things: Sequence[Circle], vehicle: VehicleDescription) -> int:
    """How many of the points the car can take, rear axle on each, before it would touch a thing; from `begin` on.

    From a point from which a thing is far off, the next that can be near it is as many steps away as it is metres.
    """
    if not things:
        return len(points)
    front, rear, half = vehicle.length_m - vehicle.rear_overhang_m, vehicle.rear_overhang_m, vehicle.width_m / 2
    reach = hypot(max(front, rear), half)
    step = max(map(dist, points, points[1:]), default=0.0) or STEP_M
    free = len(points)
    for thing in things:
        x, y, radius = thing
        at = begin
        while at < free:
            clear = dist(points[at], (x, y)) - reach - radius
            if clear > 0.0:
                at += int(clear / step) + 1
            elif _touches(points, at, thing, front, rear, half):
                free = at
            else:
                at += 1
    return free


def _touches(points: Points, at: int, thing: Circle, front_m: float, rear_m: float, half_m: float) -> bool:
    """Whether the car that stands at this point, along the way, touches the thing; with no way to stand along, it may."""
    one = min(at, max(len(points) - 2, 0))
    (x1, y1), (x2, y2) = points[one], points[min(one + 1, len(points) - 1)]
    length = hypot(x2 - x1, y2 - y1)
    if length == 0.0:
        return True
    c, s = (x2 - x1) / length, (y2 - y1) / length
    x, y, radius = thing
    dx, dy = x - points[at][0], y - points[at][1]
    ahead, left = dx * c + dy * s, dy * c - dx * s
    outside = max(ahead - front_m, -rear_m - ahead, 0.0)
    beside = max(abs(left) - half_m, 0.0)
    return hypot(outside, beside) < radius


def cut_by_standing(corridor: Corridor, around: Surroundings, odometry: Odometry, vehicle: VehicleDescription) -> int | None:
    """How many points of a new corridor are clear of standing things; None: all."""
    things = _met(corridor, as_they_stand(around.standing), vehicle)
    if not things:
        return None
    at, _ = nearest(corridor, odometry)
    free = free_points(corridor.points, at, things, vehicle)
    return None if free == len(corridor.points) else free


def free_of_corridor(corridor: Corridor, around: Surroundings, at: int, now_ns: int, vehicle: VehicleDescription) -> int | None:
    """How many of its points, from `at` on, are free now; None: all."""
    things = _met(corridor, moved_on(around.moving, (now_ns - around.seen_ns) / 1e9), vehicle)
    if not things:
        return corridor.free
    points = corridor.points[: corridor.free]
    free = free_points(points, min(at, len(points)), things, vehicle)
    return corridor.free if free == len(points) else free


def _met(corridor: Corridor, things: list[Circle], vehicle: VehicleDescription) -> list[Circle]:
    """Those that a car in the corridor might touch."""
    strip = line_of(corridor.points, vehicle).strip
    return things if strip is None else in_reach(strip, things)


def held_way(odometry: Odometry, curvature_1_m: float) -> tuple[tuple[float, float], ...]:
    """Where the rear axle goes with the wheels as they are: points STEP_M apart."""
    points = []
    x, y, heading = odometry.x_m, odometry.y_m, odometry.heading_rad
    for _ in range(round(STOPPING_CORRIDOR_M / STEP_M) + 1):
        points.append((x, y))
        middle = heading + curvature_1_m * STEP_M / 2
        x, y, heading = x + STEP_M * cos(middle), y + STEP_M * sin(middle), heading + curvature_1_m * STEP_M
    return tuple(points)


def held_free_m(
    odometry: Odometry, curvature_1_m: float, around: Surroundings, now_ns: int, vehicle: VehicleDescription
) -> float | None:
    """How far the way with held curvature is free; None when what was seen is too old to say."""
    age_ns = now_ns - around.seen_ns
    if not around.seen_ns or not 0 <= age_ns <= CORRIDOR_AGE_MAX_NS:
        return None
    points = held_way(odometry, curvature_1_m)
    things = as_they_stand(around.standing) + moved_on(around.moving, age_ns / 1e9)
    return max(free_points(points, 0, things, vehicle) - 1, 0) * STEP_M
