"""The window's keys: levels, edges, and what a window without focus sends."""

import os

import pygame
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import operator_status
from tower.window.keys import BINDINGS, Control, WindowKeys, followed, next_input, next_window_keys, released
from wire.messages.base import Gear, Indicators, Lights, Wipers, decoder, encode
from wire.messages.operating import OperatorInput, OperatorStatus

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # before pygame opens a display: these tests need no screen
COUNTED = {
    Control.ACCEPT: "accept_presses",
    Control.HAND_BACK: "hand_back_presses",
    Control.RETURN: "return_presses",
    Control.STOP: "stop_presses",
    Control.CLEAR: "clear_presses",
    Control.ENGAGE: "engage_presses",
}
HELD = st.frozensets(st.sampled_from(Control))
PRESSES = st.lists(st.sampled_from(Control), max_size=6)
Steps = list[tuple[frozenset[Control], list[Control], bool, bool]]  # held, presses, focus, standing
STEPS = st.lists(st.tuples(HELD, PRESSES, st.booleans(), st.booleans()), min_size=1, max_size=12)


def after(steps: Steps) -> OperatorInput:
    state = released(0)
    for number, (held, presses, focus, standing) in enumerate(steps):
        state = next_input(held, presses, state, focus=focus, standing=standing, now_ns=number * 16_000_000)
    return state


@given(STEPS, HELD, PRESSES)
def test_a_window_without_focus_has_released_everything(steps: Steps, held: frozenset[Control], presses: list[Control]) -> None:
    before = after(steps)
    now = next_input(held, presses, before, focus=False, standing=True, now_ns=10**12)
    assert (now.steer, now.throttle, now.brake, now.dead_man, now.horn, now.focus) == (0.0, 0.0, 0.0, False, False, False)
    for name in COUNTED.values():
        assert getattr(now, name) == getattr(before, name)
    assert (now.gear, now.indicators, now.hazard, now.touched) == (before.gear, before.indicators, before.hazard, before.touched)


@given(STEPS)
def test_counters_count_every_edge_made_with_focus(steps: Steps) -> None:
    state = after(steps)
    for control, name in COUNTED.items():
        assert getattr(state, name) == sum(presses.count(control) for _, presses, focus, _ in steps if focus)


@given(STEPS)
def test_every_input_is_a_valid_message_with_a_rising_sequence(steps: Steps) -> None:
    state = after(steps)
    assert decoder(OperatorInput).decode(encode(state)) == state
    assert state.sequence == len(steps)


@given(HELD)
def test_levels_follow_the_held_keys_alone(held: frozenset[Control]) -> None:
    state = next_input(held, (), released(0), focus=True, standing=False, now_ns=1)
    assert state.dead_man == (Control.DEAD_MAN in held)
    assert state.throttle == (1.0 if Control.THROTTLE in held else 0.0)
    assert state.brake == (1.0 if Control.BRAKE in held else 0.0)
    both = {Control.STEER_LEFT, Control.STEER_RIGHT} <= held
    assert state.steer == (0.0 if both else 1.0 if Control.STEER_LEFT in held else -1.0 if Control.STEER_RIGHT in held else 0.0)


def test_left_is_positive() -> None:
    assert next_input({Control.STEER_LEFT}, (), released(0), focus=True, standing=False, now_ns=1).steer == 1.0


def test_touched_stays_once_a_driving_key_was_held() -> None:
    pressed = next_input({Control.BRAKE}, (), released(0), focus=True, standing=False, now_ns=1)
    assert pressed.touched
    assert next_input(frozenset(), (), pressed, focus=True, standing=False, now_ns=2).touched
    assert not next_input({Control.HORN}, (Control.ACCEPT, Control.STOP), released(0), focus=True, standing=True, now_ns=1).touched


def test_the_gear_changes_only_at_standstill_and_comes_round_in_four_presses() -> None:
    moving = next_input(frozenset(), (Control.GEAR,), released(0), focus=True, standing=False, now_ns=1)
    assert moving.gear is Gear.DRIVE
    gears, state = [], released(0)
    for number in range(4):
        state = next_input(frozenset(), (Control.GEAR,), state, focus=True, standing=True, now_ns=number)
        gears.append(state.gear)
    assert gears[0] is Gear.REVERSE
    assert set(gears) == set(Gear)
    assert gears[-1] is Gear.DRIVE


def test_an_indicator_key_switches_its_side_and_a_second_press_switches_it_off() -> None:
    def pressed(*presses: Control) -> Indicators:
        return next_input(frozenset(), presses, released(0), focus=True, standing=False, now_ns=1).indicators

    assert pressed(Control.LEFT) is Indicators.LEFT
    assert pressed(Control.LEFT, Control.LEFT) is Indicators.OFF
    assert pressed(Control.LEFT, Control.RIGHT) is Indicators.RIGHT


def test_one_esc_asks_and_a_second_within_two_seconds_quits() -> None:
    asked = next_window_keys((Control.QUIT,), WindowKeys(), 10**9)
    assert not asked.quit
    assert asked.quit_asked_ns is not None
    assert next_window_keys((Control.QUIT,), asked, 10**9 + 1_900_000_000).quit
    late = next_window_keys((Control.QUIT,), asked, 10**9 + 2_100_000_000)
    assert not late.quit
    assert next_window_keys((), asked, 10**9 + 2_100_000_000).quit_asked_ns is None


def test_every_control_has_one_binding_and_no_key_has_two_meanings() -> None:
    assert sorted(binding.control for binding in BINDINGS) == sorted(Control)
    names = [name for binding in BINDINGS for name in binding.keys]
    assert len(names) == len(set(names))


def test_pygame_knows_every_key_by_its_name() -> None:
    pygame.display.init()
    codes = [pygame.key.key_code(name) for binding in BINDINGS for name in binding.keys]
    pygame.display.quit()
    assert len(codes) == len(set(codes))


def cockpit_says(device: str) -> OperatorStatus:
    return operator_status(
        device=device,
        lease_epoch=0,
        gear=Gear.REVERSE,
        indicators=Indicators.LEFT,
        hazard=True,
        lights=Lights.HIGH,
        wipers=Wipers.SLOW,
        clock_bound_ns=0,
        round_trip_ms=0.0,
    )


def test_gear_and_lights_follow_the_wheel_that_is_in_use_until_a_key_is_held() -> None:
    idle = released(0)
    after = followed(idle, cockpit_says("Logitech G920"))
    assert (after.gear, after.indicators, after.hazard) == (Gear.REVERSE, Indicators.LEFT, True)
    assert (after.lights, after.wipers) == (Lights.HIGH, Wipers.SLOW)
    assert followed(idle, cockpit_says("keyboard")) == idle
    assert followed(idle, None) == idle
    held = next_input({Control.DEAD_MAN}, (), idle, focus=True, standing=True, now_ns=1)
    assert followed(held, cockpit_says("Logitech G920")) == held
