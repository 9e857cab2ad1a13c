"""`tower drive`: cockpit and window together, looked after, for a car that is already running."""

import threading
from pathlib import Path

from rich.console import Console

from tower.demo.crew import TOWER, crew, utc_folder
from wire import certificates
from wire.configuration import read_sections
from wire.settings import WireSettings

LOOK_S = 0.2


def run(config: Path, stop: threading.Event, sessions: Path) -> int:
    """Until the window is closed or a signal comes. A process that dies is started again."""
    console = Console(highlight=False, soft_wrap=True)
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    certificates.ensure(certificates.folder_of(wire.link.certificates))
    folder = utc_folder(sessions)
    console.print(f"connecting to {wire.link.vehicle_id} at {wire.link.car_hub}; logs in {folder / 'logs'}")
    with crew(TOWER, config.resolve(), folder) as people:
        while not stop.wait(LOOK_S):
            for ended in people.look_after():
                console.print(f"{ended.name} ended ({ended.how}){': started again' if ended.started_again else ''}")
                if not ended.started_again:
                    return 0 if ended.how == "exit 0" else 1
    return 0
