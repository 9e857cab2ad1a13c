"""What survives a gateway that dies: epochs, latches, stops; and a file that cannot be read is said so."""

import signal
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.gateway import recalled_state, remember
from vehicle_gateway.memory import EPOCH_BLOCK, Memory, Remembered, recall, write
from vehicle_gateway.state import initial_state
from wire.configuration import ConfigurationError
from wire.messages.base import encode
from wire.messages.vehicle import Mode

UTC = 1_700_000_000_000_000_000  # Unix time minus the car's clock in these stories
NOW = 10**12
GRANTS = """
import sys
from pathlib import Path
from vehicle_gateway.lease import renew_epoch
from vehicle_gateway.memory import recall
from vehicle_gateway.gateway import recalled_state
lease = recalled_state(recall(Path(sys.argv[1])), "boot", 10**12, 0).lease
for _ in range(int(sys.argv[2])):
    lease = renew_epoch(lease)
print(lease.epoch, flush=True)
sys.stdin.read()
"""


def test_epochs_of_a_killed_gateway_are_never_given_again(tmp_path: Path):
    file, highest = tmp_path / "car.json", -1
    for grants in (5, 1):
        with subprocess.Popen(
            [sys.executable, "-c", GRANTS, str(file), str(grants)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            epoch = int(process.stdout.readline())
            process.send_signal(signal.SIGKILL)
        assert epoch - grants >= highest, "the first grant after the kill has an epoch that was used before"
        highest = epoch


def test_every_start_reserves_its_epochs_before_it_can_use_them(tmp_path: Path):
    file = tmp_path / "deeper" / "car.json"
    first, second, third = (recall(file).epoch_reserved for _ in range(3))
    assert first < second < third


def test_what_was_written_last_is_what_is_recalled(tmp_path: Path):
    file = tmp_path / "car.json"
    known = Remembered(epoch_reserved=17, emergency_latched=True, stop_latched=True, engaged=True, stops_utc_ns=(UTC, UTC + 1))
    with Memory(file) as memory:
        for epoch in range(17):
            memory.keep(replace(known, epoch_reserved=epoch))
        memory.keep(known)
    assert memory.failed == 0
    assert recall(file) == known


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b'{"epoch_reserved": -1}',
        b'{"epoch_reserved": "many"}',
        b'{"unknown": 1}',
        b"\x00\xff\xfe",
        b'{"stops_utc_ns": [null]}',
        b'{"\xff": 1}',
    ],
)
def test_a_damaged_file_is_refused_with_its_name_and_what_to_do(tmp_path: Path, content: bytes):
    file = tmp_path / "car.json"
    file.write_bytes(content)
    with pytest.raises(ConfigurationError, match="damaged") as told:
        recall(file)
    assert str(file) in str(told.value)
    assert file.read_bytes() == content, "the evidence was overwritten"


def test_a_place_that_cannot_be_written_is_refused_with_the_key_to_change(tmp_path: Path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(ConfigurationError, match="memory"):
        recall(tmp_path / "file" / "car.json")


def test_a_write_that_died_half_way_leaves_the_old_memory_whole(tmp_path: Path):
    file = tmp_path / "car.json"
    write(file, Remembered(epoch_reserved=5, emergency_latched=True))
    (tmp_path / "car.new").write_bytes(b'{"epoch_res')
    assert recall(file).emergency_latched


@pytest.mark.parametrize("after", ["nothing", "half of it", "all but the last letter", "all of it", "its place"])
def test_a_power_cut_between_reserving_and_using_never_gives_an_epoch_twice(tmp_path: Path, after: str):
    """What is on the disk when a start was cut off after each step of it; nothing was granted before the last one."""
    file, new = tmp_path / "car.json", tmp_path / "car.new"
    used = recalled_state(recall(file), "first", NOW, 0).lease.epoch + 1  # a grant of the first start
    whole = encode(replace(Remembered(), epoch_reserved=2 * EPOCH_BLOCK))  # what the second one was writing
    parts = {"nothing": b"", "half of it": whole[: len(whole) // 2], "all but the last letter": whole[:-1]}
    (file if after == "its place" else new).write_bytes(parts.get(after, whole))
    third = recalled_state(recall(file), "third", NOW, 0).lease.epoch + 1
    assert third > used
    assert (third > 2 * EPOCH_BLOCK) == (after == "its place")
    fourth = recalled_state(recall(file), "fourth", NOW, 0).lease.epoch + 1
    assert fourth > third


def test_an_epoch_is_on_disk_before_the_first_of_its_block_can_be_used(tmp_path: Path):
    file = tmp_path / "car.json"
    for _ in range(3):
        first = recalled_state(recall(file), "boot", NOW, 0).lease.epoch
        on_disk = msgspec.json.decode(file.read_bytes(), type=Remembered).epoch_reserved
        assert on_disk == first + EPOCH_BLOCK, "the block ends before or after what was reserved"
        assert not list(tmp_path.glob("*.new"))


def test_a_disk_that_is_read_only_is_told_at_start_and_nothing_is_granted():
    """A real one that takes no file, whoever asks: not even root may write there."""
    with pytest.raises(ConfigurationError, match=r"cannot be used: .*\[vehicle_gateway\] memory"):
        recall(Path("/proc/remote-operation-tower/car.json"))


def test_a_disk_that_fails_while_driving_is_counted_and_the_gateway_goes_on(tmp_path: Path):
    (tmp_path / "gone").write_bytes(b"")
    with Memory(tmp_path / "gone" / "car.json") as memory:
        memory.keep(Remembered(stop_latched=True))
    assert memory.failed >= 1


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=20, deadline=None)
@given(
    epoch=st.integers(0, 10**9),
    emergency=st.booleans(),
    stopped=st.booleans(),
    engaged=st.booleans(),
    stops=st.lists(st.integers(0, 10**18), max_size=3),
)
def test_whatever_is_remembered_comes_back(tmp_path: Path, epoch, emergency, stopped, engaged, stops):
    known = Remembered(
        epoch_reserved=epoch, emergency_latched=emergency, stop_latched=stopped, engaged=engaged, stops_utc_ns=tuple(stops)
    )
    write(tmp_path / "car.json", known)
    assert recall(tmp_path / "car.json") == known


def restarted(mode: Mode, **fields: object):
    """The state of the gateway that follows one that died in this mode."""
    state = initial_state("first", NOW, 100, False)
    state = replace(state, authority=replace(state.authority, mode=mode, origin=mode), **fields)
    return recalled_state(remember(state, 1_000_100, UTC), "second", NOW // 2, UTC + NOW // 2)


def test_a_restarted_gateway_drives_for_nobody_and_keeps_its_latches():
    kept = {mode: restarted(mode).authority.mode for mode in Mode}
    drives = (
        Mode.STANDBY,
        Mode.AUTONOMOUS,
        Mode.TAKEOVER_REQUESTED,
        Mode.HANDING_OVER,
        Mode.REMOTE,
        Mode.HANDING_BACK,
        Mode.LOCAL_DRIVER,
    )
    assert {kept[mode] for mode in drives} == {Mode.STANDBY}
    assert kept[Mode.EMERGENCY_STOP] is Mode.EMERGENCY_STOP
    assert {kept[Mode.SAFE_STOP], kept[Mode.STOPPED]} <= {Mode.STOPPED, Mode.SAFE_STOP}


def test_epochs_go_on_above_everything_reserved_before_the_restart():
    assert restarted(Mode.REMOTE).lease.epoch >= 1_000_100
    assert restarted(Mode.REMOTE).lease.holder == ""


def test_recent_stops_keep_their_age_over_a_restart():
    """600 s of the ten minutes are counted in real time: the restarted clock begins elsewhere."""
    stops = restarted(Mode.STOPPED, stops=(NOW - 60 * 10**9,)).stops
    assert NOW // 2 - stops[0] == 60 * 10**9


def test_a_stop_pressed_in_the_tower_is_still_pressed_after_a_restart():
    """Architecture: latches survive restarts; a STOP is cleared by a question that asks for it, not by a crash."""
    assert restarted(Mode.STOPPED, stop_pressed=True, stop_number=3).stop_pressed
