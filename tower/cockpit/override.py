"""Passing what the car's collision guard holds it for: one press of "take over" while it holds the car. Pure.

The car decides whether it counts (below walking pace only, and it records every cycle); here a press becomes a wish that
lasts a few seconds and ends by itself. A press at any other time is no such wish.
"""

from wire.messages.vehicle import Mode, VehicleState

LASTS_NS = 5_000_000_000  # ours: at walking pace a car's length and a half; longer needs another press
WALKING_M_S = 1.5  # as the car's: 5 km/h and its ripple
HELD = ("holding", "braking", "overridden")  # VehicleState.guard


def override_until_ns(until_ns: int, pressed: frozenset[str], mode: Mode | None, state: VehicleState | None, now_ns: int) -> int:
    """Until when the wish lasts.

    state  the newest of the car, None before the first
    """
    return now_ns + LASTS_NS if is_held(mode, state) and "accept" in pressed else until_ns


def is_held(mode: Mode | None, state: VehicleState | None) -> bool:
    """Whether the collision guard holds the car of an operator who drives at walking pace."""
    return mode is Mode.REMOTE and state is not None and state.guard in HELD and abs(state.speed_m_s) <= WALKING_M_S
