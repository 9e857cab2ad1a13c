"""How the ECU, which has no link, tells the health of its loop: two frames a second on the vehicle bus. Pure.

ECU_HEALTH (cycles, late ones, worst lateness) and then ECU_LOAD (CPU seconds, usual lateness, scheduling): the second
completes the report, and the gateway passes it on. Counters stop at the limit of their field, after some 46 hours.
Nothing about driving depends on them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from vehicle_gateway.can import e2e
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts
from wire.messages.health import LoopHealth
from wire.topics import ECU

LOOP = "cycle"
PERIOD_MS = 10.0
_LAYOUTS = layouts()
_HEALTH, _LOAD = _LAYOUTS["ECU_HEALTH"], _LAYOUTS["ECU_LOAD"]
_BY_ID = {layout.arbitration_id: layout for layout in (_HEALTH, _LOAD)}
HEALTH_IDS = frozenset(_BY_ID)


@dataclass(frozen=True, slots=True)
class HealthState:
    counters: Mapping[int, int] = field(default_factory=dict)  # newest received, by arbitration id
    loop: tuple[float, ...] | None = None  # of the newest ECU_HEALTH
    report: tuple[float, ...] | None = None  # newest complete one; a NEW object with every report


def encode_health(health: LoopHealth, counter: int) -> tuple[Frame, Frame]:
    """Both frames, in the order in which they are sent."""
    priority = health.scheduling.removeprefix("fifo ")
    loop = (health.cycles, health.late_cycles, health.lateness_max_ms)
    load = (health.process_cpu_s, health.lateness_p50_ms, int(priority) if priority.isdigit() else 0)
    return _HEALTH.pack(loop, counter), _LOAD.pack(load, counter)


def decode_health(state: HealthState, frame: Frame) -> tuple[HealthState, str]:
    """The state after one frame of HEALTH_IDS, and why the frame was dropped ("" when it was not)."""
    layout = _BY_ID[frame.arbitration_id]
    values, reason = layout.receive(frame, state.counters.get(frame.arbitration_id))
    if reason != "can crc":
        state = replace(state, counters={**state.counters, frame.arbitration_id: e2e.counter_of(frame)})
    if values is None:
        return state, reason
    if layout is _HEALTH:
        return replace(state, loop=values), ""
    return (state if state.loop is None else replace(state, report=(*state.loop, *values))), ""


def health_of(report: tuple[float, ...], now_ns: int) -> LoopHealth:
    """The ECU's report as everybody else's, stamped when it is passed on."""
    cycles, late_cycles, worst_ms, cpu_s, p50_ms, priority = report
    return LoopHealth(
        stamp_ns=now_ns,
        process=ECU,
        loop=LOOP,
        period_ms=PERIOD_MS,
        cycles=int(cycles),
        late_cycles=int(late_cycles),
        lateness_p50_ms=p50_ms,
        lateness_max_ms=worst_ms,
        scheduling=f"fifo {int(priority)}" if priority else "other",
        dropped={},
        process_cpu_s=cpu_s,
    )
