"""A whole drive between two machines: the car and its cameras here, the tower there, the cable between them, a clock an hour off.

The tower dies in the middle of the remote drive: the car stands within the bound that is computed beforehand. It comes back,
takes a new lease and drives on. Real processes in two network namespaces; `make drives`.
"""

import json
import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from benchmarks.fault_bounds import stops
from benchmarks.rig import read_referee
from benchmarks.two_machines import CAR_ADDRESS, VEHICLE, Listener, Sites, missing, two_machines
from recordings.read import open_recording
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode

pytestmark = [pytest.mark.long, pytest.mark.skipif(bool(missing()), reason=missing())]
PLACE = f"{CAR_ADDRESS}:7450"
SPEED_MIN_M_S = 2.5
DRIVEN_NS = 1_000_000_000  # the operator has had the car for so long
STANDSTILL_M_S = 0.05
MOVED_M = 1.0  # driven by the operator who is back
CAR = (
    ("simulate", "vehicle-gateway", "simulate"),
    ("ecu", "vehicle-gateway", "ecu"),
    ("gateway", "vehicle-gateway", "run", "--listen", PLACE),
    ("recorder", "recordings", "record"),
    ("video", "vehicle-gateway", "video"),
    ("autonomy", "autonomy", "run"),
)


Hurt = Callable[[Sites, Callable[[], None]], None]


@pytest.fixture
def sites(tmp_path: Path) -> Iterator[Sites]:
    with two_machines(tmp_path) as sites:
        for name, program, *arguments in CAR:
            sites.car.start(name, program, *arguments)
        yield sites


def start_tower(sites: Sites) -> None:
    sites.tower.start("drive", "tower", "drive", "--vehicle", VEHICLE, "--connect", PLACE)


def drives_remotely(sites: Sites, heard: Listener) -> bool:
    status, log = heard.newest.get("gateway_status"), read_referee(sites.car.folder)
    if status is None or status["mode"] != Mode.REMOTE or not log:
        return False
    return status["stamp_ns"] - status["mode_since_ns"] > DRIVEN_NS and log[-1].speed_m_s > SPEED_MIN_M_S


def kill_and_start_again(sites: Sites, stood: Callable[[], None]) -> None:
    """All of the tower at once: nobody says goodbye."""
    newest = max((sites.tower.folder / "sessions").glob("*/processes.json"))
    for pid in json.loads(newest.read_text()).values():
        os.kill(pid, signal.SIGKILL)
    sites.tower.running["drive"].kill()
    stood()
    start_tower(sites)


def pull_and_plug(sites: Sites, stood: Callable[[], None]) -> None:
    """The cable between the two: nothing is started again."""
    programs = [*sites.car.running.values(), *sites.tower.running.values()]
    sites.tower.pull()
    stood()
    sites.tower.plug()
    assert all(program.process.poll() is None for program in programs)


@pytest.mark.parametrize("hurt", [kill_and_start_again, pull_and_plug], ids=["tower-killed", "cable-pulled"])
def test_without_its_tower_the_car_stands_within_the_bound_and_with_it_the_drive_goes_on(sites: Sites, hurt: Hurt):
    bound = stops(Mode.REMOTE, "cockpit")
    assert bound is not None
    with Listener(sites.car, "gateway_status", "drive_command") as heard:
        start_tower(sites)
        heard.wait_until("the operator drives at speed", lambda: drives_remotely(sites, heard), 90.0)
        before, epoch = read_referee(sites.car.folder)[-1], heard.newest["gateway_status"]["lease_epoch"]

        def later() -> list[Referee]:
            return [each for each in read_referee(sites.car.folder) if each.stamp_ns > before.stamp_ns]

        def stood() -> None:
            heard.wait_until("safe stop", lambda: Mode.SAFE_STOP in heard.modes, 5.0)
            heard.wait_until("standstill", lambda: any(abs(each.speed_m_s) < STANDSTILL_M_S for each in later()), 10.0)
            stand = next(each for each in later() if abs(each.speed_m_s) < STANDSTILL_M_S)
            assert stand.distance_m - before.distance_m <= bound.bound_m(before.speed_m_s)

        hurt(sites, stood)
        stand_m = read_referee(sites.car.folder)[-1].distance_m
        heard.wait_until("a new epoch", lambda: heard.newest["gateway_status"]["lease_epoch"] > epoch, 30.0)
        heard.wait_until("the operator drives again", lambda: later()[-1].distance_m > stand_m + MOVED_M, 40.0)
        command = heard.newest["drive_command"]
        assert command["lease_epoch"] > epoch
        assert command["sent_ns"] - command["echoed_vehicle_ns"] > 3000e9, "the tower's clock is an hour ahead"
    assert read_referee(sites.car.folder)[-1].collisions == 0
    sites.tower.end_all()
    sites.car.end_all()
    check_recording(sites.car.folder / "drive.mcap")


def check_recording(file: Path) -> None:
    """It is whole, and tells the story: remote, stopped, remote again, with pictures."""
    with open_recording(file) as recording:
        modes = [status.mode for _, status in recording.messages("gateway_status")]
        pictures = sum(1 for _ in recording.pictures("front"))
    assert Mode.REMOTE in modes[: modes.index(Mode.SAFE_STOP)]
    assert Mode.REMOTE in modes[modes.index(Mode.SAFE_STOP) :]
    assert pictures > 100
