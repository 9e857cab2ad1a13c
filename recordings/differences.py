"""Where two JSON texts differ: the path of the first field, and both values. Pure. Numbers are compared bit for bit.

An integer and a float of the same value are equal (0 and 0.0 decode to the same field); 0.0 and -0.0 are not.
"""

import struct
from typing import Any, NamedTuple

import msgspec

_SHOWN = 120  # characters of a value: a whole corridor is no help


class Difference(NamedTuple):
    path: str  # "applied.acceleration_m_s2", "stops[2]"; "" when the whole differs
    recorded: str
    replayed: str


def difference(recorded: bytes, replayed: bytes) -> Difference | None:
    """The first field, in the order of the fields, that differs; None when all are equal. Raises DecodeError."""
    if recorded == replayed:
        return None
    return _between("", msgspec.json.decode(recorded), msgspec.json.decode(replayed))


def _between(path: str, one: Any, other: Any) -> Difference | None:
    if isinstance(one, dict) and isinstance(other, dict):
        return _between_tables(path, one, other)
    if isinstance(one, list) and isinstance(other, list):
        return _between_lists(path, one, other)
    return None if _same(one, other) else Difference(path, _text(one), _text(other))


def _between_tables(path: str, one: dict[str, Any], other: dict[str, Any]) -> Difference | None:
    for name in dict.fromkeys((*one, *other)):
        inner = f"{path}.{name}" if path else name
        if name not in one or name not in other:
            return Difference(
                inner, _text(one[name]) if name in one else "nothing", _text(other[name]) if name in other else "nothing"
            )
        found = _between(inner, one[name], other[name])
        if found is not None:
            return found
    return None


def _between_lists(path: str, one: list[Any], other: list[Any]) -> Difference | None:
    for index, (left, right) in enumerate(zip(one, other, strict=False)):
        found = _between(f"{path}[{index}]", left, right)
        if found is not None:
            return found
    return None if len(one) == len(other) else Difference(path, f"{len(one)} entries", f"{len(other)} entries")


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, bool) or isinstance(other, bool):
        return one is other
    if isinstance(one, float) or isinstance(other, float):
        numbers = isinstance(one, int | float) and isinstance(other, int | float)
        return numbers and struct.pack("<d", one) == struct.pack("<d", other)
    return type(one) is type(other) and bool(one == other)


def _text(value: Any) -> str:
    text = msgspec.json.encode(value).decode("utf-8")
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."
