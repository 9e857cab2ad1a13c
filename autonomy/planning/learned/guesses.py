"""Guidances in, a start for the local planner of each out, all of them at once. Pure. A guess decides nothing: the solver does.

Without weights, for a problem that cannot be asked, for another speed than was learned, or when no numbers come out, there is none.
"""

from collections.abc import Sequence

import numpy as np

from autonomy.planning.guidance.state import Guidance
from autonomy.planning.horizon import STEPS, Floats
from autonomy.planning.learned.features import features
from autonomy.planning.learned.network import Weights, driven, inputs
from autonomy.planning.mpc.guess import Guess
from autonomy.planning.mpc.problem import Problem, refusal, state_of
from autonomy.planning.mpc.settings import MpcSettings

LEARNED_M_S = (1.5, 2.5)  # asked for; all training drives asked for 2 m/s, and what a network says far from there is anything


def guesses(weights: Weights | None, ways: Sequence[Guidance], asked: Problem, settings: MpcSettings) -> list[Guess] | None:
    """One for each way. Asked: the ways' common problem, whose own sides do not matter."""
    people = asked.predictions
    if weights is None or not ways or people is None or refusal(asked):
        return None
    if not LEARNED_M_S[0] <= asked.speed_m_s <= LEARNED_M_S[1]:
        return None
    said = inputs(weights, features(ways, asked.start, asked.path, people, asked.speed_m_s))
    np.clip(said[..., 0], -settings.deceleration_max_m_s2, settings.acceleration_max_m_s2, out=said[..., 0])
    np.clip(said[..., 1], -settings.steering_rate_max_rad_s, settings.steering_rate_max_rad_s, out=said[..., 1])
    states: Floats = np.empty((len(ways), STEPS + 1, 6))
    car = asked.car
    driven(state_of(asked.start), said, car.wheelbase_m, car.road_wheel_angle_max_rad, settings.speed_max_m_s, states)
    if not (np.isfinite(said).all() and np.isfinite(states).all()):
        return None
    return [Guess(*each) for each in zip(states, said, strict=True)]
