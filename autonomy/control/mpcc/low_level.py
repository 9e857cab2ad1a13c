"""From the force that the tracker wants to the acceleration that is commanded, 100 Hz: feed-forward and feedback. Pure.

Feed-forward: the resistances that the car's own ECU makes up for are taken off, and the actuator's lag is undone by the rate at
which the force is to change. Feedback: acceleration that no command explains (a slope, a load, a wrong mass) is believed with a
lag and made up for. The paper, III-E. It is taken from the speed, as an accelerometer does not feel what gravity does along a
slope. At standstill the brakes close softly and hold; who rolls backwards is braked firmly.
"""

from typing import NamedTuple

from autonomy.control.mpcc.car import Car
from autonomy.control.mpcc.model import resistance
from autonomy.control.mpcc.settings import MpccSettings

ROLLS_M_S = 0.02
MOVES_M_S = 0.5  # a slower car is held by its brakes, unless it is driven: then its speed says nothing


LEAP_M_S = 0.5  # from one cycle to the next


class Disturbance(NamedTuple):
    """Acceleration that nobody asked for, as far as it is believed."""

    acceleration_m_s2: float = 0.0
    speed_m_s: float | None = None  # what commands and that acceleration make of the speed, behind the measured one by a lag


def disturbance(before: Disturbance, speed_m_s: float, explained_m_s2: float, dt_s: float, settings: MpccSettings) -> Disturbance:
    """What is believed next. explained: the acceleration that the commands make, on level ground.

    With s' = explained + d and d = (v - s) / lag, d follows v' - explained with that lag, and nothing is differentiated.
    A speed that leaps is another estimate of it, not a car that was pushed.
    """
    lag, most, believed = settings.disturbance_lag_s, settings.disturbance_max_m_s2, before.acceleration_m_s2
    if before.speed_m_s is not None and (speed_m_s >= MOVES_M_S or explained_m_s2 > 0.0):
        leaps = abs(speed_m_s - before.speed_m_s - lag * believed) > LEAP_M_S
        expected = speed_m_s - lag * believed if leaps else before.speed_m_s + dt_s * (explained_m_s2 + believed)
        believed = min(max((speed_m_s - expected) / lag, -most), most)
    return Disturbance(believed, speed_m_s - lag * believed)


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
