"""The take-over monitor's step, for the recording and run again on what was recorded of it. Pure.

The step is `monitor.judge`: its inputs are the levels of the channels and what a request would offer, its output is the
monitor's whole state. Every record carries the state before it, so that a lost one costs itself and no more.
"""

from dataclasses import dataclass
from typing import NamedTuple

import msgspec

from autonomy.uncertainty.channels import Level
from autonomy.uncertainty.monitor import MonitorSettings, MonitorState, Trouble, judge
from wire.messages.steps import MonitorStep
from wire.replay import Replay, Step, compared


@dataclass(frozen=True, slots=True, kw_only=True)
class MonitorInputs:
    levels: tuple[Level, ...]
    trouble: Trouble


@dataclass(frozen=True, slots=True, kw_only=True)
class Judged:
    """One step as it happened."""

    number: int
    now_ns: int
    before: MonitorState
    inputs: MonitorInputs
    after: MonitorState


class Memory(NamedTuple):
    """What the next step starts from."""

    state: MonitorState
    settings: MonitorSettings


_ENCODE = msgspec.json.Encoder().encode
_STATE, _INPUTS = msgspec.json.Decoder(MonitorState), msgspec.json.Decoder(MonitorInputs)
_SETTINGS = msgspec.json.Decoder(MonitorSettings)


def record(judged: Judged, settings: MonitorSettings) -> MonitorStep:
    return MonitorStep(
        number=judged.number,
        now_ns=judged.now_ns,
        settings=msgspec.Raw(_ENCODE(settings)),
        before=msgspec.Raw(_ENCODE(judged.before)),
        inputs=msgspec.Raw(_ENCODE(judged.inputs)),
        outputs=msgspec.Raw(_ENCODE(judged.after)),
    )


def begin(message: MonitorStep) -> Memory:
    return Memory(_STATE.decode(message.before), _SETTINGS.decode(message.settings))


def run(memory: Memory, message: MonitorStep) -> Step:
    """The step again, from the state that the one before it left."""
    inputs = _INPUTS.decode(message.inputs)
    after = judge(memory.state, inputs.levels, inputs.trouble, message.now_ns, memory.settings)
    return memory._replace(state=after), (
        compared(message.number, "before", bytes(message.before), _ENCODE(memory.state), _STATE.decode),
        compared(message.number, "", bytes(message.outputs), _ENCODE(after), _STATE.decode),
    )


MONITOR_STEP = Replay(
    kind="monitor step",
    topic="monitor_step",
    numbers=lambda message: range(message.number, message.number + 1),
    begin=begin,
    run=run,
)
