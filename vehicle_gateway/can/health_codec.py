"""How the ECU, which has no link, tells the health of its loop: two frames a second on the vehicle bus. Pure.

ECU_HEALTH (cycles, late ones, worst lateness) and then ECU_LOAD (CPU seconds, usual lateness, scheduling): the second
completes the report, and the gateway passes it on. Counters stop at the limit of their field, after some 46 hours.
Nothing about driving depends on them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import Layout, layouts
from wire.messages.health import LoopHealth
from wire.topics import ECU

LOOP = "cycle"
PERIOD_MS = 10.0


@dataclass(frozen=True, slots=True)
class HealthState:
    trails: Mapping[int, Trail] = field(default_factory=dict)  # by arbitration id  # newest received, by arbitration id
    loop: tuple[float, ...] | None = None  # of the newest ECU_HEALTH
    report: tuple[float, ...] | None = None  # newest complete one; a NEW object with every report


@dataclass(frozen=True, slots=True)
class HealthCodec:
    """The ECU's health by one DBC."""

    loop: Layout
    load: Layout

    def speaks(self, frame: Frame) -> bool:
        return frame.arbitration_id in (self.loop.arbitration_id, self.load.arbitration_id)

    def encode(self, health: LoopHealth, counter: int) -> tuple[Frame, Frame]:
        """Both frames, in the order in which they are sent."""
        priority = health.scheduling.removeprefix("fifo ")
        loop = (health.cycles, health.late_cycles, health.lateness_max_ms)
        load = (health.process_cpu_s, health.lateness_p50_ms, int(priority) if priority.isdigit() else 0)
        return self.loop.pack(loop, counter), self.load.pack(load, counter)

    def decode(self, state: HealthState, frame: Frame) -> tuple[HealthState, str]:
        """The state after one frame that it speaks, and why the frame was dropped ("" when it was not)."""
        layout = self.loop if frame.arbitration_id == self.loop.arbitration_id else self.load
        trail, values, reason = layout.receive(frame, state.trails.get(frame.arbitration_id, START))
        state = replace(state, trails={**state.trails, frame.arbitration_id: trail})
        if values is None:
            return state, reason
        if layout is self.loop:
            return replace(state, loop=values), ""
        return (state if state.loop is None else replace(state, report=(*state.loop, *values))), ""


def health_codec_of(frames: Mapping[str, Layout]) -> HealthCodec | None:
    """None for a car whose DBC has no such frames."""
    loop, load = frames.get("ECU_HEALTH"), frames.get("ECU_LOAD")
    return HealthCodec(loop, load) if loop is not None and load is not None else None


SHIPPED = HealthCodec(layouts()["ECU_HEALTH"], layouts()["ECU_LOAD"])


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
