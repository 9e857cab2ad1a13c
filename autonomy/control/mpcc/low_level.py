"""From the force that the tracker wants to the acceleration that is commanded, 100 Hz: feed-forward and feedback. Pure.

Feed-forward: the resistances that the car's own ECU makes up for are taken off, and the actuator's lag is undone by the rate at
which the force is to change. Feedback: acceleration that no command explains (a slope, a load, a wrong mass) is believed with a
lag and made up for. The paper, III-E. It is taken from the speed, as an accelerometer does not feel what gravity does along a
slope. At standstill the brakes close softly and hold.
"""

from typing import NamedTuple

from autonomy.control.mpcc.car import Car
from autonomy.control.mpcc.model import resistance
from autonomy.control.mpcc.settings import MpccSettings

ROLLS_M_S = 0.02
MOVES_M_S = 0.5  # of a slower car that is not driven brakes hold the speed, and it says nothing
LEAP_M_S, GAP_S = 0.5, 0.05  # from one cycle to the next
GENTLE_M_S2 = 0.5  # of braking that somebody else asks for: less is no braking yet


class Disturbance(NamedTuple):
    """Acceleration that nobody asked for, as far as it is believed."""

    acceleration_m_s2: float = 0.0
    stamp_ns: int = 0  # of the measured speed that it was last compared with
    speed_m_s: float = 0.0


def disturbance(
    before: Disturbance, stamp_ns: int, speed_m_s: float, felt_m_s2: float, explained_m_s2: float, settings: MpccSettings
) -> Disturbance:
    """What is believed next. felt: by the accelerometer; explained: the acceleration that the commands make, on level ground.

    A car that is held feels the slope it stands on; else the speed tells. A speed that leaps is another estimate of it, not a car
    that was pushed, and what it gained over a gap tells nothing.
    """
    most, believed = settings.disturbance_max_m_s2, before.acceleration_m_s2
    dt_s, gained = (stamp_ns - before.stamp_ns) * 1e-9, speed_m_s - before.speed_m_s
    unexplained = 0.0
    if 0.0 < dt_s <= GAP_S and abs(gained) <= LEAP_M_S:
        if speed_m_s >= MOVES_M_S or explained_m_s2 > 0.0:
            unexplained = gained - dt_s * (explained_m_s2 + believed)
        elif abs(speed_m_s) <= ROLLS_M_S:
            unexplained = -dt_s * (felt_m_s2 + believed)
    believed = min(max(believed + unexplained / settings.disturbance_lag_s, -most), most)
    return Disturbance(believed, stamp_ns, speed_m_s)


def bounded(wanted_m_s2: float, most_m_s2: float, disturbance_m_s2: float) -> float:
    """Not above a bound of the car's own acceleration. Downhill that takes more braking; uphill more drive, not less braking."""
    uphill = min(max(1.0 + most_m_s2 / GENTLE_M_S2, 0.0), 1.0)
    return min(wanted_m_s2, most_m_s2 - (disturbance_m_s2 if disturbance_m_s2 > 0.0 else uphill * disturbance_m_s2))


def acceleration(
    push_m_s2: float, jerk_m_s3: float, speed_m_s: float, disturbance_m_s2: float, car: Car, settings: MpccSettings
) -> float:
    """The command. push: force over mass that the tracker's model has now, and the rate it wants of it."""
    lag = car.drive_lag if push_m_s2 >= 0.0 else car.brake_lag
    wanted = push_m_s2 + jerk_m_s3 * lag - resistance(speed_m_s, car)[0] - disturbance_m_s2
    return min(max(wanted, -settings.braking_max_m_s2), settings.acceleration_max_m_s2)


def standing(before_m_s2: float, speed_m_s: float, disturbance_m_s2: float, dt_s: float, settings: MpccSettings) -> float:
    """The command of a car that stands or is about to: softly to standstill, also downhill, then held."""
    if speed_m_s < -ROLLS_M_S:
        return braking(before_m_s2, speed_m_s, dt_s, settings)
    wanted = -max(settings.settle_m_s2 + disturbance_m_s2, 0.0) if speed_m_s > ROLLS_M_S else -settings.hold_m_s2
    return towards(before_m_s2, wanted, settings.fallback_jerk_m_s3 * dt_s)


def braking(before_m_s2: float, speed_m_s: float, dt_s: float, settings: MpccSettings) -> float:
    """The command when there is nothing to follow. speed NaN: as if it moved."""
    wanted = -(settings.hold_m_s2 if abs(speed_m_s) <= ROLLS_M_S else settings.fallback_m_s2)
    return towards(min(before_m_s2, 0.0), wanted, settings.fallback_jerk_m_s3 * dt_s)


def towards(before: float, wanted: float, step: float) -> float:
    return before + min(max(wanted - before, -step), step)
