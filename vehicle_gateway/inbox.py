"""Where everything for the gateway arrives: library threads check and put, the loop takes. A shell: it decides nothing."""

import threading
from collections import Counter
from collections.abc import Callable
from hashlib import sha256
from typing import NamedTuple, Protocol, TypeVar

import msgspec

from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import HealthState, health_of
from vehicle_gateway.can.vehicles import CarBus
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import CommandGuard, refuse_command
from vehicle_gateway.measure import shown_since
from vehicle_gateway.state import Inputs
from wire.clock import Clock
from wire.latest import EventQueue, Latest
from wire.link import Link
from wire.messages.automation import AutonomyCommand, AutonomyStatus, Scene
from wire.messages.base import Message
from wire.messages.health import LoopHealth
from wire.messages.operating import DriveCommand
from wire.messages.sensing import CameraStatus
from wire.messages.session import (
    HandOverReply,
    HandOverRequest,
    LeaseReply,
    LeaseRequest,
    Outcome,
    SupervisionRequest,
)
from wire.signature import is_genuine

Reply = Callable[[Message], None]
T = TypeVar("T")
QUESTIONS_MAX = 32  # waiting at once; a flood is refused and counted


class Recognises(Protocol):
    """Whose certificate asks: `vehicle_gateway.identity.Verifier`."""

    def operator(self, request: LeaseRequest, now_ns: int) -> Identity: ...

    def supervisor(self, request: SupervisionRequest, now_ns: int) -> Identity: ...

    def is_revoked(self, common_name: str) -> bool: ...


class Replies(NamedTuple):
    """How to answer the questions in the inputs, in their order."""

    lease: list[Reply]
    hand_over: list[Reply]
    supervision: list[Reply]


class Commanded(NamedTuple):
    """The newest command, until the loop takes it."""

    command: DriveCommand
    received_ns: int
    shown_ns: dict[str, int]  # see `shown_since`


class Inbox:
    """Everything that arrived since the loop last looked. `wake` is set when a valid command or a question came."""

    def __init__(self, link: Link, boot_id: str, verifier: Recognises, clock: Clock, car: CarBus) -> None:
        self._codec, self._health_codec, self._watch_codec = car
        self.wake = threading.Event()
        self._watchdog_ns = clock.now_ns()  # when its last frame came, or we began to listen
        self.dropped: Counter[str] = Counter()
        self.guard = CommandGuard(epoch=0, boot_id=boot_id, last_sequence=0)
        self._lock = threading.Lock()
        self.key = b""  # of the current lease; "" refuses everything
        self._command: Commanded | None = None
        self._feedback = self._codec.start()
        self._ecu = HealthState()
        self._cameras: EventQueue[CameraStatus] = link.events("camera_status")
        self._stops = link.events("tower_stop", limit=64)
        self._autonomy: Latest[AutonomyCommand] = link.level("autonomy_command")
        self._status: Latest[AutonomyStatus] = link.level("autonomy_status")
        self._scene: Latest[Scene] = link.level("scene")
        self._verifier, self._clock = verifier, clock
        self._leases: EventQueue[tuple[LeaseRequest, Identity, Reply]] = EventQueue(QUESTIONS_MAX)
        self._supervisions: EventQueue[tuple[SupervisionRequest, Identity, Reply]] = EventQueue(QUESTIONS_MAX)
        self._hand_overs: EventQueue[tuple[HandOverRequest, Reply]] = EventQueue(QUESTIONS_MAX)
        self._taken: dict[int, object] = {}
        self._link = link
        link.on("drive_command", self._on_command)
        link.serve_later("lease", self._on_lease)
        link.serve_later("hand_over", self._on_hand_over)
        link.serve_later("supervision", self._on_supervision)

    def _on_command(self, command: DriveCommand, received_ns: int) -> None:
        with self._lock:
            genuine = bool(self.key) and is_genuine(command, self.key)
            reason = refuse_command(command, self.guard, genuine, received_ns)
            if reason:
                self.dropped[reason] += 1
                return
            self.guard = msgspec.structs.replace(self.guard, last_sequence=command.sequence)
            waiting = self._command
            shown = shown_since(waiting.command, waiting.received_ns, waiting.shown_ns, command) if waiting else {}
            self._command = Commanded(command, received_ns, shown)
        self.wake.set()

    def hold_to(self, epoch: int, new_key: bytes | None) -> None:
        """From now on only commands with this epoch; with a new key (a new holder) their sequence begins anew."""
        with self._lock:
            fresh = 0 if new_key is not None else self.guard.last_sequence
            self.guard = msgspec.structs.replace(self.guard, epoch=epoch, last_sequence=fresh)
            self.key = self.key if new_key is None else new_key

    def watchdog_silent_s(self, now_ns: int) -> float | None:
        """None for a car that obeys none."""
        return max(now_ns - self._watchdog_ns, 0) / 1e9 if self._watch_codec is not None else None

    def on_frame(self, frame: Frame, received_ns: int) -> None:
        if self._health_codec is not None and self._health_codec.speaks(frame):
            self._ecu, reason = self._health_codec.decode(self._ecu, frame)
        elif self._watch_codec is not None and self._watch_codec.speaks(frame):
            self._watchdog_ns = received_ns  # what it asks of the ECU is for the ECU; we only tell that it lives
            return
        else:
            self._feedback, reason = self._codec.decode(self._feedback, frame)
        if reason:
            self.dropped[reason] += 1

    def _on_lease(self, request: LeaseRequest, reply: Reply) -> None:
        """Into the queue goes what the cycle needs and may be recorded: with the session's own name anybody could renew."""
        identity = self._verifier.operator(request, self._clock.now_ns())
        hashed = sha256(request.session.encode()).hexdigest()[:32]
        self._leases.put((msgspec.structs.replace(request, session=hashed, certificate="", signature=""), identity, reply), 0)
        self.wake.set()

    def _on_supervision(self, request: SupervisionRequest, reply: Reply) -> None:
        identity = self._verifier.supervisor(request, self._clock.now_ns())
        self._supervisions.put((msgspec.structs.replace(request, certificate="", signature=""), identity, reply), 0)
        self.wake.set()

    def _on_hand_over(self, request: HandOverRequest, reply: Reply) -> None:
        if not self.key or not is_genuine(request, self.key):
            self.dropped["hand-over signature"] += 1
            reply(
                HandOverReply(
                    number=request.number,
                    outcome=Outcome.REFUSED,
                    lease_epoch=0,
                    rule="not signed with the key of the current lease: ask for it again",
                )
            )
            return
        self._hand_overs.put((request, reply), 0)
        self.wake.set()

    def take(self, holder_certificate: str) -> tuple[Inputs, Replies]:
        """What arrived since the last call, and how to answer the questions in it. Of the lease's holder: whether he still may."""
        leases = [item.message for item in self._leases.drain()]
        hand_overs = [item.message for item in self._hand_overs.drain()]
        supervisions = [item.message for item in self._supervisions.drain()]
        stops = [item.message.number for item in self._stops.drain()]
        with self._lock:  # between looking and clearing no command may come: it would be lost for a period
            command, self._command = self._command, None
        inputs = Inputs(
            feedback=self._new(0, self._feedback.feedback),
            command=command.command if command else None,
            command_ns=command.received_ns if command else 0,
            shown_ns=command.shown_ns if command else {},
            autonomy=self._newest(1, self._autonomy),
            autonomy_status=self._newest(2, self._status),
            scene=self._newest(3, self._scene),
            cameras=tuple(item.message for item in self._cameras.drain()),
            stop_number=stops[-1] if stops else 0,
            lease_requests=tuple(request for request, _, _ in leases),
            operators=tuple(identity for _, identity, _ in leases),
            hand_over_requests=tuple(request for request, _ in hand_overs),
            holder_revoked=self._verifier.is_revoked(holder_certificate),
            supervision_requests=tuple(request for request, _, _ in supervisions),
            supervisors=tuple(identity for _, identity, _ in supervisions),
        )
        return inputs, Replies(
            lease=[reply for _, _, reply in leases],
            hand_over=[reply for _, reply in hand_overs],
            supervision=[reply for _, _, reply in supervisions],
        )

    def ecu_health(self, now_ns: int) -> LoopHealth | None:
        """The newest report of the ECU's loop, once."""
        report = self._new(4, self._ecu.report)
        return None if report is None else health_of(report, now_ns)

    def _new(self, slot: int, value: T | None) -> T | None:
        """The value if it is another object than at the last call."""
        if value is None or self._taken.get(slot) is value:
            return None
        self._taken[slot] = value
        return value

    def _newest(self, slot: int, latest: Latest[T]) -> T | None:
        received = latest.get()
        return self._new(slot, received.message) if received else None

    def all_dropped(self) -> dict[str, int]:
        """Everything refused on this side, by reason."""
        refused = {
            "questions": self._leases.refused + self._hand_overs.refused + self._supervisions.refused,
            "stops": self._stops.refused,
            "camera status": self._cameras.refused,
        }
        return {**self._link.dropped, **self.dropped, **{name: count for name, count in refused.items() if count}}


def lease_reply_with_key(reply: LeaseReply, key: bytes) -> LeaseReply:
    """The answer to a granted request carries the key of the lease; a refusal never does."""
    return LeaseReply(
        granted=reply.granted,
        epoch=reply.epoch,
        key_hex=key.hex() if reply.granted else "",
        rule=reply.rule,
        boot_id=reply.boot_id,
    )
