"""Somebody who does not belong: `python -m benchmarks.intruder WHAT CONFIG`, until SIGTERM. For fault campaigns only.

He gets ready, says `ready` on standard output, and begins with SIGUSR1.

looker   another tower's window: it wants the pictures of the front camera, and says in the end how many it got
flood    another tower with the operator's certificate puts 10,000 junk messages a second on the command key
forged   it sends well-formed commands with the current epoch and ever higher numbers, without the lease's key
second   with the operator's certificate, another operator asks for the lease, twice a second
stolen   likewise with the operator's own name, as he would from another computer
rival    likewise, sixty times a second; one time in four for the car itself, signed with a key of his own
frozen   with the simulated world's certificate: the same state of the world again and again, with stamps that are always newest
stuck    likewise: the same position from the satellites, with fresh stamps
doubting with the automation's certificate: it begins to ask for a take-over 150 times a second, and takes it back as often, in no
         rhythm: a cockpit that takes when it hears of it would for ever be one beat behind. So often because the question for a
         take-over begins a cycle at once, few milliseconds after the last one
frames   on the vehicle bus: of every twelve commands of the gateway he answers three in a row by one that steers and accelerates,
         checksum right, counter the answered one's; looks at what the ECU demands of the actuators, and says so in the end
"""

import random
import secrets
import signal
import sys
import threading
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import msgspec
from msgspec.structs import replace

from benchmarks.cycle_messages import command
from benchmarks.fault_commands import FAR
from benchmarks.intruder_tower import another_tower, beside, looking_on, wait_for_the_word
from tower.cockpit.lease_client import request
from vehicle_gateway.can import e2e
from vehicle_gateway.can.actuator_codec import DemandState, decode_demand
from vehicle_gateway.can.bus import Bus, open_bus
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import Layout, layouts
from vehicle_gateway.settings import VehicleGatewaySettings
from wire.certificates import folder_of
from wire.clock import Clock, car_clock
from wire.configuration import read_sections
from wire.identity import signer_of
from wire.latest import Latest
from wire.link import Link, open_link
from wire.messages.automation import AutonomyStatus, Doubt, Reason, TakeoverRequest
from wire.messages.session import Action, HandOverRequest
from wire.messages.vehicle import GatewayStatus, Mode, VehicleDescription
from wire.pace import Pace
from wire.settings import WireSettings
from wire.signature import sign
from wire.topics import COCKPITS, Role

FLOOD_HZ, BURST = 10_000, 100
JUNK = b'{"lease_epoch": 1, "sequence": NaN}' * 4
AHEAD_NS = 30_000_000  # always newer than the genuine one
ASK_S = 0.4  # for an answer
BUDGET_S = 20.0  # longer than the operator is waited for between two requests
NOTHING_ASKED: dict[str, Any] = {"doubt": Doubt.NOMINAL, "request": None}
Tick = Callable[[int, int], None]  # number, now_ns
Prepare = Callable[[Link, Link, Path], Tick]  # where it speaks, where it listens


def flood(link: Link, _: Link, config: Path) -> Tick:
    def tick(number: int, now_ns: int) -> None:
        for _ in range(BURST):
            link.publish("drive_command", JUNK)

    return tick


def forged(link: Link, heard: Link, config: Path) -> Tick:
    status: Latest[GatewayStatus] = heard.level("gateway_status")
    car: VehicleDescription = read_sections(config, {"vehicle": VehicleDescription})["vehicle"]

    def tick(number: int, now_ns: int) -> None:
        known = status.get()
        if known is not None:
            made = command(known.message.stamp_ns, FAR + number, known.message.lease_epoch, Mode.REMOTE, car)
            full = replace(made, echoed_boot_id=known.message.boot_id, road_wheel_angle_rad=0.5, acceleration_m_s2=2.0)
            link.publish("drive_command", full)

    return tick


def asking(operator: str) -> Prepare:
    """For the lease, well signed. An operator "" is the one who holds it."""

    def prepare(link: Link, heard: Link, config: Path) -> Tick:
        status: Latest[GatewayStatus] = heard.level("gateway_status")
        settings: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
        signer = signer_of(folder_of(settings.link.certificates), Role.TOWER_SCRIPT)

        def tick(number: int, now_ns: int) -> None:
            known = status.get()
            if known is not None:
                told = known.message
                wish = request(operator or told.lease_holder, "elsewhere", told, now_ns)
                link.ask("lease", signer.sign(wish), ASK_S)

        return tick

    return prepare


def rival(link: Link, heard: Link, config: Path) -> Tick:
    status: Latest[GatewayStatus] = heard.level("gateway_status")
    ask_lease, key = asking("eve")(link, heard, config), secrets.token_bytes(32)

    def tick(number: int, now_ns: int) -> None:
        known = status.get()
        if known is not None and known.message.lease_holder:  # free, he would simply get it
            if number % 4:
                ask_lease(number, now_ns)
            else:
                link.ask("hand_over", sign(take(FAR + number, known.message, now_ns), key), ASK_S)

    return tick


def take(number: int, told: GatewayStatus, now_ns: int) -> HandOverRequest:
    return HandOverRequest(
        lease_epoch=told.lease_epoch,
        number=number,
        action=Action.TAKE,
        sent_ns=now_ns,
        echoed_vehicle_ns=told.stamp_ns,
        echoed_boot_id=told.boot_id,
    )


def doubting(link: Link, heard: Link, config: Path) -> Tick:
    genuine: list[AutonomyStatus] = []

    def hear(status: AutonomyStatus, _: int) -> None:
        if status.sequence < FAR:  # not our own
            genuine[:] = [status]

    heard.on("autonomy_status", hear)

    def tick(number: int, now_ns: int) -> None:
        if genuine:
            said = asks(number, now_ns) if random.Random(number).random() < 0.5 else NOTHING_ASKED
            link.publish("autonomy_status", replace(genuine[0], stamp_ns=now_ns + AHEAD_NS, sequence=FAR + number, **said))

    return tick


def asks(number: int, now_ns: int) -> dict[str, Any]:
    """Of the automation's status: a request of its own number."""
    why = (Reason(channel="intruder", text="asks again and again"),)
    request = TakeoverRequest(number=FAR + number, raised_ns=now_ns, reasons=why, budget_s=BUDGET_S, place=(0.0, 0.0))
    return {"doubt": Doubt.REQUEST, "request": request}


def repeated(topic: str) -> Prepare:
    """The first message of a topic for ever, each time newer than any genuine one."""

    def prepare(link: Link, heard: Link, config: Path) -> Tick:
        genuine: Latest[Any] = heard.level(topic)
        kept: list[Any] = []

        def tick(number: int, now_ns: int) -> None:
            first = genuine.get()
            if first is not None and not kept:
                kept.append(first.message)
            if kept:
                link.publish(topic, replace(kept[0], stamp_ns=now_ns + AHEAD_NS))

        return tick

    return prepare


KINDS: dict[str, tuple[Role, Role, float, Prepare]] = {  # speaks as, listens as, rate
    "flood": (Role.TOWER_SCRIPT, Role.TOWER_SCRIPT, FLOOD_HZ / BURST, flood),
    "forged": (Role.TOWER_SCRIPT, Role.TOWER_SCRIPT, 100.0, forged),
    "second": (Role.TOWER_SCRIPT, Role.TOWER_SCRIPT, 2.0, asking("eve")),
    "stolen": (Role.TOWER_SCRIPT, Role.TOWER_SCRIPT, 2.0, asking("")),
    "rival": (Role.TOWER_SCRIPT, Role.TOWER_SCRIPT, 60.0, rival),
    "doubting": (Role.AUTONOMY, Role.RECORDER, 300.0, doubting),
    "frozen": (Role.SIMULATE, Role.VIDEO, 100.0, repeated("world_state")),
    # more often than AHEAD_NS, or genuine ones get in between, as they did at 20 Hz: nothing stuck, and nobody noticed
    "stuck": (Role.SIMULATE, Role.AUTONOMY, 50.0, repeated("gnss")),
}
WANTED_RAD, WANTED_M_S2 = 0.3, 2.0  # on a straight road nobody else steers like that
WANTED_WITHIN_RAD = 0.01
RUN, EVERY = e2e.SYNC_FRAMES + 1, 12  # commands in a row that are answered, of so many


def on_the_link(kind: str, config: Path, stop: threading.Event) -> None:
    speaks, listens, rate_hz, prepare = KINDS[kind]
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    clock = car_clock(wire.clock)
    with ExitStack() as stack:
        if speaks in COCKPITS:
            link = heard = stack.enter_context(another_tower(beside(config), config, clock, stop))
        else:
            link, heard = (stack.enter_context(open_link(wire.link, role, clock, stop)) for role in (speaks, listens))
        tick = prepare(link, heard, config)
        wait_for_the_word(stop)
        for number, now_ns in enumerate(stack.enter_context(Pace(1.0 / rate_hz, clock, stop))):
            tick(number, now_ns)


class Followed(msgspec.Struct):
    """What the ECU made of it."""

    sent: int = 0
    demands: int = 0  # of the ECU, in that time
    followed: int = 0  # with the intruder's angle


def with_wrong_counter(genuine: Frame, layout: Layout) -> Frame | None:
    """The same, but steering and accelerating as the intruder wants it; None when the genuine one cannot be read."""
    values = layout.unpack(genuine.data)
    if values is None:
        return None
    mode, _, _, gear, hold = values
    return layout.pack((mode, WANTED_RAD, WANTED_M_S2, gear, hold), e2e.counter_of(genuine))


def on_the_bus(config: Path, stop: threading.Event) -> Followed:
    """Answers RUN commands in a row at once, then lets the others pass. However late these come in a bunch, a receiver uses none:
    more must follow one another before it believes a new sequence. Twelve commands later, after 50 ms, four bits fit again."""
    sections = read_sections(config, {"wire": WireSettings, "vehicle_gateway": VehicleGatewaySettings})
    can, priority = sections["vehicle_gateway"].can, sections["wire"].pace.fifo_priority
    layout, told, loose = layouts()["ACTUATION_COMMAND"], Followed(), threading.Event()
    vehicle_bus: list[Bus] = []
    heard, demanded = 0, DemandState()

    def hear(frame: Frame, _: int) -> None:
        nonlocal heard
        if not loose.is_set() or frame.arbitration_id != layout.arbitration_id:
            return
        heard += 1
        made = with_wrong_counter(frame, layout) if heard % EVERY < RUN else None
        if made is not None:
            told.sent += vehicle_bus[0].send(made)

    def look(frame: Frame, _: int) -> None:
        nonlocal demanded
        before, (demanded, _reason) = demanded, decode_demand(demanded, frame)
        if told.sent and demanded.demand is not None and demanded.demand is not before.demand:
            told.demands += 1
            told.followed += abs(demanded.demand.road_wheel_angle_rad - WANTED_RAD) < WANTED_WITHIN_RAD

    with ExitStack() as stack:
        vehicle_bus.append(stack.enter_context(open_bus(can, "vehicle", hear, Clock(), fifo_priority=priority)))
        stack.enter_context(open_bus(can, "actuator", look, Clock()))
        wait_for_the_word(stop)
        loose.set()
        stop.wait()
    return told


def main(kind: str, config: Path) -> int:
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    if kind == "frames":
        sys.stdout.buffer.write(msgspec.json.encode(on_the_bus(config, stop)))
    elif kind == "looker":
        sys.stdout.buffer.write(msgspec.json.encode(looking_on(config, stop)))
    else:
        on_the_link(kind, config, stop)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], Path(sys.argv[2])))
