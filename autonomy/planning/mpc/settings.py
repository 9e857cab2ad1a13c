"""What the local planner weighs, where it ends, how long it tries.

Weights, bounds and risk: tud-amr/mpc_planner @f26a515, its settings for the Prius of the paper, with the lag weight that works.
"""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message

Weight = Annotated[float, Meta(ge=1e-6, le=1e6)]


class Weights(Message):
    """Of squares, summed over the stages; cost has no unit."""

    contour: Weight = 0.1  # 1/m2, distance beside the path
    lag: Weight = 1.0  # 1/m2, distance along it from where the station says
    speed: Weight = 1.0  # s2/m2, from the speed asked for
    acceleration: Weight = 13.0  # s4/m2
    steering_rate: Weight = 13.6  # s2/rad2
    preview: Weight = 100.0  # 1/rad2, angle to the path at the end of the horizon
    slack: Weight = 1e4  # 1/m2
    slack_linear: Weight = 1e3  # 1/m: above every price that keeping a constraint can have, so slack is zero wherever it can be


class MpcSettings(Message):
    weights: Weights = Weights()
    acceleration_max_m_s2: Annotated[float, Meta(ge=0.1, le=5.0)] = 3.0
    deceleration_max_m_s2: Annotated[float, Meta(ge=0.5, le=9.0)] = 3.0
    steering_rate_max_rad_s: Annotated[float, Meta(ge=0.05, le=3.0)] = 1.5  # at the road wheels
    speed_max_m_s: Annotated[float, Meta(ge=0.1, le=20.0)] = 8.3  # 30 km/h, the tower's own limit
    risk: Annotated[float, Meta(ge=1e-9, le=0.49)] = 0.05  # of meeting anybody at any stage: the joint one (risk.py)
    tolerance_m: Annotated[float, Meta(ge=1e-4, le=0.1)] = (
        0.005  # accepted beyond a constraint; people are kept off by so much more
    )
    iterations_max: Annotated[int, Meta(ge=1, le=100)] = 25  # of the SQP
    steps_max: Annotated[int, Meta(ge=5, le=2000)] = 150  # of the interior point method, over all of them
