import signal
import time

import pytest

from tower.demo.crew import Member, crew
from tower.demo.demo import (
    PASSED,
    SILENT_S,
    START_PATIENCE_S,
    could_not_keep_up,
    failed,
    late,
    missing_files,
    out_of_time,
    over,
    with_slow_machine,
)
from tower.demo.session import choose, write_session
from tower.demo.story import Story
from wire.configuration import ConfigurationError, shipped
from wire.messages.vehicle import Mode
from wire.scenario import read_scenario

SCENARIO, _ = read_scenario(shipped("scenarios", "closed_road.toml"))
LIMIT_S = SCENARIO.time_limit_s


def test_a_drive_goes_on_until_something_ends_it():
    assert over(Story(elapsed_s=LIMIT_S), SCENARIO, refuses=False) is None
    assert over(Story(elapsed_s=LIMIT_S + 0.1), SCENARIO, refuses=False) == out_of_time(LIMIT_S)
    assert over(Story(goal_reached=True), SCENARIO, refuses=False) == PASSED
    collided = over(Story(goal_reached=True, collisions=1), SCENARIO, refuses=False)
    assert collided.code == 1 and not collided.ran_out_of_time, "never driven once more"


def test_with_a_file_as_camera_a_refused_hand_over_is_what_the_demo_shows():
    stood = Story(elapsed_s=30.0, stopped_since_s=20.0, mode=Mode.STOPPED, refused="camera front plays a file")
    assert over(stood, SCENARIO, refuses=True) == PASSED
    stood.was_remote = True
    assert over(stood, SCENARIO, refuses=True).code == 1
    assert over(Story(goal_reached=True, was_remote=True), SCENARIO, refuses=True).code == 1


@pytest.mark.parametrize(
    ("started", "running_s", "silent_s", "ends"),
    [
        (False, START_PATIENCE_S - 1, 0.0, False),
        (False, START_PATIENCE_S + 1, 0.0, True),
        (True, 10.0, SILENT_S - 1, False),
        (True, 10.0, SILENT_S + 1, True),
        (True, LIMIT_S + SILENT_S - 1, 0.0, False),
        (True, LIMIT_S + SILENT_S + 1, 0.0, True),
    ],
)
def test_a_stopped_world_or_hub_never_holds_the_demo_for_ever(started, running_s, silent_s, ends):
    assert (late(started, running_s, silent_s, LIMIT_S) is not None) is ends


def test_a_good_drive_that_leaves_no_recording_or_no_picture_has_failed(tmp_path):
    assert "drive.mcap" in missing_files(PASSED, tmp_path, was_remote=False).text
    for name in ("drive.mcap", "summary.json"):
        (tmp_path / name).write_text("x")
    assert missing_files(PASSED, tmp_path, was_remote=False) == PASSED
    assert "window.png" in missing_files(PASSED, tmp_path, was_remote=True).text


def test_a_stopped_process_is_shown_and_that_it_goes_on_too(tmp_path):
    tables = choose(shipped("simulated.toml"), "", "")
    tables["wire"]["link"]["certificates"] = str(tmp_path / "certificates")
    config = write_session(tables, tmp_path)
    with crew((Member("ecu", "vehicle-gateway", "ecu"),), config, tmp_path) as people:
        for sent, said in ((signal.SIGSTOP, "ecu is stopped"), (signal.SIGCONT, "ecu goes on")):
            people._processes["ecu"].send_signal(sent)
            until, told = time.monotonic() + 10.0, []
            while not told and time.monotonic() < until:
                told = people.paused()
            assert told == [said]
    assert not (tmp_path / "processes.json").exists()


@pytest.mark.parametrize(
    "text",
    [
        "[wire]\nlink = 3\n",
        '[vehicle_gateway]\nsimulation = "x"\n',
        "[tower.cockpitt]\n",
        "[vehicle_gateway.simulation]\nscenario = 5\n",
    ],
)
def test_a_wrong_type_or_name_in_the_configuration_is_one_clear_error(tmp_path, text):
    config = tmp_path / "mine.toml"
    config.write_text(text)
    with pytest.raises(ConfigurationError):
        choose(config, "", "")


def test_a_drive_that_failed_on_a_machine_that_could_not_keep_up_says_so_with_what_to_do():
    slow, quick = {"cameras": {"front": {"halved_s": 3.0}}}, {"cameras": {"front": {"halved_s": 0.0}}}
    told = with_slow_machine(failed("the goal was not reached"), slow)
    assert told.code == 1 and "the goal was not reached; this machine could not keep up" in told.text and "--config" in told.text
    assert could_not_keep_up(slow)
    for summary in (quick, None):
        assert not could_not_keep_up(summary)
        assert with_slow_machine(failed("the goal was not reached"), summary) == failed("the goal was not reached")
    assert with_slow_machine(PASSED, slow) == PASSED
