"""Compiles the tracker's kernels, or reads them from disk, by two cycles on a short path. Before any cycle counts."""

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.control.mpcc.reference import along
from autonomy.control.mpcc.settings import MpccSettings
from autonomy.control.mpcc.state import Measured, TrackerState, set_up
from autonomy.control.mpcc.tracker import track
from autonomy.planning.reference_path import through

CAR = CarShape(
    front_m=3.6, rear_m=0.9, half_width_m=0.9, wheelbase_m=2.7, road_wheel_angle_max_rad=0.6, braking_max_m_s2=8.0
)  # any


def warm_up() -> None:
    """Sizes of path and history are not compiled in; the second cycle has a history."""
    ends = np.array(((0.0, 0.0), (60.0, 0.0)))
    reference = along(through(ends, np.zeros(2), np.ones(2), np.ones(2)), np.array((0.0, 60.0)), np.full(2, 5.0))
    state, setup = TrackerState(), set_up(MpccSettings(), CAR)
    for i in (1, 2):
        measured = Measured(
            stamp_ns=i * 10_000_000 - 5_000_000,
            x_m=10.0,
            y_m=0.1,
            heading_rad=0.0,
            speed_m_s=5.0,
            yaw_rate_rad_s=0.0,
            road_wheel_angle_rad=0.0,
            acceleration_m_s2=0.0,
        )
        state, tracked = track(state, measured, reference, i * 10_000_000, setup)
        if tracked.refused:
            raise AssertionError(tracked.refused)
