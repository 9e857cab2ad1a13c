"""The whole cockpit with a wheel on its desk: what it sends and tells when the wheel is pulled out in the middle of a drive."""

from collections import deque
from collections.abc import Mapping
from typing import Any

from haptics.force_feedback import Abilities
from haptics.settings import HapticsSettings
from tests.messages import gateway_status, vehicle_description
from tower.cockpit.asker import Answer
from tower.cockpit.cockpit import Cockpit
from tower.cockpit.settings import CockpitSettings
from tower.cockpit.wheel import WheelDevice
from tower.devices.known import KNOWN, through_evdev
from tower.devices.source import Readings, Unplugged
from wire.latest import EventQueue, Latest
from wire.messages.base import Gear, Lights, Message, Wipers
from wire.messages.operating import DriveCommand, OperatorStatus, TowerStop
from wire.messages.session import Action, HandOverReply, HandOverRequest, LeaseReply, Outcome
from wire.messages.vehicle import Actuation, GatewayStatus, Mode, VehicleState
from wire.signature import is_genuine

KEY = bytes(range(32))
TICK_NS = 4_000_000
STILL = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
LEFT_PADDLE, A, B, WIPERS, LAMPS = "button 293", "button 288", "button 289", "button 296", "button 297"
CAR = vehicle_description()


class Tower:
    """Link, asker, plugs and cable of the cockpit, and a car that grants whatever it is asked."""

    def __init__(self) -> None:
        self.levels: dict[str, Latest[Any]] = {}
        self.dropped: dict[str, int] = {}
        self.sent: dict[str, list[Message]] = {}
        self.answers: EventQueue[Answer] = EventQueue()
        self.busy = False
        self.arrived: deque[WheelDevice] = deque()
        self.note = ""
        self.waiting: list[tuple[str, float]] = []
        self.cut = False
        self.mode, self.epoch, self.now = Mode.STOPPED, 5, 10**12
        self.cockpit = Cockpit(CockpitSettings(operator="ann"), HapticsSettings(), self, self, "session", lambda asked: asked, self)

    # the link and the asker ----------------------------------------------------------------------------------------------

    def level(self, name: str) -> Latest[Any]:
        return self.levels.setdefault(name, Latest())

    def publish(self, name: str, message: Message) -> None:
        self.sent.setdefault(name, []).append(message)

    def ask(self, name: str, request: Message, timeout_s: float) -> Message | None:
        raise AssertionError("the loop never asks by itself")

    def offer(self, query: str, request: Message) -> bool:
        reply: Message = LeaseReply(granted=True, epoch=self.epoch, key_hex=KEY.hex(), rule="", boot_id="b")
        if isinstance(request, HandOverRequest):
            self.epoch += 1
            self.mode = Mode.REMOTE if request.action is Action.TAKE else self.mode
            reply = HandOverReply(number=request.number, outcome=Outcome.GRANTED, rule="", lease_epoch=self.epoch)
        self.answers.put(Answer(query, reply), self.now)  # type: ignore[arg-type]
        return True

    # the wheel -----------------------------------------------------------------------------------------------------------

    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        if self.cut:
            raise Unplugged
        found, self.waiting = tuple(self.waiting), []
        return found, (0 if found else None)

    def close(self) -> None:
        pass

    def plug_in(self) -> None:
        self.cut = False
        self.arrived.append(WheelDevice(through_evdev(KNOWN["046d:c262"]), self, Abilities(), None))

    # time ----------------------------------------------------------------------------------------------------------------

    def run(self, seconds: float, *readings: tuple[str, float]) -> None:
        self.waiting += readings
        for _ in range(round(seconds * 250)):
            self.now += TICK_NS
            self.level("vehicle_description").put(CAR, self.now)
            self.level("vehicle_state").put(self._state(), self.now)
            self.level("gateway_status").put(self._status(), self.now)
            self.cockpit.cycle(self.now)

    def _state(self) -> VehicleState:
        return VehicleState(
            stamp_ns=1,
            boot_id="b",
            sequence=1,
            speed_m_s=0.0,
            acceleration_m_s2=0.0,
            yaw_rate_rad_s=0.0,
            road_wheel_angle_rad=0.0,
            gear=Gear.DRIVE,
            requested=STILL,
            applied=STILL,
            rules=(),
            speed_cap_m_s=8.0,
            loop_age_ms=100.0,
            command_age_ms=0.0,
        )

    def _status(self) -> GatewayStatus:
        return gateway_status(stamp_ns=1, mode=self.mode, mode_since_ns=1, lease_holder="ann", lease_epoch=self.epoch)

    @property
    def command(self) -> DriveCommand:
        newest = self.sent["drive_command"][-1]
        assert isinstance(newest, DriveCommand) and is_genuine(newest, KEY)
        return newest

    @property
    def told(self) -> OperatorStatus:
        newest = self.sent["operator_status"][-1]
        assert isinstance(newest, OperatorStatus)
        return newest

    def seated(self) -> None:
        """The paddle held, the rim in the middle, each pedal pressed and let go."""
        self.run(0.1, ("axis 0", 32767.5), (LEFT_PADDLE, 1.0))
        self.run(0.1, ("axis 1", 200.0), ("axis 2", 200.0))
        self.run(1.5, ("axis 1", 255.0), ("axis 2", 255.0))

    def pressed(self, button: str) -> None:
        self.run(0.1, (button, 1.0))
        self.run(0.1, (button, 0.0))


def driving() -> Tower:
    tower = Tower()
    tower.plug_in()
    tower.seated()
    tower.pressed(A)
    tower.run(0.5, ("axis 1", 0.0))
    assert tower.mode is Mode.REMOTE and tower.told.device == "Logitech G920"
    assert tower.command.dead_man and tower.command.acceleration_m_s2 == 2.0
    return tower


def test_a_wheel_takes_over_and_drives():
    tower = driving()
    tower.run(0.3, ("axis 0", 32767.5 - 65535 / 10))  # 90 degrees to the left
    assert abs(tower.command.road_wheel_angle_rad - 1.5708 / 14.0) < 1e-4
    tower.pressed(LAMPS)
    tower.pressed(WIPERS)
    assert (tower.command.lights, tower.command.wipers) == (Lights.HIGH, Wipers.SLOW)
    assert (tower.told.lights, tower.told.wipers, tower.told.armed, tower.told.device_note) == (Lights.HIGH, Wipers.SLOW, True, "")


def test_pulled_out_the_very_next_command_asks_for_nothing_and_the_window_is_told_why():
    tower = driving()
    tower.cut = True
    tower.run(0.004)
    assert not tower.command.dead_man and tower.command.acceleration_m_s2 <= 0.0
    assert tower.told.device_note == "Logitech G920 unplugged" and not tower.told.armed
    tower.run(1.0)
    commands = tower.sent["drive_command"][-90:]  # they go on: the car hears a tower without a driver, not a dead one
    assert all(isinstance(each, DriveCommand) and not each.dead_man for each in commands)


def test_plugged_in_again_it_drives_only_after_the_car_was_given_up_armed_anew_and_asked_for():
    tower = driving()
    tower.cut = True
    tower.run(0.1)
    tower.plug_in()
    tower.seated()
    assert not tower.command.dead_man  # the car still believes that it is driven
    tower.mode = Mode.SAFE_STOP
    tower.run(0.2)
    tower.mode = Mode.STOPPED
    tower.run(0.2, (LEFT_PADDLE, 0.0))
    tower.pressed(A)
    assert tower.mode is Mode.STOPPED
    tower.seated()
    assert tower.told.device_note == "" and tower.told.armed and tower.command.dead_man
    assert tower.mode is Mode.STOPPED  # armed is not asked for
    tower.pressed(A)
    assert tower.mode is Mode.REMOTE


def test_stop_on_the_wheel_is_sent_and_ends_the_commands():
    tower = driving()
    tower.pressed(B)
    stops = tower.sent["tower_stop"]
    assert isinstance(stops[0], TowerStop) and stops[0].number == 1
    sent = len(tower.sent["drive_command"])
    tower.run(0.5)
    assert len(tower.sent["drive_command"]) == sent
