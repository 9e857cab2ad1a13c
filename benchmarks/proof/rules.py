"""What is asked of every decoder that is fuzzed. Pure."""

from collections.abc import Callable
from dataclasses import fields, is_dataclass
from math import isfinite
from typing import Any, NamedTuple

import msgspec


class Broken(AssertionError):
    """A rule that a decoder broke."""


class Target(NamedTuple):
    name: str
    try_one: Callable[[bytes], None]
    seeds: tuple[bytes, ...]
    share: int = 10  # of the inputs; those that touch a file are dearer


def must_be_finite(value: Any, where: str = "") -> None:
    """No NaN and no infinity anywhere in what was let in."""
    if isinstance(value, float):
        if not isfinite(value):
            raise Broken(f"{where} is {value}")
    elif isinstance(value, msgspec.Struct):
        for name in value.__struct_fields__:
            must_be_finite(getattr(value, name), f"{where}.{name}")
    elif isinstance(value, dict):
        for key, item in value.items():
            must_be_finite(item, f"{where}[{key}]")
    elif isinstance(value, list | tuple):
        for item in value:
            must_be_finite(item, where)
    elif is_dataclass(value) and not isinstance(value, type):
        for part in fields(value):
            must_be_finite(getattr(value, part.name), f"{where}.{part.name}")
