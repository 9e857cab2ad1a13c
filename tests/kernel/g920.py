"""A Logitech G920 as the kernel shows one: a uinput device with its identity, axes, buttons and force feedback. Its own process.

Its own, because evdev's `upload_effect` waits for this side with the interpreter's lock held. Told on standard input, a line each:
`plug`, `unplug`, `axis CODE VALUE`, `button CODE 0|1`. Says on standard output, as JSON, what becomes of it: plugged, and every
upload, play, erase, gain and autocentre. Like the real one, its axes read 0 until they move: on the inverted pedals that is full.
What it does not do: turn its rim by the forces.
Source: linux/uinput.h; hid-logitech-hidpp for axes and effects; evdev 2.0 fills a wrong field in `begin_upload`, so not used.
"""

import ctypes
import json
import os
import select
import sys
from collections.abc import Iterator
from typing import Any

from evdev import AbsInfo, UInput, ff
from evdev import ecodes as e

VENDOR, PRODUCT = 0x046D, 0xC262
BUTTONS = range(288, 299)
PEDALS = (e.ABS_Y, e.ABS_Z, e.ABS_RZ)  # throttle, brake, clutch: 255 is released
CAPABILITIES = {
    e.EV_KEY: list(BUTTONS),
    e.EV_ABS: [
        (e.ABS_X, AbsInfo(value=0, min=0, max=65535, fuzz=0, flat=0, resolution=0)),
        *((code, AbsInfo(value=0, min=0, max=255, fuzz=0, flat=0, resolution=0)) for code in PEDALS),
        *((code, AbsInfo(value=0, min=-1, max=1, fuzz=0, flat=0, resolution=0)) for code in (e.ABS_HAT0X, e.ABS_HAT0Y)),
    ],
    e.EV_FF: [e.FF_CONSTANT, e.FF_SPRING, e.FF_DAMPER, e.FF_GAIN, e.FF_AUTOCENTER],
}
EFFECTS = {e.FF_CONSTANT: "constant", e.FF_SPRING: "spring", e.FF_DAMPER: "damper"}
SETTINGS = {e.FF_GAIN: "gain", e.FF_AUTOCENTER: "autocentre"}


def say(what: str, **details: object) -> None:
    print(json.dumps({"what": what, **details}), flush=True)


class Wheel:
    def __init__(self) -> None:
        self._device: UInput | None = None

    def plug(self) -> None:
        name = "Logitech G920 Driving Force Racing Wheel"
        self._device = UInput(
            CAPABILITIES, name=name, vendor=VENDOR, product=PRODUCT, version=0x111, bustype=e.BUS_USB, max_effects=16
        )
        path = self._device.device.path
        self._device.device.close()  # else its end waits for an upload that waits for us
        say("plugged", path=path)

    def unplug(self) -> None:
        if self._device is not None:
            self._device.close()
        self._device = None
        say("unplugged")

    def axis(self, code: str, value: str) -> None:
        self._event(e.EV_ABS, int(code), int(value))

    def button(self, code: str, value: str) -> None:
        self._event(e.EV_KEY, int(code), int(value))

    def _event(self, kind: int, code: int, value: int) -> None:
        if self._device is not None:
            self._device.write(kind, code, value)
            self._device.syn()

    @property
    def descriptors(self) -> list[int]:
        return [] if self._device is None else [self._device.fd]

    def answer(self) -> None:
        """What the kernel asks of the device: whoever uploads an effect waits for this."""
        for event in self._device.read() if self._device is not None else ():
            if (event.type, event.code) == (e.EV_UINPUT, e.UI_FF_UPLOAD):
                self._take(event.value)
            elif (event.type, event.code) == (e.EV_UINPUT, e.UI_FF_ERASE):
                self._erase(event.value)
            elif event.type == e.EV_FF:
                setting = SETTINGS.get(event.code)
                say(setting or "play", **({} if setting else {"id": event.code}), value=event.value)

    def _take(self, request: int) -> None:
        upload = ff.UInputUpload()
        upload.request_id = request
        self._device.dll._uinput_begin_upload(self._device.fd, ctypes.byref(upload))
        effect = upload.effect
        say("upload", id=effect.id, effect=EFFECTS[effect.type], words=_words(effect))
        upload.retval = 0
        self._device.end_upload(upload)

    def _erase(self, request: int) -> None:
        erase = ff.UInputErase()
        erase.request_id = request
        self._device.dll._uinput_begin_erase(self._device.fd, ctypes.byref(erase))
        say("erase", id=erase.effect_id)
        erase.retval = 0
        self._device.end_erase(erase)


def _words(effect: Any) -> list[int]:
    """Of a constant force its level; of the others coefficient, saturation and centre, both sides alike."""
    if effect.type == e.FF_CONSTANT:
        return [effect.u.ff_constant_effect.level]
    condition = effect.u.ff_condition_effect[0]
    return [condition.right_coeff, condition.right_saturation, condition.center]


def lines() -> Iterator[str]:
    """Whole lines of what is there now; ends the program when nothing more will come."""
    data = os.read(0, 65536)
    if not data:
        sys.exit(0)
    yield from data.decode().splitlines()  # our tests write whole lines


def main() -> None:
    wheel = Wheel()
    while True:
        ready, _, _ = select.select([0, *wheel.descriptors], [], [])
        if 0 in ready:
            for line in lines():
                name, *arguments = line.split()
                getattr(wheel, name)(*arguments)
        elif ready:
            wheel.answer()


if __name__ == "__main__":
    main()
