"""One wheel through evdev: opened for reading, read without waiting. Owns the file descriptor; decides nothing. Linux only.

Never uploads an effect: that call may block in the kernel with the interpreter's lock held (tower.devices.force_feedback does it,
in a process of its own). Import this module only on Linux.
"""

import errno
import fcntl
import struct
import time
from collections.abc import Mapping
from typing import Any

from evdev import InputDevice

from haptics.force_feedback import Abilities
from tower.devices.evdev_events import EV_ABS, FF_CONSTANT, FF_DAMPER, FF_SPRING, named, newest_ns, resynced
from tower.devices.known import Ends
from tower.devices.source import Readings, Unplugged

EV_FF = 0x15
_EVIOCSCLOCKID = 0x400445A0  # linux/input.h: stamp events with this clock
_READS_MAX = 8  # of 64 events each, per call: a wheel sends about 500 events a second


class EvdevWheel:
    def __init__(self, path: str) -> None:
        """Raises OSError when it cannot be opened (PermissionError: the udev rule is missing)."""
        self.path = path
        self._device: Any = InputDevice(path, readonly=True)
        fcntl.ioctl(self._device.fd, _EVIOCSCLOCKID, struct.pack("i", time.CLOCK_MONOTONIC))
        self._capabilities: dict[int, Any] = self._device.capabilities(absinfo=True)

    @property
    def ends(self) -> dict[int, Ends]:
        """Lowest and highest reading of each axis, as the device says."""
        return {code: (float(info.min), float(info.max)) for code, info in self._capabilities.get(EV_ABS, ())}

    def abilities(self, half_range_rad: float) -> Abilities:
        can = set(self._capabilities.get(EV_FF, ()))
        return Abilities(
            constant=FF_CONSTANT in can, spring=FF_SPRING in can, damper=FF_DAMPER in can, half_range_rad=half_range_rad
        )

    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        """See tower.devices.source."""
        try:
            events = self._waiting()
            batch = named((event.type, event.code, event.value) for event in events)
            readings = self._state(levels) if batch.dropped else batch.readings
        except OSError as error:
            raise Unplugged(errno.errorcode.get(error.errno or 0, str(error))) from None
        newest = newest_ns((event.sec, event.usec) for event in events)
        return readings, None if newest is None else max(time.monotonic_ns() - newest, 0)

    def _waiting(self) -> list[Any]:
        events: list[Any] = []
        try:
            for _ in range(_READS_MAX):
                events += self._device.read()
        except BlockingIOError:
            pass
        return events

    def _state(self, levels: Mapping[str, float]) -> Readings:
        axes = {code: self._device.absinfo(code).value for code in self.ends}
        return resynced(levels, axes, self._device.active_keys())

    def close(self) -> None:
        self._device.close()
