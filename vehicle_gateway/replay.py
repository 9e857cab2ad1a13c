"""The gateway's cycle, run again on what was recorded of it. Pure; nothing is sent, nobody is asked.

A run begins with a cycle that carries its `Start`: the state before it, the car and the limits. The journal puts one into
the first cycle that is heard, after every gap, and every START_EVERY cycles; there the replayed state is compared as well.
"""

from typing import NamedTuple

import msgspec

from vehicle_gateway.cycle import step
from vehicle_gateway.state import GatewayLimits, Inputs, Outputs, State
from wire.messages.base import Count, Message, Milliseconds, Name, decoder, encode
from wire.messages.vehicle import GatewayCycle, Mode, VehicleDescription
from wire.replay import Compared, Replay, Step, compared

START_EVERY = 100  # cycles: a check that lost its way goes on within a second


class Start(Message):
    """What a cycle starts from, and what does not change during a run."""

    state: State  # before the cycle
    vehicle: VehicleDescription
    limits: GatewayLimits


class Told(Message):
    """What the recorded message itself says about the cycle."""

    command_sequence: Count
    new_command: bool
    loop_age_ms: Milliseconds
    mode: Mode
    rules: tuple[Name, ...]


class Cycle(NamedTuple):
    """One cycle, computed."""

    start: Start  # of the next one
    outputs: Outputs
    told: Told


_START, _INPUTS, _OUTPUTS = decoder(Start), decoder(Inputs), decoder(Outputs)


def told(state: State, inputs: Inputs, outputs: Outputs) -> Told:
    """state: after the cycle."""
    return Told(
        command_sequence=state.command.sequence if state.command else 0,
        new_command=inputs.command is not None,
        loop_age_ms=state.loop_age_ms,
        mode=outputs.mode,
        rules=outputs.rules,
    )


def begin(message: GatewayCycle) -> Start | None:
    return None if bytes(message.start) == b"null" else _START.decode(message.start)


def run(start: Start, message: GatewayCycle) -> Step:
    """The cycle again, from the state that the cycle before it left."""
    made = _again(start, _INPUTS.decode(message.inputs), message.now_ns)
    recorded = Told(
        command_sequence=message.command_sequence,
        new_command=message.new_command,
        loop_age_ms=message.loop_age_ms,
        mode=message.mode,
        rules=message.rules,
    )
    number = message.number
    found = [
        compared(number, "", bytes(message.outputs), encode(made.outputs), _OUTPUTS.decode),
        Compared(number, "", encode(recorded), encode(made.told)),
    ]
    if bytes(message.start) != b"null":
        found.insert(0, compared(number, "", bytes(message.start), encode(start), _START.decode))
    return made.start, tuple(found)


def _again(start: Start, inputs: Inputs, now_ns: int) -> Cycle:
    state, outputs = step(start.state, inputs, now_ns, start.vehicle, start.limits)
    return Cycle(msgspec.structs.replace(start, state=state), outputs, told(state, inputs, outputs))


GATEWAY_CYCLE = Replay(
    kind="gateway cycle",
    topic="gateway_cycle",
    numbers=lambda message: range(message.number, message.number + 1),
    begin=begin,
    run=run,
)
