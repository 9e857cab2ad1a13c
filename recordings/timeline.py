"""When a recording is played: where it starts, and how the tower's clock of the replay is set. Pure but for reading.

Nothing recorded is changed, not even a stamp inside a picture. Instead the clock of the watching window is shifted by one
constant, so that it shows what the tower's clock showed then; a car's stamp and the recorded offset between the two clocks
then give the age that the operator saw. Ages are therefore true at the speed of the drive only.
"""

from dataclasses import dataclass

from recordings.compressed_video import has_idr
from recordings.errors import RecordingError
from recordings.read import Recording
from recordings.writer import VIDEO
from wire.messages.vehicle import VehicleDescription
from wire.picture import unpack_picture

IDR_WITHIN_NS = 10_000_000_000  # the longest interval that [vehicle_gateway.video] idr_interval_s allows


@dataclass(frozen=True, slots=True, kw_only=True)
class Timeline:
    start_ns: int  # log_time at which playing starts
    end_ns: int  # log_time of the last message
    utc_minus_vehicle_ns: int  # Unix time = the car's clock + this
    vehicle_minus_tower_ns: int  # the car's clock = the tower's + this, as the tower measured it first
    vehicle: VehicleDescription  # as it described itself
    first_pictures: dict[str, bytes]  # per camera: an IDR at the start, as the `video` topic carries it

    def tower_ns(self, log_ns: int) -> int:
        """What the tower's clock showed at a log_time."""
        return log_ns - self.utc_minus_vehicle_ns - self.vehicle_minus_tower_ns


def timeline(recording: Recording, from_s: float) -> Timeline:
    """Playing from `from_s` into the drive, or from the last IDR before it. Raises RecordingError."""
    span = recording.span_ns
    if span is None:
        raise RecordingError(f"{recording.path}: holds no messages; nothing can be played")
    wanted_ns = span[0] + round(from_s * 1e9)
    if wanted_ns > span[1]:
        raise RecordingError(
            f"--from {from_s:g}: the recording ends after {(span[1] - span[0]) / 1e9:.1f} s; name an earlier second"
        )
    pictures = _idrs_before(recording, wanted_ns)
    start_ns = min((log_ns for log_ns, _ in pictures.values()), default=wanted_ns) if from_s > 0 else span[0]
    return Timeline(
        start_ns=start_ns,
        end_ns=span[1],
        utc_minus_vehicle_ns=int(recording.metadata.get("clock", {}).get("utc_minus_vehicle_ns", 0)),
        vehicle_minus_tower_ns=_vehicle_minus_tower_ns(recording),
        vehicle=_vehicle(recording),
        first_pictures={camera: payload for camera, (_, payload) in pictures.items()},
    )


def _idrs_before(recording: Recording, wanted_ns: int) -> dict[str, tuple[int, bytes]]:
    """The last IDR of each camera up to a moment; the first after it where there is none."""
    found: dict[str, tuple[int, bytes]] = {}
    for topic, log_ns, payload in recording.payloads(max(wanted_ns - IDR_WITHIN_NS, 0)):
        if log_ns > wanted_ns and (len(found) == len(recording.cameras) or log_ns > wanted_ns + IDR_WITHIN_NS):
            break
        if topic != VIDEO:
            continue
        picture = unpack_picture(payload)
        if has_idr(picture.annex_b) and (log_ns <= wanted_ns or picture.camera not in found):
            found[picture.camera] = (log_ns, payload)
    return found


def _vehicle_minus_tower_ns(recording: Recording) -> int:
    """As the tower measured it first; without a tower its clock is taken to be the car's."""
    offsets = (status.clock_offset_ns for _, status in recording.messages("operator_status") if status.clock_bound_ns > 0)
    return next(offsets, 0)


def _vehicle(recording: Recording) -> VehicleDescription:
    """The car as it described itself. Raises RecordingError when it never did."""
    for _, description in recording.messages("vehicle_description"):
        return description  # type: ignore[no-any-return]
    raise RecordingError(f"{recording.path}: the car never described itself in it; play a drive of at least a second")
