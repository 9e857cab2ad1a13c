"""The collision guard: brakes when the car, driven on as it is, would hit something the newest scene tracks. Pure.

The car's rectangle is moved along the arc of its wheel angle at its present speed, everything tracked at its own velocity; the
first touch gives the time to collision and the deceleration needed to stop short of it. The guard only ever takes traction
and adds braking, never steers, and never acts on what is not tracked: with an old scene it is blind and says so. It acts
where nobody would brake so late on purpose: from `needed_m_s2` on, harder than any stop of our own.
Source of the decision: time to collision and needed deceleration, as UN R152 judges an emergency braking system.
"""

from enum import StrEnum
from math import copysign, cos, hypot, sin, sqrt, tan
from typing import Annotated, NamedTuple

from msgspec import Meta, Struct

from vehicle_gateway.corridor import Odometry
from vehicle_gateway.free_way import Surroundings
from vehicle_gateway.gate import Bound
from wire.messages.base import Message, Name, TimeNs
from wire.messages.vehicle import VehicleDescription

RULE, OVERRIDDEN_RULE = "collision guard", "guard overridden"
NEAR_M = 25.0  # from the rear axle, and never farther: a car at 30 km/h, its front, and who comes towards it
AROUND_M = 6.0  # ours: a car's front, a thing's radius and the doubt of both
GAINED_M_S = 1.0  # by the car until the scene is too old: 2 m/s2 for half a second
THINGS_MAX = 30  # ours: the nearest; who stands behind thirty others is met after them
CANDIDATES_MAX = 8  # ours: of those near the path; bounds a cycle's work
STEP_S, STEPS = 0.1, 15  # horizon 1.5 s: from 8.3 m/s a stop with 4 m/s2 takes 1.04 s of the way, and the reaction
SAMPLED_M_S = 1.0  # a standing car looks as far ahead as one that creeps
AT_ONCE = 2  # steps: who touches the margin already counts only when the way leads nearer within so many
NEARER_M = 0.01
ROOM_MIN_M = 0.05  # less is none
SETTLES_S = 0.5  # as the gate's cap
LIST_AGE_S = 0.1  # ours: the tracks of a scene are those of the last object list, 10 Hz


class GuardLimits(Message):
    on: bool = True
    needed_m_s2: Annotated[float, Meta(ge=1.0, le=8.0)] = 4.0  # UN R157's ceiling for a stop that is not an emergency
    release_m_s2: Annotated[float, Meta(ge=0.0, le=8.0)] = 2.0  # ours: once it brakes, it goes on to here
    reaction_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.2  # a cycle, CAN and the build-up of the brakes
    standoff_m: Annotated[float, Meta(ge=0.0, le=3.0)] = 0.3  # ours: what is left between bumper and thing
    deviations: Annotated[float, Meta(ge=0.0, le=4.0)] = 1.0  # of its place, added to a thing's radius
    growth_m_s: Annotated[float, Meta(ge=0.0, le=3.0)] = 0.2  # ours: a thing grows by so much while its evidence ages
    age_max_ms: Annotated[float, Meta(ge=100.0, le=3000.0)] = 500.0  # five scenes missed: blind
    override_m_s: Annotated[float, Meta(ge=0.0, le=2.0)] = (
        1.5  # walking pace, 5 km/h, and its ripple: below it the operator may override
    )


class Thing(Struct, frozen=True, array_like=True):
    """One tracked object in the odometry frame, at the scene's time; in a recording five numbers."""

    x_m: float
    y_m: float
    velocity_x_m_s: float
    velocity_y_m_s: float
    radius_m: float  # grown by its deviation


class Things(Message):
    """What the newest scene tracks near the car."""

    stamp_ns: TimeNs = 0  # 0: no scene yet
    near: tuple[Thing, ...] = ()


class Eye(StrEnum):
    """What the guard says of itself."""

    OFF = "off"
    BLIND = "blind"  # no scene, or an old one: it brakes for nothing
    CLEAR = "clear"
    HOLDING = "holding"  # no faster than walking pace: something is close
    BRAKING = "braking"
    OVERRIDDEN = "overridden"


class Watch(NamedTuple):
    eye: Eye
    bounds: tuple[Bound, ...]  # for the gate
    rules: tuple[Name, ...] = ()
    cap_m_s: float = 100.0  # none: the end of the message's range


class Motion(Struct, frozen=True):
    """How the car goes on, in its own frame with x along the way it drives: a car in reverse is a car in a mirror."""

    speed_m_s: float  # >= 0
    curvature_1_m: float
    front_m: float  # from the rear axle to the end that leads
    rear_m: float
    half_width_m: float


class Near(NamedTuple):
    """A thing in the frame of `Motion`."""

    x_m: float
    y_m: float
    velocity_x_m_s: float
    velocity_y_m_s: float
    radius_m: float


Car = tuple[float, float, float, float]  # x, y of the rear axle, cos and sin of its heading, where `Motion` begins


class Touch(NamedTuple):
    time_s: float
    along_m_s: float  # the thing's own speed along the way of the car


def things_of(around: Surroundings, odometry: Odometry, speed_m_s: float, limits: GuardLimits) -> Things:
    """Once per scene: those that could be met before it is too old, of many the nearest."""
    x0, y0 = odometry.x_m, odometry.y_m
    ahead_s = STEP_S * STEPS + limits.age_max_ms / 1e3
    reach_m = min(AROUND_M + (abs(speed_m_s) + GAINED_M_S) * ahead_s, NEAR_M)
    near = [
        (distance_m, thing, moves)
        for seen, within_m, moves in ((around.standing, reach_m, 0.0), (around.moving, NEAR_M, 1.0))
        for thing in seen
        if (distance_m := hypot(thing.x_m - x0, thing.y_m - y0)) < within_m
    ]
    if len(near) > THINGS_MAX:
        near = sorted(near, key=lambda each: each[0])[:THINGS_MAX]
    return Things(
        stamp_ns=around.seen_ns,
        near=tuple(
            [
                Thing(
                    thing.x_m,
                    thing.y_m,
                    moves * thing.velocity_x_m_s,
                    moves * thing.velocity_y_m_s,
                    thing.radius_m + limits.deviations * thing.deviation_m,
                )
                for _, thing, moves in near
            ]
        ),
    )


def motion_of(speed_m_s: float, road_wheel_angle_rad: float, backwards: bool, vehicle: VehicleDescription) -> Motion:
    ends = vehicle.length_m - vehicle.rear_overhang_m, vehicle.rear_overhang_m
    front, rear = reversed(ends) if backwards else ends
    return Motion(abs(speed_m_s), tan(road_wheel_angle_rad) / vehicle.wheelbase_m, front, rear, vehicle.width_m / 2)


def watch(
    things: Things,
    pose: tuple[float, float, float],
    motion: Motion,
    backwards: bool,
    braking: bool,
    now_ns: int,
    vehicle: VehicleDescription,
    limits: GuardLimits,
) -> Watch:
    """What the guard allows.

    pose     x, y, heading of the rear axle in the odometry frame
    braking  the guard braked in the last cycle: it goes on down to `release_m_s2`
    """
    if not limits.on:
        return Watch(Eye.OFF, ())
    age_s = (now_ns - things.stamp_ns) / 1e9
    if not things.stamp_ns or age_s * 1e3 > limits.age_max_ms:
        return Watch(Eye.BLIND, ())
    found = [
        (needed_m_s2(touch, room_m, motion.speed_m_s, vehicle.braking_max_m_s2), may_m_s(touch, room_m, limits))
        for touch in touches(near_path(things, pose, motion, backwards, age_s, limits), motion)
        if (room_m := room_of(touch, motion.speed_m_s, limits)) is not None
    ]
    if not found:
        return Watch(Eye.CLEAR, ())
    needed = max(need for need, _ in found)
    if needed >= (limits.release_m_s2 if braking else limits.needed_m_s2):
        return Watch(Eye.BRAKING, (Bound(RULE, -needed),))
    most = min(may for _, may in found)
    eye = Eye.HOLDING if most < limits.override_m_s else Eye.CLEAR
    return Watch(eye, (Bound(RULE, (most - motion.speed_m_s) / SETTLES_S),))


def near_path(
    things: Things, pose: tuple[float, float, float], motion: Motion, backwards: bool, age_s: float, limits: GuardLimits
) -> list[Near]:
    """Those that the path could meet within the horizon, where they are by now; of many, the nearest to the bumper."""
    x0, y0, heading = pose
    c, s, way = cos(heading), sin(heading), -1.0 if backwards else 1.0
    horizon_s = STEP_S * STEPS
    reach_m = motion.front_m + max(motion.speed_m_s, SAMPLED_M_S) * horizon_s
    grown, found = limits.growth_m_s * (age_s + LIST_AGE_S), []
    reach_m += grown
    behind_m = -motion.rear_m - grown
    aside_m = motion.half_width_m + min(reach_m**2 * abs(motion.curvature_1_m) / 2, reach_m) + grown
    for thing in things.near:
        velocity_x, velocity_y, radius = thing.velocity_x_m_s, thing.velocity_y_m_s, thing.radius_m
        dx, dy = thing.x_m + velocity_x * age_s - x0, thing.y_m + velocity_y * age_s - y0
        left, across = dy * c - dx * s, velocity_y * c - velocity_x * s
        if abs(left) >= aside_m + abs(across) * horizon_s + radius:
            continue  # most are: rows of people beside the road
        ahead, along = way * (dx * c + dy * s), way * (velocity_x * c + velocity_y * s)
        length_m = abs(along) * horizon_s + radius
        if behind_m - length_m < ahead < reach_m + length_m:
            found.append(Near(ahead, left, along, across, radius + grown))
    if len(found) > CANDIDATES_MAX:
        found = sorted(found, key=lambda near: abs(near.x_m - motion.front_m))[:CANDIDATES_MAX]
    return found


def touches(near: list[Near], motion: Motion) -> list[Touch]:
    """The first touch of each with the car's rectangle, driven on at its present speed and angle."""
    if not near:
        return []
    way = arc(motion)
    found = [first_touch(thing, way, motion) for thing in near]
    return [touch for touch in found if touch is not None]


def arc(motion: Motion) -> list[Car]:
    """The car at every step of the horizon."""
    return [pose_after(number, motion) for number in range(STEPS + 1)]


def pose_after(steps: float, motion: Motion) -> Car:
    along = max(motion.speed_m_s, SAMPLED_M_S) * STEP_S * steps
    turn = motion.curvature_1_m * along
    half = turn / 2
    chord = along * (sin(half) / half if abs(half) > 1e-9 else 1.0)
    return chord * cos(half), chord * sin(half), cos(turn), sin(turn)


def first_touch(thing: Near, way: list[Car], motion: Motion) -> Touch | None:
    """When thing and car first touch; None when they do not, or when it is touched already and the way leads away from it.

    No point of the car nears the thing faster than `nearing_m`, a step: while the gap is many of them, steps are skipped, and
    what is free at two steps may have been touched between them only when both gaps together are less than that.
    """
    swing = 1.0 + abs(motion.curvature_1_m) * (motion.front_m + motion.half_width_m)
    own_m = max(motion.speed_m_s, SAMPLED_M_S) * STEP_S
    nearing_m = own_m * swing + (abs(thing.velocity_x_m_s) + abs(thing.velocity_y_m_s)) * STEP_S
    before_number, before_m = 0, gap_m(thing, way[0], 0.0, motion)
    if before_m <= 0.0:
        nearer = gap_m(thing, way[AT_ONCE], AT_ONCE * STEP_S, motion) < before_m - NEARER_M
        return Touch(0.0, thing.velocity_x_m_s) if nearer else None
    while (number := before_number + max(1, int(before_m / nearing_m))) <= STEPS:
        now_m = gap_m(thing, way[number], number * STEP_S, motion)
        if now_m <= 0.0:
            return _touch(thing, before_number, before_m, number, now_m, way[number])
        if before_m + now_m < nearing_m and (touch := _graze(thing, way, number, before_m, motion)) is not None:
            return touch
        before_number, before_m = number, now_m
    return None


def _graze(thing: Near, way: list[Car], number: int, before_m: float, motion: Motion) -> Touch | None:
    """The touch of a corner that comes and goes within the step before `number`; `before_m` is the gap where the step begins.

    Seen from the car the thing passes on a line, nearly; nearer than at both ends of it, it comes to a convex outline only beside
    a corner.
    """
    x0, y0 = _seen(thing, way[number - 1], (number - 1) * STEP_S)
    x1, y1 = _seen(thing, way[number], number * STEP_S)
    dx, dy = x1 - x0, y1 - y0
    corner_x = motion.front_m if x0 + x1 > motion.front_m - motion.rear_m else -motion.rear_m
    corner_y = copysign(motion.half_width_m, y0 + y1)
    passed = (corner_x - x0) * dx + (corner_y - y0) * dy
    if not 0.0 < passed < dx * dx + dy * dy:
        return None
    at = number - 1 + passed / (dx * dx + dy * dy)
    car = pose_after(at, motion)
    nearest_m = gap_m(thing, car, at * STEP_S, motion)
    return _touch(thing, number - 1, before_m, at, nearest_m, car) if nearest_m <= 0.0 else None


def _touch(thing: Near, before: float, before_m: float, after: float, after_m: float, car: Car) -> Touch:
    """Where the gap falls to zero between two steps."""
    share = before_m / (before_m - after_m)
    _, _, c, s = car
    return Touch((before + share * (after - before)) * STEP_S, thing.velocity_x_m_s * c + thing.velocity_y_m_s * s)


def _seen(thing: Near, car: Car, time_s: float) -> tuple[float, float]:
    """Ahead and to the left of the car's rear axle."""
    x, y, c, s = car
    dx, dy = thing.x_m + thing.velocity_x_m_s * time_s - x, thing.y_m + thing.velocity_y_m_s * time_s - y
    return dx * c + dy * s, dy * c - dx * s


def gap_m(thing: Near, car: Car, time_s: float, motion: Motion) -> float:
    """From the car's rectangle to the thing's circle; the thing's centre inside the rectangle counts as minus its radius."""
    x, y, c, s = car  # as `_seen`, written out: most of the guard's time is spent here
    dx, dy = thing.x_m + thing.velocity_x_m_s * time_s - x, thing.y_m + thing.velocity_y_m_s * time_s - y
    ahead, left = dx * c + dy * s, abs(dy * c - dx * s)
    beyond = ahead - motion.front_m if ahead > 0.0 else -motion.rear_m - ahead
    aside = left - motion.half_width_m
    if beyond <= 0.0:
        return max(aside, 0.0) - thing.radius_m
    return (hypot(beyond, aside) if aside > 0.0 else beyond) - thing.radius_m


def room_of(touch: Touch, speed_m_s: float, limits: GuardLimits) -> float | None:
    """What is left to brake in, after the reaction [m]; None for what drives away from us or comes from behind."""
    closing = max(speed_m_s, SAMPLED_M_S) - touch.along_m_s
    if closing <= 0.0:
        return None
    real = max(speed_m_s - touch.along_m_s, 0.0)
    return closing * touch.time_s - real * limits.reaction_s - limits.standoff_m


def may_m_s(touch: Touch, room_m: float, limits: GuardLimits) -> float:
    """The speed that could be braked away in the room, with what the guard calls late."""
    return max(touch.along_m_s, 0.0) + sqrt(2 * limits.needed_m_s2 * max(room_m, 0.0))


def needed_m_s2(touch: Touch, room_m: float, speed_m_s: float, most_m_s2: float) -> float:
    """The constant deceleration that avoids the touch, at most the car's own.

    Who goes our way is not caught up with: (v - u)^2 / 2 d. Who comes towards us meets us standing: v (v / 2 + |u|) / d.
    """
    room, u = max(room_m, ROOM_MIN_M), touch.along_m_s
    needed = max(speed_m_s - u, 0.0) ** 2 / (2 * room) if u >= 0.0 else speed_m_s * (speed_m_s / 2 - u) / room
    return min(needed, most_m_s2)
