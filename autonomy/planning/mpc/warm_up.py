"""Compiles the local planner's kernels, or reads them from disk, by solving one small problem in each way. Before any cycle."""

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.planning.horizon import STEPS, CarState, Predictions
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.planner import solve
from autonomy.planning.mpc.problem import Problem
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.reference_path import through

CAR = CarShape(
    front_m=3.8, rear_m=1.0, half_width_m=1.0, wheelbase_m=2.8, road_wheel_angle_max_rad=0.5, braking_max_m_s2=8.0
)  # any
ONE = MpcSettings(iterations_max=1, steps_max=5)


def warm_up() -> None:
    """Numbers of people, pieces and half-spaces are not compiled in: one of each stands for all."""
    solve(small_problem(), ONE)
    solve(small_problem(), ONE, PLACES_M)


PLACES_M = np.stack((np.linspace(0.0, 10.0, STEPS + 1), np.zeros(STEPS + 1)), axis=1)


def small_problem() -> Problem:
    room = np.array((4.0, 4.0))
    someone = Predictions(
        numbers=(1,),
        positions_m=np.tile((20.0, 5.0), (STEPS + 1, 1, 1)),
        covariances_m2=np.tile(0.1 * np.eye(2), (STEPS + 1, 1, 1, 1)),
        radii_m=np.array((0.5,)),
    )
    return Problem(
        car=CAR,
        start=CarState(x_m=0.0, y_m=0.0, heading_rad=0.0, speed_m_s=1.0, road_wheel_angle_rad=0.0, station_m=0.0),
        path=through(np.array(((0.0, 0.0), (50.0, 0.0))), np.zeros(2), room, room),
        predictions=someone,
        speed_m_s=2.0,
        sides=half_spaces(PLACES_M, someone),
    )
