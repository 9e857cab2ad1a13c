"""Compiles the guess's kernels, or reads them from disk, and reads the weights, by guessing once. Before any cycle."""

import numpy as np

from autonomy.planning.guidance.state import Guidance
from autonomy.planning.horizon import STEPS
from autonomy.planning.learned.guesses import guesses
from autonomy.planning.learned.network import SHAPES, Weights
from autonomy.planning.learned.weights import shipped_weights
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.mpc.warm_up import PLACES_M, small_problem

NOTHING = Weights(**{name: np.zeros(shape, np.float32) for name, shape in SHAPES.items()})  # for when none are shipped


def warm_up() -> None:
    ahead = np.zeros(STEPS + 1)
    way = Guidance(
        identity=0,
        code=(),
        middle_m=PLACES_M,
        speeds_m_s=ahead,
        rear_axle_m=PLACES_M,
        headings_rad=ahead,
        points_m=PLACES_M,
        cost_m=0.0,
    )
    guesses(shipped_weights() or NOTHING, [way], small_problem(), MpcSettings())
