"""Every message: what is encoded comes back, and nothing wrong gets in - no NaN, no number out of range, no unknown field."""

import inspect as python_inspect
import json
from math import inf, nan, nextafter
from types import ModuleType

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import inspect

from tests.messages import drive_command
from wire.messages import audit, automation, health, operating, sensing, session, vehicle
from wire.messages.base import Message, decoder, encode

MODULES: tuple[ModuleType, ...] = (audit, automation, health, operating, sensing, session, vehicle)
MESSAGES = sorted(
    {
        type_
        for module in MODULES
        for _, type_ in python_inspect.getmembers(module, python_inspect.isclass)
        if issubclass(type_, Message) and type_ is not Message
    },
    key=lambda type_: type_.__name__,
)
COMMAND = drive_command(
    sequence=2,
    sent_ns=3,
    event_ns=4,
    echoed_vehicle_ns=5,
    echoed_boot_id="b",
    displayed_capture_ns={"front": 6},
    road_wheel_angle_rad=0.1,
    acceleration_m_s2=-1.0,
)


def values(kind: inspect.Type) -> st.SearchStrategy[object]:
    """Any allowed value of a field, from what msgspec knows about its type."""
    match kind:
        case inspect.FloatType():
            return st.floats(
                kind.ge if kind.ge is not None else kind.gt,
                kind.le if kind.le is not None else kind.lt,
                exclude_min=kind.gt is not None,
                allow_nan=False,
                allow_infinity=False,
            )
        case inspect.IntType():
            return st.integers(kind.ge, kind.le)
        case inspect.StrType(pattern="^(left|right)$"):
            return st.sampled_from(["left", "right"])
        case inspect.StrType(pattern="^[0-9a-f]{64}$" | "^([0-9a-f]{64})?$" | "^([0-9a-f]{2}){0,80}$"):
            return st.binary(min_size=32, max_size=32).map(bytes.hex)
        case inspect.StrType():
            return st.text(st.characters(codec="utf-8"), max_size=min(kind.max_length or 20, 20))
        case inspect.BoolType():
            return st.booleans()
        case inspect.EnumType():
            return st.sampled_from(list(kind.cls))
        case inspect.NoneType():
            return st.none()
        case inspect.UnionType():
            return st.one_of([values(each) for each in kind.types])
        case _:
            return containers(kind)


def containers(kind: inspect.Type) -> st.SearchStrategy[object]:
    match kind:
        case inspect.DictType():
            return st.dictionaries(values(kind.key_type), values(kind.value_type), max_size=3)
        case inspect.VarTupleType():
            return st.lists(values(kind.item_type), min_size=kind.min_length or 0, max_size=3).map(tuple)
        case inspect.TupleType():
            return st.tuples(*map(values, kind.item_types))
        case inspect.StructType():
            return messages(kind.cls)
        case inspect.RawType():
            return st.sampled_from([msgspec.Raw(b"{}"), msgspec.Raw(b'{"a":[1,null]}')])
    raise AssertionError(f"a message holds a {kind}: say here what is allowed in it")


def messages(type_: type[Message]) -> st.SearchStrategy[Message]:
    fields = inspect.type_info(type_).fields
    return st.builds(type_, **{field.name: values(field.type) for field in fields})


def numbers(type_: type[Message]) -> list[tuple[str, inspect.FloatType | inspect.IntType]]:
    return [
        (field.name, field.type)
        for field in inspect.type_info(type_).fields
        if isinstance(field.type, inspect.FloatType | inspect.IntType)
    ]


def altered(message: Message, name: str, text: str) -> bytes:
    """The JSON of the message with one field's value replaced by this text."""
    fields = {key: json.dumps(value) for key, value in json.loads(encode(message)).items()} | {name: text}
    return ("{" + ",".join(f"{json.dumps(key)}:{value}" for key, value in fields.items()) + "}").encode()


def refused(type_: type[Message], data: bytes) -> bool:
    try:
        decoder(type_).decode(data)
    except msgspec.DecodeError:
        return True
    return False


@pytest.mark.parametrize("type_", MESSAGES, ids=lambda type_: type_.__name__)
@settings(max_examples=15, deadline=None)
@given(data=st.data())
def test_what_is_encoded_is_what_is_decoded(type_: type[Message], data: st.DataObject):
    message = data.draw(messages(type_))
    assert decoder(type_).decode(encode(message)) == message


@pytest.mark.parametrize("type_", MESSAGES, ids=lambda type_: type_.__name__)
@settings(max_examples=1, deadline=None)
@given(data=st.data())
def test_every_number_has_a_range_and_what_is_outside_is_refused(type_: type[Message], data: st.DataObject):
    message = data.draw(messages(type_))
    for name, kind in numbers(type_):
        low = kind.ge if kind.ge is not None else kind.gt
        high = kind.le if kind.le is not None else kind.lt
        assert low is not None, f"{type_.__name__}.{name} has no lower bound"
        assert high is not None, f"{type_.__name__}.{name} has no upper bound"
        outside = (low - 1, high + 1) if isinstance(kind, inspect.IntType) else (nextafter(low, -inf), nextafter(high, inf))
        for number in outside:
            assert refused(type_, altered(message, name, repr(number))), f"{type_.__name__}.{name} = {number}"


@pytest.mark.parametrize("type_", MESSAGES, ids=lambda type_: type_.__name__)
@settings(max_examples=1, deadline=None)
@given(data=st.data())
def test_no_nan_no_infinity_no_truth_value_and_no_text_passes_for_a_number(type_: type[Message], data: st.DataObject):
    message = data.draw(messages(type_))
    for name, _ in numbers(type_):
        for text in ("NaN", "Infinity", "-Infinity", "1e999", "true", "null", '"1"', "[]"):
            assert refused(type_, altered(message, name, text)), f"{type_.__name__}.{name} = {text}"
    for field in inspect.type_info(type_).fields:
        if isinstance(field.type, inspect.BoolType):
            assert refused(type_, altered(message, field.name, "1"))


@pytest.mark.parametrize("type_", MESSAGES, ids=lambda type_: type_.__name__)
@settings(max_examples=1, deadline=None)
@given(data=st.data())
def test_unknown_and_missing_fields_are_refused(type_: type[Message], data: st.DataObject):
    message = data.draw(messages(type_))
    assert refused(type_, altered(message, "no_such_field", "1"))
    fields = json.loads(encode(message))
    for field in inspect.type_info(type_).fields:
        if field.required:
            assert refused(type_, json.dumps({name: value for name, value in fields.items() if name != field.name}).encode()), (
                field.name
            )


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_nan_of_our_own_does_not_survive_the_wire(bad: float):
    for field in ("road_wheel_angle_rad", "acceleration_m_s2"):
        assert refused(operating.DriveCommand, encode(msgspec.structs.replace(COMMAND, **{field: bad})))


@given(st.binary(max_size=200))
def test_noise_is_refused_with_one_kind_of_error_or_is_no_command(noise: bytes):
    """Whoever catches it at the edge must know what to catch, or a callback dies of noise: see test_link."""
    for data in (noise, encode(COMMAND)[:120] + noise, encode(COMMAND) + noise.strip(b" \t\r\n")):
        if data != encode(COMMAND):
            with pytest.raises(ValueError):  # msgspec's errors and those of broken text are such
                decoder(operating.DriveCommand).decode(data)


def test_messages_are_frozen_and_named_only():
    with pytest.raises(AttributeError):
        COMMAND.sequence = 3  # type: ignore[misc]
    with pytest.raises(TypeError):
        operating.ClockPing(1, 2)  # type: ignore[misc]
    assert isinstance(COMMAND, Message)
    assert not isinstance(1, Message)
    assert type(operating.DriveCommand) is type(msgspec.Struct), "a metaclass of ours makes every message four times as slowly"


def test_equal_messages_give_equal_bytes_whatever_the_order_they_were_said_in():
    one = operating.ClockPing(number=1, sent_ns=2)
    other = operating.ClockPing(sent_ns=2, number=1)
    assert encode(one) == encode(other)
