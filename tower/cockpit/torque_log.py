"""Torque steps on their way to the recording: kept until a tenth of a second is full, then one batch. Decides nothing."""

from haptics.alignment import WheelInputs, WheelLimits, WheelState
from haptics.replay import TorqueStep, batch
from wire.messages.steps import TorqueSteps

BATCH_NS = 100_000_000  # 10 Hz by the topic table
STEPS_MAX = 50  # of one batch, should the clock stand still


class TorqueLog:
    """`add` every step, and send what `due` gives: after the command, which must not wait for it."""

    def __init__(self, limits: WheelLimits) -> None:
        self._limits = limits
        self._first = 1
        self._before = WheelState()
        self._steps: list[TorqueStep] = []

    def add(self, before: WheelState, seen: WheelInputs, now_ns: int, dt_s: float, after: WheelState) -> None:
        if not self._steps:
            self._before = before
        self._steps.append(TorqueStep(now_ns, dt_s, seen, after))

    def due(self, now_ns: int) -> TorqueSteps | None:
        """A full batch, or None."""
        full = self._steps and (now_ns - self._steps[0].now_ns >= BATCH_NS or len(self._steps) >= STEPS_MAX)
        return self.rest() if full else None

    def rest(self) -> TorqueSteps | None:
        """Whatever has not been sent yet."""
        if not self._steps:
            return None
        made = batch(self._first, self._before, self._steps, self._limits)
        self._first += len(self._steps)
        self._steps = []
        return made
