"""The append-only file and the threads that write it: goes on where it ended, survives a full disk, never waits for a recorder."""

import json
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from msgspec.structs import replace

from recordings.audit.source import read_lines, readable
from recordings.audit.verify import verify
from vehicle_gateway.audit.file import AuditFile, audit_file, resume
from vehicle_gateway.audit.log import KEPT_MAX, AuditLog, Signer, risen
from vehicle_gateway.audit.trail import About, Fact, Trail, entry_of
from vehicle_gateway.authority import Authority
from vehicle_gateway.journal import Entry
from vehicle_gateway.lease import Lease
from vehicle_gateway.state import Inputs, Outputs, State, initial_state
from wire.audit_chain import GENESIS, Chain, seal
from wire.authority import issue, new_authority
from wire.clock import Clock
from wire.configuration import ConfigurationError
from wire.messages.audit import AuditKind, AuditRecord
from wire.messages.base import Message
from wire.messages.vehicle import Actuation, Mode
from wire.topics import Role

K = AuditKind
AUTHORITY = new_authority()
HUB = issue(Role.VEHICLE_HUB, (), AUTHORITY)
SIGNER = Signer(HUB.key, HUB.certificate_pem.decode())
ABOUT = About(vehicle_id="car-1", boot_id="boot", utc_minus_now_ns=0)
RECORD = seal(entry_of(Fact(kind=K.END), Trail(), 1, ABOUT), HUB.key)
CALM = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)


class Line:
    """A link into a list; deaf until somebody listens."""

    def __init__(self, heard: bool = True) -> None:
        self.heard, self.said = heard, list[AuditRecord]()
        self.hangs = threading.Event()
        self.hangs.set()

    def is_heard(self, name: str) -> bool:
        return self.heard and name == "audit"

    def publish(self, name: str, message: Message) -> None:
        assert isinstance(message, AuditRecord)
        self.hangs.wait(10.0)
        self.said.append(message)


class FullDisk:
    """Takes so many records, then none until there is room."""

    def __init__(self, room: int) -> None:
        self.room, self.kept = room, list[AuditRecord]()

    def append(self, record: AuditRecord) -> None:
        if len(self.kept) >= self.room:
            raise OSError(28, "No space left on device")
        self.kept.append(record)

    def sync(self) -> None: ...


def until(done: Callable[[], object], seconds: float = 10.0) -> None:
    pause = threading.Event()
    for _ in range(round(seconds / 0.005)):
        if done():
            return
        pause.wait(0.005)
    raise AssertionError("it did not come in time")


def clock() -> Clock:
    """Now, as the system says: certificates are valid now."""
    return Clock(offset_ns=time.time_ns() - time.monotonic_ns())


def log_on(link: Line, store: object, file: Path | None = None) -> AuditLog:
    resumed = resume(file) if file else (Chain(), Trail(), 0)
    return AuditLog(link, store, resumed, SIGNER, ABOUT, clock(), lambda: "ours", "ab" * 32)  # type: ignore[arg-type]


def cycles(*modes: Mode) -> list[Entry]:
    """One cycle per mode, from STANDBY on."""
    made, before = list[Entry](), initial_state("boot", 0, 100, False)
    for number, mode in enumerate(modes, start=1):
        after = _in(before, mode, number)
        outputs = Outputs(
            send=True, mode=mode, requested=CALM, applied=CALM, brake_hold=False, rules=(), events=("e",), causes=(), cap_m_s=8.0
        )
        made.append(Entry(number, after.now_ns, before, Inputs(), after, outputs, 0))
        before = after
    return made


def _in(before: State, mode: Mode, number: int) -> State:
    now_ns = clock().now_ns()
    lease = Lease(epoch=1, holder="ann", session="s")
    return replace(before, now_ns=now_ns, lease=lease, authority=Authority(mode=mode, origin=mode), cause=f"cycle {number}")


def verdict(file: Path) -> tuple[list[K], int, int]:
    """Kinds in the file, number signed up to, problems."""
    lines = read_lines(file)
    found = verify(lines, AUTHORITY.certificate)
    return [each.entry.kind for each in readable(lines)], found.signed_to, len(found.problems)


def test_a_drive_is_in_the_file_and_on_the_link_whole_and_signed(tmp_path: Path):
    file, link = tmp_path / "car.audit.jsonl", Line()
    with AuditFile(file) as store, log_on(link, store) as log:
        for cycle in cycles(Mode.REMOTE, Mode.AUTONOMOUS):
            log.keep(cycle)
    kinds, signed_to, problems = verdict(file)
    expected = [K.START, K.HEAD, K.DRIVE_BEGIN, K.LEASE, K.MODE, K.MODE, K.DRIVE_END, K.HEAD, K.END, K.HEAD]
    assert kinds == expected
    assert (signed_to, problems) == (10, 0)
    assert [record.hash for record in link.said] == [json.loads(line)["hash"] for line in file.read_bytes().splitlines()]
    assert log.dropped == {}


def test_what_the_gateway_refused_is_told_by_reason_and_by_how_much_it_has_risen(tmp_path: Path):
    counts, file = {"command signature": 3}, tmp_path / "car.audit.jsonl"
    with AuditFile(file) as store, log_on(Line(), store) as log:
        log.counts = lambda: counts
        until(lambda: "command signature" in file.read_text())
        counts = {"command signature": 10, "command epoch": 1}
    told = [each.entry for each in readable(read_lines(file)) if each.entry.kind is K.DROPPED]
    assert sum(entry.times for entry in told if entry.subject == "command signature") == 10
    assert sum(entry.times for entry in told if entry.subject == "command epoch") == 1
    assert risen({"a": 1, "b": 5}, {"a": 1, "b": 3, "c": 2}) == {"c": 2}


def test_the_chain_and_the_numbers_of_drives_go_on_over_restarts(tmp_path: Path):
    file = audit_file(tmp_path / "car.json")
    for _ in range(3):
        with AuditFile(file) as store, log_on(Line(), store, file) as log:
            for cycle in cycles(Mode.REMOTE, Mode.STOPPED):
                log.keep(cycle)
    drives = [each.entry.drive for each in readable(read_lines(file)) if each.entry.kind is K.DRIVE_BEGIN]
    assert drives == [1, 2, 3]
    assert verdict(file)[2] == 0


GATEWAY = """
import sys, threading
sys.path.insert(0, {tests!r})
from pathlib import Path
from test_audit_file import AuditFile, Line, Mode, cycles, log_on
file = Path(sys.argv[1])
with AuditFile(file) as store, log_on(Line(), store, file) as log:
    for cycle in cycles(Mode.REMOTE):
        log.keep(cycle)
    while "drive_begin" not in file.read_text():
        threading.Event().wait(0.005)
    print("driving", flush=True)
    sys.stdin.read()
"""


def test_a_killed_gateway_leaves_a_whole_chain_and_the_next_one_ends_its_drive(tmp_path: Path):
    file = tmp_path / "car.audit.jsonl"
    program = GATEWAY.format(tests=str(Path(__file__).parent))
    with subprocess.Popen(
        [sys.executable, "-c", program, str(file)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "driving\n"
        process.send_signal(signal.SIGKILL)
    with AuditFile(file) as store, log_on(Line(), store, file):
        pass
    lines = readable(read_lines(file))
    assert [each.entry.number for each in lines] == list(range(1, len(lines) + 1))
    ends = [each.entry for each in lines if each.entry.kind is K.DRIVE_END]
    assert len(ends) == 1 and "died" in ends[0].text and ends[0].drive == 1
    hashes = [each.record.hash for each in lines]
    assert [each.entry.previous for each in lines] == [GENESIS, *hashes[:-1]]


def test_a_record_that_was_not_written_whole_is_set_aside_and_said_so(tmp_path: Path):
    file = tmp_path / "car.audit.jsonl"
    with AuditFile(file) as store, log_on(Line(), store, file):
        pass
    whole = file.read_bytes()
    file.write_bytes(whole + b'{"entry":{"num')
    with AuditFile(file) as store, log_on(Line(), store, file):
        pass
    assert file.read_bytes().startswith(whole)
    assert file.with_suffix(".part").read_bytes() == b'{"entry":{"num\n'
    assert K.LOST in verdict(file)[0] and verdict(file)[2] == 0


DEEP = b'{"stamp_ns":0,"entry":' + b"[" * 5000 + b"\n"  # deeper than any decoder follows


@pytest.mark.parametrize("last", [b"{}\n", b"no record\n", b"\xff\xfe\n", DEEP], ids=["empty", "words", "no text", "deep"])
def test_a_damaged_file_is_refused_with_what_to_do_and_left_as_it_is(tmp_path: Path, last: bytes):
    file = tmp_path / "car.audit.jsonl"
    file.write_bytes(last)
    with pytest.raises(ConfigurationError, match="recordings audit"):
        resume(file)
    assert file.read_bytes() == last


def test_a_changed_last_record_is_refused(tmp_path: Path):
    file = tmp_path / "car.audit.jsonl"
    with AuditFile(file) as store, log_on(Line(), store, file):
        pass
    file.write_bytes(file.read_bytes().replace(b'"kind":"head"', b'"kind":"stop"'))
    with pytest.raises(ConfigurationError, match="was changed"):
        resume(file)


def test_a_full_disk_is_counted_and_caught_up_in_order_while_the_recorder_hears_everything():
    disk, link = FullDisk(room=2), Line()
    with log_on(link, disk) as log:
        for cycle in cycles(Mode.REMOTE, Mode.STOPPED):
            log.keep(cycle)
        until(lambda: log.dropped.get("audit records not on disk", 0) > 0)
        until(lambda: len(link.said) > len(disk.kept))
        disk.room = 10_000
    assert [record.hash for record in disk.kept] == [record.hash for record in link.said]
    assert log.dropped == {}


def test_a_write_that_fails_half_way_leaves_no_half_record(tmp_path: Path):
    """RLIMIT_FSIZE stops a write in the middle, as a full disk does."""
    file, (soft, hard) = tmp_path / "car.audit.jsonl", resource.getrlimit(resource.RLIMIT_FSIZE)
    with AuditFile(file) as store:
        store.append(RECORD)
        resource.setrlimit(resource.RLIMIT_FSIZE, (os.stat(file).st_size * 3 // 2, hard))
        try:
            with pytest.raises(OSError):
                store.append(RECORD)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        assert len(file.read_bytes().splitlines()) == 1 and file.read_bytes().endswith(b"\n")
        store.append(RECORD)
    assert file.read_bytes().splitlines()[0] == file.read_bytes().splitlines()[1]


def test_a_recorder_that_comes_later_is_told_from_the_start_and_one_that_hangs_holds_up_no_disk():
    disk, link = FullDisk(room=10_000), Line(heard=False)
    with log_on(link, disk) as log:
        for cycle in cycles(Mode.REMOTE):
            log.keep(cycle)
        until(lambda: len(disk.kept) >= 5)
        assert link.said == []
        link.hangs.clear()
        link.heard = True
        for cycle in cycles(Mode.STOPPED):
            log.keep(cycle)
        until(lambda: len(disk.kept) >= 8)
        assert link.said == []
        link.hangs.set()
        until(lambda: len(link.said) >= 8)
    assert [record.hash for record in disk.kept] == [record.hash for record in link.said]
    assert len(disk.kept) < KEPT_MAX
