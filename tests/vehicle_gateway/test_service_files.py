"""Units and rules as they are written for one installation; systemd's own tool reads them where it is installed."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from vehicle_gateway.service import Site, rendered, run
from wire.configuration import ConfigurationError, shipped
from wire.link_threads import for_pictures
from wire.settings import PaceSettings

CONFIG = Path("/etc/remote-operation-tower/car.toml")


def test_every_placeholder_is_filled_in_and_no_machine_s_path_is_shipped():
    for site in Site:
        for name, text in rendered(site, Path("/opt/tower/bin"), CONFIG).items():
            assert not re.search(r"@[A-Z]+@", text), name
    for file in shipped("service").iterdir():
        assert not re.search(r"/home|/root|/tmp|/opt", file.read_text()), file


def test_the_units_start_the_programs_of_this_installation_with_this_configuration():
    files = rendered(Site.CAR, Path("/opt/two words/100%/bin"), CONFIG)
    started = {Path(name).stem: re.findall(r"^ExecStart=(.*)$", text, re.M) for name, text in files.items() if "ExecStart" in text}
    folder = "/opt/two\\x20words/100%%/bin"
    assert started == {
        "remote-operation-gateway": [f"{folder}/vehicle-gateway --log-format json run --config {CONFIG}"],
        "remote-operation-watchdog": [f"{folder}/vehicle-gateway --log-format json watchdog --config {CONFIG}"],
        "remote-operation-video": [f"{folder}/vehicle-gateway --log-format json video --config {CONFIG}"],
        "remote-operation-recorder": [f"{folder}/recordings --log-format json record --config {CONFIG}"],
    }


def settings(text: str) -> dict[str, str]:
    return dict(line.split("=", 1) for line in text.splitlines() if "=" in line and not line.startswith("#"))


def test_a_program_that_dies_comes_back_and_one_that_a_person_has_to_mend_does_not():
    for name, text in rendered(Site.CAR, Path("/opt/bin"), CONFIG).items():
        if name.endswith(".service"):
            unit = settings(text)
            assert (unit["Restart"], unit["RestartPreventExitStatus"], unit["StartLimitIntervalSec"]) == ("always", "2", "0"), name


def test_the_cameras_may_take_their_real_time_priority():
    unit = settings(rendered(Site.CAR, Path("/opt/bin"), CONFIG)["etc/systemd/system/remote-operation-video.service"])
    assert int(unit["LimitRTPRIO"]) >= for_pictures(PaceSettings().fifo_priority) and "RestrictRealtime" not in unit


def test_the_control_loop_may_take_its_real_time_priority_and_only_that():
    unit = settings(rendered(Site.CAR, Path("/opt/bin"), CONFIG)["etc/systemd/system/remote-operation-gateway.service"])
    assert int(unit["LimitRTPRIO"]) >= 10 and "RestrictRealtime" not in unit
    assert (unit["CapabilityBoundingSet"], unit["NoNewPrivileges"], unit["ProtectSystem"]) == ("", "yes", "strict")
    assert "AF_CAN" in unit["RestrictAddressFamilies"]
    assert (unit["Type"], unit["WatchdogSec"]) == ("notify", "3")


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd-analyze is not installed")
def test_systemd_finds_nothing_wrong_with_the_units(tmp_path):
    programs = tmp_path / "bin"
    programs.mkdir()
    for name in ("vehicle-gateway", "recordings"):
        (programs / name).write_text("#!/bin/sh\n")
        (programs / name).chmod(0o755)
    units = []
    for name, text in rendered(Site.CAR, programs, CONFIG).items():
        if name.endswith(".service"):
            units.append(tmp_path / Path(name).name)
            units[-1].write_text(text)
    done = subprocess.run(["systemd-analyze", "verify", *map(str, units)], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(shutil.which("systemd-sysusers") is None, reason="systemd-sysusers is not installed")
def test_systemd_would_make_the_user_of_the_services():
    done = subprocess.run(
        ["systemd-sysusers", "--dry-run", str(shipped("service", "remote-operation.conf"))],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 0 and "user 'remote-operation'" in done.stdout + done.stderr


def udev_verifies() -> bool:
    """`udevadm verify` came with systemd 254."""
    if shutil.which("udevadm") is None:
        return False
    version = subprocess.run(["udevadm", "--version"], capture_output=True, text=True, timeout=60, check=False).stdout
    return version.strip().isdigit() and int(version) >= 254


@pytest.mark.skipif(not udev_verifies(), reason="udevadm verify is not there: systemd 254 or newer")
def test_udev_finds_nothing_wrong_with_the_rules():
    rules = shipped("service", "70-remote-operation-wheels.rules")
    done = subprocess.run(["udevadm", "verify", str(rules)], capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_every_line_of_the_rules_is_matches_then_assignments_and_names_every_wheel():
    """The grammar of udev(7), plainly: KEY op "value", separated by commas; a rule has to assign something."""
    text = shipped("service", "70-remote-operation-wheels.rules").read_text()
    rules = [line for line in text.splitlines() if line and not line.startswith("#")]
    one = r'(?:[A-Z]+(?:\{[A-Za-z_]+\})?)(?:==|!=|\+=|-=|:=|=)"(?:[^"\\]|\\.)*"'
    for rule in rules:
        assert re.fullmatch(rf"{one}(?:, {one})*", rule), rule
        assert re.search(r'(?:TAG|RUN)\+="', rule) and re.search(r'=="', rule)
    for product in ("C24F", "C262", "C26E"):  # G29, G920, G923 Xbox
        assert f"046D:{product}" in text
    assert int(Path("70-remote-operation-wheels.rules").name[:2]) < 73


def test_they_are_printed_by_default_and_written_below_a_folder_when_asked(tmp_path, capsys):
    assert run(shipped("example_car.toml"), Site.CAR, None) == 0
    shown = capsys.readouterr().out
    assert "# /etc/systemd/system/remote-operation-gateway.service\n" in shown
    assert run(shipped("example_car.toml"), Site.TOWER, tmp_path) == 0
    assert (tmp_path / "etc/udev/rules.d/70-remote-operation-wheels.rules").is_file()
    assert "udevadm control --reload" in capsys.readouterr().out


def test_a_folder_that_cannot_be_written_and_a_configuration_that_is_not_there_are_one_line(tmp_path):
    (tmp_path / "etc").touch()
    with pytest.raises(ConfigurationError, match=r"cannot be written: .*; run it with sudo"):
        run(shipped("example_car.toml"), Site.CAR, tmp_path)
    with pytest.raises(ConfigurationError, match="no such file; name one with --config FILE"):
        run(tmp_path / "none.toml", Site.CAR, None)
