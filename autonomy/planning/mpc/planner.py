"""The local planner's door: a problem and a guess in, one trajectory out. Pure: the same in, the same out, bit for bit.

Contouring MPC with chance constraints (the paper, III-D). Never raises for what stands in a problem and never returns NaN: what
cannot be asked or solved comes back `feasible=False` with its violation and, when it was refused, why. It does not decide,
does not watch the time and does not remember: the last trajectory is the caller's, as a guess.
"""

import numpy as np

from autonomy.planning.horizon import STEPS, Floats, Trajectory
from autonomy.planning.mpc.guess import Guess, along, from_places
from autonomy.planning.mpc.problem import STAGES, Arrays, Problem, arrays, refusal, state_of
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.mpc.sqp import Result, optimise


def solve(problem: Problem, settings: MpcSettings, guess: Guess | Floats | None = None) -> Trajectory:
    """Guess: a `Guess`; places (STEPS + 1, 2) of a guidance; None: along the path."""
    refused = refusal(problem)
    if refused:
        return standing(problem, refused)
    asked = arrays(problem, settings)
    states, inputs = start_of(asked, guess)
    result = optimise(asked, states, inputs, settings.iterations_max, settings.steps_max)
    if not (np.isfinite(states).all() and np.isfinite(inputs).all() and np.isfinite(result.cost)):
        return standing(problem, "no numbers came out")
    return trajectory(states, inputs, result, settings)


def start_of(asked: Arrays, guess: Guess | Floats | None) -> tuple[Floats, Floats]:
    """Copies (K, 6) and (K, 3) to work on. A guess that is no numbers, or has another size, is none."""
    if isinstance(guess, np.ndarray) and guess.shape == (STAGES, 2):
        guess = from_places(asked, np.array(guess, dtype=np.float64))
    if not isinstance(guess, Guess) or not _is_usable(guess):
        guess = along(asked)
    inputs = np.zeros((STAGES, 3))
    inputs[:STEPS, :2] = guess.inputs
    return np.array(guess.states, dtype=np.float64, order="C"), inputs


def _is_usable(guess: Guess) -> bool:
    sized = guess.states.shape == (STAGES, 6) and guess.inputs.shape == (STEPS, 2)
    return sized and bool(np.isfinite(guess.states).all() and np.isfinite(guess.inputs).all())


def trajectory(states: Floats, inputs: Floats, result: Result, settings: MpcSettings) -> Trajectory:
    return Trajectory(
        states=states,
        inputs=inputs[:STEPS, :2].copy(),
        cost=result.cost,
        feasible=result.violation <= settings.tolerance_m,
        violation=result.violation,
    )


def standing(problem: Problem, refused: str) -> Trajectory:
    """Nothing to drive after: the car where it is, as far as that is known."""
    state = np.nan_to_num(state_of(problem.start), nan=0.0, posinf=0.0, neginf=0.0)
    states = np.tile(state, (STAGES, 1))
    return Trajectory(states=states, inputs=np.zeros((STEPS, 2)), cost=np.inf, feasible=False, violation=np.inf, refused=refused)
