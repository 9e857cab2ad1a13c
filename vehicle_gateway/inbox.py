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
from vehicle_gateway.door import Door
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import Lease
from vehicle_gateway.state import Inputs, State
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


class Inbox:
    """Everything that arrived since the loop last looked. `wake` is set when a valid command or a question came."""

    def __init__(self, link: Link, boot_id: str, verifier: Recognises, clock: Clock, car: CarBus) -> None:
        self._codec, self._health_codec, self._watch_codec = car
        self.wake = threading.Event()
        self._watchdog_ns = clock.now_ns()  # when its last frame came, or we began to listen
        self.dropped: Counter[str] = Counter()
        self.boot_id = boot_id
        self._lock = threading.Lock()
        self._holder, self._next = Door(boot_id), Door(boot_id)
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
            door = self._door_of(command.lease_epoch)
            reason = door.let_in(command, received_ns)
            if reason:
                self.dropped[reason] += 1
                return
        if door is self._holder:
            self.wake.set()

    def _door_of(self, epoch: int) -> Door:
        """The next operator's for his epoch alone."""
        return self._next if self._next.key and epoch == self._next.guard.epoch else self._holder

    def open_for(self, before: State, after: State, new_key: Callable[[Lease], bytes]) -> None:
        """Whose commands are let in after a cycle: those of the lease's holder, and beside them the next operator's.

        A new holder gets a new key. A next one who becomes the holder keeps his, and what waits of his commands counts.
        """
        lease, next_one, was, was_next = after.lease, after.successor.lease, before.lease, before.successor.lease
        with self._lock:
            if was_next.holder and lease.epoch == was_next.epoch:
                self._holder, self._next = self._next, Door(self.boot_id)
            elif lease != was:
                self._holder.hold_to(lease.epoch, new_key(lease) if lease.owner != was.owner else None)
            if not next_one.holder:
                self._next = Door(self.boot_id)
            elif next_one.epoch != was_next.epoch:
                self._next.hold_to(next_one.epoch, new_key(next_one))

    def key_of(self, epoch: int) -> bytes:
        """The key of the lease that has, or had, this epoch; b"" of a lease that has been lost in the meantime."""
        return self._next.key_of(epoch) or self._holder.key_of(epoch)

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
        with self._lock:
            genuine = self._door_of(request.lease_epoch).is_genuine(request)
        if not genuine:
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

    def take(self, holder_certificate: str, next_certificate: str = "") -> tuple[Inputs, Replies]:
        """What arrived since the last call, how to answer the questions in it, and whether holder and next one still may ask."""
        leases = [item.message for item in self._leases.drain()]
        hand_overs = [item.message for item in self._hand_overs.drain()]
        supervisions = [item.message for item in self._supervisions.drain()]
        stops = [item.message.number for item in self._stops.drain()]
        with self._lock:  # between looking and clearing no command may come: it would be lost for a period
            command, next_command = self._holder.take(), self._next.take()
        inputs = Inputs(
            feedback=self._new(0, self._feedback.feedback),
            command=command.command if command else None,
            command_ns=command.received_ns if command else 0,
            told_ns=command.told_ns if command else {},
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
            next_command=next_command.command if next_command else None,
            next_command_ns=next_command.received_ns if next_command else 0,
            next_told_ns=next_command.told_ns if next_command else {},
            next_revoked=self._verifier.is_revoked(next_certificate),
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
    """The answer to a granted request carries the key of the lease; a refusal never does.

    A lease can change hands in the very cycle in which its holder renews it: then there is no key for him any more.
    """
    if reply.granted and not key:
        lost = "the lease has just gone to somebody else: ask again"
        return LeaseReply(granted=False, epoch=0, key_hex="", rule=lost, boot_id=reply.boot_id)
    return msgspec.structs.replace(reply, key_hex=key.hex() if reply.granted else "")
