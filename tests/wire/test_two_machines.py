"""The link between two machines with addresses of their own: found, told, lost and found again, with nothing restarted.

Real programs in two network namespaces; the tower's clock is an hour off. Needs root.
"""

from collections.abc import Iterator

import pytest

from benchmarks.two_machines import CAR_ADDRESS, TOWER_ADDRESS, VEHICLE, Listener, Sites, missing, two_machines

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())
PLACE = f"{CAR_ADDRESS}:7450"
PATIENCE_S = 40.0  # of a machine that does three other things beside; what has to be quick has its own bound


@pytest.fixture(scope="module")
def sites(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Sites]:
    with two_machines(tmp_path_factory.mktemp("two")) as sites:
        sites.car.start("gateway", "vehicle-gateway", "run", "--listen", PLACE)
        yield sites


@pytest.fixture(scope="module")
def heard(sites: Sites) -> Iterator[Listener]:
    with Listener(sites.car, "gateway_status", "drive_command") as listener:
        listener.wait_until("the gateway speaks", lambda: listener.mode == "standby", PATIENCE_S)
        yield listener


def holder(heard: Listener) -> tuple[str, int]:
    status = heard.newest["gateway_status"]
    return status["lease_holder"], status["lease_epoch"]


def commands_flow(heard: Listener) -> bool:
    """Whether commands arrive that the car takes: of the lease that it speaks of, answering this start of it."""
    status, command = heard.newest["gateway_status"], heard.newest.get("drive_command")
    if command is None or heard.silence_s("drive_command") > 0.2 or heard.silence_s("gateway_status") > 0.5:
        return False
    return (command["lease_epoch"], command["echoed_boot_id"]) == (status["lease_epoch"], status["boot_id"])


def silent(heard: Listener) -> bool:
    return heard.silence_s("drive_command") > 0.6


def test_the_tower_sees_the_car_s_state_over_the_network(sites: Sites, heard: Listener):
    told = sites.tower.ask("tower", "vehicles", "--vehicle", VEHICLE, "--connect", PLACE)
    assert told.returncode == 0, told.stderr
    assert told.stdout.split()[-4:] == ["standby", "0", "km/h", "nobody"]


def test_a_car_of_another_name_is_not_found_there(sites: Sites, heard: Listener):
    told = sites.tower.ask("tower", "vehicles", "--vehicle", "car-2", "--connect", PLACE, "--seconds", "1")
    assert told.returncode == 1
    assert "not there" in told.stdout


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (CAR_ADDRESS, "the port is missing"),
        (f"tcp/{PLACE}", "QUIC only"),
        (f"{CAR_ADDRESS}:0", "no port"),
        ("none.invalid:7450", "no host"),
    ],
)
def test_a_wrong_address_is_one_line_and_no_traceback(sites: Sites, place: str, words: str):
    told = sites.tower.ask("tower", "drive", "--connect", place)
    assert told.returncode == 2
    assert words in told.stderr
    assert len(told.stderr.strip().splitlines()) == 1


def test_a_tower_of_another_authority_is_told_so_and_what_to_do(sites: Sites, heard: Listener):
    strange = sites.tower.folder / "strange.toml"
    text = sites.tower.config.read_text()
    strange.write_text(text.replace(str(sites.tower.folder / "certificates"), str(sites.tower.folder / "strange")))
    config, sites.tower.config = sites.tower.config, strange
    try:
        told = sites.tower.ask("tower", "drive", "--vehicle", VEHICLE, "--connect", PLACE)
    finally:
        sites.tower.config = config
    assert told.returncode == 2
    assert "another authority" in told.stderr and "tower certificates export" in told.stderr


def test_a_killed_cockpit_comes_back_with_a_new_lease_and_a_pulled_cable_needs_no_restart(sites: Sites, heard: Listener):
    text = sites.tower.config.read_text()
    sites.tower.config.write_text(
        text.replace("[wire.link]", f'[wire.link]\nconnect = ["{PLACE}"]').replace('"simulated-1"', f'"{VEHICLE}"')
    )
    first = sites.tower.start("cockpit", "tower", "cockpit")
    heard.wait_until("commands flow", lambda: commands_flow(heard), PATIENCE_S)
    name, epoch = holder(heard)
    assert name == "demo"
    first.kill()
    heard.wait_until("silence", lambda: silent(heard), PATIENCE_S)
    second = sites.tower.start("cockpit", "tower", "cockpit")
    heard.wait_until("commands flow under a new lease", lambda: commands_flow(heard) and holder(heard)[1] > epoch, PATIENCE_S)

    sites.tower.pull()
    heard.wait_until("silence", lambda: silent(heard), PATIENCE_S)
    sites.tower.plug()
    heard.wait_until("commands flow again", lambda: commands_flow(heard), PATIENCE_S)
    assert second.process.poll() is None
    assert sites.car.running["gateway"].process.poll() is None

    sites.car.running["gateway"].kill()
    sites.car.start("gateway", "vehicle-gateway", "run", "--listen", PLACE)
    heard.wait_until("a restarted car is found by the same cockpit", lambda: commands_flow(heard), PATIENCE_S)
    assert second.process.poll() is None


def test_a_car_behind_nat_dials_the_tower(sites: Sites, heard: Listener):
    sites.tower.end_all()
    sites.car.running["gateway"].kill()
    place = f"{TOWER_ADDRESS}:7451"
    sites.car.start("gateway", "vehicle-gateway", "run", "--connect", place)
    told = sites.tower.ask("tower", "vehicles", "--vehicle", VEHICLE, "--listen", place, "--seconds", "10")
    assert told.returncode == 0, told.stdout + told.stderr
    assert "km/h" in told.stdout
    text = sites.tower.config.read_text()
    sites.tower.config.write_text(text.replace(f'connect = ["{PLACE}"]', f'listen = ["{place}"]'))
    sites.tower.start("cockpit", "tower", "cockpit")
    heard.wait_until("commands flow to a car that dialled", lambda: commands_flow(heard), PATIENCE_S)
