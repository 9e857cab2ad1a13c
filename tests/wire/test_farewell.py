"""A client whose hub is gone still ends at once and as it was asked to: two real processes on loopback."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import msgspec

from wire import certificates
from wire.ports import free_addresses
from wire.settings import LinkSettings

PROGRAM = """
import sys
from pathlib import Path
import msgspec
from wire.clock import Clock
from wire.link import open_link
from wire.process import run_until_stopped
from wire.settings import LinkSettings
from wire.topics import Role

def run(config, stop):
    role, settings = Role(sys.argv[1]), msgspec.json.decode(sys.argv[2], type=LinkSettings)
    with open_link(settings, role, Clock(), stop, hub=role is Role.VEHICLE_HUB) as link:
        link.level("gateway_status")
        print("up", flush=True)
        stop.wait()
    return 3

sys.exit(run_until_stopped(run, Path("none.toml")))
"""
SOON_S = 6.0  # the farewell itself would take nine


def started(role: str, settings: LinkSettings) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", PROGRAM, role, msgspec.json.encode(settings).decode()]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "up\n"
    return process


def test_a_program_whose_hub_was_killed_leaves_at_once_with_its_own_code_and_nothing_to_say(tmp_path: Path):
    certificates.make(tmp_path / "certificates")
    (place,) = free_addresses(1)
    settings = LinkSettings(certificates=str(tmp_path / "certificates"), car_hub=place)
    with started("vehicle-hub", settings) as hub, started("car-observer", settings) as client:
        hub.kill()
        hub.wait()
        client.send_signal(signal.SIGTERM)
        began = time.monotonic()
        _, said = client.communicate(timeout=30)
    assert (client.returncode, said) == (3, "")
    assert time.monotonic() - began < SOON_S
