"""The real link on loopback: Zenoh over QUIC with mutual TLS, two hubs and their clients in this process.

That something does NOT arrive is shown beside something that does, on the same route and after it: nothing waits in vain.
"""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from tests.messages import drive_command
from wire import certificates
from wire.clock import Clock
from wire.link import Link, LinkError, Stopped, open_link
from wire.messages.automation import AutonomyCommand
from wire.messages.base import Indicators, encode
from wire.messages.operating import ClockPong, TowerStop, WindowStatus
from wire.messages.sensing import Gnss, Imu, MovingPerson, Pose, WorldState
from wire.messages.session import Action, HandOverReply, HandOverRequest, LeaseReply, LeaseRequest, Outcome
from wire.ports import free_addresses
from wire.settings import LinkSettings
from wire.topics import Role

PATIENCE_S = 8.0
COMMAND = drive_command(sequence=0, sent_ns=1, event_ns=1, road_wheel_angle_rad=0.1, acceleration_m_s2=-0.5)
STATUS = WindowStatus(stamp_ns=1, sequence=0, displayed_capture_ns={}, frozen=False, shown=(), frames_dropped=0)
WORLD = WorldState(
    stamp_ns=1,
    car=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
    speed_m_s=0.0,
    road_wheel_angle_rad=0.0,
    pitch_rad=0.0,
    roll_rad=0.0,
    indicators=Indicators.OFF,
    hazard=False,
    brake_lights=False,
    people=(),
)
IMU = Imu(
    stamp_ns=1,
    acceleration_x_m_s2=0.0,
    acceleration_y_m_s2=0.0,
    acceleration_z_m_s2=9.81,
    roll_rate_rad_s=0.0,
    pitch_rate_rad_s=0.0,
    yaw_rate_rad_s=0.0,
)
GNSS = Gnss(stamp_ns=1, x_m=1.25, y_m=2.5, deviation_m=0.07, heading_rad=0.1, heading_deviation_rad=0.006)
ASK = LeaseRequest(operator="ann", session="s", sent_ns=1)
GRANTED = LeaseReply(granted=True, epoch=7, key_hex="00ff", rule="", boot_id="b")


def until(done: Callable[[], object], meanwhile: Callable[[], object] = lambda: None) -> None:
    """Repeat `meanwhile` every 10 ms until `done`; fail when that takes too long."""
    pause = threading.Event()
    for _ in range(round(PATIENCE_S / 0.01)):
        meanwhile()
        if done():
            return
        pause.wait(0.01)
    raise AssertionError("it did not come in time")


def heard(link: Link, name: str) -> list[Any]:
    """Everything valid that arrives from now on."""
    messages: list[Any] = []
    link.on(name, lambda message, _: messages.append(message))
    return messages


@pytest.fixture(scope="module")
def trusted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("link") / "certificates"
    certificates.make(folder)
    return folder


@pytest.fixture(scope="module")
def world(trusted: Path) -> Iterator["World"]:
    with ExitStack() as stack:
        yield World(stack, trusted)


class World:
    """Both hubs, joined, and whoever else is asked for."""

    def __init__(self, stack: ExitStack, trusted: Path, **settings: Any) -> None:
        car, tower = free_addresses(2)
        self.settings = LinkSettings(certificates=str(trusted), car_hub=car, tower_hub=tower, accepts_script=True)
        self.settings = replace(self.settings, **settings)
        self._stack = stack
        self._opened: dict[Role, Link] = {}
        self.car = self.open(Role.VEHICLE_HUB, hub=True)
        self.tower = self.open(Role.TOWER_HUB, hub=True)
        self.commands = heard(self.car, "drive_command")
        self.statuses = heard(self.tower, "window_status")
        self.car.serve("lease", lambda request: replace(GRANTED, boot_id=request.session))

    def open(self, role: Role, *, hub: bool = False, settings: LinkSettings | None = None) -> Link:
        return self._stack.enter_context(open_link(settings or self.settings, role, Clock(), threading.Event(), hub=hub))

    def client(self, role: Role) -> Link:
        if role not in self._opened:
            self._opened[role] = self.open(role)
        return self._opened[role]

    def joined(self) -> "World":
        until(lambda: self.commands, lambda: self.tower.publish("drive_command", COMMAND))
        return self


def test_a_command_of_the_tower_s_hub_arrives_at_the_car_s_as_it_was_sent(world: World):
    world.joined()
    marked = replace(COMMAND, sequence=4711, displayed_capture_ns={"front": 2**60})
    until(lambda: marked in world.commands, lambda: world.tower.publish("drive_command", marked))


def test_every_stop_arrives_once_and_in_order(world: World):
    stops = heard(world.joined().car, "tower_stop")
    until(lambda: stops, lambda: world.tower.publish("tower_stop", TowerStop(number=1, sent_ns=1, operator="first")))
    for number in range(2, 52):
        world.tower.publish("tower_stop", TowerStop(number=number, sent_ns=1, operator="ann"))
    until(lambda: len([stop for stop in stops if stop.operator == "ann"]) >= 50)
    assert [stop.number for stop in stops if stop.operator == "ann"] == list(range(2, 52))


def test_python_keeps_what_it_knows_of_a_thread_that_brings_messages(world: World):
    kept, counts = threading.local(), [0]

    def count(_: TowerStop, __: int) -> None:
        kept.messages = getattr(kept, "messages", 0) + 1
        counts.append(kept.messages)

    world.joined().car.on("tower_stop", count)
    until(lambda: max(counts) >= 3, lambda: world.tower.publish("tower_stop", TowerStop(number=1, sent_ns=1, operator="kept")))


def test_the_car_s_answer_to_a_question_comes_back_and_silence_is_none(world: World):
    world.joined()
    answers: list[Any] = []
    until(lambda: answers and answers[-1] is not None, lambda: answers.append(world.tower.ask("lease", ASK, 0.5)))
    assert answers[-1] == replace(GRANTED, boot_id="s")
    assert world.tower.ask("hand_over", ASK, 0.1) is None


def test_an_answer_given_later_on_another_thread_comes_back_and_a_question_nobody_can_read_gets_none(world: World):
    world.joined()
    refused = HandOverReply(number=3, outcome=Outcome.REFUSED, rule="later", lease_epoch=7)
    world.car.serve_later("hand_over", lambda _, reply: threading.Thread(target=reply, args=(refused,)).start())
    answers: list[Any] = []
    question = HandOverRequest(lease_epoch=7, number=3, action=Action.TAKE, sent_ns=1)
    until(lambda: answers and answers[-1] is not None, lambda: answers.append(world.tower.ask("hand_over", question, 0.5)))
    assert answers[-1] == refused
    assert world.tower.ask("hand_over", ASK, 1.0) is None
    assert world.car.dropped["hand_over undecodable"] == 1


def test_a_window_reaches_its_own_hub_and_never_the_car_with_a_command(world: World):
    window = world.joined().client(Role.WINDOW)
    forged = replace(COMMAND, sequence=666)

    def speak() -> None:
        window.publish("drive_command", forged)
        window.publish("window_status", STATUS)

    until(lambda: len(world.statuses) > 20, speak)
    passed = len(world.commands)
    until(lambda: len(world.commands) > passed + 10, lambda: world.tower.publish("drive_command", COMMAND))
    assert forged not in world.commands


def test_a_window_that_dials_the_car_itself_is_nobody_there(world: World):
    """Its certificate is genuine, but the car's hub knows no window."""
    world.joined()
    outside = world.open(Role.WINDOW, settings=replace(world.settings, tower_hub=world.settings.car_hub))
    overheard = heard(outside, "clock_pong")
    forged = replace(COMMAND, sequence=667)
    pongs = heard(world.tower, "clock_pong")

    def speak() -> None:
        outside.publish("drive_command", forged)
        outside.publish("tower_stop", TowerStop(number=9, sent_ns=1, operator="nobody"))
        world.car.publish("clock_pong", ClockPong(number=1, ping_sent_ns=1, received_ns=1, sent_ns=1))
        world.tower.publish("drive_command", COMMAND)

    until(lambda: len(pongs) > 20, speak)
    assert outside.ask("lease", ASK, 0.1) is None
    assert forged not in world.commands
    assert overheard == []


def test_the_world_state_reaches_video_and_not_the_automation(world: World):
    simulate, video, autonomy = (world.client(role) for role in (Role.SIMULATE, Role.VIDEO, Role.AUTONOMY))
    seen, stolen, felt = heard(video, "world_state"), heard(autonomy, "world_state"), heard(autonomy, "imu")
    at_the_hub, at_the_tower = heard(world.car, "world_state"), heard(world.tower, "world_state")

    def speak() -> None:
        simulate.publish("world_state", WORLD)
        simulate.publish("imu", IMU)

    until(lambda: len(seen) > 20 and len(felt) > 20, speak)
    assert stolen == []
    assert at_the_tower == []
    assert len(at_the_hub) <= len(seen) + 40  # the hub itself is the car's own gateway: it may, and does not use it


def test_what_a_car_says_all_at_once_arrives_whole(world: World):
    """Sensors of 100, 50 and 10 Hz fall due together, and a datagram holds few of them."""
    simulate, autonomy, video = (world.client(role) for role in (Role.SIMULATE, Role.AUTONOMY, Role.VIDEO))
    felt, shown, placed = heard(autonomy, "imu"), heard(video, "world_state"), heard(autonomy, "gnss")

    def speak(number: int, state: WorldState) -> None:
        simulate.publish("imu", replace(IMU, stamp_ns=number))
        simulate.publish("world_state", replace(state, stamp_ns=number))
        simulate.publish("gnss", replace(GNSS, stamp_ns=number))

    until(lambda: felt and shown and placed, lambda: speak(1, WORLD))
    person = MovingPerson(x_m=1.0, y_m=2.0, heading_rad=0.5, speed_m_s=1.25, phase=0.123456789)
    crowded, tick = replace(WORLD, people=(person,) * 20), threading.Event()
    for number in range(2, 102):
        speak(number, crowded)
        if number % 2:
            tick.wait(0.01)
    until(lambda: placed[-1].stamp_ns == 101)
    assert [fix.stamp_ns for fix in placed if fix.stamp_ns > 1] == list(range(2, 102))


def test_what_stays_in_the_car_does_not_cross(world: World):
    autonomy = world.joined().client(Role.AUTONOMY)
    here, there = heard(world.car, "autonomy_command"), heard(world.tower, "autonomy_command")
    command = AutonomyCommand(stamp_ns=1, sequence=1, road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    until(lambda: len(here) > 20, lambda: autonomy.publish("autonomy_command", command))
    assert there == []


def test_noise_is_dropped_and_counted_and_what_follows_is_heard(world: World):
    window = world.client(Role.WINDOW)
    kinds = {
        "not json": b"\x00\x01",
        "broken text": b'{"\xff": 1}',
        "another message": encode(IMU),
        "nan": encode(STATUS).replace(b"1", b"NaN"),
    }
    for noise in kinds.values():
        before = world.tower.dropped["window_status undecodable"]
        until(
            lambda before=before: world.tower.dropped["window_status undecodable"] > before,
            lambda noise=noise: window.publish("window_status", noise),
        )
    heard_before = len(world.statuses)
    until(lambda: len(world.statuses) > heard_before, lambda: window.publish("window_status", STATUS))


def test_a_stranger_with_certificates_of_his_own_gets_no_session_and_delivers_nothing(world: World, tmp_path: Path):
    certificates.make(tmp_path / "own")
    world.joined()
    stranger = replace(world.settings, certificates=str(tmp_path / "own"), tower_hub=free_addresses(1)[0])
    stop = threading.Event()
    threading.Timer(0.6, stop.set).start()
    with pytest.raises(Stopped), open_link(stranger, Role.AUTONOMY, Clock(), stop):
        pass
    forged = replace(COMMAND, sequence=668)
    with open_link(stranger, Role.TOWER_HUB, Clock(), threading.Event(), hub=True) as foreign:
        passed = len(world.commands)

        def speak() -> None:
            foreign.publish("drive_command", forged)
            world.tower.publish("drive_command", COMMAND)

        until(lambda: len(world.commands) > passed + 40, speak)
        assert foreign.ask("lease", ASK, 0.1) is None
    assert forged not in world.commands


def hub(settings: LinkSettings, role: Role, stack: ExitStack) -> Link:
    """A hub, as soon as its port is free: one that was just closed in this process keeps it for a moment."""
    opened: list[Link] = []

    def attempt() -> None:
        try:
            opened.append(stack.enter_context(open_link(settings, role, Clock(), threading.Event(), hub=True)))
        except LinkError:
            return

    until(lambda: opened, attempt)
    return opened[0]


@pytest.mark.parametrize(
    ("dials", "first"), [("tower", Role.TOWER_HUB), ("car", Role.VEHICLE_HUB), ("car", Role.TOWER_HUB)]
)  # the fourth is the world of all the other tests
def test_the_hubs_find_each_other_whoever_dials_and_whoever_is_there_first(trusted: Path, dials: str, first: Role):
    """A car sits behind NAT, so either side may dial; and nobody starts the two of them in order."""
    car, tower = free_addresses(2)
    settings = LinkSettings(certificates=str(trusted), car_hub=car, tower_hub=tower, dials=dials)
    second = Role.TOWER_HUB if first is Role.VEHICLE_HUB else Role.VEHICLE_HUB
    with ExitStack() as stack:
        links = {role: hub(settings, role, stack) for role in (first, second)}
        commands, pongs = heard(links[Role.VEHICLE_HUB], "drive_command"), heard(links[Role.TOWER_HUB], "clock_pong")

        def speak() -> None:
            links[Role.TOWER_HUB].publish("drive_command", COMMAND)
            links[Role.VEHICLE_HUB].publish("clock_pong", ClockPong(number=1, ping_sent_ns=1, received_ns=1, sent_ns=1))

        until(lambda: commands and pongs, speak)


def test_a_car_that_accepts_no_script_hears_nothing_from_a_scripted_cockpit(trusted: Path):
    """The same cockpit with a person's certificate is heard at once."""
    car, tower = free_addresses(2)
    settings = LinkSettings(certificates=str(trusted), car_hub=car, tower_hub=tower, accepts_script=False)
    with ExitStack() as stack:
        gateway = hub(settings, Role.VEHICLE_HUB, stack)
        commands = heard(gateway, "drive_command")
        gateway.serve("lease", lambda _: GRANTED)
        with ExitStack() as cockpit:
            script = hub(settings, Role.TOWER_SCRIPT, cockpit)
            script.publish("drive_command", replace(COMMAND, sequence=1))
            assert script.ask("lease", ASK, 0.5) is None
            script.publish("drive_command", replace(COMMAND, sequence=1))
        person = hub(settings, Role.TOWER_HUB, stack)
        until(lambda: commands, lambda: person.publish("drive_command", replace(COMMAND, sequence=2)))
        assert {command.sequence for command in commands} == {2}


def test_a_client_joins_again_by_itself_when_its_hub_was_restarted(trusted: Path):
    car, tower = free_addresses(2)
    settings = LinkSettings(certificates=str(trusted), car_hub=car, tower_hub=tower)
    command = AutonomyCommand(stamp_ns=1, sequence=1, road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    with ExitStack() as stack:
        with ExitStack() as first:
            before = hub(settings, Role.VEHICLE_HUB, first)
            autonomy = stack.enter_context(open_link(settings, Role.AUTONOMY, Clock(), threading.Event()))
            felt, commands = heard(autonomy, "imu"), heard(before, "autonomy_command")
            until(lambda: commands, lambda: autonomy.publish("autonomy_command", command))
        autonomy.publish("autonomy_command", command)  # nobody is there: no exception, no waiting
        again = heard(hub(settings, Role.VEHICLE_HUB, stack), "autonomy_command")
        simulate = stack.enter_context(open_link(settings, Role.SIMULATE, Clock(), threading.Event()))
        until(lambda: again, lambda: autonomy.publish("autonomy_command", command))
        until(lambda: felt, lambda: simulate.publish("imu", IMU))


def test_a_taken_port_is_told_with_the_key_to_change(world: World):
    with (
        pytest.raises(LinkError, match="car_hub") as told,
        open_link(world.settings, Role.VEHICLE_HUB, Clock(), threading.Event(), hub=True),
    ):
        pass
    assert world.settings.car_hub in str(told.value)


def test_missing_certificates_are_told_with_the_command_that_makes_them(tmp_path: Path):
    (tmp_path / "authority.pem").write_text("the only one: somebody has begun to set this folder up")
    settings = LinkSettings(certificates=str(tmp_path))
    with pytest.raises(LinkError, match="tower certificates"), open_link(settings, Role.WINDOW, Clock(), threading.Event()):
        pass


def test_where_there_are_no_certificates_the_first_program_makes_them(tmp_path: Path):
    place = tmp_path / "new" / "certificates"
    settings = LinkSettings(certificates=str(place), car_hub=free_addresses(1)[0])
    with open_link(settings, Role.VEHICLE_HUB, Clock(), threading.Event(), hub=True):
        assert certificates.missing(place) == ()


def test_a_topic_that_is_not_in_the_table_and_a_level_taken_for_an_event_are_errors(world: World):
    with pytest.raises(KeyError):
        world.car.publish("no_such_topic", IMU)
    with pytest.raises(ValueError, match="event"):
        world.car.level("tower_stop")
    with pytest.raises(ValueError, match="on_raw"):
        world.car.on("video", lambda *_: None)
