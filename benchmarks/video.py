"""Video: capture to decoded picture, our chain beside stock aiortc VP8, the cameras of the configuration, one run.

Sender and receiver are two processes on one machine and one clock. Ours: vehicle_gateway.video.sender and
tower.video.receiver as the programs run them, the stamp inside the picture. The peer: benchmarks.stock_vp8. Latency is from
the frame in the camera thread's hand to the decoded frame in the other process's hand; both convert each picture that is
shown. Pictures: a moving texture. A pipe carries offer and answer. Not measured: camera, renderer, screen, network.
"""

import multiprocessing
import threading
from collections.abc import Callable, Iterator
from itertools import chain
from multiprocessing.connection import Connection

import cv2

from benchmarks import stock_vp8
from benchmarks.figures import Figure, figure, percentile
from benchmarks.pictures import WARM_UP_S, Cameras, Measured, Meter, PipeLink, SceneSource, three_cameras
from tower.video.receiver import VideoReceiver
from vehicle_gateway.video.sender import video_sender
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription

NAME = "video"
DURATION_S = 8.0  # of each chain and case
DISPLAY_S = 1 / 60  # the window's display rate
REACH_RATIO = 0.2  # p50 at least five times below the peer's
PEER = "stock aiortc VP8"
CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
Send = Callable[[Connection, Cameras], None]
Receive = Callable[[Connection, Cameras, float], Measured]


def figures() -> Iterator[Figure]:
    """The front camera alone, and all cameras that are sent while the car drives forward."""
    all_cameras = three_cameras(CAR)
    for cameras in dict.fromkeys((all_cameras[:1], all_cameras)):
        yield from compare(cameras)


def compare(cameras: Cameras) -> Iterator[Figure]:
    case = " + ".join(f"{camera.name} {camera.width_px}x{camera.height_px}@{camera.frame_rate_hz:g}" for camera in cameras)
    ours = measure(send, receive, cameras)
    peer = measure(stock_vp8.send, stock_vp8.receive, cameras)
    for what, share in (("p50", 0.50), ("p99", 0.99)):
        beside = (PEER, percentile(pooled(peer), share))
        reach = REACH_RATIO if what == "p50" else None
        yield figure(NAME, case, f"latency {what}", "ms", percentile(pooled(ours), share), peer=beside, ratio_at_most=reach)
    yield figure(NAME, case, "pictures", "1/s", len(pooled(ours)) / ours.spent_s, peer=(PEER, len(pooled(peer)) / peer.spent_s))
    yield figure(NAME, case, "sender's share of a core", "", ours.sender_cpu, peer=(PEER, peer.sender_cpu))
    yield figure(NAME, case, "receiver's share of a core", "", ours.receiver_cpu, peer=(PEER, peer.receiver_cpu))


def pooled(measured: Measured) -> list[float]:
    """Of all cameras together."""
    return list(chain.from_iterable(measured.latencies_ms.values()))


def measure(sending: Send, receiving: Receive, cameras: Cameras) -> Measured:
    context = multiprocessing.get_context("spawn")
    car, tower = context.Pipe()
    result_out, result_in = context.Pipe()
    sender = context.Process(target=sending, args=(car, cameras))
    receiver = context.Process(target=_receive_and_tell, args=(receiving, tower, cameras, result_in))
    sender.start()
    receiver.start()
    measured: Measured = result_out.recv()
    receiver.join()
    sender.join()
    return measured


def _receive_and_tell(receiving: Receive, pipe: Connection, cameras: Cameras, out: Connection) -> None:
    out.send(receiving(pipe, cameras, DURATION_S))


def send(pipe: Connection, cameras: Cameras) -> None:
    cv2.setNumThreads(1)
    link = PipeLink(pipe)
    sources = {camera.name: SceneSource(camera) for camera in cameras}
    with video_sender(link, cameras, sources, VideoSettings(), Clock()):
        link.answer_until_told_the_end()


def receive(pipe: Connection, cameras: Cameras, duration_s: float) -> Measured:
    clock, pause = Clock(), threading.Event()
    names = tuple(camera.name for camera in cameras)
    latencies_ms: dict[str, dict[int, float]] = {name: {} for name in names}
    with VideoReceiver(PipeLink(pipe), clock, names) as video:
        pause.wait(WARM_UP_S)
        meter = Meter(pipe, clock)
        while clock.now_ns() - meter.start_ns < duration_s * 1e9:
            for name, found in latencies_ms.items():
                frame = video.newest(name)
                if frame is not None and frame.sequence not in found:
                    found[frame.sequence] = (frame.decoded_ns - frame.capture_ns) / 1e6
                    frame.image  # noqa: B018 - converted, as the window does
            pause.wait(DISPLAY_S)
        result = Measured({name: list(found.values())[1:] for name, found in latencies_ms.items()}, *meter.read())
    pipe.send("end")
    return result
