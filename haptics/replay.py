"""The wheel's torque step as columns for the recording, and run again on what was recorded of it. Pure.

250 steps a second cross the link: a batch holds the columns of its steps, a column that never changed holds one value, and
the batch carries the state it starts from, so that a lost one costs its own steps and no more.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from operator import attrgetter
from typing import Any, NamedTuple

import msgspec

from haptics.alignment import WheelInputs, WheelLimits, WheelState, step
from wire.messages.steps import TorqueSteps
from wire.replay import Replay, Step, compared

_INPUT_NAMES = tuple(field.name for field in fields(WheelInputs))
_STATE_NAMES = WheelState.__struct_fields__
_input_values, _state_values = attrgetter(*_INPUT_NAMES), attrgetter(*_STATE_NAMES)
_ENCODE = msgspec.json.Encoder().encode
_STATE, _LIMITS = msgspec.json.Decoder(WheelState), msgspec.json.Decoder(WheelLimits)
_COLUMNS = msgspec.json.Decoder(dict[str, list[Any]])


class TorqueStep(NamedTuple):
    """One step as it happened."""

    now_ns: int
    dt_s: float
    seen: WheelInputs
    after: WheelState


class Memory(NamedTuple):
    """What the next step starts from."""

    state: WheelState
    limits: WheelLimits


def batch(first: int, before: WheelState, steps: Sequence[TorqueStep], limits: WheelLimits) -> TorqueSteps:
    """The record of one or more steps that followed each other; `first` is the number of the first."""
    rows = [(each.now_ns, each.dt_s, *_input_values(each.seen)) for each in steps]
    return TorqueSteps(
        stamp_ns=steps[-1].now_ns,
        first=first,
        count=len(steps),
        limits=msgspec.Raw(_ENCODE(limits)),
        before=msgspec.Raw(_ENCODE(before)),
        inputs=msgspec.Raw(_ENCODE(columns(("now_ns", "dt_s", *_INPUT_NAMES), rows))),
        outputs=msgspec.Raw(_ENCODE(columns(_STATE_NAMES, [_state_values(each.after) for each in steps]))),
    )


def columns(names: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> dict[str, list[Any]]:
    """Rows of the same values by name; a column whose values have one and the same text holds it once."""
    return {name: _once(list(column)) for name, column in zip(names, zip(*rows, strict=True), strict=True)}


def _once(column: list[Any]) -> list[Any]:
    if column.count(column[0]) != len(column):
        return column
    signs_differ = column[0] == 0 and len({str(value) for value in column}) > 1  # 0.0 and -0.0 are equal, and not the same
    return column if signs_differ else column[:1]


def rows_of(table: Mapping[str, list[Any]], count: int) -> list[dict[str, Any]]:
    """The rows of `columns` again. Raises ValidationError when a column is neither of one value nor of `count`."""
    for name, column in table.items():
        if len(column) not in (1, count):
            raise msgspec.ValidationError(f"{len(column)} values of {name} for {count} steps")
    return [{name: column[row if len(column) > 1 else 0] for name, column in table.items()} for row in range(count)]


def begin(message: TorqueSteps) -> Memory:
    return Memory(_STATE.decode(message.before), _LIMITS.decode(message.limits))


def run(memory: Memory, message: TorqueSteps) -> Step:
    """Every step of the batch again, from the state that the batch before it left."""
    state = memory.state
    found = [compared(message.first, "before", bytes(message.before), _ENCODE(state), _STATE.decode)]
    recorded = rows_of(_COLUMNS.decode(message.outputs), message.count)
    for offset, row in enumerate(rows_of(_COLUMNS.decode(message.inputs), message.count)):
        now_ns, dt_s = msgspec.convert((row.pop("now_ns"), row.pop("dt_s")), tuple[int, float])
        state = step(state, msgspec.convert(row, WheelInputs), now_ns, dt_s, memory.limits)
        found.append(compared(message.first + offset, "", _ENCODE(recorded[offset]), _ENCODE(state), _STATE.decode))
    return memory._replace(state=state), tuple(found)


TORQUE_STEPS = Replay(
    kind="torque step",
    topic="torque_steps",
    numbers=lambda message: range(message.first, message.first + message.count),
    begin=begin,
    run=run,
)
