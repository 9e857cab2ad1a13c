"""Which configuration section each room has: a packaging entry-point group that every room declares.

A program that has to read the whole file finds the other rooms' settings here and imports none of them itself.
"""

from importlib.metadata import entry_points
from typing import Any

from wire.configuration import ConfigurationError

GROUP = "remote_operation_tower.settings"
ROOMS_WITH_SETTINGS = ("tower", "vehicle_gateway", "haptics", "autonomy", "recordings")


def settings_of_rooms() -> dict[str, type[Any]]:
    """The settings struct of every room but wire. Raises ConfigurationError when the installation is older than a room."""
    found = {point.name: point for point in entry_points(group=GROUP)}
    missing = [room for room in ROOMS_WITH_SETTINGS if room not in found]
    if missing:
        raise ConfigurationError(f"no settings installed for {', '.join(missing)}; install again: make setup")
    return {room: found[room].load() for room in ROOMS_WITH_SETTINGS}
