"""The wheels we know: vendor and product, which axis is what, which end is released, what the buttons do. Pure data.

Where the ends lie is not in the table but asked of the device (absinfo): wheels of one model report 0..255 or 0..65535.
Sources: our reference on wheels (axes, inversion, button codes 288..303 then 704 up, from oversteer and the kernel's drivers);
button order of the G29 and G920 as SDL's controller data base lists it. Never tried on hardware: `tower devices learn` corrects it.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tower.devices.profile import EVDEV, SDL, WHEEL, Pedal, Profile, Steering

ABS_X, ABS_Y, ABS_Z, ABS_RZ = 0, 1, 2, 5  # linux/input-event-codes.h
BUTTONS_LOW, BUTTONS_HIGH, LOW_COUNT = 288, 704, 16  # BTN_JOYSTICK, BTN_TRIGGER_HAPPY1

Ends = tuple[float, float]  # lowest and highest reading of an axis


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownWheel:
    name: str
    id: str
    steering: int  # evdev code of the axis; its lowest reading is the left end
    throttle: int  # pedals of all these wheels are inverted: the HIGHEST reading is released
    brake: int
    clutch: int  # not used: an automated car shifts by itself
    rotation_deg: float
    buttons: Mapping[int, str]  # number of the button -> what it does
    ends: Mapping[int, Ends]  # as the drivers report them; what the device itself says counts more

    @property
    def axes(self) -> tuple[int, ...]:
        return tuple(sorted((self.steering, self.throttle, self.brake, self.clutch)))


# A wheel's paddle stays under the hand that steers: the left one is the dead-man control, the right one the horn.
_XBOX = {
    5: "dead_man",
    4: "horn",
    0: "accept",  # A
    1: "stop",  # B: red
    2: "hand_back",  # X
    3: "return",  # Y
    6: "gear",  # menu
    7: "engage",  # view
    8: "wipers",  # RSB
    9: "lights",  # LSB
    10: "clear",  # Xbox
}
_PLAYSTATION = {
    5: "dead_man",
    4: "horn",
    0: "accept",  # cross
    2: "stop",  # circle: red
    1: "hand_back",  # square
    3: "return",  # triangle
    9: "gear",  # options
    8: "engage",  # share
    6: "wipers",  # R2
    7: "lights",  # L2
    24: "clear",  # PS
}
_HAT = {"hat 0 left": "left", "hat 0 right": "right", "hat 0 up": "hazard"}
_PEDALS_8_BIT = {ABS_X: (0.0, 65535.0), ABS_Y: (0.0, 255.0), ABS_Z: (0.0, 255.0), ABS_RZ: (0.0, 255.0)}


def _hidpp(name: str, identity: str) -> KnownWheel:
    return KnownWheel(
        name=name,
        id=identity,
        steering=ABS_X,
        throttle=ABS_Y,
        brake=ABS_Z,
        clutch=ABS_RZ,
        rotation_deg=900.0,
        buttons=_XBOX,
        ends=_PEDALS_8_BIT,
    )


def _lg4ff(name: str, identity: str) -> KnownWheel:
    return KnownWheel(
        name=name,
        id=identity,
        steering=ABS_X,
        throttle=ABS_Z,
        brake=ABS_RZ,
        clutch=ABS_Y,
        rotation_deg=900.0,
        buttons=_PLAYSTATION,
        ends=_PEDALS_8_BIT,
    )


KNOWN: dict[str, KnownWheel] = {
    wheel.id: wheel
    for wheel in (
        _hidpp("Logitech G920", "046d:c262"),
        _hidpp("Logitech G923 (Xbox)", "046d:c26e"),
        _lg4ff("Logitech G29", "046d:c24f"),
        _lg4ff("Logitech G923 (PlayStation)", "046d:c266"),
    )
}
XBOX_MODE = {"046d:c261": "a G920 in Xbox mode; switch it: usb_modeswitch -v 046d -p c261 -M 0f00010142 -m 01 -r 81"}


def button_code(number: int) -> int:
    """The evdev code of the wheel's button."""
    return BUTTONS_LOW + number if number < LOW_COUNT else BUTTONS_HIGH + number - LOW_COUNT


def through_evdev(wheel: KnownWheel, ends: Mapping[int, Ends] | None = None) -> Profile:
    """The profile of a known wheel.

    ends  lowest and highest reading by axis code, as the device says; None: as its driver usually does
    """
    found = {**wheel.ends, **(ends or {})}
    buttons = {f"button {button_code(number)}": name for number, name in wheel.buttons.items()}
    return _profile(wheel, EVDEV, {code: f"axis {code}" for code in wheel.axes}, found, buttons)


def through_sdl(wheel: KnownWheel) -> Profile:
    """The same wheel where there is no evdev: SDL counts axes in the order of their codes, from -1 to 1, and buttons from 0."""
    axes = {code: f"axis {index}" for index, code in enumerate(wheel.axes)}
    ends = dict.fromkeys(wheel.axes, (-1.0, 1.0))
    return _profile(wheel, SDL, axes, ends, {f"button {number}": name for number, name in wheel.buttons.items()})


def _profile(
    wheel: KnownWheel, through: str, axes: Mapping[int, str], ends: Mapping[int, Ends], buttons: Mapping[str, str]
) -> Profile:
    left, right = ends[wheel.steering]
    return Profile(
        name=wheel.name,
        id=wheel.id,
        kind=WHEEL,
        through=through,
        steering=Steering(axis=axes[wheel.steering], left=left, right=right, rotation_deg=wheel.rotation_deg),
        throttle=_inverted(axes[wheel.throttle], ends[wheel.throttle]),
        brake=_inverted(axes[wheel.brake], ends[wheel.brake]),
        buttons={**buttons, **_HAT},
    )


def _inverted(axis: str, ends: Ends) -> Pedal:
    return Pedal(axis=axis, released=ends[1], pressed=ends[0])
