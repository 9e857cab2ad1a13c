"""The [autonomy] section: the map, and what every part of the stack reckons with."""

from typing import Annotated, Literal

from msgspec import Meta

from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.speed import SpeedSettings
from autonomy.control.steering import SteeringSettings
from autonomy.localization.ekf import LocalizationSettings
from autonomy.perception.tracking import TrackingSettings
from autonomy.planning.braking_planner import PlanningSettings
from autonomy.planning.mpc.settings import MpcSettings, Weights
from autonomy.planning.topology import TopologySettings
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


ACCELERATION_M_S2 = 1.2  # as the braking planner's
STEERING_RATE_RAD_S = 0.11  # that steering.py allows at the speed limit: plans have one for all speeds
# Weights: the tuned ones of Table I (benchmarks/crossings/methods.py); contour: so that it keeps to the middle in a bend
LOCAL = MpcSettings(
    weights=Weights(contour=1.0, acceleration=4.0, speed=4.0),
    acceleration_max_m_s2=ACCELERATION_M_S2,
    deceleration_max_m_s2=PlanningSettings().firm_m_s2,
    steering_rate_max_rad_s=STEERING_RATE_RAD_S,
)


class AutonomySettings(Message):
    map: Text = "bend.toml"  # a path, or the name of a file in config/maps
    ages: InputAges = InputAges()
    localization: LocalizationSettings = LocalizationSettings()
    tracking: TrackingSettings = TrackingSettings()
    planning: PlanningSettings = PlanningSettings()
    planner: Literal["braking", "topology"] = "topology"  # who decides how people are passed; what stands is the braking planner's
    topology: TopologySettings = TopologySettings(local=LOCAL, learned_guess=False)  # learned at walking pace
    tracker: MpccSettings = MpccSettings(
        acceleration_max_m_s2=ACCELERATION_M_S2,
        steering_rate_max_rad_s=SteeringSettings().rate_max_rad_s,
        lateral_jerk_max_m_s3=SteeringSettings().lateral_jerk_max_m_s3,
    )
    steering: SteeringSettings = SteeringSettings()
    speed: SpeedSettings = SpeedSettings()
    channels: ChannelSettings = ChannelSettings()
    monitor: MonitorSettings = MonitorSettings()
    budget: BudgetSettings = BudgetSettings()
