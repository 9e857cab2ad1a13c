"""What is fuzzed of CAN: every end of our own bus, the watchdog's ear, and the Toyota's codec. Pure.

An input is frames one after the other, ten bytes each: the first chooses the identifier, the second whether the frame's own
protection is made good, the rest is its payload.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

from benchmarks.proof.rules import Broken, Target, must_be_finite
from vehicle_gateway.can.actuator_codec import DemandState, PlantState, decode_demand, decode_plant
from vehicle_gateway.can.e2e import COUNTER_MODULUS, protect
from vehicle_gateway.can.ecu_codec import CommandState, decode_command
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import HealthState
from vehicle_gateway.can.layout import Layout, layouts
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.toyota_codec import ToyotaCodec, toyota_codec
from vehicle_gateway.can.toyota_feedback import LATERAL_MAX_M_S2, ToyotaState
from vehicle_gateway.can.toyota_layout import ToyotaLayout, checksum, toyota_layouts
from vehicle_gateway.can.vehicles import car_bus_of
from vehicle_gateway.can.watch_codec import SHIPPED, StopState, decode_stop
from vehicle_gateway.watchdog_ear import Ear, ears_of, hear
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription

SHARE = 40
EACH = 10  # bytes of an input for one frame
FRAMES_MAX = 10  # of one input
NO_FRAME_OF_OURS = 240  # from this first byte on
EARS = ears_of(layouts())
# All that a feedback wants, and then the wheels at 10 m/s, twice: raw numbers saturate, what is not named is 0.
TOYOTA_DRIVES: tuple[tuple[str, dict[str, float]], ...] = (
    ("SPEED", {"SPEED": 36.0}),
    ("STEER_ANGLE_SENSOR", {"STEER_ANGLE": 12.0}),
    ("STEER_TORQUE_SENSOR", {}),
    ("PCM_CRUISE", {"CRUISE_ACTIVE": 1.0}),
    ("PCM_CRUISE_2", {}),
    ("EPS_STATUS", {"LTA_STATE": 5.0}),
    ("GEAR_PACKET", {}),
    *((("WHEEL_SPEEDS", dict.fromkeys(("FRONT_LEFT", "FRONT_RIGHT", "REAR_LEFT", "REAR_RIGHT"), 36.0)),) * 2),
)


class Bus(NamedTuple):
    """The frames of a car, and how one of them is made good."""

    known: Sequence[Any]  # layouts
    good: Callable[[Any, bytes, int], bytes]  # layout, payload, how many frames came before -> payload


def _protected(layout: Layout, body: bytes, counter: int) -> bytes:
    return protect(layout.data_id, bytes((body[1] & 0xF0 | counter % COUNTER_MODULUS,)) + body[2:])


def _summed(layout: ToyotaLayout, body: bytes, _: int) -> bytes:
    return body[:-1] + bytes((checksum(layout.arbitration_id, body[:-1]),)) if layout.has_checksum else body


OURS = Bus(tuple(layouts().values()), _protected)
TOYOTA = Bus(tuple(toyota_layouts().values()), _summed)


def can_targets() -> Iterator[Target]:
    yield from _ours()
    yield from _toyota()


def _ours() -> Iterator[Target]:
    car = car_bus_of(CanSettings(), _vehicle("simulated.toml"))
    codec, health = car.codec, car.health
    seeds = tuple(
        bytes((number, 0)) + layout.pack([field.low for field in layout.fields], 0).data for number, layout in enumerate(OURS.known)
    )
    ends: tuple[tuple[str, Callable[[], Any], Callable[[Any, Frame], tuple[Any, str]]], ...] = (
        ("CAN gateway", codec.start, codec.decode),
        ("CAN ECU command", CommandState, decode_command),
        ("CAN demand", DemandState, decode_demand),
        ("CAN plant", PlantState, decode_plant),
        ("CAN watchdog ear", Ear, lambda ear, frame: hear(ear, frame, 1, EARS)),
    )
    for name, start, decode in ends:
        yield Target(name, _frames(OURS, start, decode), seeds, SHARE)
    if health is not None:
        yield Target("CAN health", _frames(OURS, HealthState, health.decode, health.speaks), seeds, SHARE)
    yield Target("CAN watchdog stop", _frames(OURS, StopState, decode_stop, _asks_for_a_stop), seeds, SHARE)
    yield Target("CAN layouts", _layouts, seeds, SHARE)


def _vehicle(name: str) -> VehicleDescription:
    found: VehicleDescription = read_sections(shipped(name), {"vehicle": VehicleDescription})["vehicle"]
    return found


def _asks_for_a_stop(frame: Frame) -> bool:
    return frame.arbitration_id == SHIPPED.stop.arbitration_id


def _frames(
    bus: Bus,
    start: Callable[[], Any],
    decode: Callable[[Any, Frame], tuple[Any, str]],
    speaks: Callable[[Frame], bool] = lambda _: True,
    check: Callable[[Any], None] = lambda _: None,
) -> Callable[[bytes], None]:
    """check  what must hold of the state besides"""

    def try_one(data: bytes) -> None:
        state = start()
        for number, frame in enumerate(frames_of(bus, data)):
            if speaks(frame):
                state, reason = decode(state, frame)
                if not isinstance(reason, str):
                    raise Broken(f"frame {number} was dropped for {reason!r}")
                check(state)
        must_be_finite(state, "state")

    return try_one


def frames_of(bus: Bus, data: bytes) -> Iterator[Frame]:
    for number, at in enumerate(range(0, min(len(data), EACH * FRAMES_MAX), EACH)):
        yield _frame(bus, data[at : at + EACH], number)


def _frame(bus: Bus, data: bytes, counter: int) -> Frame:
    number, wanted, body = data[0], data[1:2] == b"\x00", data[2:]
    if number >= NO_FRAME_OF_OURS:
        return Frame(number * 8, body)
    layout = bus.known[number % len(bus.known)]
    if not wanted or len(body) < layout.size:
        return Frame(layout.arbitration_id, body)
    return Frame(layout.arbitration_id, bus.good(layout, body[: layout.size], counter))


def _layouts(data: bytes) -> None:
    """What is let in, and packed again, is let in as the same."""
    if len(data) < EACH:
        return
    layout = OURS.known[data[0] % len(OURS.known)]
    values = layout.unpack(data[2 : 2 + layout.size])
    if values is None:
        return
    must_be_finite(values, layout.name)
    again = layout.unpack(layout.pack(values, 0).data)
    if again is None or any(abs(a - b) > 1e-9 for a, b in zip(values, again, strict=True)):
        raise Broken(f"{layout.name}: {values} became {again}")


def _toyota() -> Iterator[Target]:
    codec = toyota_codec("", _vehicle("example_toyota.toml"))
    names = [layout.name for layout in TOYOTA.known]
    frames = [bytes((names.index(name), 0)) + _packed(name, values) for name, values in TOYOTA_DRIVES]
    seeds = (b"".join(frames), *frames)
    yield Target("CAN Toyota", _frames(TOYOTA, codec.start, codec.decode, check=_belongs_together), seeds, SHARE)
    yield Target("CAN Toyota layouts", _toyota_layouts, seeds, SHARE)
    must_drive(codec, seeds[0])


def _packed(name: str, values: dict[str, float]) -> bytes:
    return toyota_layouts()[name].pack(values).data.ljust(EACH - 2, b"\x00")


def must_drive(codec: ToyotaCodec, seed: bytes) -> None:
    """Raises Broken when the seed is no feedback: then nothing behind it would be fuzzed."""
    state = codec.start()
    for frame in frames_of(TOYOTA, seed):
        state, _ = codec.decode(state, frame)
    if state.feedback is None:
        raise Broken("the Toyota's seed gives no feedback")


def _belongs_together(state: ToyotaState) -> None:
    """Where there is a feedback, no tyre would have to hold more than the codec says."""
    told = state.feedback
    if told is not None and abs(told.speed_m_s * told.yaw_rate_rad_s) > LATERAL_MAX_M_S2:
        raise Broken(f"{told.speed_m_s} m/s and {told.yaw_rate_rad_s} rad/s were believed together")


def _toyota_layouts(data: bytes) -> None:
    """What is received, and packed again, is received as the same."""
    for frame in frames_of(TOYOTA, data):
        layout = next((each for each in TOYOTA.known if each.arbitration_id == frame.arbitration_id), None)
        values, reason = layout.receive(frame) if layout is not None else ({}, "")
        if layout is None or reason:
            continue
        must_be_finite(values, layout.name)
        again, reason = layout.receive(layout.pack(values))
        if reason or any(abs(values[name] - again[name]) > 1e-9 for name in values):
            raise Broken(f"{layout.name}: {values} became {again}")
