"""A wheel on the desk: its readings are a list here, everything after them is the cockpit's own."""

from collections import deque
from collections.abc import Mapping
from math import pi

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.alignment import Phase, WheelInputs, WheelState
from haptics.force_feedback import Abilities, Effects, law
from haptics.settings import HapticsSettings
from tower.cockpit.desk import Desk
from tower.cockpit.devices import Controls, View
from tower.cockpit.pedals import Arming, PedalSettings, arm
from tower.cockpit.settings import CockpitSettings
from tower.cockpit.wheel import WheelDevice
from tower.devices.known import KNOWN, through_evdev
from tower.devices.source import Readings, Unplugged
from tower.window.keys import released
from wire.latest import Received
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.operating import InputKind, OperatorInput
from wire.messages.vehicle import Actuation, VehicleState

G920 = through_evdev(KNOWN["046d:c262"])
HAPTICS = HapticsSettings()
TICK_NS = 4_000_000
LEFT_PADDLE, STOP, A, GEAR, HORN = "button 293", "button 289", "button 288", "button 294", "button 292"
CAN = Abilities(constant=True, spring=True, damper=True, half_range_rad=2.5 * pi)


class Cable:
    """A source whose readings the test puts in; cut, it is unplugged."""

    def __init__(self) -> None:
        self.waiting: list[tuple[str, float]] = []
        self.age_ns = 0
        self.cut = self.closed = False

    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        if self.cut:
            raise Unplugged
        found, self.waiting = tuple(self.waiting), []
        return found, (self.age_ns if found else None)

    def close(self) -> None:
        self.closed = True


class Plugs:
    """Where wheels arrive."""

    def __init__(self) -> None:
        self.arrived: deque[WheelDevice] = deque()
        self.note = ""

    def plug_in(self) -> tuple[Cable, WheelDevice]:
        cable = Cable()
        device = WheelDevice(G920, cable, CAN, None)
        self.arrived.append(device)
        return cable, device


def at_speed(speed_m_s: float) -> VehicleState:
    act = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    return VehicleState(
        stamp_ns=1,
        boot_id="b",
        sequence=1,
        speed_m_s=speed_m_s,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=Gear.DRIVE,
        requested=act,
        applied=act,
        rules=(),
        speed_cap_m_s=8.0,
        loop_age_ms=100.0,
        command_age_ms=0.0,
    )


class Person:
    """A desk with plugs, its arming gate, and time."""

    def __init__(self, device: str = "keyboard") -> None:
        self.plugs = Plugs()
        self.desk = Desk(CockpitSettings(device=device), HAPTICS, self.plugs)
        self.now = 10**12
        self.speed, self.driving, self.arming = 0.0, False, Arming()
        self.keys: OperatorInput | None = None
        self.controls: Controls | None = None
        self.pressed: frozenset[str] = frozenset()

    def tick(self, **keys: object) -> Controls:
        self.now += TICK_NS
        if keys or self.keys is not None:
            self.keys = msgspec.structs.replace(self.keys or released(0), **{**keys, "stamp_ns": self.now, "focus": True})
        view = View(
            vehicle_state=Received(at_speed(self.speed), self.now),
            operator_input=Received(self.keys, self.now) if self.keys is not None else None,
        )
        self.controls = self.desk.step(view, 0.0, 0.004, self.now, driving=self.driving, armed=self.arming.armed)
        self.arming = arm(self.arming, self.controls, self.desk.switched or self.desk.lost, PedalSettings())
        self.pressed = self.desk.pressed
        return self.controls

    def say(self, cable: Cable, *readings: tuple[str, float]) -> Controls:
        cable.waiting += readings
        return self.tick()

    def armed_wheel(self) -> Cable:
        """A wheel that was plugged in, touched, and armed; its dead-man held."""
        cable, _ = self.plugs.plug_in()
        self.say(cable, ("axis 0", 32767.5), ("axis 1", 255.0), ("axis 2", 255.0))
        self.say(cable, (LEFT_PADDLE, 1.0))
        self.say(cable, ("axis 1", 254.0))
        assert self.desk.name == "Logitech G920" and self.arming.armed
        return cable


def test_a_wheel_is_used_once_its_paddle_is_held_and_turning_the_rim_alone_is_no_touch():
    person = Person()
    cable, _ = person.plugs.plug_in()
    person.say(cable, ("axis 0", 0.0))
    assert person.desk.name == "keyboard"
    person.say(cable, (LEFT_PADDLE, 1.0))
    assert person.desk.name == "Logitech G920"
    assert person.tick().wheel.angle_rad == pytest.approx(2.5 * pi)


def test_a_throttle_that_rests_at_the_kernels_first_zero_never_arms_and_never_counts():
    """Nothing is read but what was sent: a G920's throttle at 0 would be full throttle."""
    person = Person()
    cable, _ = person.plugs.plug_in()
    person.say(cable, (LEFT_PADDLE, 1.0), ("axis 0", 30000.0))
    for _ in range(50):
        now = person.tick()
    assert (now.throttle, now.throttle_reported, person.arming.armed) == (0.0, False, False)
    assert person.arming.missing == "Press and release both pedals once"


def test_a_pedal_that_is_down_when_it_first_reports_arms_only_after_it_was_let_go():
    person = Person()
    cable, _ = person.plugs.plug_in()
    person.say(cable, (LEFT_PADDLE, 1.0), ("axis 0", 30000.0), ("axis 1", 20.0), ("axis 2", 255.0))
    assert not person.arming.armed
    person.say(cable, ("axis 1", 255.0))
    assert person.arming.armed


def test_a_wheel_that_never_said_where_it_stands_does_not_arm():
    person = Person()
    cable, device = person.plugs.plug_in()
    person.say(cable, (LEFT_PADDLE, 1.0), ("axis 1", 255.0), ("axis 2", 255.0))
    assert not person.arming.armed
    assert person.arming.missing == "Turn the wheel a little"
    assert device.missing == ("the wheel",)
    person.say(cable, ("axis 0", 30000.0))
    assert person.arming.armed


def test_a_wheel_that_is_held_still_for_a_minute_is_still_there():
    person = Person()
    cable = person.armed_wheel()
    person.say(cable, ("axis 1", 100.0))
    for _ in range(1000):
        now = person.tick()
    assert now.dead_man and now.throttle == pytest.approx(155 / 255)


def test_the_event_is_as_old_as_the_kernel_says():
    person = Person()
    cable = person.armed_wheel()
    cable.age_ns = 1_500_000
    now = person.say(cable, ("axis 0", 31000.0))
    assert now.event_ns == person.now - 1_500_000
    assert person.tick().event_ns == now.event_ns


def test_a_wheel_unplugged_while_driving_leaves_everything_released_and_says_so():
    person = Person()
    cable = person.armed_wheel()
    person.say(cable, ("axis 0", 30000.0), ("axis 1", 0.0), (HORN, 1.0))
    person.driving, angle = True, person.tick().wheel.angle_rad
    cable.cut = True
    now = person.tick()
    assert (now.dead_man, now.throttle, now.brake, now.horn) == (False, 0.0, 0.0, False)
    assert now.wheel.angle_rad == angle
    assert person.desk.note == "Logitech G920 unplugged"
    assert cable.closed and not person.arming.armed


def test_plugged_in_again_within_the_blink_of_an_eye_it_does_not_drive_on():
    person = Person()
    cable = person.armed_wheel()
    person.driving, cable.cut = True, True
    person.tick()
    again, _ = person.plugs.plug_in()
    person.say(again, ("axis 0", 30000.0), ("axis 1", 255.0), ("axis 2", 255.0), (LEFT_PADDLE, 1.0))
    for _ in range(100):
        now = person.tick()
    assert not now.dead_man and person.desk.note == "Logitech G920 unplugged"
    person.driving = False  # the car has stopped itself
    person.say(again, (LEFT_PADDLE, 0.0))
    person.say(again, (LEFT_PADDLE, 1.0))
    for _ in range(3):
        now = person.tick()
    assert now.dead_man and person.arming.armed and person.desk.note == ""


def test_the_keyboard_may_be_touched_after_the_loss_but_drives_only_after_the_car_was_given_up():
    person = Person()
    cable = person.armed_wheel()
    person.tick(touched=False)
    person.driving, cable.cut = True, True
    person.tick()
    for _ in range(20):
        now = person.tick(touched=True, touches=1, dead_man=True)
    assert person.desk.name == "keyboard" and not now.dead_man
    person.driving = False
    for _ in range(3):
        now = person.tick(touched=True, touches=1, dead_man=True)
    assert now.dead_man


def test_a_held_dead_man_of_the_wheel_keeps_it_and_a_released_one_lets_the_keyboard_in():
    person = Person()
    cable = person.armed_wheel()
    person.tick(touched=False)
    person.tick(touched=True, touches=1, steer=1.0)
    assert person.desk.name == "Logitech G920"
    person.say(cable, (LEFT_PADDLE, 0.0))
    person.tick(touched=True, touches=2, steer=1.0)
    person.tick()
    assert person.desk.name == "keyboard"
    assert not person.arming.wheel_reported or person.arming.armed


def test_stop_counts_on_a_wheel_that_is_not_in_use_and_nothing_else_does():
    person = Person()
    cable, _ = person.plugs.plug_in()
    person.say(cable, (STOP, 1.0), (A, 1.0))
    assert person.desk.name == "keyboard" and person.pressed == {"stop"}
    person.tick()
    assert person.pressed == frozenset()


def test_buttons_of_the_wheel_in_use_count_once_per_press():
    person = Person()
    cable = person.armed_wheel()
    person.say(cable, (A, 1.0))
    assert person.pressed == {"accept"}
    person.tick()
    assert person.pressed == frozenset()


def test_lamps_wipers_indicators_and_gear_are_latched_and_the_gear_only_at_standstill():
    person = Person()
    cable = person.armed_wheel()
    person.speed = 3.0
    moving = person.say(cable, (GEAR, 1.0), (GEAR, 0.0), ("hat 0 left", 1.0), ("button 297", 1.0), ("button 296", 1.0))
    assert moving.gear is Gear.DRIVE
    assert (moving.indicators, moving.lights, moving.wipers) == (Indicators.LEFT, Lights.HIGH, Wipers.SLOW)
    person.speed = 0.0
    assert person.say(cable, (GEAR, 1.0)).gear is Gear.REVERSE


def test_gear_lights_and_wipers_do_not_jump_when_a_wheel_is_selected():
    person = Person()
    person.tick(gear=Gear.REVERSE, lights=Lights.HIGH, wipers=Wipers.FAST, hazard=True)
    person.armed_wheel()
    now = person.tick()
    assert person.desk.name == "Logitech G920"
    assert (now.gear, now.lights, now.wipers, now.hazard) == (Gear.REVERSE, Lights.HIGH, Wipers.FAST, True)


def test_the_scripted_operator_lets_go_when_a_paddle_is_held_while_nobody_drives():
    person = Person("scripted")
    cable, _ = person.plugs.plug_in()
    person.driving = True
    person.say(cable, (LEFT_PADDLE, 1.0), (LEFT_PADDLE, 0.0))
    assert person.desk.name == "scripted"
    person.driving = False
    person.say(cable, (LEFT_PADDLE, 1.0))
    assert person.desk.name == "Logitech G920"
    assert "the scripted operator has let go" in person.desk.let_go


def test_a_window_s_gamepad_that_is_unplugged_is_a_loss_as_well():
    person = Person()
    pad = {"device": "gamepad (Pad)", "kind": InputKind.GAMEPAD, "touched": True}
    for _ in range(3):
        now = person.tick(**pad, touches=1, dead_man=True)
    assert now.dead_man and person.desk.name == "gamepad (Pad)"
    person.driving = True
    now = person.tick(dead_man=False, unplugged="gamepad (Pad)", pedals_reported=False)
    assert not now.dead_man and person.desk.note == "gamepad (Pad) unplugged"
    now = person.tick(device="keyboard", kind=InputKind.KEYBOARD, unplugged="", pedals_reported=True, dead_man=True, touches=2)
    assert not now.dead_man
    person.driving = False
    for _ in range(3):
        now = person.tick()
    assert now.dead_man and person.desk.note == ""


def test_a_wheel_through_the_window_is_used_as_it_stands():
    person = Person()
    wheel = {"device": "Wheel", "kind": InputKind.WHEEL, "touched": True, "touches": 1}
    for _ in range(100):
        now = person.tick(**wheel, steering_wheel_angle_rad=1.25, throttle=0.5, dead_man=True)
    assert (now.wheel.angle_rad, now.throttle, now.dead_man) == (1.25, 0.5, True)
    assert abs(now.wheel.rate_rad_s) < 0.01
    assert person.desk.name == "Wheel"


def test_a_wheel_of_the_window_touched_while_driving_gives_the_car_up_first():
    person = Person()
    person.tick(touched=True, touches=1, dead_man=True)
    person.driving = True
    now = person.tick(device="Wheel", kind=InputKind.WHEEL, steering_wheel_angle_rad=3.0, dead_man=True, touches=2)
    assert not now.dead_man and "take over again" in person.desk.note


def test_only_the_wheel_in_use_is_given_forces():
    person = Person()
    used = person.armed_wheel()
    _, other = person.plugs.plug_in()
    person.tick()
    seen = WheelInputs(
        angle_rad=1.0,
        rate_rad_s=0.0,
        car_angle_rad=0.0,
        telemetry_age_ns=0,
        speed_m_s=8.33,
        lateral_m_s2=0.0,
        lock_rad=8.4,
        wanted=False,
        driving=True,
        armed=True,
    )
    active = WheelState(phase=Phase.ACTIVE)
    for _ in range(200):
        person.now += TICK_NS
        person.desk.feel(seen, law(active, seen, person.now, HAPTICS.wheel_limits()), 0.004, person.now)
    in_use = person.desk._device
    assert isinstance(in_use, WheelDevice) and in_use.effects.spring_max > 0.2
    assert (other.effects.spring_max, other.effects.constant) == (0.0, 0.0)
    assert isinstance(other.effects, Effects) and not used.closed


NAMES = st.sampled_from(["axis 0", "axis 1", "axis 2", LEFT_PADDLE, STOP, A, GEAR, HORN, "hat 0 left", "button 999"])
EVENTS = st.lists(st.lists(st.tuples(NAMES, st.sampled_from([0.0, 1.0, 128.0, 255.0, 65535.0])), max_size=5), max_size=40)


@given(EVENTS, st.integers(0, 40))
def test_whatever_a_wheel_says_the_controls_stay_in_range_and_a_dead_one_asks_for_nothing(
    events: list[list[tuple[str, float]]], cut_at: int
):
    person = Person()
    cable, _ = person.plugs.plug_in()
    person.driving = True
    for number, readings in enumerate(events):
        cable.cut = number >= cut_at
        now = person.say(cable, *readings)
        assert 0.0 <= now.throttle <= 1.0 and 0.0 <= now.brake <= 1.0 and abs(now.wheel.angle_rad) <= 2.5 * pi + 1e-9
        if cable.cut and person.desk.name == G920.name:
            assert not now.dead_man and now.throttle == 0.0
