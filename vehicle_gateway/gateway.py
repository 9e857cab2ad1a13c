"""`vehicle-gateway run`: the shell around the cycle. Owns the car's hub, the vehicle bus and the clock; decides nothing.

A cycle runs on every valid command, at most 250 Hz, and otherwise on its own 10 ms deadline: silence from everybody still
gives a cycle, and a cycle that sees silence brakes.
"""

import logging
import secrets
import threading
import time
from contextlib import AbstractContextManager
from pathlib import Path

import msgspec

from vehicle_gateway.audit.file import audit_file
from vehicle_gateway.audit.log import AuditLog
from vehicle_gateway.audit.open import open_audit
from vehicle_gateway.can.bus import Bus, open_bus
from vehicle_gateway.can.cyclic import Sent, take_due
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.vehicles import CarBus, car_bus_of
from vehicle_gateway.cycle import step
from vehicle_gateway.identity import Verifier
from vehicle_gateway.inbox import Inbox, Replies, lease_reply_with_key
from vehicle_gateway.journal import Entry, Journal
from vehicle_gateway.memory import EPOCH_BLOCK, Memory, Remembered, default_file, recall
from vehicle_gateway.reports import newest_command_ns, status_of, vehicle_state_of
from vehicle_gateway.settings import VehicleGatewaySettings, limits_with_map, refuse_on_a_road
from vehicle_gateway.state import Inputs, Outputs, State, initial_state
from wire.clock import Clock, car_clock, utc_minus_monotonic_ns
from wire.configuration import read_sections
from wire.link import Link, open_link
from wire.link_threads import beneath
from wire.load import stolen_s
from wire.logs import fields
from wire.messages.operating import ClockPing, ClockPong
from wire.messages.vehicle import Mode, VehicleDescription
from wire.notify import NOBODY, Notifier, notifier
from wire.pace import Lateness, ready_for_a_loop
from wire.settings import WireSettings
from wire.site import override
from wire.topics import PROGRAMS, Role

log = logging.getLogger(__name__)
PROGRAM = PROGRAMS[Role.VEHICLE_HUB]
DEADLINE_NS = 10_000_000
SHORTEST_NS = 4_000_000  # 250 Hz
STATE_NS, STATUS_NS, SECOND_NS = 20_000_000, 50_000_000, 1_000_000_000


def run(config: Path, stop: threading.Event, connect: tuple[str, ...] = (), listen: tuple[str, ...] = ()) -> int:
    """The gateway until `stop` is set. Raises ConfigurationError and LinkError at start; an exception later exits 1.

    connect, listen  where to dial the tower, or wait for it, instead of what is configured
    """
    sections = read_sections(
        config, {"wire": WireSettings, "vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings}
    )
    wire: WireSettings = sections["wire"]
    settings: VehicleGatewaySettings = sections["vehicle_gateway"]
    limits = limits_with_map(settings, config)
    settings = msgspec.structs.replace(settings, limits=limits)
    refuse_on_a_road(settings, wire.link.accepts_script, wire.clock.real_time_factor)
    car = car_bus_of(settings.can, sections["vehicle"])
    link_settings = override(wire.link, "", connect, listen)
    file = Path(settings.memory) if settings.memory else default_file(wire.link.vehicle_id)
    remembered = recall(file)
    clock = car_clock(wire.clock)
    boot_id = secrets.token_hex(8)
    fifo, served = wire.pace.fifo_priority, beneath(wire.pace.fifo_priority)
    with (
        Memory(file) as memory,
        open_link(link_settings, Role.VEHICLE_HUB, clock, stop, hub=True, fifo_priority=served) as link,
        Verifier(link_settings, clock, utc_minus_monotonic_ns()) as verifier,
    ):
        inbox = Inbox(link, boot_id, verifier, clock, car)
        with (
            Journal(link, sections["vehicle"], limits, served) as journal,
            open_audit(link, audit_file(file), config, wire.link, boot_id, settings.map_origin, clock, served) as audit,
            open_car(settings.can, car, inbox, clock, fifo) as bus,
        ):
            gateway = Gateway(link, bus, inbox, memory, journal, audit, clock, sections["vehicle"], settings, remembered, car)
            can = f"{settings.can.interface} {settings.can.channel}"
            where = {"hub": wire.link.car_hub, "can": can, "boot_id": boot_id}
            log.info("started", extra=fields(vehicle=wire.link.vehicle_id, **where))
            with notifier() as manager:
                return gateway.run(stop, fifo, manager)


def open_car(settings: CanSettings, car: CarBus, inbox: Inbox, clock: Clock, fifo_priority: int) -> AbstractContextManager[Bus]:
    """The vehicle bus, with the list of what may be sent to this car: the one way out."""
    return open_bus(settings, "vehicle", inbox.on_frame, clock, fifo_priority=fifo_priority, permits=car.permits)


class Gateway:
    def __init__(
        self,
        link: Link,
        bus: Bus,
        inbox: Inbox,
        memory: Memory,
        journal: Journal,
        audit: AuditLog,
        clock: Clock,
        vehicle: VehicleDescription,
        settings: VehicleGatewaySettings,
        remembered: Remembered,
        car: CarBus,
    ) -> None:
        self._link, self._bus, self._inbox, self._memory, self._clock = link, bus, inbox, memory, clock
        self._journal, self._audit, self._manager = journal, audit, NOBODY
        self._codec, self._sent = car.codec, Sent()
        self._watch, self._shown = car.watch, Sent()
        self._vehicle, self._limits = vehicle, settings.limits
        self._epoch_reserved = remembered.epoch_reserved + EPOCH_BLOCK
        self._utc_ns = utc_minus_monotonic_ns()
        self.state = recalled_state(remembered, inbox.boot_id, clock.now_ns(), self._utc_ns)
        self._remembered = remember(self.state, self._epoch_reserved, self._utc_ns)  # as of the newest cycle
        self._lateness = Lateness(DEADLINE_NS)
        self._scheduling = "other"
        self._number = 0
        audit.counts = self._dropped
        self._told: dict[str, int] = {}  # when each periodic topic was last published
        link.on("clock_ping", self._on_ping)

    def _on_ping(self, ping: ClockPing, received_ns: int) -> None:
        self._link.publish(
            "clock_pong",
            ClockPong(number=ping.number, ping_sent_ns=ping.sent_ns, received_ns=received_ns, sent_ns=self._clock.now_ns()),
        )

    def run(self, stop: threading.Event, fifo_priority: int, manager: Notifier) -> int:
        """Cycles until `stop`. manager: of services, told once a second that cycles are made, and who drives."""
        self._scheduling, self._manager = ready_for_a_loop(fifo_priority), manager
        deadline_ns = self._clock.now_ns()
        try:
            while not stop.is_set():
                if not self._bus.reading:
                    raise RuntimeError("the reader of the vehicle bus has died")  # started again, we hear the car again
                now_ns, deadline_ns = self._wait(deadline_ns)
                self._cycle(now_ns)
        except Exception:  # noqa: BLE001 - whatever it is: the car must stop, and the ECU does that when we are silent
            self._audit.ending = "the gateway ended by an error"
            log.exception("ended by an error; the ECU stops the car")
            return 1
        return 0

    def _wait(self, deadline_ns: int) -> tuple[int, int]:
        """Until the deadline or a valid command, whichever is first. Now, and the next deadline."""
        earliest_ns = self.state.now_ns + SHORTEST_NS
        woken = self._inbox.wake.wait(self._clock.real_s(max(deadline_ns - self._clock.now_ns(), 0)))
        rest_ns = earliest_ns - self._clock.now_ns()
        if woken and rest_ns > 0:
            time.sleep(self._clock.real_s(rest_ns))  # an event nobody sets would do, at half as much again
        self._inbox.wake.clear()
        now_ns = self._clock.now_ns()
        self._lateness.add(min(deadline_ns, now_ns), now_ns)
        return now_ns, now_ns + DEADLINE_NS

    def _cycle(self, now_ns: int) -> None:
        inputs, replies = self._inbox.take(self.state.lease.certificate, self.state.successor.lease.certificate)
        before = self.state
        self.state, outputs = step(before, inputs, now_ns, self._vehicle, self._limits)
        if outputs.send:
            self._send(outputs, now_ns)
        sent_ns = self._clock.now_ns()
        self._answer(before, outputs, replies)
        self._remember()
        self._publish(before, inputs, outputs, now_ns, sent_ns)

    def _send(self, outputs: Outputs, now_ns: int) -> None:
        self._sent, frames = self._codec.commands(
            self._sent, outputs.applied, outputs.mode, outputs.brake_hold, self.state.feedback, now_ns
        )
        for frame in frames:
            self._bus.send(frame)
        self._show_watchdog(now_ns)

    def _show_watchdog(self, now_ns: int) -> None:
        """The newest command of who drives: a cycle that hangs cannot make it newer."""
        if self._watch is not None:
            self._shown, counters = take_due(self._shown, (self._watch.sources,), now_ns)
            for counter in counters.values():
                self._bus.send(self._watch.encode_sources(newest_command_ns(self.state), counter))

    def _answer(self, before: State, outputs: Outputs, replies: Replies) -> None:
        self._inbox.open_for(before, self.state, lambda _: secrets.token_bytes(32))
        for reply, lease_answer in zip(replies.lease, outputs.lease_replies, strict=True):
            reply(lease_reply_with_key(lease_answer, self._inbox.key_of(lease_answer.epoch)))
        for reply, answer in zip(replies.hand_over, outputs.hand_over_replies, strict=True):
            reply(answer)
        for reply, told in zip(replies.supervision, outputs.supervision_replies, strict=True):
            reply(told)

    def _remember(self) -> None:
        new = remember(self.state, self._epoch_reserved, self._utc_ns)
        if new != self._remembered:
            self._memory.keep(new)
        self._remembered = new

    def _publish(self, before: State, inputs: Inputs, outputs: Outputs, now_ns: int, sent_ns: int) -> None:
        self._number += 1
        cycle = Entry(self._number, now_ns, before, inputs, self.state, outputs, sent_ns)
        self._journal.keep(cycle)
        self._audit.keep(cycle)
        changed = _told_at_once(before) != _told_at_once(self.state)
        if (before.authority.mode, before.lease.holder) != (self.state.authority.mode, self.state.lease.holder):
            self._tell_mode()
        if self._due("vehicle_state", STATE_NS, now_ns):
            self._link.publish(
                "vehicle_state",
                vehicle_state_of(self.state, outputs, self._number, self._clock.now_ns(), self._vehicle, self._limits),
            )
        if self._due("gateway_status", STATUS_NS, now_ns) or changed or outputs.lease_replies:
            silent_s = self._inbox.watchdog_silent_s(now_ns)
            status = status_of(self.state, now_ns, self._vehicle, self._limits, self._dropped(), silent_s)
            self._link.publish("gateway_status", status)
        if self._due("vehicle_description", SECOND_NS, now_ns):
            self._link.publish("vehicle_description", self._vehicle)
            self._tell_health(now_ns)

    def _tell_mode(self) -> None:
        """To whoever reads the log or asks the service manager."""
        mode, cause, operator = self.state.authority.mode, self.state.cause, self.state.lease.holder
        log.info("mode", extra=fields(mode=mode, cause=cause, operator=operator))
        self._manager.tell(f"STATUS={mode.replace('_', ' ')}: {cause}")

    def _tell_health(self, now_ns: int) -> None:
        """Our own loop's, and the ECU's, which has no link."""
        own = self._lateness.health(PROGRAM, "cycle", now_ns, self._scheduling, self._dropped(), stolen_s())
        ecu = self._inbox.ecu_health(now_ns)
        for health in (own, ecu):
            if health is not None:
                self._link.publish("car_health", health)
        self._manager.tell("READY=1", "WATCHDOG=1")

    def _due(self, name: str, period_ns: int, now_ns: int) -> bool:
        if now_ns - self._told.get(name, 0) < period_ns:
            return False
        self._told[name] = now_ns if now_ns - self._told.get(name, 0) > 2 * period_ns else self._told[name] + period_ns
        return True

    def _dropped(self) -> dict[str, int]:
        lost = {"cycles not recorded": self._journal.dropped, "latches not saved": self._memory.failed}
        return (
            self._inbox.all_dropped()
            | self._bus.dropped
            | self._audit.dropped
            | {name: count for name, count in lost.items() if count}
        )


def _told_at_once(state: State) -> tuple[object, ...]:
    """A change of any is told before the next regular status."""
    next_one = state.successor
    return state.authority, state.hand_over, state.lease_note, (next_one.operator, next_one.lease.epoch, next_one.agreed_ns)


def recalled_state(remembered: Remembered, boot_id: str, now_ns: int, utc_minus_now_ns: int) -> State:
    """The state a gateway starts with: latches, epochs and recent stops survive a restart."""
    state = initial_state(boot_id, now_ns, remembered.epoch_reserved, remembered.emergency_latched)
    if remembered.stop_latched and not remembered.emergency_latched:
        authority = msgspec.structs.replace(state.authority, mode=Mode.SAFE_STOP, origin=Mode.SAFE_STOP)  # which stands, or stops
        state = msgspec.structs.replace(state, authority=authority, cause="stopped before the gateway was restarted")
    return msgspec.structs.replace(
        state,
        engaged=remembered.engaged,
        stops=tuple(max(at - utc_minus_now_ns, 0) for at in remembered.stops_utc_ns),
        barred={name: max(at - utc_minus_now_ns, 0) for name, at in remembered.barred_utc_ns.items()},
        stop_pressed=remembered.stop_pressed,
        was_local=remembered.local_driver,
    )


def remember(state: State, epoch_reserved: int, utc_minus_now_ns: int) -> Remembered:
    """What a restarted gateway has to know."""
    mode = state.authority.mode
    return Remembered(
        epoch_reserved=epoch_reserved,
        emergency_latched=mode is Mode.EMERGENCY_STOP,
        stop_pressed=state.stop_pressed,
        stop_latched=mode in (Mode.SAFE_STOP, Mode.STOPPED),
        engaged=state.engaged,
        local_driver=mode is Mode.LOCAL_DRIVER,
        stops_utc_ns=tuple(at + utc_minus_now_ns for at in state.stops),
        barred_utc_ns={name: at + utc_minus_now_ns for name, at in state.barred.items()},
    )
