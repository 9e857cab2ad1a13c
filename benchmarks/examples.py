"""A plausible full-size message of every type, made from its type alone: for load, and for tests that send every topic."""

import json
import random
import re
from typing import Any

import msgspec
from msgspec import inspect

from wire.messages.base import decoder
from wire.topics import TOPICS

_LIST_ITEMS = 12  # objects of a scene, points of a plan
_DEEP = 100_000  # brackets: far beyond any recursion limit
_RAW_BYTES = 1500  # inputs and outputs of one gateway cycle, each


def example(type_: Any) -> Any:
    """A plausible JSON value of a message's type, lists and texts filled."""
    if isinstance(type_, inspect.StructType):
        return {field.encode_name: example(field.type) for field in type_.fields}
    if isinstance(type_, inspect.UnionType):
        return example(next(choice for choice in type_.types if not isinstance(choice, inspect.NoneType)))
    if isinstance(type_, inspect.VarTupleType):
        return [example(type_.item_type)] * min(_LIST_ITEMS, type_.max_length or _LIST_ITEMS)
    if isinstance(type_, inspect.TupleType):
        return [example(item) for item in type_.item_types]
    if isinstance(type_, inspect.DictType):
        return {"front": example(type_.value_type)}
    if isinstance(type_, inspect.EnumType):
        return next(iter(type_.cls)).value
    if isinstance(type_, inspect.StrType):
        if type_.pattern:
            return "right" if "right" in type_.pattern else "0" * 64  # a side of the road, or the digits of a hash
        return "x" * min(type_.max_length or 20, 20)
    if isinstance(type_, inspect.BoolType):
        return True
    if isinstance(type_, inspect.RawType | inspect.AnyType):
        return {f"value_{number}": 0.123456 for number in range(_RAW_BYTES // 20)}
    return _number(type_)


def _number(type_: Any) -> int | float:
    low, high = type_.ge if type_.ge is not None else type_.gt, type_.le
    if isinstance(type_, inspect.IntType):
        return min(123_456_789_012, high) if high is not None else 1
    return random.Random(low).uniform(low or 0.0, min(high or 1.0, 100.0))


def encode_example(name: str) -> bytes:
    message_type = TOPICS[name].type
    if message_type is None:
        raise ValueError(f"{name} carries bytes")
    payload = msgspec.json.encode(example(inspect.type_info(message_type)))
    decoder(message_type).decode(payload)
    return payload


def changed(payload: bytes, **fields: object) -> bytes:
    """The message with some of its fields set to anything."""
    return json.dumps(json.loads(payload) | fields).encode()


def wrong(name: str) -> dict[str, bytes]:
    """What may not get in on this topic, by what is wrong with it."""
    good = encode_example(name)
    number = re.search(rb'"(\w+)":(-?\d[\d.e+-]*)', good)  # the first number, wherever it stands
    if number is None:
        raise ValueError(f"{name} has no number")
    field = number[1].decode()
    nested = "inputs" if "inputs" in json.loads(good) else field  # the one field that takes any JSON, where there is one

    def with_number(text: bytes) -> bytes:
        return good[: number.start(2)] + text + good[number.end(2) :]

    kinds = {
        "nothing": b"",
        "noise": b"\x00\xff\x17",
        "not text": good.replace(b'"', b'"\xff', 1),
        "half of it": good[: len(good) // 2],
        "all but its end": good[:-1],
        "twice": good + good,
        "deep nesting": changed(good, **{nested: "deep"}).replace(b'"deep"', b"[" * _DEEP + b"]" * _DEEP),
        "another message": encode_example("clock_ping" if name != "clock_ping" else "imu"),
        f"unknown key beside {field}": changed(good, surprise=1),
        f"{field} is NaN": with_number(b"NaN"),
        f"{field} is infinite": with_number(b"1e999"),
        f"{field} is far below its range": with_number(b"-1e18"),
        f"{field} is far above its range": with_number(b"1e19"),
        f"{field} is a text": with_number(b'"1"'),
        f"{field} is missing": json.dumps({key: value for key, value in json.loads(good).items() if key != field}).encode(),
    }
    return {what: payload for what, payload in kinds.items() if not (what.endswith("missing") and field not in json.loads(good))}
