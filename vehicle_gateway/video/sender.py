"""All cameras of a car at work: their threads, the WebRTC session, the recorder's topic, status and health.

Sources, link and clock are given: the program (vehicle_gateway.video.video), the tests and the benchmark all run this.
"""

import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from functools import partial
from typing import Any, Protocol

from vehicle_gateway.video.camera import CameraLoop
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.picture import Source
from vehicle_gateway.video.session import VideoSessions
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.ice import DIRECT, Ways
from wire.loop_thread import loop_in_thread
from wire.messages.base import Message
from wire.messages.vehicle import CameraCalibration
from wire.pace import Pace
from wire.picture import EncodedPicture, pack_picture
from wire.topics import PROGRAMS, Role

PROCESS = PROGRAMS[Role.VIDEO]
_STATUS_PERIOD_S = 0.2
_HEALTH_EVERY = 5  # statuses


class SenderLink(Protocol):
    """What the sender needs of wire.link.Link."""

    def publish(self, name: str, message: Message | bytes) -> None: ...

    def serve(self, name: str, handler: Callable[[Any], Message]) -> None: ...


class VideoSender:
    """Running cameras. `sessions` serves the watcher."""

    def __init__(
        self, link: SenderLink, loops: list[CameraLoop], sessions: VideoSessions, clock: Clock, workers: list["Future[None]"]
    ) -> None:
        self.sessions = sessions
        self._link, self._loops, self._clock, self._workers = link, loops, clock, workers

    def report(self, stop: threading.Event) -> None:
        """Publish status and health until `stop`. Raises what a camera's thread raised: the program then ends."""
        with Pace(_STATUS_PERIOD_S, self._clock, stop) as pace:
            for number, now_ns in enumerate(pace):
                self._raise_what_failed()
                for loop in self._loops:
                    self._link.publish("camera_status", loop.status(now_ns, self.sessions.watching))
                if number % _HEALTH_EVERY == 0:
                    self._publish_health(pace, now_ns)

    def _publish_health(self, pace: Pace, now_ns: int) -> None:
        dropped = {"pictures not sent": self.sessions.dropped} if self.sessions.dropped else {}
        self._link.publish("car_health", pace.health(PROCESS, "status", dropped))
        for loop in self._loops:
            self._link.publish("car_health", loop.health(PROCESS, now_ns))

    def _raise_what_failed(self) -> None:
        for worker in self._workers:
            if worker.done():
                worker.result()


@contextmanager
def video_sender(
    link: SenderLink,
    calibrations: tuple[CameraCalibration, ...],
    sources: Mapping[str, Source],
    settings: VideoSettings,
    clock: Clock,
    ways: Ways = DIRECT,
) -> Iterator[VideoSender]:
    """Start everything; leaving the context stops the threads and closes the session and the sources."""
    halt = threading.Event()
    with ExitStack() as stack:
        for source in sources.values():
            stack.enter_context(source)
        encoders = {calibration.name: Encoder(calibration, settings) for calibration in calibrations}
        loop = stack.enter_context(loop_in_thread("video-session"))
        sessions = VideoSessions(loop, encoders, ways)
        stack.callback(sessions.close)
        link.serve("video_session", sessions.answer)
        deliver = partial(_deliver, link, sessions)
        cameras = [
            CameraLoop(calibration, sources[calibration.name], encoders[calibration.name], clock, deliver)
            for calibration in calibrations
        ]
        pool = stack.enter_context(ThreadPoolExecutor(max(len(cameras), 1), thread_name_prefix="camera"))
        stack.callback(halt.set)
        yield VideoSender(link, cameras, sessions, clock, [pool.submit(camera.run, halt) for camera in cameras])


def _deliver(link: SenderLink, sessions: VideoSessions, picture: EncodedPicture, ready_ns: int) -> None:
    """To the watcher first, who waits for it; then to the recorder."""
    sessions.show(picture, ready_ns)
    link.publish("video", pack_picture(picture))
