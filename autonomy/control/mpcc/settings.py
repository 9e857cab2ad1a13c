"""What the tracker is told: weights of its cost, limits it keeps, when it gives up.

The weights: the best of 24 drawn ones on the track `TUNING` (benchmarks/tracker_tracks.py; never on the measured one), then half
a step towards smoothness, as noise of the measured state would otherwise shake the wheel: rate and jerk a little dearer.
"""

from typing import Annotated

from msgspec import Meta

from autonomy.control.mpcc.car import CarModel
from wire.messages.base import Message

Weight = Annotated[float, Meta(ge=0.0, le=1e6)]
Positive = Annotated[float, Meta(gt=0.0, le=100.0)]


class Weights(Message):
    """Of squares, per stage. The paper, III-E, (2): the first five."""

    contour: Weight = 50.0  # 1/m2
    lag: Weight = 50.0  # 1/m2
    speed: Weight = 3.0  # s2/m2
    rate: Weight = 6.0  # s2/rad2, of the road wheels' angle; less at low speed (tracker.py)
    jerk: Weight = 0.03  # s6/m2, rate of force over mass
    progress: Weight = 0.1  # s2/m2, the place on the path runs as fast as the car does
    end: Weight = 4.0  # contour at the horizon's end, times the others'
    closing: Weight = 1.0  # s2/m2, speed away from or towards the path at the horizon's end
    barrier: Annotated[float, Meta(gt=0.0, le=10.0)] = 0.03  # of every limit


class MpccSettings(Message):
    car: CarModel = CarModel()
    weights: Weights = Weights()
    acceleration_max_m_s2: Annotated[float, Meta(ge=0.1, le=5.0)] = 2.0
    braking_max_m_s2: Annotated[float, Meta(ge=0.5, le=9.0)] = 6.0
    jerk_max_m_s3: Annotated[float, Meta(ge=0.5, le=200.0)] = 20.0
    steering_rate_max_rad_s: Annotated[float, Meta(ge=0.05, le=3.0)] = 0.45  # at the road wheels; the simulated car's can do 0.5
    lateral_jerk_max_m_s3: Annotated[float, Meta(ge=0.5, le=200.0)] = 200.0  # the faster the car, the slower the wheels turn
    friction_share: Annotated[float, Meta(ge=0.1, le=1.0)] = 0.9  # of each axle's friction circle
    iterations_max: Annotated[int, Meta(ge=1, le=50)] = 3  # a cycle
    age_max_s: Annotated[float, Meta(ge=0.01, le=1.0)] = 0.2  # of the measured state
    off_path_max_m: Positive = 3.0  # farther from its path it does not find back to it but stops
    fallback_m_s2: Annotated[float, Meta(ge=0.5, le=9.0)] = 3.0
    fallback_jerk_m_s3: Positive = 10.0
    disturbance_lag_s: Positive = 1.0  # with which acceleration that nobody asked for is believed: less shakes the command
    disturbance_max_m_s2: Annotated[float, Meta(ge=0.0, le=3.0)] = 1.0  # a slope of 10 %
    stand_m_s: Positive = 0.3  # slower, with nothing faster asked for: it stands, or is about to
    settle_m_s2: Positive = 0.35  # while it still rolls then
    hold_m_s2: Positive = 2.0  # at standstill: on a slope of 20 %, as the gateway
