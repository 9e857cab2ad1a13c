"""Pure pursuit: the tracker everybody knows, beside which the predictive one is measured. Pure, 100 Hz.

Steers along the arc through a point of the path ahead; speed by the reference's acceleration and the error a moment ahead. Delays
are bridged by carrying the pose on along its present arc; nothing else is modelled. Source: Coulter, CMU-RI-TR-92-01; Snider,
CMU-RI-TR-09-08, 2.2 (look-ahead in proportion to speed).
"""

from math import atan, atan2, cos, hypot, inf, nan, sin, sqrt
from typing import Annotated

from msgspec import Meta

from autonomy.control.mpcc.reference import Reference, foot, square_at
from autonomy.control.mpcc.state import Measured
from autonomy.planning.mpc.line import piece_of, spot
from wire.messages.base import Message

Positive = Annotated[float, Meta(gt=0.0, le=50.0)]


class PursuitSettings(Message):
    """Tuned on the same track as the other tracker: the best of 32 drawn sets, then a look-ahead that stays stable 20 % shorter."""

    look_ahead_s: Positive = 0.28
    look_ahead_least_m: Positive = 2.2
    delay_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.055  # from the stamp to the effect, lags included
    speed_ahead_s: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.06  # the wanted speed is read so far ahead: the drive's lag
    speed_gain_1_s: Positive = 3.3
    hold_m_s2: Positive = 0.8


def pursue(
    measured: Measured, reference: Reference, wheelbase_m: float, angle_max_rad: float, settings: PursuitSettings
) -> tuple[float, float]:
    """Road wheel angle and acceleration; no number where the path runs nowhere near."""
    speed, dt = measured.speed_m_s, settings.delay_s
    heading = measured.heading_rad + measured.yaw_rate_rad_s * dt
    middle = (measured.heading_rad + heading) / 2.0
    x, y = measured.x_m + speed * dt * cos(middle), measured.y_m + speed * dt * sin(middle)
    station = foot(reference.line, x, y, heading, 0.0, inf)
    if station != station:
        return nan, nan
    goal = station + max(settings.look_ahead_s * speed, settings.look_ahead_least_m)
    there = spot(reference.line, goal, piece_of(reference.line, goal, 0))
    bearing = atan2(there.y - y, there.x - x) - heading
    angle = atan(2.0 * wheelbase_m * sin(bearing) / max(hypot(there.y - y, there.x - x), 0.1))
    square, slope = square_at(reference.stations_m, reference.squares_m2_s2, station + settings.speed_ahead_s * speed)
    acceleration = slope + settings.speed_gain_1_s * (sqrt(square) - speed)
    if square < 0.01 and slope <= 0.0 and speed < 0.3:
        acceleration = -settings.hold_m_s2
    return min(max(angle, -angle_max_rad), angle_max_rad), acceleration
