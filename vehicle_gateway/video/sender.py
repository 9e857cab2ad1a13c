"""All cameras of a car at work: their threads, the WebRTC sessions, the recorder's topic, status and health.

Sources, link and clock are given: the program (vehicle_gateway.video.video), the tests and the benchmark all run this.
"""

import logging
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from typing import Any, Protocol

from vehicle_gateway.video.camera import CameraLoop
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.load import (
    ALONE,
    LADDER,
    STARVED_NS,
    ControlLoops,
    Load,
    after_a_second,
    allowance,
    hear,
    others_may_give,
)
from vehicle_gateway.video.picture import Source
from vehicle_gateway.video.session import VideoSessions
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.ice import DIRECT, Ways
from wire.loop_thread import loop_in_thread
from wire.messages.base import Message
from wire.messages.health import LoopHealth
from wire.messages.vehicle import CameraCalibration, GatewayStatus, VehicleState
from wire.pace import Pace
from wire.picture import EncodedPicture, pack_picture
from wire.rear_view import REAR, is_rear_asked_for, is_rear_wanted
from wire.topics import PROGRAMS, Role

log = logging.getLogger(__name__)

PROCESS = PROGRAMS[Role.VIDEO]
_STATUS_PERIOD_S = 0.2
_HEALTH_EVERY = 5  # statuses
_SPEED_AGE_MAX_NS = 200_000_000  # told at 50 Hz, from feedback at 100 Hz


class SenderLink(Protocol):
    """What the sender needs of wire.link.Link."""

    def publish(self, name: str, message: Message | bytes) -> None: ...

    def serve(self, name: str, handler: Callable[[Any], Message]) -> None: ...

    def on(self, name: str, callback: Callable[[Any, int], None]) -> None: ...


class Wishes:
    """What the car says that matters to its cameras. Called on the link's threads."""

    def __init__(self, link: SenderLink, note_wanted: Callable[[tuple[str, ...]], None]) -> None:
        """note_wanted: told who holds the lease and who is next, when that changes."""
        self._note_wanted, self._wanted = note_wanted, tuple[str, ...]()
        self._rear_ns: int | None = None
        self._speed: tuple[float, int] | None = None  # m/s, and when the car measured it
        self._control = ControlLoops()
        link.on("vehicle_state", self._hear_state)
        link.on("car_health", self._hear_health)
        link.on("gateway_status", self._hear_status)

    def _hear_state(self, state: VehicleState, received_ns: int) -> None:
        self._speed = state.speed_m_s, received_ns - round(state.feedback_age_ms * 1e6)
        if is_rear_asked_for(state):
            self._rear_ns = received_ns

    def _hear_status(self, status: GatewayStatus, received_ns: int) -> None:
        wanted = tuple(name for name in (status.lease_holder, status.succession.operator) if name)
        if wanted != self._wanted:
            self._wanted = wanted
            self._note_wanted(wanted)

    def _hear_health(self, health: LoopHealth, received_ns: int) -> None:
        self._control = hear(self._control, health)

    def is_rear_wanted(self, now_ns: int) -> bool:
        return is_rear_wanted(self._rear_ns, now_ns)

    def speed_m_s(self, now_ns: int) -> float | None:
        """As the car measured it last; None when that is too long ago."""
        speed = self._speed
        return speed[0] if speed is not None and now_ns - speed[1] <= _SPEED_AGE_MAX_NS else None

    def control_was_late(self) -> bool:
        """Since this was last asked."""
        control, self._control = self._control, replace(self._control, were_late=False)
        return control.were_late


class VideoSender:
    """Running cameras. `sessions` serves the watchers."""

    def __init__(
        self,
        link: SenderLink,
        loops: list[CameraLoop],
        sessions: VideoSessions,
        wishes: Wishes,
        clock: Clock,
        workers: list["Future[None]"],
    ) -> None:
        self.sessions = sessions
        self._link, self._loops, self._clock, self._workers = link, loops, clock, workers
        self._wishes, self._load = wishes, Load()
        self._ladder = ALONE if all(loop.calibration.required for loop in loops) else LADDER

    def report(self, stop: threading.Event, others_late_ns: Callable[[], int] = lambda: 0, fifo_priority: int = 0) -> None:
        """Publish status and health until `stop`. Raises what a camera's thread raised: the program then ends.

        others_late_ns  how long those wait for the processor who have no priority
        """
        with Pace(_STATUS_PERIOD_S, self._clock, stop, fifo_priority=fifo_priority) as pace:
            for number, now_ns in enumerate(pace):
                self._raise_what_failed()
                for loop in self._loops:
                    self._link.publish("camera_status", loop.status(now_ns, self.sessions.watching))
                if number % _HEALTH_EVERY == 0:
                    self._give_way(now_ns, others_late_ns())
                    self._publish_health(pace, now_ns)

    def _give_way(self, now_ns: int, others_late_ns: int) -> None:
        """Once a second: fewer pictures when the machine cannot keep up, more again when it can."""
        others = others_may_give(self._load, self._ladder)
        late = [loop for loop in self._loops if loop.was_late(now_ns)]
        why = [f"camera {loop.calibration.name}" for loop in late if others or loop.calibration.required]
        why += ["programs without a priority"] if others_late_ns > STARVED_NS else []
        why += ["a control loop"] if self._wishes.control_was_late() else []
        before, self._load = self._load, after_a_second(self._load, bool(why), self._ladder)
        if self._load.level != before.level:
            said = f"late: {', '.join(why)}" if why else "nothing was late"
            log.info(
                "cameras: level %d of %d of giving way to the rest of the car; %s", self._load.level, len(self._ladder) - 1, said
            )
            for loop in self._loops:
                loop.limit(allowance(loop.calibration.frame_rate_hz, loop.calibration.required, self._load, self._ladder))

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
    """Start everything; leaving the context stops the threads and closes the sessions and the sources."""
    halt = threading.Event()
    with ExitStack() as stack:
        for source in sources.values():
            stack.enter_context(source)
        encoders = {each.name: Encoder(each, settings, clock.real_time_factor) for each in calibrations}
        loop = stack.enter_context(loop_in_thread("video-session"))
        sessions = VideoSessions(loop, encoders, ways)
        stack.callback(sessions.close)
        link.serve("video_session", sessions.answer)
        wishes = Wishes(link, sessions.follow)
        cameras = [
            CameraLoop(
                calibration,
                sources[calibration.name],
                encoders[calibration.name],
                clock,
                partial(_deliver, link, sessions),
                wishes.is_rear_wanted if calibration.name == REAR else lambda now_ns: True,
                wishes.speed_m_s,
            )
            for calibration in calibrations
        ]
        pool = stack.enter_context(ThreadPoolExecutor(max(len(cameras), 1), thread_name_prefix="camera"))
        stack.callback(halt.set)
        yield VideoSender(link, cameras, sessions, wishes, clock, [pool.submit(camera.run, halt) for camera in cameras])


def _deliver(link: SenderLink, sessions: VideoSessions, picture: EncodedPicture, ready_ns: int) -> None:
    """To the watchers first, who wait for it; then to the recorder."""
    sessions.show(picture, ready_ns)
    link.publish("video", pack_picture(picture))
