"""Gamepads as SDL gives them: its own virtual joystick, plugged in, heard through pygame, unplugged."""

import os
from collections.abc import Iterator

import pygame
import pytest

from benchmarks.virtual_gamepad import (
    BACK,
    DPAD_LEFT,
    LEFT_SHOULDER,
    LEFT_STICK,
    LEFT_TRIGGER,
    LEFT_X,
    RIGHT_SHOULDER,
    RIGHT_TRIGGER,
    WHEEL,
    A,
    B,
    VirtualJoystick,
)
from tower.devices.known import KNOWN, through_sdl
from tower.devices.profile import SDL
from tower.devices.sdl_events import identity
from tower.devices.store import Saved
from tower.devices.switches import Control
from tower.window.joysticks import Joysticks
from tower.window.keys import next_input, released
from tower.window.sticks import Hands
from wire.messages.base import Indicators, Lights
from wire.messages.operating import InputKind, OperatorInput

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ["SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"] = "1"  # there is no window here that could have the focus


class Desk:
    """pygame, the joysticks, and the input that the window makes of them."""

    def __init__(self, saved: Saved) -> None:
        pygame.display.init()
        self.joysticks = Joysticks(saved)
        self.joysticks.open()
        self.input: OperatorInput = released(0)
        self.now_ns = 0

    def close(self) -> None:
        self.joysticks.close()
        pygame.display.quit()

    def look(self, keys: frozenset[Control] = frozenset(), focus: bool = True) -> OperatorInput:
        for event in pygame.event.get():
            self.joysticks.hear(event)
        self.now_ns += 16_000_000
        self.input = next_input(
            keys,
            self.joysticks.take_presses(),
            self.input,
            focus=focus,
            standing=True,
            now_ns=self.now_ns,
            sticks=self.joysticks.hands,
        )
        return self.input

    @property
    def hands(self) -> tuple[Hands, ...]:
        return self.joysticks.hands


@pytest.fixture
def desk() -> Iterator[Desk]:
    it = Desk({})
    yield it
    it.close()


def plugged_in(desk: Desk) -> VirtualJoystick:
    """A pad whose triggers were pressed once and let go."""
    pad = VirtualJoystick()
    for value in (-1.0, 0.3, -1.0):
        pad.move(LEFT_TRIGGER, value)
        pad.move(RIGHT_TRIGGER, value)
        desk.look()
    return pad


def test_a_pad_is_found_when_it_is_plugged_in_and_used_once_its_bumper_is_held(desk: Desk):
    desk.look()
    pad = plugged_in(desk)
    before = desk.look()
    assert (before.device, before.touched) == ("gamepad (Virtual pad)", True)  # a trigger is a driving control
    pad.press(LEFT_SHOULDER)
    now = desk.look()
    assert (now.device, now.kind, now.dead_man, now.pedals_reported) == ("gamepad (Virtual pad)", InputKind.GAMEPAD, True, True)
    pad.unplug()


def test_stick_and_triggers_are_where_the_fingers_hold_them_and_left_is_positive(desk: Desk):
    pad = plugged_in(desk)
    pad.press(LEFT_SHOULDER)
    pad.move(LEFT_X, -1.0)
    pad.move(RIGHT_TRIGGER, 0.0)
    now = desk.look()
    assert now.steer == pytest.approx(1.0)
    assert now.throttle == pytest.approx(0.5, abs=0.001)
    assert now.brake == 0.0
    pad.move(LEFT_X, 0.05)
    assert desk.look().steer == 0.0
    pad.unplug()


def test_what_sdl_makes_up_before_a_trigger_moved_is_no_report(desk: Desk):
    pad = VirtualJoystick()
    pad.press(LEFT_SHOULDER)
    for _ in range(3):
        now = desk.look()
    assert now.dead_man and not now.pedals_reported
    pad.move(RIGHT_TRIGGER, 1.0)
    assert not desk.look().pedals_reported
    pad.move(LEFT_TRIGGER, 1.0)
    assert desk.look().pedals_reported
    pad.unplug()


def test_the_buttons_do_what_the_table_says(desk: Desk):
    pad = plugged_in(desk)
    pad.press(LEFT_SHOULDER)
    desk.look()
    for button in (A, B, BACK, DPAD_LEFT, LEFT_STICK, RIGHT_SHOULDER):
        pad.press(button)
        desk.look()
    now = desk.look()
    assert (now.accept_presses, now.stop_presses, now.engage_presses) == (1, 1, 1)
    assert (now.indicators, now.lights, now.horn) == (Indicators.LEFT, Lights.HIGH, True)
    pad.unplug()


def test_stop_on_a_pad_counts_while_the_keyboard_is_used(desk: Desk):
    desk.look(frozenset({Control.DEAD_MAN}))
    pad = VirtualJoystick()
    desk.look(frozenset({Control.DEAD_MAN}))
    pad.press(B)
    pad.press(LEFT_SHOULDER)
    now = desk.look(frozenset({Control.DEAD_MAN}))
    assert (now.device, now.stop_presses) == ("keyboard", 1)
    pad.unplug()


def test_a_pad_unplugged_in_use_leaves_everything_released_and_says_so_until_something_is_touched(desk: Desk):
    pad = plugged_in(desk)
    pad.press(LEFT_SHOULDER)
    pad.move(RIGHT_TRIGGER, 1.0)
    assert desk.look().throttle == pytest.approx(1.0)
    pad.unplug()
    gone = desk.look()
    assert (gone.unplugged, gone.dead_man, gone.throttle, gone.pedals_reported) == ("gamepad (Virtual pad)", False, 0.0, False)
    touches = gone.touches
    back = desk.look(frozenset({Control.THROTTLE}))
    assert (back.device, back.unplugged, back.touches) == ("keyboard", "", touches + 1)


def test_without_focus_a_pad_is_released_and_no_press_counts(desk: Desk):
    pad = plugged_in(desk)
    pad.press(LEFT_SHOULDER)
    pad.move(RIGHT_TRIGGER, 1.0)
    desk.look()
    pad.press(A)
    away = desk.look(focus=False)
    assert (away.dead_man, away.throttle, away.accept_presses, away.focus) == (False, 0.0, 0, False)
    pad.unplug()


def test_two_pads_have_two_names(desk: Desk):
    one, two = VirtualJoystick(), VirtualJoystick()
    desk.look()
    assert [hands.device for hands in desk.hands] == ["gamepad (Virtual pad)", "gamepad (Virtual pad) 2"]
    two.unplug()
    one.unplug()


def test_a_device_that_is_no_gamepad_and_was_never_calibrated_is_left_alone(desk: Desk):
    strange = VirtualJoystick(WHEEL)
    desk.look()
    assert desk.hands == ()
    strange.unplug()


def test_a_wheel_that_the_cockpit_reads_is_left_to_it(desk: Desk):
    wheel = VirtualJoystick(WHEEL, vendor=0x046D, product=0xC262)
    desk.look()
    assert desk.hands == ()
    wheel.unplug()


def test_a_calibrated_wheel_is_read_through_sdl():
    profile = through_sdl(KNOWN["046d:c262"])
    desk = Desk({("1234:5678", SDL): profile})
    wheel = VirtualJoystick(WHEEL)
    for value in (0.9, 1.0):
        for axis in range(3):
            wheel.move(axis, value)
        now = desk.look()
    assert not now.touched
    wheel.press(5)  # the left paddle
    wheel.move(0, 0.5)
    now = desk.look()
    assert (now.kind, now.device, now.dead_man) == (InputKind.WHEEL, "Logitech G920", True)
    assert now.steering_wheel_angle_rad == pytest.approx(-0.5 * 7.854, abs=0.001)
    assert (now.throttle, now.pedals_reported) == (0.0, True)
    wheel.unplug()
    desk.close()


def test_vendor_and_product_stand_in_sdls_guid():
    assert identity("ff0028b2341200007856000000007601") == "1234:5678"
