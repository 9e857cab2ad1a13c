"""Two cars on this machine, each with certificates of its own and its real gateway, standing in STANDBY; a tower that knows both.

What it does not have: cameras, a world, CAN on the other side. Enough to choose one by its state and to join it.
"""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import tomli_w

from benchmarks.session import program, running
from tower.demo.session import choose, write_session
from wire import bundle, certificates
from wire.configuration import read_tables, shipped
from wire.ports import free_udp_ports

CARS = ("car-1", "car-2")


@contextmanager
def two_cars(folder: Path) -> Iterator[Path]:
    """The tower's configuration, with both cars in its fleet."""
    certificates.make(folder / "tower")
    places = {name: _car(folder, name) for name in CARS}
    with ExitStack() as stack:
        for name, (written, _) in places.items():
            stack.enter_context(running(folder / name, program("vehicle-gateway", "run", "--config", str(written))))
        yield _tower(folder, {name: hub for name, (_, hub) in places.items()})


def _car(folder: Path, name: str) -> tuple[Path, str]:
    """Its configuration, and where its hub listens."""
    bundle.install(bundle.export(folder / "tower", name, (), False), folder / name / "certificates", replace=False)
    tables = choose(shipped("simulated.toml"), "short", "")
    tables["wire"]["link"] |= {"vehicle_id": name, "certificates": str(folder / "tower")}
    tables["vehicle"]["vehicle_id"] = name
    tables["vehicle_gateway"]["limits"]["authority"]["engage_autonomously"] = False
    written = write_session(tables, folder / name)
    tables = read_tables(written)
    tables["wire"]["link"] |= {"certificates": str(folder / name / "certificates"), "dials": "tower"}
    written.write_bytes(tomli_w.dumps(tables).encode())
    return written, tables["wire"]["link"]["car_hub"]


def _tower(folder: Path, hubs: dict[str, str]) -> Path:
    tables = read_tables(shipped("simulated.toml"))
    (port,) = free_udp_ports(1)
    tables["tower"]["cockpit"] |= {"device": "keyboard", "operator": "ann"}
    tables["wire"]["link"] |= {
        "vehicle_id": "none-yet",
        "certificates": str(folder / "tower"),
        "tower_hub": f"127.0.0.1:{port}",
        "fleet": [{"vehicle_id": name, "connect": hub} for name, hub in hubs.items()],
    }
    written = folder / "tower.toml"
    written.write_bytes(tomli_w.dumps(tables).encode())
    return written
