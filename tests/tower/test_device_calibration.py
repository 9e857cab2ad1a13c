"""Calibration by showing: the arithmetic alone, and the whole interview with SDL's own virtual joystick."""

import os
from collections.abc import Callable, Iterator

import pygame
import pytest
from hypothesis import given
from hypothesis import strategies as st
from typer.testing import CliRunner

from benchmarks.virtual_gamepad import WHEEL, VirtualJoystick
from tower.devices.attached import Attached, Joystick, attached, picked
from tower.devices.calibration import NotClear, Shown, calibrated, moved, taught
from tower.devices.dialogue import Fault, finish, starting_profile
from tower.devices.found import Node
from tower.devices.interview import calibrate, learn
from tower.devices.known import KNOWN, through_evdev
from tower.devices.profile import EVDEV, SDL, problems, steering_share, travel
from tower.devices.sdl_source import Sdl, SdlSource
from tower.devices.switches import Control
from tower.program import application

G920 = through_evdev(KNOWN["046d:c262"])
ENDS = {"axis 0": (0.0, 65535.0), "axis 1": (0.0, 255.0), "axis 2": (0.0, 255.0), "axis 5": (0.0, 255.0)}
READINGS = st.dictionaries(st.sampled_from(sorted(ENDS)), st.floats(0.0, 255.0))
REST = {"axis 0": 32768.0, "axis 1": 250.0, "axis 2": 247.0}
SHOWN = Shown(
    left={**REST, "axis 0": 900.0},
    right={**REST, "axis 0": 64000.0},
    throttle_pressed={**REST, "axis 1": 20.0},
    throttle_released=REST,
    brake_pressed={**REST, "axis 2": 60.0},
    brake_released=REST,
)


def test_what_was_shown_is_what_counts_with_a_little_margin_at_the_ends():
    profile = calibrated(G920, SHOWN, ENDS, 900.0)
    assert steering_share({"axis 0": 900.0}, profile.steering) == 1.0
    assert steering_share({"axis 0": 64000.0}, profile.steering) == -1.0
    assert travel({"axis 1": 20.0}, profile.throttle) == 1.0
    assert travel({"axis 1": 250.0}, profile.throttle) == 0.0
    # 2 % of the travel from 247 to 60
    assert (profile.brake.released, profile.brake.pressed) == (pytest.approx(243.26), pytest.approx(63.74))


def test_a_foot_that_also_rests_on_the_other_pedal_is_understood():
    resting = Shown(
        left=SHOWN.left,
        right=SHOWN.right,
        throttle_pressed=SHOWN.throttle_pressed,
        throttle_released=SHOWN.throttle_released,
        brake_pressed={**REST, "axis 2": 60.0, "axis 1": 230.0},
        brake_released=REST,
    )
    assert calibrated(G920, resting, ENDS, 900.0).brake.axis == "axis 2"


def test_nothing_that_moved_clearly_is_an_error_that_says_what_to_do():
    with pytest.raises(NotClear, match="start again: tower devices calibrate"):
        moved(REST, {**REST, "axis 1": 240.0}, ENDS, (), "the throttle")
    with pytest.raises(NotClear):
        moved({}, {}, ENDS, (), "the throttle")


@given(
    st.dictionaries(st.sampled_from(sorted(ENDS)), st.floats(0.0, 255.0)),
    st.dictionaries(st.sampled_from(sorted(ENDS)), st.floats(0.0, 255.0)),
)
def test_the_axis_that_is_found_moved_farthest_of_all(before: dict[str, float], after: dict[str, float]):
    spans = {axis: ENDS[axis][1] for axis in ENDS}
    shares = {axis: abs(before[axis] - after[axis]) / spans[axis] for axis in before if axis in after}
    if max(shares.values(), default=0.0) < 0.2:
        with pytest.raises(NotClear):
            moved(before, after, ENDS, (), "it")
    else:
        assert shares[moved(before, after, ENDS, (), "it")] == max(shares.values())


def test_a_button_means_one_thing_and_each_thing_has_one_button():
    again = taught(G920, Control.HORN, "button 289")  # was STOP
    assert again.buttons["button 289"] == "horn"
    assert list(again.buttons.values()).count("horn") == 1
    assert "stop" not in again.buttons.values()
    assert any("tower devices learn" in problem for problem in problems(again))


def test_what_cannot_be_driven_with_is_not_saved(tmp_path):
    with pytest.raises(Fault, match="not saved: .*tower devices learn"):
        finish(taught(G920, Control.HORN, "button 289"), tmp_path)
    assert list(tmp_path.iterdir()) == []
    assert finish(G920, tmp_path).is_file()


class Hands:
    """A person who does what each step asks with a virtual joystick, and presses Enter two looks later."""

    def __init__(self, acts: Iterator[Callable[[], object]]) -> None:
        self.asked: list[str] = []
        self._acts, self._looks = acts, 0

    def ask(self, text: str) -> None:
        self.asked.append(text)
        next(self._acts, lambda: None)()
        self._looks = 0

    def done(self) -> bool:
        self._looks += 1
        return self._looks > 2


@pytest.fixture
def sdl() -> Iterator[Sdl]:
    os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
    with Sdl() as it:
        yield it


def test_an_unknown_wheel_is_calibrated_and_taught_by_showing_it_everything(sdl: Sdl):
    wheel = VirtualJoystick(WHEEL, vendor=0x044F, product=0xB66E)
    # pedals of this one rest at 1
    moves = (
        {0: -1.0, 1: 0.9, 3: 0.9},
        {0: 1.0, 1: 1.0, 3: 1.0},
        {3: -1.0},
        {3: 1.0},
        {1: -0.8},
        {1: 1.0},
    )
    acts = (lambda step=step: [wheel.move(axis, value) for axis, value in step.items()] for step in moves)
    source = SdlSource(wheel.index)
    device = Attached(name="Strange wheel", id="044f:b66e", through=SDL, place="joystick 0", state="", usable=False)
    profile = calibrate(starting_profile(device, {}, {}), source, source.ends, 1080.0, Hands(acts))
    assert (profile.steering.axis, profile.throttle.axis, profile.brake.axis) == ("axis 0", "axis 3", "axis 1")
    assert (profile.steering.rotation_deg, profile.kind) == (1080.0, "wheel")
    assert travel({"axis 3": -1.0}, profile.throttle) == 1.0
    presses = iter((lambda: wheel.press(4), lambda: wheel.press(7)))
    profile = learn(profile, source, Hands(presses), (Control.DEAD_MAN, Control.STOP, Control.HORN))
    assert profile.buttons == {"button 4": "dead_man", "button 7": "stop"}
    assert problems(profile) == ()
    source.close()
    wheel.unplug()


def test_each_device_is_listed_once_with_what_is_known_about_it():
    nodes = (
        Node("/dev/input/event1", "0001:0001", "Keyboard", frozenset()),
        Node("/dev/input/event2", "046d:c262", "Logitech G920", frozenset({0, 1, 2, 5})),
        Node("/dev/input/event3", "045e:028e", "Xbox pad", frozenset({0, 1, 2, 3, 4, 5})),
        Node("/dev/input/event4", "046d:c261", "Logitech G920 in Xbox mode", frozenset()),
        Node("/dev/input/event5", "044f:b66e", "Thrustmaster", frozenset({0, 1, 5})),
    )
    joysticks = (
        Joystick(index=0, id="046d:c262", name="Logitech G920", is_gamepad=False),
        Joystick(index=1, id="045e:028e", name="Xbox pad", is_gamepad=True),
    )
    listed = {each.id: each for each in attached(nodes, joysticks, {}, lambda path: path != "/dev/input/event5")}
    assert {each: (listed[each].through, listed[each].usable) for each in listed} == {
        "046d:c262": (EVDEV, True),
        "046d:c261": (EVDEV, False),
        "044f:b66e": (EVDEV, False),
        "045e:028e": (SDL, True),
    }
    assert "udev" in listed["044f:b66e"].state and "usb_modeswitch" in listed["046d:c261"].state


def test_a_device_is_picked_by_part_of_its_name_and_a_doubt_names_the_choices():
    wheel = Attached(name="Logitech G920", id="046d:c262", through=EVDEV, place="/dev/input/event2", state="", usable=True)
    pad = Attached(name="Xbox pad", id="045e:028e", through=SDL, place="joystick 1", state="", usable=True)
    assert picked((wheel, pad), "g920") is wheel
    assert picked((pad,), "") is pad
    assert "plug one in" in str(picked((), "g920"))
    for doubt in (picked((wheel, pad), ""), picked((wheel, pad), "fanatec")):
        assert "'Logitech G920' (046d:c262)" in str(doubt) and "--device" in str(doubt)


def test_the_command_lists_a_virtual_pad_and_asks_nobody_without_a_terminal(tmp_path):
    run = CliRunner(env={"XDG_CONFIG_HOME": str(tmp_path), "COLUMNS": "160"})
    for command, code, told in ((("list",), 0, "not known: tower devices calibrate"), (("learn",), 2, "run this in a terminal")):
        pygame.joystick.init()
        VirtualJoystick(WHEEL, vendor=0x044F, product=0xB66E)  # gone again when the command lets SDL go
        result = run.invoke(application, ["devices", *command], input="")
        assert (result.exit_code, told in result.output, "Traceback" in result.output) == (code, True, False), result.output
        assert "044f:b66e" in result.output


def test_a_spoiled_profile_is_one_line_that_names_the_file(tmp_path):
    folder = tmp_path / "remote-operation-tower" / "devices"
    folder.mkdir(parents=True)
    (folder / "x.toml").write_text("colour = 1\n")
    result = CliRunner(env={"XDG_CONFIG_HOME": str(tmp_path)}).invoke(application, ["devices"])
    assert result.exit_code == 2 and "x.toml" in result.output and "Traceback" not in result.output
