"""Compiles every kernel of the guidance planner (seconds to minutes the first time, then read from disk) before a cycle counts."""

import numpy as np

from autonomy.planning.guidance.line import wrapped
from autonomy.planning.guidance.planner import guide
from autonomy.planning.guidance.settings import GuidanceSettings
from autonomy.planning.guidance.state import initial_state
from autonomy.planning.guidance.winding import half_turns
from autonomy.planning.horizon import STEPS, CarState, Predictions
from autonomy.planning.reference_path import through


def warm_up() -> None:
    """One cycle beside one person: kernels take their types from the arrays, which are always the same.

    And the two kernels that identities ask from Python, in the first cycle in which the car passes somebody.
    """
    half_turns(wrapped(0.0))
    ends = np.array([[0.0, 0.0], [30.0, 0.0]])
    path = through(ends, np.zeros(2), np.full(2, 3.5), np.full(2, 3.5))
    car = CarState(x_m=1.0, y_m=0.0, heading_rad=0.0, speed_m_s=1.0, road_wheel_angle_rad=0.0, station_m=1.0)
    person = Predictions(
        numbers=(1,),
        positions_m=np.full((STEPS + 1, 1, 2), (9.0, 0.5)),
        covariances_m2=np.zeros((STEPS + 1, 1, 2, 2)),
        radii_m=np.full(1, 0.4),
    )
    guide(initial_state(0), car, path, person, GuidanceSettings())
