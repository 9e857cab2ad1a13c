"""When the picture to the rear is wanted: the car renders and sends it then, the window shows it then. One rule for both. Pure.

Reverse asked for is enough: the gate lets nobody reverse before the picture is there. An indicator asks for it too: who moves
aside looks behind first. Hazard lights do not.
"""

from wire.messages.base import Gear, Indicators
from wire.messages.vehicle import VehicleState

REAR = "rear"  # name of the camera that looks backwards
LINGER_NS = 1_500_000_000  # ours: it stays for so long after the last wish, so that a short tap does not make it flicker


def is_rear_asked_for(state: VehicleState) -> bool:
    """Whether this state of the car asks for the picture now."""
    asked = state.requested
    return Gear.REVERSE in (asked.gear, state.gear) or asked.indicators is not Indicators.OFF


def is_rear_wanted(asked_ns: int | None, now_ns: int) -> bool:
    """Whether it is still wanted. asked_ns: when a state last asked for it, on the caller's clock; None: never."""
    return asked_ns is not None and now_ns - asked_ns <= LINGER_NS
