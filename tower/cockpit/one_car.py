"""One operator drives one car: whether another car that this tower sees is held by the same operator. Pure.

Cars do not talk to each other, so this is the tower's to keep; it sees the cars that have dialled it, and the one it dials.
"""

from collections.abc import Iterable

from wire.latest import Received
from wire.messages.vehicle import GatewayStatus

FRESH_NS = 1_500_000_000  # the status is told at 20 Hz; older than this nobody knows who holds that car
SILENT_S = 5.0  # a lease whose holder is silent for so long is the next one's (architecture)


def held_elsewhere(
    others: Iterable[tuple[str, Received[GatewayStatus] | None]], operator: str, certificate: str, now_ns: int
) -> str:
    """Why no other car may be asked for now, in words; "" when it may.

    others       the other cars by their id, and what was last heard of each
    certificate  common name of the cockpit's own: somebody of the same name with another one is another person
    """
    for vehicle_id, heard in others:
        if heard is None or now_ns - heard.received_ns > FRESH_NS:
            continue
        status = heard.message
        mine = (status.lease_holder, status.lease_certificate) == (operator, certificate) and status.lease_silent_s < SILENT_S
        is_next = bool(status.succession.lease_epoch) and status.succession.operator == operator
        if mine or is_next:
            return f"you hold {vehicle_id}: one operator drives one car; close the cockpit that holds it"
    return ""
