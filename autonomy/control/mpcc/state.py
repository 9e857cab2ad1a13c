"""What the tracker is given, what it remembers and what it answers. Plain data."""

from dataclasses import dataclass
from typing import NamedTuple

from msgspec import Struct
from msgspec.structs import astuple

from autonomy.car_shape import CarShape
from autonomy.control.mpcc.car import Car, car_of
from autonomy.control.mpcc.cost import Limits, Prices
from autonomy.control.mpcc.delay import NOTHING_SENT, Sent
from autonomy.control.mpcc.low_level import Disturbance
from autonomy.control.mpcc.reference import Reference
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.planning.horizon import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """Rear axle in the map frame, and what the car's own sensors say, at one time."""

    stamp_ns: int
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float
    yaw_rate_rad_s: float
    road_wheel_angle_rad: float
    acceleration_m_s2: float
    lateral_m_s: float | None = None  # of the rear axle, left positive; None: as in a steady bend


class Setup(NamedTuple):
    """What does not change during a drive."""

    settings: MpccSettings
    car: Car
    limits: Limits
    prices: Prices


class TrackerState(Struct, frozen=True):
    now_ns: int = 0
    sent: Sent = NOTHING_SENT
    inputs: Floats | None = None  # (N, 3) of the last solution
    reference: Reference | None = None
    station_m: float = 0.0  # on that reference
    disturbance: Disturbance = Disturbance()
    angle_rad: float | None = None  # commanded last
    acceleration_m_s2: float = 0.0


class Tracked(Struct, frozen=True, kw_only=True):
    """The command, and how it came about."""

    road_wheel_angle_rad: float
    road_wheel_rate_rad_s: float
    force_n: float  # of all wheels, when the command begins to act
    acceleration_m_s2: float
    refused: str = ""  # why it brakes; then the rest says nothing
    station_m: float = 0.0
    contour_m: float = 0.0  # of the state that was planned from, left of the path positive
    wanted_m_s: float = 0.0
    iterations: int = 0
    expected: Floats | None = None  # (N + 1, 9) states, for looking at


def set_up(settings: MpccSettings, shape: CarShape) -> Setup:
    """Raises ValueError for a car that the model cannot follow."""
    braking_max = min(settings.braking_max_m_s2, shape.braking_max_m_s2)
    limits = Limits(
        rate=settings.steering_rate_max_rad_s,
        jerk=settings.jerk_max_m_s3,
        angle=shape.road_wheel_angle_max_rad,
        push_low=-braking_max,
        push_high=settings.acceleration_max_m_s2 + 0.5,  # and what resistances take
        friction=settings.friction_share,
    )
    # Floats throughout: an integer would have the kernels compiled anew for its type.
    prices = Prices(*map(float, astuple(settings.weights)))
    return Setup(settings, car_of(settings.car, shape), Limits(*map(float, limits)), prices)
