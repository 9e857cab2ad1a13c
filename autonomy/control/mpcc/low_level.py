"""From the force that the tracker wants to the acceleration that is commanded, 100 Hz: feed-forward and feedback. Pure.

Feed-forward: the resistances that the car's own ECU makes up for are taken off, and the actuator's lag is undone by the rate at
which the force is to change. Feedback: acceleration that no command explains (a slope, a load, a wrong mass) is believed with a
lag and made up for. The paper, III-E. At standstill the brakes close softly and hold.
"""

from autonomy.control.mpcc.car import Car
from autonomy.control.mpcc.model import resistance
from autonomy.control.mpcc.settings import MpccSettings

ROLLS_M_S = 0.02
MOVES_M_S = 0.5  # a slower car is held or released by its brakes: no acceleration says anything


def disturbance(
    before_m_s2: float, measured_m_s2: float, explained_m_s2: float, speed_m_s: float, dt_s: float, settings: MpccSettings
) -> float:
    """What is believed next of the acceleration that nobody asked for."""
    if speed_m_s < MOVES_M_S:
        return before_m_s2
    share = min(dt_s / settings.disturbance_lag_s, 1.0)
    believed = before_m_s2 + share * (measured_m_s2 - explained_m_s2 - before_m_s2)
    return min(max(believed, -settings.disturbance_max_m_s2), settings.disturbance_max_m_s2)


def acceleration(
    push_m_s2: float, jerk_m_s3: float, speed_m_s: float, disturbance_m_s2: float, car: Car, settings: MpccSettings
) -> float:
    """The command. push: force over mass that the tracker's model has now, and the rate it wants of it."""
    lag = car.drive_lag if push_m_s2 >= 0.0 else car.brake_lag
    wanted = push_m_s2 + jerk_m_s3 * lag - resistance(speed_m_s, car)[0] - disturbance_m_s2
    return min(max(wanted, -settings.braking_max_m_s2), settings.acceleration_max_m_s2)


def standing(before_m_s2: float, speed_m_s: float, dt_s: float, settings: MpccSettings) -> float:
    """The command of a car that stands or is about to: softly to standstill, then held."""
    wanted = -(settings.settle_m_s2 if speed_m_s > ROLLS_M_S else settings.hold_m_s2)
    return towards(before_m_s2, wanted, settings.fallback_jerk_m_s3 * dt_s)


def braking(before_m_s2: float, speed_m_s: float, dt_s: float, settings: MpccSettings) -> float:
    """The command when there is nothing to follow. speed NaN: as if it moved."""
    wanted = -(settings.hold_m_s2 if speed_m_s <= ROLLS_M_S else settings.fallback_m_s2)
    return towards(min(before_m_s2, 0.0), wanted, settings.fallback_jerk_m_s3 * dt_s)


def towards(before: float, wanted: float, step: float) -> float:
    return before + min(max(wanted - before, -step), step)
