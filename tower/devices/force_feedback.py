"""The wheel's forces, from the cockpit's side: a small process of its own, fed with the newest wanted effects through a pipe.

An upload may block in the kernel with the interpreter's lock held, so it must not happen in a control loop's process. Writing to
the pipe never waits: a packet that does not fit is dropped, the next one says the same. When the cockpit dies the pipe ends, and
with it the forces.
"""

import os
import struct
import subprocess
import sys

from haptics.force_feedback import Effects, ForceFeedbackSettings

PACKET = struct.Struct("<5d")  # spring, spring_max, centre, damper, constant: 40 bytes, whole or not at all (PIPE_BUF)
REPEAT_NS = 50_000_000  # well below the silence after which the process lets the wheel go


def pack(effects: Effects) -> bytes:
    return PACKET.pack(effects.spring, effects.spring_max, effects.centre, effects.damper, effects.constant)


def unpack(packet: bytes) -> Effects:
    spring, spring_max, centre, damper, constant = PACKET.unpack(packet)
    return Effects(spring=spring, spring_max=spring_max, centre=centre, damper=damper, constant=constant)


class ForceFeedback:
    def __init__(self, path: str, sign: int, settings: ForceFeedbackSettings) -> None:
        arguments = [path, "--sign", str(sign), "--gain", str(settings.gain), "--uploads", str(settings.uploads_max_1_s)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tower.program", "force-feedback", *arguments], stdin=subprocess.PIPE, start_new_session=True
        )
        assert self._process.stdin is not None  # asked for above
        self._pipe = self._process.stdin.fileno()
        os.set_blocking(self._pipe, False)
        self._sent = b""
        self._sent_ns = -REPEAT_NS
        self.ended = False

    def feel(self, effects: Effects, now_ns: int) -> None:
        """Let the wheel render these; repeated when nothing changes. Never waits."""
        packet = pack(effects)
        if self.ended or (packet == self._sent and now_ns - self._sent_ns < REPEAT_NS):
            return
        try:
            os.write(self._pipe, packet)
        except BlockingIOError:
            return  # it is behind: what it reads next is old by then anyway
        except OSError:
            self.ended = True
        self._sent, self._sent_ns = packet, now_ns

    def close(self) -> None:
        """Ends the pipe, and with it the process, which resets the wheel by itself. Never waits."""
        self.ended = True
        if self._process.stdin is not None:
            self._process.stdin.close()
