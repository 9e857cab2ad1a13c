"""What is fuzzed: every decoder, with the errors it documents, what must hold of what it lets in, and real seeds.

Each target takes bytes. It raises for nothing but a broken rule: `Broken` names it. Never opens a link, never writes but to the
folder it is given.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
from msgspec import inspect

from benchmarks.examples import encode_example, example
from benchmarks.proof.can_targets import can_targets
from benchmarks.proof.rules import Broken, Target, must_be_finite
from benchmarks.proof.signed_targets import signed_targets
from recordings.errors import RecordingError
from recordings.provenance import Provenance
from recordings.read import open_recording
from recordings.recover import examine
from recordings.writer import DriveWriter
from vehicle_gateway.memory import EPOCH_BLOCK, Remembered, recall
from wire.bundle import read as read_bundle
from wire.certificates import CertificateError
from wire.configuration import ConfigurationError, shipped
from wire.messages.base import UNDECODABLE, Message, decoder, encode
from wire.picture import EncodedPicture, pack_picture, unpack_picture
from wire.scenario import read_map, read_scenario
from wire.stamp import Stamp, read_stamp, stamp_payload
from wire.topics import QUERIES, TOPICS


def targets(folder: Path) -> tuple[Target, ...]:
    """folder  for what is read from files"""
    return (*_messages(), *_bytes(), *can_targets(), *signed_targets(folder), *_files(folder))


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


def _files(folder: Path) -> Iterator[Target]:
    drive = recording(folder / "seed.mcap")
    scenario, road = shipped("scenarios", "closed_road.toml"), shipped("maps", "bend.toml")
    yield Target("scenario", _file(folder / "a.toml", _read_scenario, ConfigurationError), (scenario.read_bytes(),), 1)
    yield Target("map", _file(folder / "b.toml", read_map, ConfigurationError), (road.read_bytes(),), 1)
    yield Target("bundle", _file(folder / "c.bundle", read_bundle, CertificateError), (b"{}", BUNDLE), 1)
    yield Target("recording", _file(folder / "d.mcap", _read_recording, RecordingError), (drive,), 1)
    remembered = Remembered(epoch_reserved=EPOCH_BLOCK, stop_latched=True, stops_utc_ns=(1, 2), barred_utc_ns={"ann": 3})
    yield Target("memory", _memory(folder / "f.json"), (encode(remembered), encode(Remembered())), 1)
    yield Target("recover", _file(folder / "e.mcap", examine, RecordingError), (drive,), 1)


BUNDLE = b'{"vehicle_id":"car-1","authority":"x","roles":{"vehicle-hub":{"key":"k","certificate":"c"}},"digest":"0"}'


def _memory(place: Path) -> Callable[[bytes], None]:
    """What is damaged stays as it is; what is let in comes back at the next start, with the next block of epochs."""

    def try_one(data: bytes) -> None:
        place.write_bytes(data)
        try:
            known = recall(place)
        except ConfigurationError:
            if place.read_bytes() != data:
                raise Broken("a damaged memory was overwritten") from None
            return
        must_be_finite(known, "memory")
        if recall(place) != msgspec.structs.replace(known, epoch_reserved=known.epoch_reserved + EPOCH_BLOCK):
            raise Broken(f"{known} was forgotten")

    return try_one


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
