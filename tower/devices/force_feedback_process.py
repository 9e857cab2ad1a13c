"""Program `tower force-feedback`: the one writer of a wheel's effects. Owns a second descriptor of the device; decides nothing.

Reads packets of wanted effects from stdin, always the newest; uploads what haptics.effect_words says is due. Each effect is played
once, without end (length 0), and updated in place. FF_GAIN and FF_AUTOCENTER outlive a process: both are set at start and reset
at exit. Silence, a closed pipe or SIGTERM: the forces go; they come back slowly (haptics.fading). A wheel that is gone ends the
program. Linux only.
Source: Documentation/input/ff.rst, python-evdev 2.0; our reference measurements on queues of uploads.
"""

import errno
import os
import select
import signal
import sys
import threading
from collections.abc import Callable
from typing import Any

from haptics import effect_words
from haptics.effect_words import CONSTANT, DAMPER, LEFT, SPRING, Uploads, Words
from haptics.fading import Hearing, heard, rendered
from haptics.force_feedback import Abilities, Effects
from tower.devices.evdev_events import FF_CONSTANT, FF_DAMPER, FF_SPRING
from tower.devices.force_feedback import PACKET, unpack
from wire.clock import Clock

EV_FF, FF_GAIN, FF_AUTOCENTER = 0x15, 0x60, 0x61
LOOK_S = 0.005
_TYPES = {CONSTANT: FF_CONSTANT, SPRING: FF_SPRING, DAMPER: FF_DAMPER}


class Renderer:
    """The wheel's effects: one slot each. Every method may block in the kernel and raises OSError."""

    def __init__(self, path: str, gain: float) -> None:
        from evdev import InputDevice, ff

        self._ff: Any = ff
        self._device: Any = InputDevice(path)
        known = set(self._device.capabilities(absinfo=False).get(EV_FF, ()))
        self.can = Abilities(constant=FF_CONSTANT in known, spring=FF_SPRING in known, damper=FF_DAMPER in known)
        self._known = known
        self._ids: dict[str, int] = {}
        self._reset(gain)

    def _reset(self, gain: float) -> None:
        for code, value in ((FF_GAIN, gain), (FF_AUTOCENTER, 0.0)):
            if code in self._known:
                self._device.write(EV_FF, code, round(0xFFFF * gain if code == FF_GAIN else value))

    def upload(self, name: str, words: Words) -> None:
        """A new effect is uploaded and played; a known one is changed in place, without starting it again."""
        effect = self._ff.Effect(
            _TYPES[name], self._ids.get(name, -1), LEFT, self._ff.Trigger(0, 0), self._ff.Replay(0, 0), self._body(name, words)
        )
        number = self._device.upload_effect(effect)
        if name not in self._ids:
            self._device.write(EV_FF, number, 1)
        self._ids[name] = number

    def _body(self, name: str, words: Words) -> Any:
        if name == CONSTANT:
            return self._ff.EffectType(ff_constant_effect=self._ff.Constant(level=words[0]))
        coefficient, saturation, centre = words if name == SPRING else (words[0], 0xFFFF, 0)
        condition = self._ff.Condition(
            right_saturation=saturation,
            left_saturation=saturation,
            right_coeff=coefficient,
            left_coeff=coefficient,
            deadband=0,
            center=centre,
        )
        return self._ff.EffectType(ff_condition_effect=(self._ff.Condition * 2)(condition, self._ff.Condition()))

    def close(self) -> None:
        """No forces any more, gain and autocentre as a wheel has them that nobody uses."""
        try:
            for number in self._ids.values():
                self._device.erase_effect(number)
            self._reset(1.0)
        except OSError:
            pass  # it is gone, and its effects with it
        self._device.close()


def run(path: str, sign: int, gain: float, uploads_max_1_s: float) -> int:
    """Until stdin ends, SIGTERM, or the wheel is gone. 0, or 1 when the wheel cannot be written to."""
    stop = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the cockpit ends us, and the wheel is let go in order
    try:
        renderer = Renderer(path, gain)
    except OSError as error:
        print(f"force feedback: {path}: {error.strerror}; is the udev rule installed?", file=sys.stderr)
        return 1
    try:
        _serve(renderer, sign, uploads_max_1_s, stop, Clock().now_ns)
    except OSError as error:
        if error.errno != errno.ENODEV and not _pipe_ended():  # an upload under way when it is pulled out: ETIMEDOUT
            print(f"force feedback: {path}: {error.strerror}; the wheel stays without forces", file=sys.stderr)
            return 1
    finally:
        renderer.close()
    return 0


def _serve(renderer: Renderer, sign: int, uploads_max_1_s: float, stop: threading.Event, now: Callable[[], int]) -> None:
    hearing, uploads, rest = Hearing(), Uploads(), b""
    while not stop.is_set():
        if select.select([sys.stdin.fileno()], [], [], LOOK_S)[0]:
            data = os.read(sys.stdin.fileno(), 65536)
            if not data:
                return
            newest, rest = newest_packet(rest + data)
            hearing = heard(hearing, newest or hearing.wanted, now())
        now_ns = now()
        wanted = effect_words.words(rendered(hearing, now_ns, renderer.can), renderer.can, sign)
        uploads, name = effect_words.due(uploads, wanted, now_ns, uploads_max_1_s)
        if name is not None:
            renderer.upload(name, uploads.sent[name])


def _pipe_ended() -> bool:
    """Whether the cockpit has let go of this wheel: it notices first that one is gone."""
    while select.select([sys.stdin.fileno()], [], [], 0.0)[0]:
        if not os.read(sys.stdin.fileno(), 65536):
            return True
    return False


def newest_packet(data: bytes) -> tuple[Effects | None, bytes]:
    """(the last whole packet or None, the bytes of one that is not whole yet)."""
    whole = len(data) // PACKET.size * PACKET.size
    return (unpack(data[whole - PACKET.size : whole]) if whole else None), data[whole:]
