"""What the guidance planner reckons with.

Defaults: speed and car (Prius) of the paper's Table I; goals and samples as the method's authors have them.
"""

from typing import Annotated, NamedTuple

from msgspec import Meta

from autonomy.planning.horizon import STEP_S, STEPS
from wire.messages.base import Message

Metres = Annotated[float, Meta(ge=0.0, le=10.0)]
Positive = Annotated[float, Meta(gt=0.0, le=10.0)]


class GuidanceSettings(Message):
    speed_m_s: Annotated[float, Meta(gt=0.0, le=14.0)] = 2.0  # the car would like to drive; Table I
    overspeed: Annotated[float, Meta(ge=1.0, le=3.0)] = 1.5  # of it, at most, along an edge
    acceleration_m_s2: Positive = 3.0  # either way, between two edges and from the car's own speed
    slant: Positive = 1.0  # metres aside per metre ahead, at most
    ahead_m: Annotated[float, Meta(ge=0.1, le=5.0)] = 1.4  # from the rear axle to the car's middle, which is what is guided
    half_width_m: Metres = 1.125
    margin_m: Metres = 0.2  # of the graph beyond car and person; smoothing may use it up
    samples: Annotated[int, Meta(ge=10, le=200)] = 50
    trajectories: Annotated[int, Meta(ge=1, le=8)] = 4
    goals_ahead: Annotated[int, Meta(ge=2, le=9)] = 5
    goals_aside: Annotated[int, Meta(ge=0, le=3)] = 1  # to each side of the one on the path


class Drive(NamedTuple):
    """How the car can move, for the kernels."""

    speed_m_s: float  # now
    top_m_s: float
    acceleration_m_s2: float
    slant: float
    step_s: float
    last: float  # stage at the horizon's end


def drive_of(speed_m_s: float, settings: GuidanceSettings) -> Drive:
    speed = max(speed_m_s, 0.0)
    top = max(settings.speed_m_s * settings.overspeed, speed)
    return Drive(speed, top, settings.acceleration_m_s2, settings.slant, STEP_S, float(STEPS))
