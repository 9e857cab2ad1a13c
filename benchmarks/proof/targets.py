"""What is fuzzed: every decoder, with the errors it documents, what must hold of what it lets in, and real seeds.

Each target takes bytes. It raises for nothing but a broken rule: `Broken` names it. Never opens a link, never writes but to the
folder it is given.
"""

from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
from msgspec import inspect

from benchmarks.examples import encode_example, example
from recordings.errors import RecordingError
from recordings.provenance import Provenance
from recordings.read import open_recording
from recordings.recover import examine
from recordings.writer import DriveWriter
from vehicle_gateway.can.actuator_codec import DemandState, PlantState, decode_demand, decode_plant
from vehicle_gateway.can.e2e import COUNTER_MODULUS, protect
from vehicle_gateway.can.ecu_codec import CommandState, decode_command
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import HealthState
from vehicle_gateway.can.layout import Layout, layouts
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.vehicles import car_bus_of
from wire.bundle import read as read_bundle
from wire.certificates import CertificateError
from wire.configuration import ConfigurationError, read_sections, shipped
from wire.messages.base import UNDECODABLE, Message, decoder, encode
from wire.messages.vehicle import VehicleDescription
from wire.picture import EncodedPicture, pack_picture, unpack_picture
from wire.scenario import read_map, read_scenario
from wire.stamp import Stamp, read_stamp, stamp_payload
from wire.topics import QUERIES, TOPICS

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]


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


def targets(folder: Path) -> tuple[Target, ...]:
    """folder  for what is read from files"""
    return (*_messages(), *_bytes(), *_can(), *_files(folder))


def _messages() -> Iterator[Target]:
    types = {topic.type for topic in TOPICS.values() if topic.type is not None}
    types |= {kind for query in QUERIES.values() for kind in (query.request, query.reply)}
    for message_type in sorted(types, key=lambda kind: kind.__name__):
        seed = msgspec.json.encode(example(inspect.type_info(message_type)))
        yield Target(f"message {message_type.__name__}", _message(message_type), (seed,))


def _message(message_type: type[Message]) -> Callable[[bytes], None]:
    known = decoder(message_type)

    def try_one(data: bytes) -> None:
        try:
            message = known.decode(data)
        except UNDECODABLE:
            return
        must_be_finite(message, message_type.__name__)
        if known.decode(encode(message)) != message:
            raise Broken(f"{message_type.__name__}: not the same after encoding and decoding")

    return try_one


def _bytes() -> Iterator[Target]:
    whole = pack_picture(EncodedPicture(camera="front", capture_ns=1, sequence=1, is_idr=True, annex_b=b"\x00\x00\x00\x01\x65"))
    yield Target("picture", _picture, (whole,))
    yield Target("stamp", _stamp, (stamp_payload(Stamp(123, 4)),))


def _picture(data: bytes) -> None:
    try:
        picture = unpack_picture(data)
    except ValueError:
        return
    if unpack_picture(pack_picture(picture)) != picture:
        raise Broken("picture: not the same after packing and unpacking")


def _stamp(data: bytes) -> None:
    stamp = read_stamp([data, data[1:]])
    if stamp is not None and read_stamp([stamp_payload(stamp)]) != stamp:
        raise Broken("stamp: not the same after writing and reading")


def _can() -> Iterator[Target]:
    car = car_bus_of(CanSettings(), CAR)
    codec, health = car.codec, car.health
    known = tuple(layouts().values())
    seeds = tuple(
        bytes((number, 0)) + layout.pack([field.low for field in layout.fields], 0).data for number, layout in enumerate(known)
    )
    ends: tuple[tuple[str, Callable[[], Any], Callable[[Any, Frame], tuple[Any, str]]], ...] = (
        ("CAN gateway", codec.start, codec.decode),
        ("CAN ECU command", CommandState, decode_command),
        ("CAN demand", DemandState, decode_demand),
        ("CAN plant", PlantState, decode_plant),
    )
    for name, start, decode in ends:
        yield Target(name, _frames(known, start, decode), seeds, 40)
    if health is not None:
        yield Target("CAN health", _frames(known, HealthState, health.decode, health.speaks), seeds, 40)
    yield Target("CAN layouts", _layouts(known), seeds, 40)


def _frames(
    known: tuple[Layout, ...],
    start: Callable[[], Any],
    decode: Callable[[Any, Frame], tuple[Any, str]],
    speaks: Callable[[Frame], bool] = lambda _: True,
) -> Callable[[bytes], None]:
    """Frames one after the other: the first byte chooses the identifier, the second whether its protection is made good."""

    def try_one(data: bytes) -> None:
        state = start()
        for at in range(0, min(len(data), 100), 10):
            frame = _frame(known, data[at : at + 10], at // 10)
            if speaks(frame):
                state, reason = decode(state, frame)
                if not isinstance(reason, str):
                    raise Broken(f"a frame was dropped for {reason!r}")
        must_be_finite(state, "state")

    return try_one


def _frame(known: tuple[Layout, ...], data: bytes, counter: int) -> Frame:
    number, protected, body = data[0], data[1:2] == b"\x00", data[2:]
    layout = known[number % len(known)]
    if number >= 240 or len(body) != layout.size or not protected:
        return Frame(layout.arbitration_id if number < 240 else number * 8, body)
    return _protected(layout, body, counter)


def _protected(layout: Layout, body: bytes, counter: int) -> Frame:
    return Frame(layout.arbitration_id, protect(layout.data_id, bytes((body[1] & 0xF0 | counter % COUNTER_MODULUS,)) + body[2:]))


def _layouts(known: tuple[Layout, ...]) -> Callable[[bytes], None]:
    """What is let in, and packed again, is let in as the same."""

    def try_one(data: bytes) -> None:
        if len(data) < 10:
            return
        layout = known[data[0] % len(known)]
        values = layout.unpack(data[2 : 2 + layout.size])
        if values is None:
            return
        must_be_finite(values, layout.name)
        again = layout.unpack(layout.pack(values, 0).data)
        if again is None or any(abs(a - b) > 1e-9 for a, b in zip(values, again, strict=True)):
            raise Broken(f"{layout.name}: {values} became {again}")

    return try_one


def _files(folder: Path) -> Iterator[Target]:
    drive = recording(folder / "seed.mcap")
    scenario, road = shipped("scenarios", "closed_road.toml"), shipped("maps", "bend.toml")
    yield Target("scenario", _file(folder / "a.toml", _read_scenario, ConfigurationError), (scenario.read_bytes(),), 1)
    yield Target("map", _file(folder / "b.toml", read_map, ConfigurationError), (road.read_bytes(),), 1)
    yield Target("bundle", _file(folder / "c.bundle", read_bundle, CertificateError), (b"{}", BUNDLE), 1)
    yield Target("recording", _file(folder / "d.mcap", _read_recording, RecordingError), (drive,), 1)
    yield Target("recover", _file(folder / "e.mcap", examine, RecordingError), (drive,), 1)


BUNDLE = b'{"vehicle_id":"car-1","authority":"x","roles":{"vehicle-hub":{"key":"k","certificate":"c"}},"digest":"0"}'


def _read_scenario(file: Path) -> Any:
    return read_scenario(file)[0]


def _read_recording(file: Path) -> None:
    with open_recording(file) as drive:
        for topic, _, payload in drive.payloads():
            if not isinstance(payload, bytes):
                raise Broken(f"{topic}: a payload that is no bytes")


def _file(place: Path, read: Callable[[Path], Any], documented: type[Exception]) -> Callable[[bytes], None]:
    def try_one(data: bytes) -> None:
        place.write_bytes(data)
        place.chmod(0o600)
        try:
            value = read(place)
        except documented:
            return
        must_be_finite(value, place.suffix)

    return try_one


def recording(file: Path) -> bytes:
    """A small real one, made by the writer itself."""
    writer = DriveWriter(
        file.open("wb"), Provenance(vehicle_id="car-1", utc_minus_vehicle_ns=0, versions={}, notes={}, attached=())
    )
    for name in ("drive_command", "vehicle_state", "imu"):
        for at_ns in range(1, 4):
            writer.add(name, encode_example(name), at_ns * 1_000_000)
    writer.close()
    return file.read_bytes()
