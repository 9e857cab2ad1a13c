"""`tower devices calibrate|learn`: asks a person to do one thing after the other, and reads the device meanwhile.

`ask(text)` begins a step, `done()` says that the person has finished it: the terminal's Enter, or a test. Decides nothing itself.
"""

from collections.abc import Callable, Mapping
from typing import Protocol

from tower.devices.calibration import Shown, calibrated, taught
from tower.devices.known import Ends
from tower.devices.profile import Levels, Profile, noticed
from tower.devices.source import Source
from tower.devices.switches import FOR_BUTTONS, Control

STEPS = (
    ("left", "Turn the steering all the way to the LEFT and hold it there"),
    ("right", "Turn it all the way to the RIGHT and hold it there"),
    ("throttle_pressed", "Let the steering go. Press the THROTTLE all the way down and hold it"),
    ("throttle_released", "Let the throttle go"),
    ("brake_pressed", "Press the BRAKE all the way down and hold it"),
    ("brake_released", "Let the brake go"),
)


class Person(Protocol):
    def ask(self, text: str) -> None: ...

    def done(self) -> bool:
        """Whether the step is finished; waits a moment (about 10 ms) before it says no."""
        ...


def calibrate(profile: Profile, source: Source, ends: Mapping[str, Ends], rotation_deg: float, person: Person) -> Profile:
    """The profile with steering and pedals as they were shown. Raises NotClear, Unplugged."""
    levels: Levels = {}
    shown: dict[str, Levels] = {}
    for name, text in STEPS:
        person.ask(f"{text}, then press Enter")
        levels, _ = _until(source, levels, person.done)
        shown[name] = levels
    return calibrated(profile, Shown(**shown), ends, rotation_deg)


def learn(profile: Profile, source: Source, person: Person, controls: tuple[Control, ...] = FOR_BUTTONS) -> Profile:
    """The profile with the buttons that were pressed; Enter leaves one as it is. Raises Unplugged."""
    levels: Levels = {}
    for control in controls:
        now = next((button for button, name in profile.buttons.items() if name == control.name.lower()), "none")
        person.ask(f"Press the button for '{control.value}', or Enter to leave it ({now})")
        levels, pressed = _until(source, levels, person.done, on_press=True)
        if pressed:
            profile = taught(profile, control, pressed[0])
    return profile


def _until(source: Source, levels: Levels, done: Callable[[], bool], on_press: bool = False) -> tuple[Levels, tuple[str, ...]]:
    while True:
        finished = done()
        readings, _ = source.read(levels)
        levels, pressed = noticed(levels, readings)
        if finished or (on_press and pressed):
            return levels, pressed if on_press else ()
