"""`recordings audit`: the numbered drives of a trail, from a recording and from the car's own file; exit codes; JSON."""

import json
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace
from typer.testing import CliRunner

from recordings.audit.drives import Counted, remote_drives
from recordings.program import app
from wire.audit_chain import Chain, follow
from wire.authority import issue, new_authority
from wire.messages.audit import AuditEntry, AuditKind, MapPosition
from wire.messages.base import encode
from wire.messages.vehicle import Mode
from wire.topics import Role

K = AuditKind
AUTHORITY = new_authority()
HUB = issue(Role.VEHICLE_HUB, (), AUTHORITY)
NOW_NS = round(datetime.now(UTC).timestamp()) * 10**9
HERE = MapPosition(x_m=12.5, y_m=-3.0, heading_rad=0.0, deviation_m=0.1, age_s=0.1)


def entry(kind: AuditKind, at_s: float, drive: int, remote: bool = True, **changes: object) -> AuditEntry:
    plain = AuditEntry(
        number=1,
        previous="0" * 64,
        kind=kind,
        stamp_ns=round(at_s * 1e9),
        utc_ns=NOW_NS + round(at_s * 1e9),
        boot_id="boot",
        vehicle_id="car-1",
        mode=Mode.REMOTE,
        drive=drive,
        remote=remote,
        operator="ann",
        signer_pem=HUB.certificate_pem.decode() if kind is K.HEAD else "",
    )
    return replace(plain, **changes)


STORY = (
    entry(K.START, 0, 0, remote=False, software="ours 1.0", configuration_sha256="ab" * 32),
    entry(K.HEAD, 0, 0, remote=False),
    entry(K.INTERVENTION, 0.5, 0, remote=False, subject="jerk"),  # of the automation, before the drive
    entry(K.DRIVE_BEGIN, 1, 1, text="ann took over", position=HERE),
    entry(K.INTERVENTION, 2, 1, subject="speed cap"),
    entry(K.INTERVENTION_END, 2, 1, subject="jerk", times=100, lasted_s=1.0),
    entry(K.INTERVENTION_END, 3, 1, subject="speed cap", times=40, lasted_s=0.4),
    entry(K.INTERVENTION, 4, 1, subject="speed cap"),
    entry(K.STOP, 5, 1),
    entry(K.FAILSAFE, 5.5, 1, subject="command_lost"),
    entry(K.DRIVE_END, 6, 1, remote=False, text="no valid command", position=HERE),
    entry(K.HEAD, 6, 1, remote=False),
    entry(K.INTERVENTION_END, 7, 1, remote=False, subject="speed cap", times=60, lasted_s=0.6),
    entry(K.INTERVENTION, 8, 1, remote=False, subject="jerk"),  # of the safe stop, after it
    entry(K.DRIVE_BEGIN, 9, 2, operator="bob"),
    entry(K.HEAD, 10, 2, operator="bob"),
)


def lines(entries: tuple[AuditEntry, ...] = STORY) -> list[bytes]:
    stands, made = Chain(), list[bytes]()
    for each in entries:
        stands, record = follow(stands, each, HUB.key)
        made.append(encode(record))
    return made


@pytest.fixture
def authority(tmp_path: Path) -> Path:
    (tmp_path / "authority.pem").write_bytes(AUTHORITY.certificate_pem)
    return tmp_path / "authority.pem"


@pytest.fixture
def trail(tmp_path: Path) -> Path:
    (tmp_path / "car.audit.jsonl").write_bytes(b"".join(line + b"\n" for line in lines()))
    return tmp_path / "car.audit.jsonl"


def run(*arguments: object) -> Any:
    return CliRunner(env={"COLUMNS": "200"}).invoke(app, ["audit", *(str(argument) for argument in arguments)])


def test_drives_are_numbered_with_begin_end_operator_and_what_intervened_in_them_alone():
    first, second = remote_drives(STORY)
    assert (first.number, first.operator, first.duration_s, first.end_cause) == (1, "ann", 5.0, "no valid command")
    assert first.interventions == {"speed cap": Counted(episodes=2, cycles=100, seconds=1.0)}
    assert first.failsafes == {"command_lost": Counted(episodes=1)}
    assert (first.stops, first.begin_at, first.end_at) == (1, HERE, HERE)
    assert (second.number, second.operator, second.duration_s, second.end_utc_ns) == (2, "bob", None, None)


def test_a_trail_that_begins_in_the_middle_of_a_drive_knows_its_number_and_not_its_begin():
    (drive,) = remote_drives(STORY[4:12])
    assert (drive.number, drive.begin_utc_ns, drive.duration_s) == (1, None, None)


def test_a_file_of_the_car_is_verified_and_its_drives_are_listed(trail: Path, authority: Path):
    result = run(trail, "--authority", authority)
    assert result.exit_code == 0, result.output
    for words in (
        "16 records, 1 to 16, of car-1",
        "chain whole",
        "signed up to record 16",
        "ours 1.0",
        "no valid command",
        "5.0 s",
    ):
        assert words in result.stdout
    assert "map x 12.5 y -3.0 m" in result.stdout
    assert "stolen key" in result.stdout and "cut off behind the last signed head" in " ".join(result.stdout.split())


def test_a_recording_is_verified_like_the_file(recorded: Callable[..., Path], authority: Path):
    path = recorded([("audit", line, number) for number, line in enumerate(lines())])
    report = json.loads(run(path, "--authority", authority, "--json").stdout)
    assert report["verdict"]["problems"] == [] and report["verdict"]["signed_to"] == 16
    assert [drive["number"] for drive in report["drives"]] == [1, 2]


def test_a_changed_record_is_named_and_the_exit_code_is_1(trail: Path, authority: Path):
    trail.write_bytes(trail.read_bytes().replace(b"no valid command", b"ann parked it   "))
    result = run(trail, "--authority", authority)
    assert result.exit_code == 1
    assert "record 11 (line 11) was changed" in result.stdout


def test_another_authority_is_a_problem_of_every_head(trail: Path, tmp_path: Path):
    other = tmp_path / "other.pem"
    other.write_bytes(new_authority().certificate_pem)
    result = run(trail, "--authority", other)
    assert result.exit_code == 1
    assert result.stdout.count("another authority issued") == 3 and "no good signature" in result.stdout


def test_what_can_be_fixed_is_one_line_and_exit_code_2(recorded: Callable[..., Path], build: Any, tmp_path: Path, trail: Path):
    for arguments, words in (
        ((tmp_path / "none",), "name a recording"),
        ((recorded(build.imu_rows(2)),), "no audit records in it"),
        ((trail, "--authority", tmp_path / "none.pem"), "--authority FILE"),
        ((trail, "--authority", trail), "--authority FILE"),
    ):
        result = run(*arguments)
        assert (result.exit_code, result.stdout) == (2, "")
        assert words in result.stderr and len(result.stderr.splitlines()) == 1
