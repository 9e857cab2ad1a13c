"""The [tower] section."""

from tower.cockpit.settings import CockpitSettings
from tower.window.settings import WindowSettings
from wire.messages.base import Message


class TowerSettings(Message):
    cockpit: CockpitSettings = CockpitSettings()
    window: WindowSettings = WindowSettings()
