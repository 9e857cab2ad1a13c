"""The shell of the stack: newest messages in, one cycle of `autonomy.stack` every 10 ms, messages out."""

import logging
import threading
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from autonomy.car_shape import car_shape
from autonomy.compile import warm_up
from autonomy.inputs import Inputs
from autonomy.planner_view.colours import Given
from autonomy.planner_view.message import next_view
from autonomy.replay import record
from autonomy.settings import AutonomySettings
from autonomy.stack import Outputs, step
from autonomy.state import Setup, StackState, setup_of
from wire.clock import car_clock
from wire.configuration import ConfigurationError, read_sections
from wire.latest import Latest
from wire.link import Link, open_link
from wire.link_threads import beneath
from wire.messages.vehicle import VehicleDescription
from wire.pace import Pace
from wire.road import Road
from wire.scenario import find_map, read_map
from wire.settings import WireSettings
from wire.topics import PROGRAMS, Role

log = logging.getLogger(__name__)
PERIOD_S = 0.01
SLOWLY_CYCLES = 100  # map and health once a second


class Newest:
    """The slots the link fills."""

    def __init__(self, link: Link) -> None:
        names = ("imu", "gnss", "wheel_speeds", "object_list", "gateway_status")
        self._slots: tuple[Latest[Any], ...] = tuple(link.level(name) for name in names)

    def inputs(self) -> Inputs:
        imu, gnss, wheels, objects, gateway = (
            None if (received := slot.get()) is None else received.message for slot in self._slots
        )
        return Inputs(imu=imu, gnss=gnss, wheels=wheels, objects=objects, gateway=gateway)


def setup_from(config: Path) -> tuple[Setup, WireSettings]:
    """Everything the configuration says. Raises ConfigurationError."""
    rooms = {"wire": WireSettings, "vehicle": VehicleDescription, "autonomy": AutonomySettings}
    sections = read_sections(config, rooms)
    settings: AutonomySettings = sections["autonomy"]
    road = Road(read_map(find_map(settings.map, config)))
    try:
        return setup_of(road, car_shape(sections["vehicle"]), settings), sections["wire"]
    except ValueError as error:
        raise ConfigurationError(f"{config}: [vehicle] and [autonomy.tracker]: {error}") from None


def run(config: Path, stop: threading.Event) -> int:
    """Drive until `stop` is set. Exit code. Raises ConfigurationError, LinkError, Stopped."""
    setup, wire = setup_from(config)
    if setup.among_people is not None:
        warm_up(log.info)  # reads what was compiled at set-up; no cycle may wait for a compiler
    clock = car_clock(wire.clock)
    fifo = wire.pace.fifo_priority
    with open_link(wire.link, Role.AUTONOMY, clock, stop, fifo_priority=beneath(fifo)) as link:
        newest = Newest(link)
        given: Given = {}  # colours of the ways
        with Pace(PERIOD_S, clock, stop, fifo_priority=fifo) as pace:
            for state, outputs in cycles(pace, newest.inputs, setup):
                _publish(link, outputs, setup)
                if outputs.decision is not None:
                    given, view = next_view(given, outputs.decision, outputs.predictions, state.now_ns)
                    link.publish("planner_view", view)
                if state.sequence % SLOWLY_CYCLES == 1:
                    link.publish("road_map", setup.road.map)
                    link.publish("car_health", pace.health(PROGRAMS[Role.AUTONOMY], "drive", link.dropped))
    return 0


def cycles(times_ns: Iterable[int], newest: Callable[[], Inputs], setup: Setup) -> Iterator[tuple[StackState, Outputs]]:
    """One cycle of the stack at each of the times; whoever takes the outputs publishes them before the next."""
    state = StackState()
    for now_ns in times_ns:
        state, outputs = step(state, newest(), now_ns, setup)
        yield state, outputs


def _publish(link: Link, outputs: Outputs, setup: Setup) -> None:
    judged = None if outputs.judged is None else record(outputs.judged, setup.settings.monitor)
    rows = (
        ("autonomy_command", outputs.command),
        ("autonomy_status", outputs.status),
        ("scene", outputs.scene),
        ("monitor_step", judged),
    )
    for name, message in rows:
        if message is not None:
            link.publish(name, message)
