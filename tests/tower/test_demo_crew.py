import signal
import threading
import time
from pathlib import Path

import pytest

from tower.demo.crew import CAR, TOWER, Crew, Member, compile_first, core_of, crew, usable_cores, utc_folder
from tower.demo.session import choose, write_session
from wire.configuration import ConfigurationError, shipped


@pytest.fixture
def config(tmp_path):
    tables = choose(shipped("simulated.toml"), "", "")
    tables["wire"]["link"]["certificates"] = str(tmp_path / "certificates")
    (tmp_path / "session").mkdir()
    return write_session(tables, tmp_path / "session")


def wait_for_end(people: Crew):
    until = time.monotonic() + 20.0
    while time.monotonic() < until:
        ended = people.look_after()
        if ended:
            return ended[0]
    raise AssertionError("nothing ended")


def test_a_killed_process_is_started_again_and_told(config):
    with crew((Member("ecu", "vehicle-gateway", "ecu"),), config, config.parent) as people:
        before = people._processes["ecu"].pid
        people._processes["ecu"].send_signal(signal.SIGKILL)
        ended = wait_for_end(people)
        assert (ended.name, ended.how, ended.started_again) == ("ecu", "killed by SIGKILL", True)
        assert people._processes["ecu"].pid != before
        process = people._processes["ecu"]
    assert process.poll() is not None, "leaving the crew ends its processes"


@pytest.mark.parametrize(
    ("usable", "gateway", "window", "video"), [([2, 5], "2", "5", ""), ([0], "", "", ""), ([0, 1, 2], "", "", ""), ([], "", "", "")]
)
def test_of_two_cores_the_loops_of_the_car_have_one_and_the_operators_programs_the_other(usable, gateway, window, video):
    members = {member.name: member for member in (*CAR, *TOWER)}
    assert [core_of(members[name], usable) for name in ("gateway", "window", "video")] == [gateway, window, video]


@pytest.mark.skipif(len(usable_cores()) != 2, reason="needs two cores")
@pytest.mark.parametrize("core", [0, 1, None])
def test_a_program_keeps_to_its_core(core, config):
    script = config.parent / "cores.py"
    script.write_text("import os; print(sorted(os.sched_getaffinity(0)))")
    with crew((Member("cores", "python", str(script), restarts=False, core=core),), config, config.parent) as people:
        wait_for_end(people)
    told = (config.parent / "logs" / "cores.log").read_text()
    assert told == f"{usable_cores() if core is None else [usable_cores()[core]]}\n"


def test_an_error_the_user_can_fix_is_told_in_its_own_words_and_not_tried_again(config):
    config.write_text("[autonomyy]\n")
    with crew((Member("autonomy", "autonomy", "run"),), config, config.parent) as people:
        ended = wait_for_end(people)
    assert not ended.started_again
    assert "[autonomyy]: unknown section" in ended.how


def test_a_window_that_was_closed_is_not_started_again_whatever_its_log_said_last(config):
    script = config.parent / "closed.py"
    script.write_text("print('no video session: the car did not answer')")
    with crew((Member("window", "python", str(script)),), config, config.parent) as people:
        ended = wait_for_end(people)
    assert (ended.how, ended.started_again) == ("exit 0", False)


def test_kernels_are_compiled_before_anybody_drives(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    compile_first(threading.Event())  # not installed: the crew says so
    (tmp_path / "autonomy").write_text(f"#!/bin/sh\nsleep 0.2\necho $1 > {tmp_path}/told\n")
    (tmp_path / "autonomy").chmod(0o755)
    compile_first(threading.Event())
    assert (tmp_path / "told").read_text() == "compile\n"


def test_who_stops_the_demo_need_not_wait_for_the_compiler(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    (tmp_path / "autonomy").write_text("#!/bin/sh\nexec sleep 60\n")
    (tmp_path / "autonomy").chmod(0o755)
    stop, begin_s = threading.Event(), time.monotonic()
    stop.set()
    compile_first(stop)
    assert time.monotonic() - begin_s < 30.0


def test_a_folder_that_cannot_be_written_is_one_clear_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ConfigurationError, match="cannot be written"):
        utc_folder(tmp_path / "file")


def test_two_sessions_in_one_second_get_two_folders(tmp_path):
    first, second = utc_folder(tmp_path), utc_folder(tmp_path)
    assert first != second
    assert isinstance(first, Path)
