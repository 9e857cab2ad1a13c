"""The rules every message keeps: frozen, keyword-only, unknown fields refused, every number with a range.

JSON on the wire and in the recording. Only decoding validates (ranges, NaN, unknown fields): whatever came in through
`decode` may be trusted, whatever was built by a constructor is our own.

Units are in the names. SI inside. Frames are ISO 8855 (x forward, y left, z up). The map frame has x east, y north.
Time is integer nanoseconds on the SENDER's monotonic clock unless the name says otherwise.
"""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, TypeVar, dataclass_transform

import msgspec
from msgspec import Meta

if TYPE_CHECKING:
    # Type checkers know frozen and keyword-only from this; they cannot follow a metaclass of our own.
    @dataclass_transform(frozen_default=True, kw_only_default=True)
    class Message(msgspec.Struct, frozen=True, kw_only=True): ...
else:

    class _Struct(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
        """What every message is at run time."""

    class _Keyword(type):
        """msgspec does not inherit `kw_only`: every class has to be told, and here it is.

        The class that comes out is a plain struct, none of this metaclass: CPython 3.11 makes instances of those four times as
        slowly (a metaclass written in Python has no vectorcall; 295 instead of 79 ns for six numbers).
        """

        def __new__(cls, name, bases, namespace):  # noqa: ANN001, ANN204
            if not bases:
                return super().__new__(cls, name, bases, namespace)
            return type(_Struct)(name, (_Struct,), namespace, kw_only=True)

        def __instancecheck__(cls, instance):  # noqa: ANN001, ANN204
            return isinstance(instance, _Struct)

        def __subclasscheck__(cls, subclass):  # noqa: ANN001, ANN204
            return issubclass(subclass, _Struct)

    class Message(metaclass=_Keyword):
        """Base of every message and of every section of the configuration."""


M = TypeVar("M", bound=Message)

TimeNs = Annotated[int, Meta(ge=0, le=2**62)]
DurationNs = Annotated[int, Meta(ge=-(2**62), le=2**62)]
Count = Annotated[int, Meta(ge=0, le=2**53)]
Angle = Annotated[float, Meta(ge=-6.3, le=6.3)]  # rad
RoadWheelAngle = Annotated[float, Meta(ge=-0.8, le=0.8)]  # rad at the road wheels, positive turns left
SteeringWheelAngle = Annotated[float, Meta(ge=-16.0, le=16.0)]  # rad at the steering wheel, positive turns left
Acceleration = Annotated[float, Meta(ge=-30.0, le=30.0)]  # m/s2, forward positive
CommandAcceleration = Annotated[float, Meta(ge=-10.0, le=5.0)]  # m/s2
Speed = Annotated[float, Meta(ge=-30.0, le=100.0)]  # m/s, forward positive
Rate = Annotated[float, Meta(ge=-20.0, le=20.0)]  # rad/s
Length = Annotated[float, Meta(ge=0.0, le=1e5)]  # m
Position = Annotated[float, Meta(ge=-1e6, le=1e6)]  # m, map frame
Ratio = Annotated[float, Meta(ge=0.0, le=1.0)]
SignedRatio = Annotated[float, Meta(ge=-1.0, le=1.0)]
Milliseconds = Annotated[float, Meta(ge=0.0, le=1e9)]
DeviceDelay = Annotated[float, Meta(ge=0.0, le=500.0)]  # ms, of a camera or a screen, or its bound; ours: more is none to drive
Seconds = Annotated[float, Meta(ge=0.0, le=1e9)]
Text = Annotated[str, Meta(max_length=2000)]
Name = Annotated[str, Meta(max_length=64)]
Point = tuple[Position, Position]  # x_m, y_m in the map frame
Path = Annotated[tuple[Point, ...], Meta(max_length=1000)]  # ours: many times the longest plan, walked in every cycle
CAMERAS_MAX = 16  # ours: more than any car has


class Gear(StrEnum):
    PARK = "park"
    REVERSE = "reverse"
    NEUTRAL = "neutral"
    DRIVE = "drive"


class Indicators(StrEnum):
    OFF = "off"
    LEFT = "left"
    RIGHT = "right"


class Lights(StrEnum):
    OFF = "off"
    LOW = "low"
    HIGH = "high"


class Wipers(StrEnum):
    OFF = "off"
    SLOW = "slow"
    FAST = "fast"


UNDECODABLE = (msgspec.DecodeError, UnicodeDecodeError, RecursionError)  # text that is not UTF-8; too deep nesting in a Raw
_ENCODER = msgspec.json.Encoder()


def encode(message: Message) -> bytes:
    """JSON bytes of a message. Fields in declaration order, so equal messages give equal bytes."""
    return _ENCODER.encode(message)


def decoder(message_type: type[M]) -> "msgspec.json.Decoder[M]":
    """A reusable decoder. Its `decode(bytes)` raises one of UNDECODABLE on anything wrong."""
    return msgspec.json.Decoder(message_type)
