"""Random numbers whose state is a number: splitmix64 (Steele, Lea and Flood, OOPSLA 2014). A kernel, the same everywhere."""

import numpy as np

from autonomy.planning.kernels import kernel

GOLDEN, MIX_A, MIX_B = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
A, B, C, D = np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11)


@kernel
def draw(chance: np.uint64) -> tuple[np.uint64, float]:
    """The next state and a number in 0..1, 1 excluded."""
    chance = chance + GOLDEN
    z = (chance ^ (chance >> A)) * MIX_A
    z = (z ^ (z >> B)) * MIX_B
    return chance, float((z ^ (z >> C)) >> D) * 2.0**-53
