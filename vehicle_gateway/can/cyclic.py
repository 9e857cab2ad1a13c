"""Which cyclic frames are due, each with a counter of its own. Pure.

The gateway's cycle comes every 4 to 10 ms, a frame has its own period: it is sent in the first cycle of its slot, and the
slots keep their phase. Nothing repeats a frame between cycles: no kernel broadcast manager, no thread. When the gateway
stops, its frames stop.
"""

from collections.abc import Iterable

from vehicle_gateway.can.transmit import Sendable
from wire.messages.base import Message

EARLY = 0.25  # of a period: a cycle that comes that much early still sends, instead of a whole cycle late


class Sent(Message):
    """By name of the frame."""

    due_ns: dict[str, int] = {}  # start of the next slot
    counts: dict[str, int] = {}  # frames sent


def take_due(sent: Sent, layouts: Iterable[Sendable], now_ns: int) -> tuple[Sent, dict[str, int]]:
    """The state after this cycle, and the counter of each frame that is due in it, by name, in the order of the layouts."""
    due, counts, counters = dict(sent.due_ns), dict(sent.counts), {}
    for layout in layouts:
        name, period_ns = layout.name, layout.least_period_ms * 1_000_000
        slot_ns = due.get(name, now_ns)
        if now_ns < slot_ns - EARLY * period_ns:
            continue
        late = now_ns >= slot_ns + period_ns
        due[name] = (now_ns if late else slot_ns) + period_ns
        counters[name] = counts.get(name, 0)
        counts[name] = counters[name] + 1
    return Sent(due_ns=due, counts=counts), counters
