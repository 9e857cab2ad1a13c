"""One drive as an MCAP file: every payload as it came, one channel per topic, one video channel per camera; and for a 3D panel
what the planner among people weighed, drawn.

A payload that does not decode as its topic's type is kept apart: as base64 in the channel "undecodable", and counted,
so that a reader may rely on every other channel. Never overwrites a file; never waits for the disk to sync (a killed
process loses nothing that was flushed; a machine without power may). Not safe between threads: one thread writes.
Source of the format: mcap.dev/spec; of the flush: reference measurements of killed recorders.
"""

import base64
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from mcap.writer import CompressionType, Writer

from recordings import compressed_video, planner_scene
from recordings.errors import RecordingError
from recordings.provenance import Provenance
from recordings.schemas import json_schema
from recordings.stamps import Clocks, publish_time_ns, stamp_field
from wire.messages import base
from wire.messages.automation import PlannerView
from wire.messages.base import Message, Text, TimeNs, decoder, encode
from wire.messages.operating import OperatorStatus
from wire.picture import unpack_picture
from wire.scene_schema import SCHEMA, SCHEMA_NAME
from wire.software import PACKAGE
from wire.topics import TOPICS

UNDECODABLE = "undecodable"
VIDEO = "video"
_CHUNK_BYTES = 1 << 20  # a chunk ends here at the latest; the flush usually ends it earlier


class Undecodable(Message):
    """A payload that is not a message of its topic, as it came."""

    stamp_ns: TimeNs  # vehicle clock, when it arrived
    topic: Text
    error: Text
    payload_base64: str


@dataclass(frozen=True, slots=True)
class _Channel:
    number: int
    decode: Any
    stamp: str | None
    from_car: bool


class DriveWriter:
    """Writes one drive to `stream`; `close` completes the file. Every method may raise OSError (a full disk)."""

    def __init__(self, stream: IO[bytes], provenance: Provenance) -> None:
        self._stream = stream
        self._clocks = Clocks(utc_minus_vehicle_ns=provenance.utc_minus_vehicle_ns)
        self._channels: dict[str, _Channel] = {}
        self._cameras: dict[str, int] = {}
        self._video_schema = 0
        self._scenes = 0  # channel
        self.added: Counter[str] = Counter()  # messages by topic
        self.undecodable: Counter[str] = Counter()  # of them, kept apart, by topic
        self._mcap: Any = Writer(stream, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._mcap.start(profile="", library=PACKAGE)
        self._write_provenance(provenance)
        self.flush()

    def add(self, topic: str, payload: bytes, received_ns: int) -> None:
        """One message as it arrived at `received_ns` (vehicle clock)."""
        self.added[topic] += 1
        try:
            if topic == VIDEO:
                self._add_picture(payload, received_ns)
            else:
                self._add_message(topic, payload, received_ns)
        except (*base.UNDECODABLE, ValueError) as error:
            self._keep_apart(topic, payload, received_ns, str(error))

    def flush(self) -> None:
        """Complete what was added so far: it survives the death of this process."""
        self._mcap.flush()

    def close(self) -> None:
        """Write the index and close the file."""
        self._mcap.finish()
        self._stream.close()

    def _add_message(self, topic: str, payload: bytes, received_ns: int) -> None:
        channel = self._channels.get(topic) or self._open_channel(topic)
        message = channel.decode(payload)
        if isinstance(message, OperatorStatus) and message.clock_bound_ns > 0:
            self._clocks = Clocks(utc_minus_vehicle_ns=self._clocks.utc_minus_vehicle_ns, tower_offset_ns=message.clock_offset_ns)
        stamp_ns = getattr(message, channel.stamp) if channel.stamp else None
        log_ns = received_ns + self._clocks.utc_minus_vehicle_ns
        publish_ns = publish_time_ns(stamp_ns, log_ns, channel.from_car, self._clocks)
        self._mcap.add_message(channel.number, log_ns, payload, publish_ns)
        if isinstance(message, PlannerView):
            self._add_scene(message, log_ns, publish_ns)

    def _add_scene(self, view: PlannerView, log_ns: int, publish_ns: int) -> None:
        self._scenes = self._scenes or self._mcap.register_channel(
            planner_scene.TOPIC, "protobuf", self._mcap.register_schema(SCHEMA_NAME, "protobuf", SCHEMA)
        )
        self._mcap.add_message(self._scenes, log_ns, planner_scene.encode_scene(view, publish_ns), publish_ns)

    def _add_picture(self, payload: bytes, received_ns: int) -> None:
        picture = unpack_picture(payload)
        offset_ns = self._clocks.utc_minus_vehicle_ns
        number = self._cameras.get(picture.camera) or self._open_camera(picture.camera)
        self._mcap.add_message(
            number,
            received_ns + offset_ns,
            compressed_video.encode_video(picture, offset_ns),
            picture.capture_ns + offset_ns,
            picture.sequence,
        )

    def _keep_apart(self, topic: str, payload: bytes, received_ns: int, error: str) -> None:
        self.undecodable[topic] += 1
        channel = self._channels.get(UNDECODABLE) or self._register(UNDECODABLE, Undecodable, True)
        log_ns = received_ns + self._clocks.utc_minus_vehicle_ns
        event = Undecodable(
            stamp_ns=received_ns, topic=topic, error=error[:2000], payload_base64=base64.b64encode(payload).decode("ascii")
        )
        self._mcap.add_message(channel.number, log_ns, encode(event), log_ns)

    def _open_channel(self, name: str) -> _Channel:
        topic = TOPICS[name]
        if topic.type is None:
            raise ValueError(f"{name} carries no messages")
        return self._register(name, topic.type, topic.origin_is_car)

    def _register(self, name: str, message_type: type[Message], from_car: bool) -> _Channel:
        schema = self._mcap.register_schema(message_type.__name__, "jsonschema", json_schema(message_type))
        number = self._mcap.register_channel(name, "json", schema, {})
        channel = _Channel(number, decoder(message_type).decode, stamp_field(message_type), from_car)
        self._channels[name] = channel
        return channel

    def _open_camera(self, camera: str) -> int:
        self._video_schema = self._video_schema or self._mcap.register_schema(
            compressed_video.SCHEMA_NAME, "protobuf", compressed_video.SCHEMA
        )
        number: int = self._mcap.register_channel(
            f"{VIDEO}/{camera}", "protobuf", self._video_schema, {"utc_minus_vehicle_ns": str(self._clocks.utc_minus_vehicle_ns)}
        )
        self._cameras[camera] = number
        return number

    def _write_provenance(self, provenance: Provenance) -> None:
        self._mcap.add_metadata("drive", {"vehicle_id": provenance.vehicle_id, **provenance.notes})
        self._mcap.add_metadata("versions", provenance.versions)
        self._mcap.add_metadata(
            "clock",
            {
                "utc_minus_vehicle_ns": str(provenance.utc_minus_vehicle_ns),
                "log_time": "vehicle clock at arrival + utc_minus_vehicle_ns",
                "publish_time": "the sender's stamp on the same scale; a tower's through operator_status.clock_offset_ns",
            },
        )
        for attached in provenance.attached:
            self._mcap.add_attachment(0, 0, attached.name, attached.media_type, attached.data)


def open_drive_file(folder: Path) -> tuple[Path, IO[bytes]]:
    """A new file drive.mcap in `folder` (drive-2.mcap, drive-3.mcap ... when there is one). Raises RecordingError."""
    number = 1
    while True:
        path = folder / ("drive.mcap" if number == 1 else f"drive-{number}.mcap")
        try:
            return path, path.open("xb")
        except FileExistsError:
            number += 1
        except OSError as error:
            raise unusable(folder, error) from None


def unusable(folder: Path, error: OSError) -> RecordingError:
    return RecordingError(
        f"{folder}: cannot write a recording there: {error.strerror}; "
        f"choose another folder with [wire.session] folder, or free some space"
    )
