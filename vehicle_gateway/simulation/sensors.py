"""What the simulated car's sensors say: IMU, satellite position, wheel speeds, a list of detected objects. Pure.

Every random number comes from the generator passed in. Errors are those of the specification below, not of any real
device. Not modelled: multipath beside buildings, temperature, rain, detections merged into one, people behind people.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, cos, hypot, pi, sin
from random import Random
from typing import Annotated

from msgspec import Meta

from vehicle_gateway.simulation.powertrain import Car, CarParameters, wheel_speeds_m_s
from vehicle_gateway.simulation.shapes import Outline, Polygon, sees_through, to_car
from vehicle_gateway.simulation.single_track import GRAVITY_M_S2
from vehicle_gateway.simulation.site import StaticObject
from wire.messages.base import Message, Ratio
from wire.messages.sensing import DetectedObject, Gnss, Imu, ObjectList, WheelSpeeds
from wire.road import wrap_angle

Sigma = Annotated[float, Meta(ge=0.0, le=100.0)]  # one standard deviation


class SensorSettings(Message):
    """One standard deviation unless named otherwise. Biases are drawn once per drive."""

    imu_acceleration_m_s2: Sigma = 0.03
    imu_acceleration_bias_m_s2: Sigma = 0.03
    imu_rate_rad_s: Sigma = 0.002
    imu_rate_bias_rad_s: Sigma = 0.001
    road_roughness_m_s2: Sigma = 0.25  # vertical, at 5 m/s and above, falling to 0 at standstill
    gnss_m: Sigma = 0.05  # satellite positioning with corrections, open sky
    gnss_bias_m: Sigma = 0.05
    gnss_heading_rad: Sigma = 0.006
    wheel_m_s: Sigma = 0.02
    wheel_scale: Sigma = 0.004  # tyre radius
    road_wheel_angle_rad: Sigma = 0.0005
    road_wheel_angle_bias_rad: Sigma = 0.001
    object_range_m: Annotated[float, Meta(gt=1.0, le=300.0)] = 50.0
    object_m: Sigma = 0.08  # at the car, across and along
    object_per_m: Sigma = 0.002  # more for every metre of distance
    object_misses: Ratio = 0.03  # share of detections lost at the car
    object_misses_far: Ratio = 0.12  # and at the end of the range
    object_false_per_scan: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.05  # mean
    object_wrong_kind: Ratio = 0.02  # reported as unknown
    sensor_ahead_m: Annotated[float, Meta(ge=-5.0, le=5.0)] = 1.5  # of the rear axle, on the roof, looking all round
    track_m: Annotated[float, Meta(gt=0.5, le=3.0)] = 1.53


@dataclass(frozen=True, slots=True, kw_only=True)
class Biases:
    """Drawn once per drive."""

    acceleration_m_s2: tuple[float, float, float]
    rate_rad_s: tuple[float, float, float]
    gnss_m: tuple[float, float]
    wheel_scale: tuple[float, float, float, float]
    road_wheel_angle_rad: float


@dataclass(frozen=True, slots=True)
class Thing:
    """Something the object sensor can see."""

    kind: str
    x_m: float
    y_m: float
    radius_m: float


def draw_biases(settings: SensorSettings, random: Random) -> Biases:
    def three(sigma: float) -> tuple[float, float, float]:
        return random.gauss(0, sigma), random.gauss(0, sigma), random.gauss(0, sigma)

    scale = settings.wheel_scale
    return Biases(
        acceleration_m_s2=three(settings.imu_acceleration_bias_m_s2),
        rate_rad_s=three(settings.imu_rate_bias_rad_s),
        gnss_m=(random.gauss(0, settings.gnss_bias_m), random.gauss(0, settings.gnss_bias_m)),
        wheel_scale=(random.gauss(1, scale), random.gauss(1, scale), random.gauss(1, scale), random.gauss(1, scale)),
        road_wheel_angle_rad=random.gauss(0, settings.road_wheel_angle_bias_rad),
    )


def imu(car: Car, biases: Biases, settings: SensorSettings, random: Random, now_ns: int, slope_rad: float = 0.0) -> Imu:
    """Specific force at the rear axle in the body's frame: gravity shows in x and y when the body pitches and rolls.

    slope_rad: of the ground along the car, uphill positive. What gravity does to a car that rolls on it is not felt.
    """
    pitch = car.pitch_rad - slope_rad
    noise, rate_noise = settings.imu_acceleration_m_s2, settings.imu_rate_rad_s
    rough = settings.road_roughness_m_s2 * min(abs(car.body.vx_m_s) / 5.0, 1.0)
    bx, by, bz = biases.acceleration_m_s2
    rx, ry, rz = biases.rate_rad_s
    return Imu(
        stamp_ns=now_ns,
        acceleration_x_m_s2=car.body.ax_m_s2 - GRAVITY_M_S2 * sin(pitch) + random.gauss(bx, noise),
        acceleration_y_m_s2=car.body.ay_m_s2 + GRAVITY_M_S2 * sin(car.roll_rad) + random.gauss(by, noise),
        acceleration_z_m_s2=(GRAVITY_M_S2 * cos(pitch) * cos(car.roll_rad) + random.gauss(bz, hypot(noise, rough))),
        roll_rate_rad_s=car.roll_rate_rad_s + random.gauss(rx, rate_noise),
        pitch_rate_rad_s=car.pitch_rate_rad_s + random.gauss(ry, rate_noise),
        yaw_rate_rad_s=car.body.yaw_rate_rad_s + random.gauss(rz, rate_noise),
    )


def gnss(car: Car, biases: Biases, settings: SensorSettings, random: Random, now_ns: int) -> Gnss:
    """Position of the rear axle. The claimed deviation covers noise and bias."""
    body = car.body
    return Gnss(
        stamp_ns=now_ns,
        x_m=body.x_m + random.gauss(biases.gnss_m[0], settings.gnss_m),
        y_m=body.y_m + random.gauss(biases.gnss_m[1], settings.gnss_m),
        deviation_m=hypot(settings.gnss_m, settings.gnss_bias_m),
        heading_rad=wrap_angle(body.heading_rad + random.gauss(0, settings.gnss_heading_rad)),
        heading_deviation_rad=settings.gnss_heading_rad,
    )


def wheel_speeds(
    car: Car, parameters: CarParameters, biases: Biases, settings: SensorSettings, random: Random, now_ns: int
) -> WheelSpeeds:
    """A standing wheel gives exactly 0: an encoder without pulses."""
    rolling = wheel_speeds_m_s(car, parameters.chassis, settings.track_m)
    front_left, front_right, rear_left, rear_right = (
        0.0 if speed == 0.0 else speed * scale + random.gauss(0, settings.wheel_m_s)
        for speed, scale in zip(rolling, biases.wheel_scale, strict=True)
    )
    angle = car.road_wheel_angle_rad + random.gauss(biases.road_wheel_angle_rad, settings.road_wheel_angle_rad)
    return WheelSpeeds(
        stamp_ns=now_ns,
        front_left_m_s=front_left,
        front_right_m_s=front_right,
        rear_left_m_s=rear_left,
        rear_right_m_s=rear_right,
        road_wheel_angle_rad=min(max(angle, -0.8), 0.8),
    )


def things_of(objects: Sequence[StaticObject]) -> tuple[Thing, ...]:
    """Static objects as the sensor resolves them: a long barrier is several detections side by side."""
    return tuple(part for thing in objects for part in _parts(thing))


def _parts(thing: StaticObject) -> list[Thing]:
    count = max(1, ceil(thing.length_m / 0.8))
    piece = thing.length_m / count
    c, s = cos(thing.heading_rad), sin(thing.heading_rad)
    radius, lefts = max(piece, thing.width_m) / 2, [(i + 0.5) * piece - thing.length_m / 2 for i in range(count)]
    return [Thing(thing.kind, thing.x_m - left * s, thing.y_m + left * c, radius) for left in lefts]


def object_list(
    car: Outline, things: Sequence[Thing], buildings: Sequence[Polygon], settings: SensorSettings, random: Random, now_ns: int
) -> ObjectList:
    """One scan: what is in range and not behind a building, in the car's frame, with noise, misses, false objects."""
    ahead = settings.sensor_ahead_m
    eye = (car.x_m + ahead * cos(car.heading_rad), car.y_m + ahead * sin(car.heading_rad))
    seen = [thing for thing in things if _visible(eye, thing, buildings, settings.object_range_m)]
    detected = [_detection(car, thing, settings, random) for thing in seen if not _missed(eye, thing, settings, random)]
    false = [_false_object(settings, random) for _ in range(_poisson(settings.object_false_per_scan, random))]
    objects = detected + false
    random.shuffle(objects)  # the order says nothing about identity
    return ObjectList(stamp_ns=now_ns, range_m=settings.object_range_m, objects=tuple(objects))


def _visible(eye: tuple[float, float], thing: Thing, buildings: Sequence[Polygon], range_m: float) -> bool:
    place = (thing.x_m, thing.y_m)
    return hypot(place[0] - eye[0], place[1] - eye[1]) <= range_m and all(
        sees_through(eye, place, building) for building in buildings
    )


def _missed(eye: tuple[float, float], thing: Thing, settings: SensorSettings, random: Random) -> bool:
    share = hypot(thing.x_m - eye[0], thing.y_m - eye[1]) / settings.object_range_m
    return random.random() < settings.object_misses + (settings.object_misses_far - settings.object_misses) * share


def _detection(car: Outline, thing: Thing, settings: SensorSettings, random: Random) -> DetectedObject:
    ahead, left = to_car(car, thing.x_m, thing.y_m)
    sigma = settings.object_m + settings.object_per_m * hypot(ahead, left)
    kind = "unknown" if random.random() < settings.object_wrong_kind else thing.kind
    return DetectedObject(
        x_m=random.gauss(ahead, sigma), y_m=random.gauss(left, sigma), radius_m=thing.radius_m * random.uniform(0.9, 1.1), kind=kind
    )


def _false_object(settings: SensorSettings, random: Random) -> DetectedObject:
    """Anywhere in range, evenly over the area."""
    distance, bearing = settings.object_range_m * random.random() ** 0.5, random.uniform(-pi, pi)
    return DetectedObject(
        x_m=distance * cos(bearing), y_m=distance * sin(bearing), radius_m=random.uniform(0.1, 0.5), kind="unknown"
    )


def _poisson(mean: float, random: Random) -> int:
    """A count with that mean: exponential gaps that fit into one unit."""
    if mean <= 0.0:
        return 0
    count, used = 0, random.expovariate(mean)
    while used < 1.0:
        count, used = count + 1, used + random.expovariate(mean)
    return count
