"""Where the gateway believes the car is: the newest scene's pose carried on by odometry, how old and how sure. Pure.

The automation localizes; the gateway only carries its last pose on. Nothing here ever makes a pose better, and one that is
too old or too doubtful is none: `place_of` says None, and whoever needs a place has to do without.
"""

from math import cos, sin
from typing import Annotated

from msgspec import Meta, Struct

from vehicle_gateway.corridor import Odometry, Shift, advance
from wire.messages.automation import Scene
from wire.messages.base import Angle, Length, Message, Position, TimeNs


class PlaceLimits(Message):
    age_max_s: Annotated[float, Meta(ge=0.1, le=30.0)] = 3.0  # ours: 30 scenes missed; at 30 km/h 25 m by wheel speeds alone
    deviation_max_m: Annotated[float, Meta(ge=0.1, le=20.0)] = 1.0  # ours: more, and nobody knows which lane it is
    drift_per_m: Annotated[float, Meta(ge=0.0, le=0.2)] = 0.03  # ours: 1 % of wheel radius and 0.01 rad/s of yaw bias


class Fix(Message):
    """A pose of the newest scene, and the odometry at the moment it is valid for."""

    stamp_ns: TimeNs = 0  # 0: none yet
    x_m: Position = 0.0  # rear axle, map frame
    y_m: Position = 0.0
    heading_rad: Angle = 0.0
    deviation_m: Length = 0.0
    odometry: Odometry = Odometry()


class Place(Struct, frozen=True):
    x_m: float  # rear axle, map frame
    y_m: float
    heading_rad: float
    deviation_m: float  # one standard deviation, grown with the way since the fix
    age_s: float


def fix_of(scene: Scene, odometry: Odometry, speed_m_s: float, yaw_rate_rad_s: float, now_ns: int) -> Fix:
    """The scene's pose is `now - stamp` old: the odometry is taken back by that much."""
    return Fix(
        stamp_ns=scene.stamp_ns,
        x_m=scene.x_m,
        y_m=scene.y_m,
        heading_rad=scene.heading_rad,
        deviation_m=scene.deviation_m,
        odometry=advance(odometry, speed_m_s, yaw_rate_rad_s, -(now_ns - scene.stamp_ns) / 1e9),
    )


def shift_of(fix: Fix) -> Shift:
    """From the map frame into that of the odometry: the fix is the same place in both."""
    turn = fix.odometry.heading_rad - fix.heading_rad
    return Shift(fix.x_m, fix.y_m, fix.odometry.x_m, fix.odometry.y_m, cos(turn), sin(turn))


def place_of(fix: Fix, odometry: Odometry, now_ns: int, limits: PlaceLimits) -> Place | None:
    """None when the fix is too old, or too doubtful after the way since."""
    if not fix.stamp_ns:
        return None
    then = fix.odometry
    dx, dy, turn = odometry.x_m - then.x_m, odometry.y_m - then.y_m, fix.heading_rad - then.heading_rad
    age_s = (now_ns - fix.stamp_ns) / 1e9
    deviation = fix.deviation_m + limits.drift_per_m * (abs(dx) + abs(dy))
    if age_s > limits.age_max_s or deviation > limits.deviation_max_m:
        return None
    c, s = cos(turn), sin(turn)
    return Place(fix.x_m + dx * c - dy * s, fix.y_m + dx * s + dy * c, odometry.heading_rad + turn, deviation, age_s)
