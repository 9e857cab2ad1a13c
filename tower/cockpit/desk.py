"""What stands on the operator's desk: every device, which of them has the controls, and what became of one that was unplugged.

Each wheel is read every tick, used or not, so that touching it can select it and its STOP always counts. Joins the devices and
the rules of tower.cockpit.selection; decides nothing about driving.
"""

from collections import deque
from dataclasses import replace
from typing import Protocol

from haptics.alignment import WheelInputs
from haptics.force_feedback import Effects, Law, effects, silent
from haptics.settings import HapticsSettings
from haptics.virtual_wheel import VirtualWheel
from tower.cockpit.command import trusted
from tower.cockpit.devices import Controls, Device, View
from tower.cockpit.keyboard import KeyboardDevice
from tower.cockpit.scripted import ScriptedOperator
from tower.cockpit.selection import SCRIPTED, WINDOW, Held, Offer, chosen, held_back
from tower.cockpit.settings import CockpitSettings
from tower.cockpit.wheel import WheelDevice
from tower.cockpit.window_wheel import WindowWheel
from tower.devices.switches import COUNTERS
from wire.messages.operating import InputKind, OperatorInput

# Names of the cockpit's buttons, by control: "accept_presses" counts "accept"; "return" is a word of the language.
BUTTONS = {
    control: {"return": "return_"}.get(name := counter.removesuffix("_presses"), name) for control, counter in COUNTERS.items()
}


class Arrivals(Protocol):
    """What the desk needs of tower.devices.finder.Finder."""

    @property
    def arrived(self) -> deque[WheelDevice]: ...
    @property
    def note(self) -> str: ...


class Desk:
    def __init__(self, settings: CockpitSettings, haptics: HapticsSettings, arrivals: Arrivals | None = None) -> None:
        self._settings, self._haptics, self._arrivals = settings, haptics, arrivals
        self._wheels: dict[str, WheelDevice] = {}
        self._arrived = 0  # numbers the keys
        self._key = settings.device if settings.device == SCRIPTED else WINDOW
        self._device: Device = self._start(VirtualWheel())
        self._kind = InputKind.KEYBOARD
        self._touches: tuple[bool, int] | None = None  # of the window, when last seen
        self._held = Held()
        self._unplugged = ""  # of the window, as last seen
        self.controls = Controls(wheel=VirtualWheel())
        self.pressed: frozenset[str] = frozenset()  # buttons of wheels that went down in this tick
        self.switched = False  # the device is another one than a tick ago, or a new one in its place
        self.lost = False  # the device in use was lost in this tick
        self.let_go = ""  # what made the scripted operator let go, in this tick

    def _start(self, wheel: VirtualWheel) -> Device:
        if self._key == SCRIPTED:
            known = self._settings
            return ScriptedOperator(known.scripted, known.pedals, self._haptics.virtual_wheel, wheel, known.operator)
        return KeyboardDevice(self._settings.keyboard, self._haptics.virtual_wheel, wheel)

    @property
    def name(self) -> str:
        return self._device.name

    @property
    def note(self) -> str:
        """What happened to the controls, in words, until they may be used again; "" when nothing did."""
        return self._held.note

    @property
    def hint(self) -> str:
        """What keeps a device that is there from being used, with the fix; "" when nothing does."""
        return self._arrivals.note if self._arrivals is not None else ""

    def step(self, view: View, torque: float, dt_s: float, now_ns: int, *, driving: bool, armed: bool) -> Controls:
        """The controls of the device in use.

        torque   of the last tick, normalised, left positive
        driving  the operator drives the car, as known a tick ago
        armed    what the arming gate said a tick ago
        """
        self.switched, self.let_go, before = False, "", self._key
        self._welcome()
        for wheel in self._wheels.values():
            wheel.read(view, dt_s, now_ns)
        touched = self._touched(view)
        self._select(chosen(self._key, touched, holds=self.controls.dead_man, driving=driving))
        loss = self._loss(view, driving)
        self.lost = bool(loss)
        now = trusted(self._device.step(view, torque, dt_s, now_ns), self.controls, now_ns)
        self._held = held_back(self._held, loss, driving=driving, armed=armed and not self.switched and not loss)
        self.controls = replace(now, dead_man=False, throttle=0.0) if self._held.back else now
        self.pressed = self._buttons()
        if before == SCRIPTED and self._key != SCRIPTED:
            self.let_go = f"{self.name} touched: the scripted operator has let go"
        return self.controls

    def _welcome(self) -> None:
        """Wheels that were plugged in; those that are gone and not in use leave."""
        while self._arrivals is not None and self._arrivals.arrived:
            self._arrived += 1
            self._wheels[f"wheel {self._arrived}"] = self._arrivals.arrived.popleft()
        for key in [key for key, wheel in self._wheels.items() if wheel.unplugged and key != self._key]:
            del self._wheels[key]

    def _touched(self, view: View) -> tuple[Offer, ...]:
        offers = [Offer(key=key, is_wheel=True) for key, wheel in self._wheels.items() if wheel.newly_touched]
        message = view.operator_input.message if view.operator_input is not None else None
        if message is not None:
            touches, before = (message.touched, message.touches), self._touches
            self._touches = touches
            if message.touched and (before is None or touches != before):
                offers.append(Offer(key=WINDOW, is_wheel=message.kind is InputKind.WHEEL))
        return tuple(offers)

    def _select(self, key: str) -> None:
        if key == self._key:
            return
        self._key, self.switched = key, True
        if key == WINDOW:
            self._kind = InputKind.KEYBOARD
            self._device = self._start(self.controls.wheel)
        else:
            self._wheels[key].adopt(self.controls)
            self._device = self._wheels[key]

    def _loss(self, view: View, driving: bool) -> str:
        """What happened to the device in use in this tick."""
        if isinstance(self._device, WheelDevice):
            return f"{self._device.name} unplugged" if self._device.newly_unplugged else ""
        message = view.operator_input.message if view.operator_input is not None else None
        if message is None or self._key != WINDOW:
            return ""
        before, self._unplugged = self._unplugged, message.unplugged
        lost = f"{message.unplugged} unplugged" if message.unplugged and message.unplugged != before else ""
        return self._follow(message, driving) or lost

    def _follow(self, message: OperatorInput, driving: bool) -> str:
        """The window says itself which of its devices is touched; a wheel among them has an angle of its own."""
        if message.kind is self._kind:
            return ""
        was_wheel, is_wheel = self._kind is InputKind.WHEEL, message.kind is InputKind.WHEEL
        self._kind, self.switched = message.kind, True
        if is_wheel:
            self._device = WindowWheel(self.controls.wheel)
        elif was_wheel:
            self._device = self._start(self.controls.wheel)
        return f"{message.device} touched while driving: take over again" if driving and is_wheel else ""

    def _buttons(self) -> frozenset[str]:
        """Of the wheel in use every button counts, of the others STOP alone."""
        return frozenset(
            BUTTONS[control]
            for key, wheel in self._wheels.items()
            for control in wheel.pressed
            if control in BUTTONS and (key == self._key or BUTTONS[control] == "stop")
        )

    def feel(self, seen: WheelInputs, law: Law, dt_s: float, now_ns: int) -> None:
        """The forces of a real wheel; those that are not in use let go."""
        settings = self._haptics
        for device in self._wheels.values():
            if device is self._device and not device.unplugged:
                wanted: Effects = effects(device.effects, law, seen, dt_s, device.can, settings.torque, settings.force_feedback)
            else:
                wanted = silent(device.can)
            device.feel(wanted, now_ns)
