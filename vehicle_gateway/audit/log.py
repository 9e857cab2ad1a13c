"""The audit trail's own threads: one turns cycles into chained records and writes them, one says them to the recorder.

The control loop only puts its cycles into a bounded queue. Records go to the disk first; a full disk is counted and tried again,
in order, and the drive goes on. A recorder that was not there yet is told what it missed. Shells: they decide nothing.
"""

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, Protocol

from cryptography.hazmat.primitives.asymmetric import ec
from msgspec.structs import replace

from vehicle_gateway.audit.file import Resumed
from vehicle_gateway.audit.trail import About, Fact, entry_of, observe, start
from vehicle_gateway.journal import WAITING_MAX, Entry, JournalLink
from wire.audit_chain import SIGNED_AT_ONCE, follow
from wire.clock import Clock
from wire.link_threads import threads_with
from wire.messages.audit import AuditEntry, AuditKind, AuditRecord

LOOK_S = 0.05  # how often the thread looks at cycles in which nothing was decided: what a killed gateway loses at most
RETRY_S = 1.0  # after the disk refused
HEAD_S = 10.0  # ours: at most so much at the end of a chain stands unsigned
KEPT_MAX = 10_000  # records that wait for the disk or for a recorder: hours of driving
DROPPED_S = 10.0  # ours: how often it looks at what was refused; a flood is one record each time


class AuditStore(Protocol):
    """What the log needs of audit.file.AuditFile."""

    def append(self, record: AuditRecord) -> None: ...
    def sync(self) -> None: ...


class Signer(NamedTuple):
    key: ec.EllipticCurvePrivateKey
    certificate_pem: str


class AuditLog:
    """A context manager: entering it tells the start, leaving it the end, for at most two seconds.

    software  asked on the audit's thread: in a work tree it takes a program to answer, and no gateway waits for that
    """

    def __init__(
        self,
        link: JournalLink,
        store: AuditStore,
        resumed: Resumed,
        signer: Signer,
        about: About,
        clock: Clock,
        software: Callable[[], str],
        configuration_sha256: str,
        fifo_priority: int = 0,
    ) -> None:
        """fifo_priority: of its threads. They take the interpreter's lock, for which the loop of the gateway would wait."""
        self._store, self._signer, self._about, self._clock = store, signer, about, clock
        self._chain, self._trail, self._set_aside = resumed
        self._said, self._fifo_priority = (software, configuration_sha256), fifo_priority
        self._cycles: deque[Entry] = deque()
        self._unsaved: deque[AuditRecord] = deque()
        self._untold: deque[AuditRecord] = deque()
        self._teller = Teller(link)
        self._unsigned, self._head_ns, self._retry_ns, self._told_lost = 0, 0, 0, 0
        self._news, self._stop = threading.Event(), False
        self._thread = threading.Thread(target=self._run, name="audit", daemon=True)
        self.ending = "the gateway was stopped"
        self.counts: Callable[[], dict[str, int]] = dict  # messages refused or lost so far, by reason: the gateway's own
        self._counted, self._counted_ns = dict[str, int](), 0
        self._unseen = 0  # cycles that did not fit into the queue; the control loop counts them
        self._gave_way = 0  # records that waited too long for the disk
        self._refused = False  # by the disk, at the last try

    def __enter__(self) -> "AuditLog":
        with threads_with(self._fifo_priority):
            self._teller.start()
            self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop = True
        self._news.set()
        self._thread.join(2.0)
        self._teller.stop()

    @property
    def dropped(self) -> dict[str, int]:
        """For the gateway's own count: nothing when all is well."""
        waiting = len(self._unsaved) if self._refused else 0
        counts = {"audit records not on disk": waiting, "audit lost": self._unseen + self._gave_way + self._teller.lost}
        return {name: count for name, count in counts.items() if count}

    def keep(self, cycle: Entry) -> None:
        """From the control loop: never waits."""
        if len(self._cycles) >= WAITING_MAX:
            self._unseen += 1
            return
        self._cycles.append(cycle)
        outputs = cycle.outputs
        if outputs.events or outputs.lease_replies or outputs.hand_over_replies:
            self._news.set()

    def _run(self) -> None:
        self._begin(self._clock.now_ns())
        while not self._stop:
            self._news.wait(LOOK_S)
            self._news.clear()
            self._take()
            self._save(self._clock.now_ns())
        self._take()
        self._tell_dropped(self._clock.now_ns())
        self._tell(AuditKind.END, self.ending)
        self._save(self._clock.now_ns(), last=True)

    def _begin(self, now_ns: int) -> None:
        software, configuration_sha256 = self._said
        self._trail, entries = start(self._trail, now_ns, self._about, software(), configuration_sha256)
        self._add(entries)
        if self._set_aside:
            text = f"{self._set_aside} bytes of a record that was not written whole were set aside"
            self._tell(AuditKind.LOST, text, times=1)
        self._save(now_ns)

    def _take(self) -> None:
        """Every cycle that waits."""
        unseen = self._unseen
        if unseen > self._told_lost:
            self._tell(AuditKind.LOST, "cycles that the audit could not take", times=unseen - self._told_lost)
            self._told_lost = unseen
        while self._cycles:
            self._trail, entries = observe(self._trail, self._cycles.popleft(), self._about)
            self._add(entries)
        now_ns = self._clock.now_ns()
        if now_ns - self._counted_ns > DROPPED_S * 1e9:
            self._tell_dropped(now_ns)
        if self._unsigned and now_ns - self._head_ns > HEAD_S * 1e9:
            self._sign()

    def _tell_dropped(self, now_ns: int) -> None:
        counted, self._counted_ns = self.counts(), now_ns
        for reason, times in risen(self._counted, counted).items():
            fact = Fact(kind=AuditKind.DROPPED, subject=reason, times=times)
            self._add((entry_of(fact, self._trail, now_ns, self._about),))
        self._counted = counted

    def _tell(self, kind: AuditKind, text: str, times: int = 0) -> None:
        self._add((entry_of(Fact(kind=kind, text=text, times=times), self._trail, self._clock.now_ns(), self._about),))

    def _add(self, entries: Iterable[AuditEntry]) -> None:
        for entry in entries:
            self._chain, record = follow(self._chain, entry, self._signer.key)
            self._put(record)
            if entry.kind in SIGNED_AT_ONCE:
                self._sign()

    def _sign(self) -> None:
        bare = entry_of(Fact(kind=AuditKind.HEAD), self._trail, self._clock.now_ns(), self._about)
        head = replace(bare, signer_pem=self._signer.certificate_pem)
        self._chain, record = follow(self._chain, head, self._signer.key)
        self._put(record)
        self._unsigned, self._head_ns = 0, head.stamp_ns

    def _put(self, record: AuditRecord) -> None:
        self._unsigned += 1
        self._unsaved.append(record)
        self._untold.append(record)

    def _save(self, now_ns: int, last: bool = False) -> None:
        """To the disk, in order, and then to the recorder: a killed gateway said nothing that its file does not hold."""
        if self._unsaved and (last or now_ns >= self._retry_ns):
            self._write(now_ns)
        while self._untold:
            self._teller.keep(self._untold.popleft())

    def _write(self, now_ns: int) -> None:
        """What the disk refuses waits; the oldest gives way when too much does."""
        try:
            while self._unsaved:
                self._store.append(self._unsaved[0])
                self._unsaved.popleft()
            if not self._unsigned:
                self._store.sync()
            self._refused = False
        except OSError:
            self._refused = True
            self._retry_ns = now_ns + round(RETRY_S * 1e9)
            while len(self._unsaved) > KEPT_MAX:
                self._unsaved.popleft()
                self._gave_way += 1


def risen(before: Mapping[str, int], now: Mapping[str, int]) -> dict[str, int]:
    """By how much each count has risen, where it has."""
    grown = {reason: count - before.get(reason, 0) for reason, count in now.items()}
    return {reason: more for reason, more in grown.items() if more > 0}


class Teller:
    """Says records to the recorder, on a thread of its own: a recorder that hangs holds up nobody else."""

    def __init__(self, link: JournalLink) -> None:
        self._link = link
        self._waiting: deque[AuditRecord] = deque()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="audit to the recorder", daemon=True)
        self.lost = 0  # that no recorder was there for, for too long

    def start(self) -> None:
        self._thread.start()

    def stop(self) -> None:
        self._stop.set()
        self._thread.join(1.0)

    def keep(self, record: AuditRecord) -> None:
        if len(self._waiting) >= KEPT_MAX:
            self._waiting.popleft()
            self.lost += 1
        self._waiting.append(record)

    def _run(self) -> None:
        while not self._stop.wait(LOOK_S):
            self._tell()
        self._tell()

    def _tell(self) -> None:
        while self._waiting and self._link.is_heard("audit"):
            self._link.publish("audit", self._waiting.popleft())
