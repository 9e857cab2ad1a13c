"""From what a person did to a device to its profile: which axis moved, from where to where, which button was meant. Pure.

Never guesses: what did not move clearly is an error that says what to do again.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import msgspec

from tower.devices.known import Ends
from tower.devices.profile import Levels, Pedal, Profile, Steering
from tower.devices.switches import Control

CLEAR_SHARE = 0.2  # of an axis' range: less is a foot that rests, not one that presses
MARGIN = 0.02  # of the travel at both ends: the same foot does not reach the same end every time


class NotClear(Exception):
    """What was done cannot be understood; the text says what to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Shown:
    """Where everything was at the end of each step; an axis that has not reported is absent."""

    left: Levels
    right: Levels
    throttle_pressed: Levels
    throttle_released: Levels
    brake_pressed: Levels
    brake_released: Levels


def calibrated(profile: Profile, shown: Shown, ends: Mapping[str, Ends], rotation_deg: float) -> Profile:
    """The profile with steering and pedals as they were shown. Raises NotClear.

    ends          lowest and highest possible reading by axis, as the device says
    rotation_deg  of the wheel from end to end; nobody can measure that from here
    """
    axis = moved(shown.left, shown.right, ends, (), "the steering: turn it all the way to both sides")
    steering = Steering(
        axis=axis,
        left=shown.left[axis],
        right=shown.right[axis],
        rotation_deg=rotation_deg,
        dead_zone=profile.steering.dead_zone,
        exponent=profile.steering.exponent,
    )
    throttle = _pedal(shown.throttle_released, shown.throttle_pressed, ends, (axis,), "throttle")
    brake = _pedal(shown.brake_released, shown.brake_pressed, ends, (axis, throttle.axis), "brake")
    return msgspec.structs.replace(profile, steering=steering, throttle=throttle, brake=brake)


def _pedal(released: Levels, pressed: Levels, ends: Mapping[str, Ends], taken: tuple[str, ...], name: str) -> Pedal:
    axis = moved(released, pressed, ends, taken, f"the {name}: press it all the way, alone; separate pedals are needed")
    margin = MARGIN * (pressed[axis] - released[axis])
    return Pedal(axis=axis, released=round(released[axis] + margin, 4), pressed=round(pressed[axis] - margin, 4))


def moved(before: Levels, after: Levels, ends: Mapping[str, Ends], taken: tuple[str, ...], what: str) -> str:
    """The axis that moved most between two moments, as a share of its range. Raises NotClear when none did clearly."""
    shares = {
        axis: abs(after[axis] - before[axis]) / ((ends[axis][1] - ends[axis][0]) or 1.0)
        for axis in before
        if axis in after and axis in ends and axis not in taken
    }
    best = max(shares, key=lambda axis: shares[axis], default=None)
    if best is None or shares[best] < CLEAR_SHARE:
        raise NotClear(f"nothing moved clearly for {what}, then start again: tower devices calibrate")
    return best


def taught(profile: Profile, control: Control, button: str) -> Profile:
    """The profile in which this button, and no other, stands for the control."""
    name = control.name.lower()
    kept = {each: other for each, other in profile.buttons.items() if other != name and each != button}
    return msgspec.structs.replace(profile, buttons={**kept, button: name})
