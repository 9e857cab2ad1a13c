"""Looks once a second for wheels that were plugged in, opens them, and hands them to the cockpit's loop. One thread, Linux only.

Looks in sysfs; opens only what is a wheel it knows or one that was calibrated. Where there is no evdev it finds nothing.
"""

import threading
from collections import deque
from collections.abc import Callable, Mapping
from pathlib import Path

import msgspec

from haptics.force_feedback import ForceFeedbackSettings
from tower.cockpit.wheel import WheelDevice
from tower.devices.force_feedback import ForceFeedback, Forces, command
from tower.devices.found import SYSFS, UDEV_FIX, Node, has_evdev, nodes
from tower.devices.known import KNOWN, XBOX_MODE, Ends, through_evdev
from tower.devices.profile import EVDEV, Profile, half_range_rad
from tower.devices.store import Saved
from wire.clock import Clock

LOOK_S = 1.0
Open = Callable[[Node], WheelDevice]


def wanted_nodes(seen: tuple[Node, ...], saved: Saved) -> tuple[Node, ...]:
    """Those of the devices that are steering wheels of ours: known or calibrated, and with every axis that is driven with.
    A wheel may show further devices of the same name, for its keys."""
    return tuple(node for node in seen if (axes := _needed(node.id, saved)) and axes <= node.axes)


def _needed(identity: str, saved: Saved) -> frozenset[int]:
    profile = saved.get((identity, EVDEV)) or (through_evdev(KNOWN[identity]) if identity in KNOWN else None)
    if profile is None:
        return frozenset()
    inputs = (profile.steering.axis, profile.throttle.axis, profile.brake.axis)
    return frozenset(int(each.removeprefix("axis ")) for each in inputs if each.startswith("axis"))


def profile_for(node: Node, saved: Saved, ends: Mapping[int, Ends]) -> Profile:
    """What was saved for this device, or else the table's entry with the ends that the device names; turning as far as its
    driver has set it now."""
    profile = saved.get((node.id, EVDEV)) or through_evdev(KNOWN[node.id], ends)
    if node.rotation_deg is None:
        return profile
    steering = msgspec.structs.replace(profile.steering, rotation_deg=node.rotation_deg)
    return msgspec.structs.replace(profile, steering=steering)


def opened(node: Node, saved: Saved, settings: ForceFeedbackSettings) -> WheelDevice:
    """Raises OSError."""
    from tower.devices.evdev_wheel import EvdevWheel

    wheel = EvdevWheel(node.path)
    profile = profile_for(node, saved, wheel.ends)
    can = wheel.abilities(half_range_rad(profile.steering))
    feels = profile.force_sign != 0 and (can.constant or can.spring)
    program = command(node.path, profile.force_sign, settings)
    return WheelDevice(profile, wheel, can, Forces(lambda: ForceFeedback(program), Clock().now_ns()) if feels else None)


class Finder:
    """`with Finder(...) as finder:`; `arrived` and `note` are read by the cockpit's loop and never wait."""

    def __init__(self, saved: Saved, open_: Open, root: Path = SYSFS) -> None:
        self.arrived: deque[WheelDevice] = deque()
        self.note = ""  # what keeps a wheel that is there from being used
        self._saved, self._open, self._root = saved, open_, root
        self._devices: dict[str, WheelDevice] = {}
        self._clock = Clock()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="wheel finder", daemon=True)

    def __enter__(self) -> "Finder":
        if has_evdev():
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join(2 * LOOK_S)
        for device in self._devices.values():
            if not device.unplugged:
                device.close()

    def _run(self) -> None:
        while not self._stop.is_set():
            self.look()
            self._stop.wait(LOOK_S)

    def look(self) -> None:
        """Once: open what has come, forget what has gone."""
        seen, note = nodes(self._root), ""
        for node in wanted_nodes(seen, self._saved):
            known = self._devices.get(node.path)
            try:
                if known is not None and not known.unplugged:
                    wrong = known.look(self._clock.now_ns())
                    note = f"{known.name}: {wrong}" if wrong else note
                    continue
                device = self._open(node)
            except PermissionError:
                note = f"{node.name}: no permission for {node.path}; {UDEV_FIX}"
            except OSError as error:
                note = f"{node.name}: {node.path}: {error.strerror}"
            else:
                self._devices[node.path] = device
                self.arrived.append(device)
        asleep = next((XBOX_MODE[node.id] for node in seen if node.id in XBOX_MODE), "")
        self.note = note or asleep
