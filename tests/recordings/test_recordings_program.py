"""The program as its user sees it: exit codes, one clear line, and JSON that is nothing but JSON."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from recordings.program import app, summary_path


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_info_as_json_is_the_summary_with_its_promised_keys(recorded: Callable[..., Path], build: Any) -> None:
    result = run("info", recorded(build.imu_rows(3)), "--json")
    assert result.exit_code == 0
    assert set(json.loads(result.stdout)) == {
        "recording",
        "versions",
        "drive_s",
        "distance_m",
        "modes_s",
        "takeovers",
        "collisions",
        "goal_reached",
        "gate_interventions",
        "loop_age_ms",
        "motion_to_motion_ms",
        "cameras",
        "command_rate_hz",
        "wheel_to_can_ms",
        "messages_dropped",
        "loops",
        "load",
    }
    assert json.loads(result.stdout)["recording"]["topics"] == {"imu": 3}


def test_info_for_people_names_the_channels(recorded: Callable[..., Path], build: Any) -> None:
    result = run("info", recorded(build.imu_rows(201)))
    assert result.exit_code == 0
    assert "201 messages on 1 channels" in result.stdout and "100.5 Hz" in result.stdout


def test_a_truncated_recording_is_one_line_and_exit_code_2_until_it_is_recovered(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded(build.imu_rows(10), flush_every=5)
    path.write_bytes(path.read_bytes()[:-40])
    result = run("info", path)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == f"{path}: truncated, its recorder did not finish it; run: recordings recover {path}\n"
    recovered = run("recover", path)
    assert recovered.exit_code == 0
    assert f"{path.with_suffix('')}.recovered.mcap: 10 messages saved" in recovered.stdout
    assert run("info", f"{path.with_suffix('')}.recovered.mcap").exit_code == 0


def test_a_whole_recording_is_said_to_be_whole_and_left_alone(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded(build.imu_rows(10))
    result = run("recover", path)
    assert (result.exit_code, result.stdout) == (0, f"{path}: whole, 10 messages\n")
    assert list(path.parent.iterdir()) == [path]


def test_parts_are_joined_into_the_file_that_is_asked_for(recorded: Callable[..., Path], build: Any, tmp_path: Path) -> None:
    parts = [recorded(build.imu_rows(3)), recorded(build.imu_rows(4, start_ns=10**9))]
    result = run("recover", *parts, "--output", tmp_path / "joined.mcap")
    assert (result.exit_code, result.stdout.splitlines()[-1]) == (0, f"{tmp_path / 'joined.mcap'}: 7 messages saved")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[recordings]\nflush_period_ms = 500\n", "recordings.flush_period_ms"),
        ("[recordings]\nflush = 1\n", "allowed keys: flush_period_ms, queue_limit"),
        ('[wire.session]\nfolder = "/dev/null/sessions"\n', "choose another folder with [wire.session] folder"),
    ],
)
def test_a_wrong_configuration_is_one_line_and_exit_code_2(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "wrong.toml").write_text(text)
    result = run("record", "--config", tmp_path / "wrong.toml")
    assert result.exit_code == 2
    assert says in result.stderr and result.stderr.count("\n") == 1


def test_the_summary_stands_beside_its_recording() -> None:
    assert summary_path(Path("a/drive.mcap")) == Path("a/summary.json")
    assert summary_path(Path("a/drive-2.mcap")) == Path("a/summary-2.json")


def test_a_session_s_configuration_names_its_recording_and_with_neither_the_fix_is_told(
    recorded: Callable[..., Path], build: Any, tmp_path: Path
) -> None:
    recording = recorded(build.imu_rows(3))
    folder = tmp_path / "session"
    folder.mkdir()
    (folder / "drive.mcap").write_bytes(recording.read_bytes())
    config = folder / "session.toml"
    config.write_text(f'[wire.session]\nfolder = "{folder}"\n')
    assert json.loads(run("info", "--json", "--config", config).stdout)["recording"]["messages"] == 3
    assert run("recover", "--config", config).exit_code == 0
    nothing = run("info")
    assert nothing.exit_code == 2
    assert "--config" in nothing.stderr
