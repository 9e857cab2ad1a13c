"""The wheel's forces, from the cockpit's side: a small process of its own, fed with the newest wanted effects through a pipe.

An upload may block in the kernel with the interpreter's lock held, so it must not happen in a control loop's process. Writing to
the pipe never waits: a packet that does not fit is dropped, the next one says the same. When the cockpit dies the pipe ends, and
with it the forces. When the process dies it is started again (tower.devices.revival) by whoever may wait for that: never by `feel`.
"""

import os
import struct
import subprocess
import sys
from collections.abc import Callable
from typing import Protocol

from haptics.force_feedback import Effects, ForceFeedbackSettings
from tower.devices.revival import Revival, looked, words

PACKET = struct.Struct("<5d")  # spring, spring_max, centre, damper, constant: 40 bytes, whole or not at all (PIPE_BUF)
REPEAT_NS = 50_000_000  # well below the silence after which the process lets the wheel go


def pack(effects: Effects) -> bytes:
    return PACKET.pack(effects.spring, effects.spring_max, effects.centre, effects.damper, effects.constant)


def unpack(packet: bytes) -> Effects:
    spring, spring_max, centre, damper, constant = PACKET.unpack(packet)
    return Effects(spring=spring, spring_max=spring_max, centre=centre, damper=damper, constant=constant)


def command(path: str, sign: int, settings: ForceFeedbackSettings) -> list[str]:
    """The program that renders the forces of the wheel at `path`."""
    arguments = [path, "--sign", str(sign), "--gain", str(settings.gain), "--uploads", str(settings.uploads_max_1_s)]
    return [sys.executable, "-m", "tower.program", "force-feedback", *arguments]


class Renders(Protocol):
    """What is kept alive: one process."""

    @property
    def ended(self) -> bool: ...
    def feel(self, effects: Effects, now_ns: int) -> None: ...
    def close(self) -> None: ...


class Forces:
    """The forces of one wheel for as long as it is plugged in: `feel` never waits, `look` may (it starts processes)."""

    def __init__(self, start: Callable[[], Renders], now_ns: int) -> None:
        self._start = start
        self._running = start()
        self._revival = Revival(started_ns=now_ns)
        self._closed = False

    def feel(self, effects: Effects, now_ns: int) -> None:
        self._running.feel(effects, now_ns)

    def look(self, now_ns: int) -> str:
        """Start again what has ended, when it is time. In words what is wrong; "" when nothing is. Raises OSError."""
        self._revival, start = looked(self._revival, self._running.ended and not self._closed, now_ns)
        if start:
            # The old pipe is closed with its last reference: closed here, `feel` in the loop's thread might be about to write to a
            # descriptor that means something else by then.
            self._running = self._start()
            if self._closed:  # in another thread, meanwhile
                self._running.close()
        return words(self._revival, now_ns)

    def close(self) -> None:
        self._closed = True
        self._running.close()


class ForceFeedback:
    """One process. `feel` and `close` never wait."""

    def __init__(self, program: list[str]) -> None:
        self._process = subprocess.Popen(program, stdin=subprocess.PIPE, start_new_session=True)
        assert self._process.stdin is not None  # asked for above
        self._pipe = self._process.stdin.fileno()
        os.set_blocking(self._pipe, False)
        self._sent = b""
        self._sent_ns = -REPEAT_NS
        self._closed = False

    @property
    def ended(self) -> bool:
        return self._closed or self._process.poll() is not None

    def feel(self, effects: Effects, now_ns: int) -> None:
        """Let the wheel render these; repeated when nothing changes. Never waits."""
        packet = pack(effects)
        if self._closed or (packet == self._sent and now_ns - self._sent_ns < REPEAT_NS):
            return
        try:
            os.write(self._pipe, packet)
        except OSError:
            return  # it is behind, and what it reads next is old by then anyway; or it has ended
        self._sent, self._sent_ns = packet, now_ns

    def close(self) -> None:
        """Ends the pipe, and with it the process, which resets the wheel by itself. Never waits."""
        self._closed = True
        if self._process.stdin is not None:
            self._process.stdin.close()
