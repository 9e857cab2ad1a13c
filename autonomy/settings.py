"""The [autonomy] section: the map, and what every part of the stack reckons with."""

from pathlib import Path
from typing import Annotated

from msgspec import Meta

from autonomy.control.speed import SpeedSettings
from autonomy.control.steering import SteeringSettings
from autonomy.localization.ekf import LocalizationSettings
from autonomy.perception.tracking import TrackingSettings
from autonomy.planning.braking_planner import PlanningSettings
from autonomy.uncertainty.budget import BudgetSettings
from autonomy.uncertainty.channels import ChannelSettings
from autonomy.uncertainty.monitor import MonitorSettings
from wire.configuration import ConfigurationError, shipped
from wire.messages.base import Message, Text

Milliseconds = Annotated[int, Meta(ge=10, le=10_000)]


class InputAges(Message):
    """Older than this, by its own stamp, an input is stale and the stack not healthy."""

    imu_ms: Milliseconds = 500
    gnss_ms: Milliseconds = 500
    objects_ms: Milliseconds = 500
    wheels_ms: Milliseconds = 200


class AutonomySettings(Message):
    map: Text = "bend.toml"  # a path, or the name of a file in config/maps
    ages: InputAges = InputAges()
    localization: LocalizationSettings = LocalizationSettings()
    tracking: TrackingSettings = TrackingSettings()
    planning: PlanningSettings = PlanningSettings()
    steering: SteeringSettings = SteeringSettings()
    speed: SpeedSettings = SpeedSettings()
    channels: ChannelSettings = ChannelSettings()
    monitor: MonitorSettings = MonitorSettings()
    budget: BudgetSettings = BudgetSettings()


def find_map(name: str, config: Path) -> Path:
    """The map file that `[autonomy] map` names: absolute, beside the configuration, in its maps/ folder, or shipped.

    Raises ConfigurationError that lists where it was looked for.
    """
    places = (config.parent / name, config.parent / "maps" / name, shipped("maps", name))  # an absolute name wins each
    for place in places:
        if place.is_file():
            return place
    looked = ", ".join(str(place) for place in dict.fromkeys(places))
    raise ConfigurationError(f"{config}: autonomy.map = {name!r}: no such map; looked at {looked}")
