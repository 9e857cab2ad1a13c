"""How much time a take-over request gives, and the slowing that ends at standstill with it. Pure.

Constant gentle deceleration over d metres from v ends after t = 2 d / v. An attentive operator needs about 15 s (the
reference notes on remote driving), so what is farther off waits, and what is nearer gives less.
"""

from typing import Annotated, NamedTuple

from msgspec import Meta

from wire.messages.base import Message

Positive = Annotated[float, Meta(gt=0.0, le=100.0)]
STANDS_M_S = 0.3


class BudgetSettings(Message):
    most_s: Positive = 15.0
    deceleration_max_m_s2: Positive = 2.0


class Slowing(NamedTuple):
    budget_s: float
    distance_m: float  # to standstill
    deceleration_m_s2: float


def slowing(speed_m_s: float, distance_m: float, settings: BudgetSettings) -> Slowing:
    """distance_m: to where the car has to stand. A standing car has the whole budget and stays where it is."""
    if speed_m_s < STANDS_M_S:
        return Slowing(settings.most_s, 0.0, settings.deceleration_max_m_s2)
    least = speed_m_s / settings.deceleration_max_m_s2
    budget = min(max(2.0 * distance_m / speed_m_s, least), settings.most_s)
    return Slowing(budget, speed_m_s * budget / 2.0, speed_m_s / budget)


def relevant_distance_m(speed_limit_m_s: float, gap_m: float, settings: BudgetSettings) -> float:
    """From the bumper: what is nearer than this leaves no more than the whole budget at the speed limit."""
    return speed_limit_m_s * settings.most_s / 2.0 + gap_m
