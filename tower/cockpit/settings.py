"""The [tower.cockpit] section: who operates, with which device, and how the device becomes commands."""

from typing import Annotated

from msgspec import Meta

from tower.cockpit.keyboard import KeyboardSettings
from tower.cockpit.pedals import PedalSettings
from tower.cockpit.scripted import ScriptedSettings
from wire.messages.base import Message


class CockpitSettings(Message):
    operator: Annotated[str, Meta(min_length=1, max_length=64)] = "operator-1"
    device: Annotated[str, Meta(pattern="^(scripted|keyboard)$")] = "keyboard"  # which one the drive starts with
    pedals: PedalSettings = PedalSettings()
    keyboard: KeyboardSettings = KeyboardSettings()
    scripted: ScriptedSettings = ScriptedSettings()
