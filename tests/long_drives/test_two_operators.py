"""A second tower beside the one that drives, real programs and real pictures: it looks on, and then its operator takes over.

Both operators are scripted, and keen: the first one takes the car and keeps it, passes it on when a supervisor names the second,
and he takes it when he is named. Two windows and two cockpits on one machine: the pictures are small and few.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import tomli_w

from benchmarks.rig import driving, with_lighter_pictures
from recordings.check import check, installed_replays
from recordings.read import open_recording
from tower.demo.crew import TOWER, crew
from wire.configuration import read_tables
from wire.messages.audit import AuditEntry, AuditKind
from wire.messages.base import decoder
from wire.messages.vehicle import Mode
from wire.ports import free_udp_ports

decode_entry = decoder(AuditEntry).decode
FIRST, SECOND = "demo", "ben"
DRIVE_S = 150.0
pytestmark = pytest.mark.long


def first_tower(folder: Path) -> Path:
    """The configuration of the car and its first tower."""
    tables = read_tables(with_lighter_pictures(folder))
    tables["tower"]["cockpit"].setdefault("scripted", {})["keen"] = True
    written = folder / "first.toml"
    written.write_bytes(tomli_w.dumps(tables).encode())
    return written


def second_tower(first: Path) -> Path:
    """The configuration of another tower for the car of a running session."""
    tables, folder = read_tables(first / "session.toml"), first / "second"
    folder.mkdir()
    (port,) = free_udp_ports(1)
    tables["wire"]["link"]["tower_hub"] = f"127.0.0.1:{port}"
    tables["wire"]["session"].update(folder=str(folder), name=folder.name)
    tables["tower"]["cockpit"]["operator"] = SECOND
    config = folder / "session.toml"
    config.write_bytes(tomli_w.dumps(tables).encode())
    return config


def held_by(drive, operator):
    return drive.observer.status is not None and drive.observer.status.lease_holder == operator


def supervise(config, *arguments):
    program = Path(sys.executable).parent / "tower"
    done = subprocess.run(
        [program, "supervise", *arguments, "--config", config], capture_output=True, text=True, timeout=30.0, check=False
    )
    return done.returncode, done.stdout + done.stderr


def test_the_next_operator_takes_over_from_the_one_who_drives_and_brings_the_car_to_its_goal(tmp_path):
    with driving(tmp_path, "--scenario", "short", "--config", str(first_tower(tmp_path))) as drive:
        session = drive.folder / "session.toml"
        vehicle = read_tables(session)["wire"]["link"]["vehicle_id"]
        config = second_tower(drive.folder)
        drive.wait_until("the first operator has the car", lambda: held_by(drive, FIRST), DRIVE_S)
        with crew(TOWER, config, config.parent):  # they start while nobody drives: it takes both cores
            drive.wait_until("the first operator drives", lambda: drive.mode is Mode.REMOTE, DRIVE_S)
            assert held_by(drive, FIRST)
            code, said = supervise(session, "revoke", vehicle, "--to", SECOND, "--reason", "end of her shift")
            assert code == 0, said
            drive.wait_until("the second one has the car", lambda: held_by(drive, SECOND), 30.0)
            assert drive.mode is Mode.REMOTE
            code = drive.wait(DRIVE_S)
    summary = json.loads((drive.folder / "summary.json").read_text())
    assert (code, summary["goal_reached"], summary["collisions"]) == (0, True, 0), drive.said()
    assert "safe_stop" not in summary["modes_s"], drive.said()
    with open_recording(drive.folder / "drive.mcap") as recording:
        assert [
            line for tally in check(recording, installed_replays()) for line in tally.mismatches if tally.kind == "gateway cycle"
        ] == []
        entries = [decode_entry(record.entry) for _, record in recording.messages("audit")]
        drives = [
            (entry.kind, entry.drive, entry.operator)
            for entry in entries
            if entry.kind in (AuditKind.DRIVE_BEGIN, AuditKind.DRIVE_END)
        ]
        statuses = [status for _, status in recording.messages("gateway_status")]
    assert drives == [  # the second one keeps the car: his drive ends with the gateway, after the recorder
        (AuditKind.DRIVE_BEGIN, 1, FIRST),
        (AuditKind.DRIVE_END, 1, FIRST),
        (AuditKind.DRIVE_BEGIN, 2, SECOND),
    ]
    named = [status for status in statuses if status.succession.operator == SECOND]
    assert {status.lease_holder for status in named} == {FIRST} and any(status.succession.agreed for status in named)
