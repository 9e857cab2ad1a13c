"""What the cameras gave up, from what the car said of them."""

from recordings.drive import CameraRow
from recordings.summary_cameras import giving
from wire.messages.sensing import CameraStatus

S = 1_000_000_000


def row(
    at_s: float, camera: str = "left", rate_hz: float = 13.5, skipped: int = 0, wanted: bool = True, halved: bool = False
) -> CameraRow:
    status = CameraStatus(
        stamp_ns=1,
        camera=camera,
        source="simulated",
        live=True,
        newest_capture_ns=1,
        frames=1,
        repeated=0,
        bitrate_kbps=100.0,
        encode_ms=1.0,
        watching=1,
        wanted=wanted,
        skipped=skipped,
        nominal_hz=13.5,
        rate_hz=rate_hz,
        halved=halved,
    )
    return CameraRow(round(at_s * S), status)


def test_the_time_at_a_lower_rate_is_summed_and_a_silence_is_not() -> None:
    rows = [row(0.0), row(0.5, rate_hz=9.0), row(1.0, rate_hz=4.5, halved=True), row(1.25), row(2.0, rate_hz=9.0), row(9.0)]
    left = giving(rows)["left"]
    assert left.reduced_s == 0.75
    assert left.halved_s == 0.25
    assert left.lowest_hz == 4.5


def test_skipped_pictures_of_a_restarted_process_are_added_up() -> None:
    assert giving([row(0.0, skipped=3), row(0.2, skipped=5), row(0.4, skipped=1)])["left"].skipped == 6


def test_each_camera_has_its_own_and_one_that_rests_says_so() -> None:
    found = giving([row(0.0), row(0.0, "rear", wanted=False), row(0.2), row(0.2, "rear")])
    assert not found["left"].rests
    assert found["rear"].rests
    assert found["left"].reduced_s == 0.0


def test_a_recording_from_before_they_told_it_has_no_rate() -> None:
    old = CameraStatus(
        stamp_ns=1,
        camera="front",
        source="simulated",
        live=True,
        newest_capture_ns=1,
        frames=1,
        repeated=0,
        bitrate_kbps=1.0,
        encode_ms=1.0,
        watching=1,
    )
    assert giving([CameraRow(1, old), CameraRow(2, old)])["front"].lowest_hz is None
    assert giving([CameraRow(1, old), CameraRow(2, old)])["front"].reduced_s == 0.0
