"""Inputs that are almost right: a real one with a few things changed. Pure: the same generator gives the same inputs."""

import random
import re

NUMBERS = (
    b"NaN",
    b"Infinity",
    b"-Infinity",
    b"1e999",
    b"-1e999",
    b"1e308",
    b"-0.0",
    b"1e-400",
    b"9223372036854775808",
    b"-1",
    b"0",
)
TOKENS = (*NUMBERS, b"null", b"true", b'""', b"[]", b"{}", b"\xff", b"\x00", b"nan", b"inf", b'"\\ud800"')
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?|\bnan\b|\binf\b")
LONGEST = 20_000  # bytes


def changed(source: random.Random, data: bytes) -> bytes:
    """One to four changes."""
    for _ in range(source.choice((1, 1, 2, 4))):
        data = source.choice(CHANGES)(source, data)
    return data[:LONGEST]


def _number(source: random.Random, data: bytes) -> bytes:
    places = list(_NUMBER.finditer(data))
    if not places:
        return _byte(source, data)
    place = source.choice(places)
    text = source.choice(NUMBERS) if source.random() < 0.7 else repr(source.uniform(-1e3, 1e3)).encode()
    return data[: place.start()] + text + data[place.end() :]


def _byte(source: random.Random, data: bytes) -> bytes:
    at = source.randrange(len(data) + 1)
    return data[:at] + bytes((source.randrange(256),)) + data[at + 1 :]


def _bit(source: random.Random, data: bytes) -> bytes:
    if not data:
        return b"\x01"
    at = source.randrange(len(data))
    return data[:at] + bytes((data[at] ^ 1 << source.randrange(8),)) + data[at + 1 :]


def _token(source: random.Random, data: bytes) -> bytes:
    at = source.randrange(len(data) + 1)
    return data[:at] + source.choice(TOKENS) + data[at:]


def _cut(source: random.Random, data: bytes) -> bytes:
    low, high = sorted((source.randrange(len(data) + 1), source.randrange(len(data) + 1)))
    return data[:low] + data[high:] if source.random() < 0.5 else data[low:high]


def _twice(source: random.Random, data: bytes) -> bytes:
    low, high = sorted((source.randrange(len(data) + 1), source.randrange(len(data) + 1)))
    return data[:high] + data[low:high] + data[high:]


CHANGES = (_number, _number, _number, _byte, _byte, _bit, _bit, _token, _cut, _twice)
