"""`vehicle-gateway status`: what is told of what was heard, and the command beside a real gateway with a real bus and link."""

import json
import os
import socket
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from tests.messages import gateway_status
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.codec import FOLLOWING
from vehicle_gateway.can.ecu_codec import Controls, Motion, encode_controls, encode_drive_state, encode_motion
from vehicle_gateway.can.health_codec import SHIPPED
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.status import Heard, rows_of, status_from
from wire import certificates
from wire.clock import Clock
from wire.configuration import shipped
from wire.messages.base import Gear, decoder, encode
from wire.messages.health import LoopHealth
from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import Actuation, HandOver, Mode, Succession, VehicleState
from wire.ports import free_udp_ports

MS, SECOND = 1_000_000, 1_000_000_000
NOW = 100 * SECOND
GATEWAY = [sys.executable, "-c", "from vehicle_gateway.program import main; main()"]


def loop(process: str, name: str = "cycle", cycles: int = 1000, late: int = 2, worst_ms: float = 3.0) -> LoopHealth:
    return LoopHealth(
        stamp_ns=NOW,
        process=process,
        loop=name,
        period_ms=10.0,
        cycles=cycles,
        late_cycles=late,
        lateness_p50_ms=0.1,
        lateness_max_ms=worst_ms,
        scheduling="fifo 10",
        dropped={},
    )


def camera(name: str, age_ms: int, live: bool = True, watching: int = 1) -> CameraStatus:
    return CameraStatus(
        stamp_ns=NOW,
        camera=name,
        source="v4l2",
        live=live,
        newest_capture_ns=NOW - age_ms * MS if age_ms >= 0 else 0,
        frames=9,
        repeated=0,
        bitrate_kbps=4000.0,
        encode_ms=5.0,
        watching=watching,
    )


STATUS = gateway_status(
    stamp_ns=NOW,
    mode=Mode.REMOTE,
    mode_since_ns=NOW - 12 * SECOND,
    cause="anna took over",
    lease_holder="anna",
    lease_epoch=7,
    hand_over=HandOver(number=1, action="take", state="committed", rule=""),
    stops_in_ten_minutes=1,
    dropped={"command epoch": 3},
)
STATE = VehicleState(
    stamp_ns=NOW,
    boot_id="b",
    sequence=1,
    speed_m_s=5.0,
    acceleration_m_s2=0.0,
    yaw_rate_rad_s=0.0,
    road_wheel_angle_rad=0.0,
    gear=Gear.DRIVE,
    requested=Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0),
    applied=Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0),
    rules=(),
    speed_cap_m_s=8.33,
    loop_age_ms=121.0,
    command_age_ms=9.0,
    feedback_age_ms=4.0,
)
ALL = tuple(loop(name) for name in ("vehicle-gateway run", "vehicle-gateway video", "recordings record", "tower cockpit"))
HEARD = Heard(vehicle_id="car-1", now_ns=NOW, status=STATUS, state=STATE, cameras=(camera("front", 40),), health=ALL)


def bad_rows(heard: Heard) -> set[str]:
    return {name for name, _, is_well in rows_of(status_from(heard)) if not is_well}


def test_everything_at_work_is_told_with_its_figures():
    told = status_from(HEARD)
    assert (told.mode, told.mode_s, told.lease_holder, told.silent) == ("remote", 12.0, "anna", ())
    assert (told.can_feedback_age_ms, told.loop_age_ms, told.tower_heard, told.recording) == (4.0, 121.0, True, True)
    assert told.cameras["front"].picture_age_ms == pytest.approx(40.0)
    assert told.loops["vehicle-gateway run/cycle"].late_share == pytest.approx(0.002)
    assert bad_rows(HEARD) == set()
    text = {name: words for name, words, _ in rows_of(told)}
    assert text["speed"] == "18.0 km/h, at most 30"
    assert text["dropped"] == "command epoch 3"
    standing = replace(HEARD, state=msgspec.structs.replace(STATE, speed_m_s=0.0, speed_cap_m_s=100.0))
    assert ("speed", "0.0 km/h, no bound now", True) in rows_of(status_from(standing))


def test_the_lease_is_told_with_whose_certificate_holds_it_and_is_not_well_in_its_last_day():
    def row(**changes: object) -> tuple[str, bool]:
        rows = rows_of(status_from(replace(HEARD, status=msgspec.structs.replace(STATUS, **changes))))
        return next((words, is_well) for name, words, is_well in rows if name == "lease")

    known = {"lease_certificate": "tower-hub.anna", "lease_fingerprint": "0123456789abcdef" * 4}
    words = "anna, epoch 7; certificate tower-hub.anna 0123456789abcdef"
    assert row(**known, certificate_left_s=90_000.0) == (f"{words}, ends in 25.0 h", True)
    assert row(**known, certificate_left_s=80_000.0) == (f"{words}, ends in 22.2 h", False)
    assert row() == ("anna, epoch 7", True)
    assert row(succession=Succession(operator="ben")) == ("anna, epoch 7; ben is next", True)
    assert row(lease_holder="", lease_note="carla took it") == ("nobody: carla took it", True)


def test_what_says_nothing_is_silent_and_never_guessed():
    alone = replace(HEARD, state=None, cameras=(), health=(loop("vehicle-gateway run"),))
    told = status_from(alone)
    assert told.silent == ("vehicle-gateway video", "recordings record")
    assert (told.speed_m_s, told.can_feedback_age_ms, told.tower_heard, told.recording) == (None, None, False, False)
    assert bad_rows(alone) == {"speed", "CAN", "link", "recorder", "silent"}


@pytest.mark.parametrize(
    ("heard", "rows"),
    [
        (replace(HEARD, status=msgspec.structs.replace(STATUS, failsafe="command_lost")), {"mode", "failsafe"}),
        (replace(HEARD, state=msgspec.structs.replace(STATE, feedback_age_ms=201.0)), {"CAN"}),
        (replace(HEARD, state=msgspec.structs.replace(STATE, feedback_age_ms=1e9)), {"CAN"}),
        (replace(HEARD, status=msgspec.structs.replace(STATUS, watchdog_silent_s=0.6)), {"watchdog"}),
        (replace(HEARD, status=msgspec.structs.replace(STATUS, watchdog_silent_s=0.02)), set()),
        (replace(HEARD, cameras=(camera("front", 1500, live=False),)), {"camera front"}),
        (replace(HEARD, cameras=(camera("front", 1), camera("rear", -1, live=False))), {"camera rear"}),
        (replace(HEARD, health=(*ALL, loop("autonomy run", "drive", worst_ms=11.0))), {"loop autonomy run/drive"}),
    ],
)
def test_what_is_not_as_it_should_be_stands_out(heard, rows):
    assert bad_rows(heard) == rows


def test_the_newest_report_of_a_loop_counts_and_a_loop_that_never_ran_has_no_share():
    told = status_from(replace(HEARD, health=(loop("a", cycles=5, late=5), loop("a", cycles=0, late=0))))
    assert told.loops["a/cycle"].cycles == 0 and told.loops["a/cycle"].late_share == 0.0


def test_the_answer_is_a_message_that_keeps_its_own_ranges():
    told = status_from(HEARD)
    assert decoder(type(told)).decode(encode(told)) == told


@pytest.fixture
def configuration(tmp_path: Path) -> tuple[Path, CanSettings]:
    certificates.ensure(tmp_path / "certificates")
    car_port, tower_port, can_port, actuator_port = free_udp_ports(4)
    can = CanSettings(port=can_port, actuator_port=actuator_port)
    text = shipped("simulated.toml").read_text(encoding="utf-8")
    text = text.replace(
        "[wire.link]",
        f'[wire.pace]\nfifo_priority = 0\n[wire.link]\ncertificates = "{tmp_path}/certificates"\n'
        f'car_hub = "127.0.0.1:{car_port}"\ntower_hub = "127.0.0.1:{tower_port}"',
    )
    text = text.replace("[vehicle_gateway]\n", f'[vehicle_gateway]\nmemory = "{tmp_path}/memory.json"\n')
    (tmp_path / "car.toml").write_text(f"{text}\n[vehicle_gateway.can]\nport = {can.port}\n", encoding="utf-8")
    return tmp_path / "car.toml", can


def status_of(config: Path, *options: str) -> subprocess.CompletedProcess[str]:
    command = [*GATEWAY, "status", "--config", str(config), *options]
    return subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)


def test_where_no_gateway_answers_it_is_one_line_that_names_the_fix(configuration):
    config, _ = configuration
    done = status_of(config, "--wait", "0.3", "--json")
    assert (done.returncode, done.stdout) == (1, "")
    (line,) = done.stderr.splitlines()
    assert line.startswith("no gateway of simulated-1 answers at 127.0.0.1:")
    assert f"start it: vehicle-gateway run --config {config}" in line


def drive_by_wire(can: CanSettings, stop: threading.Event) -> None:
    """Feedback of a car that stands, every 10 ms, and once in 200 ms the health of this very loop."""
    health, counter = loop("vehicle-gateway ecu", cycles=4321), 0
    with open_bus(can, "vehicle", lambda *_: None, Clock()) as bus:
        while not stop.wait(0.01):
            counter += 1
            bus.send(encode_drive_state(Gear.DRIVE, FOLLOWING, True, counter))
            bus.send(encode_controls(Controls(), counter))
            bus.send(encode_motion(Motion(0.0, 0.0, 0.0, 0.0), counter))
            for frame in SHIPPED.encode(health, counter // 20) if counter % 20 == 0 else ():
                bus.send(frame)


def test_a_real_gateway_is_seen_by_status_by_the_service_manager_and_in_its_log(configuration, tmp_path):
    config, can = configuration
    stop = threading.Event()
    ecu = threading.Thread(target=drive_by_wire, args=(can, stop))
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager, (tmp_path / "log").open("wb") as log:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(30.0)
        gateway = subprocess.Popen(
            [*GATEWAY, "--log-format", "json", "run", "--config", str(config)],
            stderr=log,
            env={**os.environ, "NOTIFY_SOCKET": str(tmp_path / "notify")},
        )
        try:
            ecu.start()
            assert manager.recv(4096) == b"READY=1\nWATCHDOG=1"
            for _ in range(5):  # every loop tells its health once a second, which a busy machine may stretch
                done = status_of(config, "--json", "--wait", "20")
                if done.returncode or "vehicle-gateway ecu" in done.stdout:
                    break
            assert manager.recv(4096) == b"READY=1\nWATCHDOG=1", "every second anew"
            gateway.terminate()
            assert gateway.wait(20.0) == 0
            while (last := manager.recv(4096)) != b"STOPPING=1":
                assert last == b"READY=1\nWATCHDOG=1"
        finally:
            stop.set()
            ecu.join()
            gateway.kill()
            gateway.wait()
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert (told["mode"], told["lease_holder"], told["tower_heard"]) == ("standby", "", False)
    assert told["watchdog_silent_s"] > 0.5, "there is none beside it"
    assert told["can_feedback_age_ms"] < 1000.0
    assert told["loops"]["vehicle-gateway ecu/cycle"]["cycles"] == 4321, "from CAN through the gateway"
    assert told["loops"]["vehicle-gateway run/cycle"]["cycles"] > 10
    assert set(told["silent"]) == {"vehicle-gateway video", "recordings record"}
    (started, *_) = [json.loads(line) for line in (tmp_path / "log").read_text().splitlines()]
    assert (started["process"], started["level"], started["event"]) == ("vehicle-gateway run", "info", "started")
    assert started["vehicle"] == "simulated-1"
