"""What every planner among people shares: the time grid, and what is predicted on it. Arrays, map frame, SI.

Index k of an array is the time k * STEP_S after the plan's stamp. Source of N and dt: the paper, III-D.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

STEPS = 35  # N: inputs of a trajectory; it has one state more
STEP_S = 0.2
HORIZON_S = STEPS * STEP_S
PLAN_PERIOD_S = 0.1  # a plan is made anew so often

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Predictions:
    """Where n people and things will be. Gaussian, one after the other independent."""

    numbers: tuple[int, ...]  # of their tracks: who is who from one cycle to the next
    positions_m: Floats  # (STEPS + 1, n, 2) means
    covariances_m2: Floats  # (STEPS + 1, n, 2, 2) symmetric, positive semidefinite
    radii_m: Floats  # (n,)

    @property
    def count(self) -> int:
        return len(self.numbers)


@dataclass(frozen=True, slots=True, kw_only=True)
class CarState:
    """Kinematic bicycle, rear axle."""

    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float
    road_wheel_angle_rad: float
    station_m: float  # of its foot on the reference path


@dataclass(frozen=True, slots=True, kw_only=True)
class Trajectory:
    """What a planner found, or shows why it did not."""

    states: Floats  # (STEPS + 1, 6): x_m, y_m, heading_rad, speed_m_s, road_wheel_angle_rad, station_m
    inputs: Floats  # (STEPS, 2): acceleration_m_s2, road wheel angle rate in rad/s
    cost: float
    feasible: bool  # inside every tolerance; else the rest is for looking at only
    violation: float  # largest, of any constraint: metres, or the unit of its bound; infinite when refused
    refused: str = ""  # why it was not even tried; then the states say nothing
