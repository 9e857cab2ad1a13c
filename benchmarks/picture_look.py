"""CPU of one look at a picture: has it moved as the car does (vehicle_gateway.video.picture_motion)? Beside one picture's digest.

Pictures of noise at the size of the shipped front camera; what is in them does not matter to the time. Five looks a second, while
the car moves; the floor is what every picture costs already to tell a new one from a repeated one.
"""

import zlib
from collections.abc import Callable, Iterator
from time import process_time_ns

import cv2
import numpy as np

from benchmarks.cycle import CAR
from benchmarks.figures import Figure, figure, percentile
from vehicle_gateway.video.picture import Bytes
from vehicle_gateway.video.picture_motion import LOOK_NS, PictureMotion, cells, judge

NAME = "picture_look"
LOOKS = 400
REACH_MS = 0.3  # ours, for a picture: 27 of them a second then take less than a hundredth of a core
DIGEST_ROWS = 16  # as in vehicle_gateway.video.camera
SPEED_M_S = 4.0


def figures() -> Iterator[Figure]:
    cv2.setNumThreads(1)  # as in the program
    camera = next(camera for camera in CAR.cameras if camera.required)
    draw = np.random.default_rng(1)
    pictures = [draw.integers(16, 235, (camera.height_px, camera.width_px), np.uint8) for _ in range(2)]
    state = judge(PictureMotion(), cells(pictures[0]), SPEED_M_S, LOOK_NS)

    def look(picture: Bytes) -> None:
        judge(state, cells(picture), SPEED_M_S, 2 * LOOK_NS)

    looks, digests = timed(look, pictures), timed(lambda picture: zlib.crc32(picture[::DIGEST_ROWS].tobytes()), pictures)
    size = f"{camera.width_px} x {camera.height_px}"
    for what, share in (("p50", 0.5), ("p99", 0.99)):
        beside = ("digest of a picture", percentile(digests, share))
        yield figure(NAME, size, f"a look, {what}", "ms", percentile(looks, share), peer=beside)
    share_of_looks = 1e9 / LOOK_NS / camera.frame_rate_hz
    yield figure(NAME, size, "a picture, mean", "ms", sum(looks) / len(looks) * share_of_looks, at_most=REACH_MS)


def timed(work: Callable[[Bytes], object], pictures: list[Bytes]) -> list[float]:
    """Milliseconds of CPU, each time."""
    took = []
    for number in range(LOOKS):
        began_ns = process_time_ns()
        work(pictures[number % 2])
        took.append((process_time_ns() - began_ns) / 1e6)
    return took
