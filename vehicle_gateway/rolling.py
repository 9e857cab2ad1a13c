"""Rolling away: the car moves against its gear, or at all while its brakes are held. Pure.

The ECU holds a standing car with the brakes, without us; here is noticed when that is not enough. Distance counts, not speed: a
sensor's last digit is no motion, and a slow creep down a hill is one.
"""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import Gear, Length, Message

_WAY = {Gear.DRIVE: 1.0, Gear.REVERSE: -1.0}


class RollingLimits(Message):
    rolled_m: Annotated[float, Meta(ge=0.02, le=2.0)] = 0.15  # ours: more than brakes give when they take up the load
    hold_hard_m_s2: Annotated[float, Meta(ge=-8.0, le=-2.0)] = -6.0  # as the emergency brake


class Rolling(Message):
    stood: bool = False  # since its brakes are held, the car has stood
    rolled_m: Length = 0.0  # so far the wrong way, or while held; 0 as soon as it stands or goes its way
    hold_hard: bool = False  # it rolled away: held with all the brakes have until somebody drives


def watch_rolling(
    before: Rolling,
    speed_m_s: float,
    gear: Gear,
    held: bool,
    driven: bool,
    dt_s: float,
    standstill_m_s: float,
    limits: RollingLimits,
) -> Rolling:
    """One cycle later.

    held    the gateway holds the brakes; driven  somebody moves the car: operator, automation, or the person in it
    """
    stands = abs(speed_m_s) < standstill_m_s
    stood = held and (before.stood or stands)
    backwards = speed_m_s * _WAY.get(gear, 0.0) < 0.0
    wrong = not stands and (backwards or stood)
    rolled_m = before.rolled_m + abs(speed_m_s) * dt_s if wrong else 0.0
    hold_hard = rolled_m > limits.rolled_m or (before.hold_hard and not driven)
    return Rolling(stood=stood, rolled_m=rolled_m, hold_hard=hold_hard)
