"""The [autonomy] section: the map, and what every part of the stack reckons with."""

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
