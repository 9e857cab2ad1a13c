"""The DBC of another car: what it must have for us to speak it, and its frames. Pure but for reading the file.

Names, units and what a number stands for have to be those of config/drive_by_wire.dbc; everything else is its own.
"""

from functools import cache
from pathlib import Path
from typing import Any

from vehicle_gateway.can.layout import (
    DATA_ID,
    PROTECTION,
    Layout,
    data_id_of,
    database_in,
    layout_of,
    layouts,
    shipped_database,
)
from wire.configuration import ConfigurationError

PROTECTED = {"CRC": (0, 8), "COUNTER": (8, 4)}  # start bit and length, E2E Profile 1 variant 1A
NEEDED = ("ACTUATION_COMMAND", "BODY_COMMAND", "MOTION_FEEDBACK", "DRIVE_STATE", "LOCAL_CONTROLS", "WHEEL_SPEEDS")


@cache
def read_layouts(file: str) -> dict[str, Layout]:
    """The frames of a car's DBC by name; "" is the shipped one. Raises ConfigurationError that names what is wrong with it."""
    if not file:
        return layouts()
    database = database_in(Path(file).expanduser())
    problems = problems_of(database)
    if problems:
        raise ConfigurationError(f"[vehicle_gateway.can] dbc = {file!r}: {problems[0]}")
    found = {message.name: message for message in database.messages}
    return {
        name: layout_of(found[name], [field.name for field in ours.fields]) for name, ours in layouts().items() if name in found
    }


def problems_of(database: Any) -> tuple[str, ...]:
    """Why this DBC cannot be spoken, one line each; () when it can."""
    found = {message.name: message for message in database.messages}
    problems = [f"message {name} is missing" for name in NEEDED if name not in found]
    for name, message in found.items():
        ours = layouts().get(name)
        if ours is not None:
            problems += [f"{name}: {problem}" for problem in _message_problems(message, ours)]
    ids = [data_id_of(found[name]) for name in found if name in layouts()]
    problems += [f"{DATA_ID} {number} is used twice" for number in sorted({x for x in ids if ids.count(x) > 1} - {0})]
    return tuple(problems)


def _message_problems(message: Any, ours: Layout) -> list[str]:
    signals = {signal.name: signal for signal in message.signals}
    extra = set(signals) - {field.name for field in ours.fields} - set(PROTECTION)
    problems = [f"signal {name} is missing" for name in (*PROTECTION, *(f.name for f in ours.fields)) if name not in signals]
    problems += [f"signal {name} is not ours: it would be sent as 0" for name in sorted(extra)]
    problems += [f"signal {name} is big-endian: ours are Intel" for name, s in signals.items() if s.byte_order != "little_endian"]
    problems += [f"signal {name} has no range [minimum|maximum]" for name, s in signals.items() if None in (s.minimum, s.maximum)]
    problems += [
        f"signal {name}: bit {signals[name].start}, length {signals[name].length}; E2E Profile 1 has {place[0]}, {place[1]}"
        for name, place in PROTECTED.items()
        if name in signals and (signals[name].start, signals[name].length) != place
    ]
    for own in shipped_database().get_message_by_name(ours.name).signals:
        if own.name in signals:
            problems += _meaning_problems(signals[own.name], own)
    problems += ["no E2EDataId"] * (not data_id_of(message))
    problems += [f"identifier {message.frame_id:#x} has more than 11 bit"] * bool(message.is_extended_frame)
    return problems + ["longer than 8 bytes: CAN FD is not spoken"] * (message.length > 8)


def _meaning_problems(signal: Any, own: Any) -> list[str]:
    """The same name has to mean the same: its unit, and what each number stands for."""
    problems = [f"signal {own.name} is in {signal.unit or 'no unit'}, ours in {own.unit}"] * (signal.unit != own.unit)
    theirs, wanted = ({int(number): str(word) for number, word in (each.choices or {}).items()} for each in (signal, own))
    differing = [number for number in wanted if theirs.get(number) != wanted[number]]
    return problems + [
        f"signal {own.name}: {number} is {theirs.get(number, 'nothing')!r}, ours is {wanted[number]!r} (VAL_)"
        for number in differing
    ]
