"""The stage of a replay: two hubs on loopback with certificates of their own, and the programs that show it.

The certificates are made for this one replay and thrown away: no program of a drive can join, and there is neither a
cockpit nor a gateway, so nothing that is played can be driven. The programs are started by name, never imported.
"""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import tomli_w

from recordings.errors import RecordingError
from wire import certificates
from wire.messages.vehicle import VehicleDescription
from wire.ports import free_udp_ports

_PATIENCE_S = 5.0  # for SIGTERM, then SIGKILL


def stage_tables(base: dict[str, Any], vehicle: VehicleDescription, vehicle_id: str, label: str, folder: Path) -> dict[str, Any]:
    """The configuration of a replay: the watcher's own window, the recorded car, ports and certificates of its own."""
    car_port, tower_port = free_udp_ports(2)
    window = base.get("tower", {}).get("window", {})
    return {
        "wire": {
            "link": {
                "vehicle_id": vehicle_id,
                "car_hub": f"127.0.0.1:{car_port}",
                "tower_hub": f"127.0.0.1:{tower_port}",
                "certificates": str(folder / "certificates"),
            },
        },
        "vehicle": msgspec.to_builtins(vehicle),
        "tower": {"window": {**window, "replay": label}},
    }


@contextmanager
def stage_folder() -> Iterator[Path]:
    """A folder with fresh certificates, gone afterwards."""
    with tempfile.TemporaryDirectory(prefix="replay-") as name:
        certificates.make(Path(name) / "certificates")
        yield Path(name)


def write_configuration(tables: dict[str, Any], tower_offset_ns: int, file: Path) -> Path:
    """The tables with the tower's clock shifted, as a file."""
    wire = {**tables["wire"], "clock": {"tower_offset_ns": tower_offset_ns}}
    file.write_bytes(tomli_w.dumps({**tables, "wire": wire}).encode())
    return file


class Program:
    """One of our programs, ended when the context is left; it also ends when this process dies."""

    def __init__(self, folder: Path, name: str, *arguments: str) -> None:
        program = Path(sys.executable).parent / name
        if not program.is_file():
            raise RecordingError(f"{program}: not installed; run: make setup")
        self.name = f"{name} {arguments[0]}"
        self._log = folder / f"{arguments[0]}.log"
        with self._log.open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-m", "tower.demo.child", str(os.getpid()), "", str(program), *arguments],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                start_new_session=True,
            )

    def __enter__(self) -> "Program":
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def runs(self) -> bool:
        """False when it was closed. Raises RecordingError when it failed."""
        code = self._process.poll()
        if code not in (None, 0):
            said = self._log.read_text(errors="replace").strip().splitlines()
            raise RecordingError(f"{self.name} ended with {code}: {said[-1] if said else 'it said nothing'}")
        return code is None
