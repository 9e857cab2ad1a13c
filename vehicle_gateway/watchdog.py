"""The independent watchdog: is what the gateway puts on the bus alive and plausible? Pure.

It trusts nothing but frames: their E2E counters, their modes, the source stamp behind them, and the car's own speed. It steers
nothing and ends no process; it asks the ECU to stop, and goes on until the gateway has been sane for a while and the car stands.
What the ECU sees by itself (no valid frame for 100 ms) it has answered long before; the watchdog is for what looks alive.
Source of the time-out: ArduPilot Rover's 200 ms; of the modes: the table of `authority`.
"""

from typing import Annotated

from msgspec import Meta
from msgspec.structs import replace

from vehicle_gateway.authority import DRIVES, Source
from vehicle_gateway.can.watch_codec import Fault
from wire.messages.base import Message, Milliseconds, Seconds, TimeNs
from wire.messages.vehicle import Mode

STANDS_BELOW_M_S = 0.05
MOVES_FROM_M_S = 0.3
STOPS = (Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP, Mode.LOCAL_DRIVER)  # how a safe stop may go on while the car moves
UNDRIVEN = (Mode.STANDBY, Mode.SAFE_STOP, Mode.STOPPED, Mode.EMERGENCY_STOP, Mode.LOCAL_DRIVER)  # the gateway asks for no traction
DRIVEN = tuple(mode for mode in Mode if DRIVES[mode] in (Source.OPERATOR, Source.AUTONOMY) and mode is not Mode.HANDING_OVER)


class WatchLimits(Message):
    silent_ms: Annotated[float, Meta(ge=100.0, le=1000.0)] = 200.0
    undriven_ms: Annotated[float, Meta(ge=20.0, le=1000.0)] = 200.0
    starved_ms: Milliseconds = 700.0  # ours: the gateway itself stops after 500 ms of silence
    slept_ms: Milliseconds = 60.0  # ours, three of its own periods: it was away itself, and accuses nobody of that time
    sane_s: Seconds = 1.0  # ours: so long before the ECU may follow again


class Heard(Message):
    """The newest of the bus, by the time it was received; 0: never."""

    command_ns: TimeNs = 0
    mode: Mode = Mode.STANDBY
    acceleration_m_s2: float = 0.0
    sources: int | None = None  # None: this car has no such frame
    motion_ns: TimeNs = 0
    speed_m_s: float = 0.0


class Watch(Message):
    """What is remembered from one look to the next."""

    fault: Fault = Fault.NONE
    looked_ns: TimeNs = 0
    awake_since_ns: TimeNs = 0  # since when it has looked without a break
    mode: Mode = Mode.STANDBY
    mode_since_ns: TimeNs = 0
    sources: int | None = None
    sources_since_ns: TimeNs = 0
    undriven_since_ns: TimeNs = 0  # 0: no traction where nobody drives
    left_stop: bool = False  # out of a safe stop while moving; until it stands
    sane_since_ns: TimeNs = 0  # 0: it is not


def watch_step(watch: Watch, heard: Heard, now_ns: int, limits: WatchLimits) -> Watch:
    """One look; its fault is what the ECU is told."""
    if not heard.command_ns:
        return watch  # no gateway yet: the car stands, its ECU holds it
    stands = abs(heard.speed_m_s) < STANDS_BELOW_M_S and (now_ns - heard.motion_ns) / 1e6 <= limits.silent_ms
    pushed = heard.mode in UNDRIVEN and heard.acceleration_m_s2 > 0.0
    left = watch.mode is Mode.SAFE_STOP and heard.mode not in STOPS and abs(heard.speed_m_s) >= MOVES_FROM_M_S
    seen = replace(
        watch,
        looked_ns=now_ns,
        awake_since_ns=watch.awake_since_ns if (now_ns - watch.looked_ns) / 1e6 <= limits.slept_ms else now_ns,
        mode=heard.mode,
        mode_since_ns=watch.mode_since_ns if heard.mode is watch.mode else now_ns,
        sources=heard.sources,
        sources_since_ns=watch.sources_since_ns if heard.sources == watch.sources else now_ns,
        undriven_since_ns=(watch.undriven_since_ns or now_ns) if pushed else 0,
        left_stop=(watch.left_stop or left) and not stands,
    )
    fault = fault_of(seen, heard, now_ns, limits)
    sane_since_ns = 0 if fault else (watch.sane_since_ns or now_ns)
    sane = bool(sane_since_ns) and (now_ns - sane_since_ns) / 1e9 >= limits.sane_s
    kept = Fault.NONE if sane and stands else watch.fault
    return replace(seen, fault=fault or kept, sane_since_ns=sane_since_ns)


def fault_of(watch: Watch, heard: Heard, now_ns: int, limits: WatchLimits) -> Fault:
    """What is wrong now, the worst first."""

    def since_ms(at_ns: int) -> float:
        return (now_ns - at_ns) / 1e6

    awake_ns = watch.awake_since_ns
    starving_ms = since_ms(max(watch.mode_since_ns, watch.sources_since_ns, awake_ns))
    table = (
        (since_ms(max(heard.command_ns, awake_ns)) > limits.silent_ms, Fault.SILENT),
        (bool(watch.undriven_since_ns) and since_ms(max(watch.undriven_since_ns, awake_ns)) >= limits.undriven_ms, Fault.UNDRIVEN),
        (watch.left_stop, Fault.LEFT_STOP),
        (heard.mode in DRIVEN and heard.sources is not None and starving_ms > limits.starved_ms, Fault.STARVED),
    )
    return next((fault for wrong, fault in table if wrong), Fault.NONE)
