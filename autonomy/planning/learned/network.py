"""The network: from what is told of guidances to inputs over the horizon, and by the car's own dynamics to trajectories. Pure.

Everybody near the way goes through one small encoder, and the largest and the sum of what comes out go on: neither number nor order
of people matters. The decoder is the bicycle itself, so every guess can be driven. numpy alone: 0.1 Mflop a way is no work for a
runtime. Source: the paper, III-D, with accelerations for its jerks (they are the local planner's inputs) and an encoder for its
LSTM: predictions are told at ten times, and 35 steps one after the other would cost more than what is saved.
"""

from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import STEP_S, STEPS, Floats
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.learned.features import CAR, LINE, PERSON, WAY, Features, Singles
from autonomy.planning.mpc.bicycle import ANGLE, SPEED, step

EACH, HIDDEN = 48, 160  # numbers kept of a person, and of all
OUT = np.array((3.0, 1.0), np.float32)  # m/s2, rad/s: the most it can say
SUM_SHARE = np.float32(0.25)  # of the sum over people: about 1, as the rest


class Weights(NamedTuple):
    person_in: Singles
    person_in_bias: Singles
    person_out: Singles
    person_out_bias: Singles
    into: Singles
    into_bias: Singles
    through: Singles
    through_bias: Singles
    out: Singles
    out_bias: Singles


SHAPES: dict[str, tuple[int, ...]] = {
    "person_in": (PERSON, EACH),
    "person_in_bias": (EACH,),
    "person_out": (EACH, EACH),
    "person_out_bias": (EACH,),
    "into": (WAY + LINE + CAR + 2 * EACH, HIDDEN),
    "into_bias": (HIDDEN,),
    "through": (HIDDEN, HIDDEN),
    "through_bias": (HIDDEN,),
    "out": (HIDDEN, 2 * STEPS),
    "out_bias": (2 * STEPS,),
}


def inputs(weights: Weights, told: Features) -> Floats:
    """(w, STEPS, 2) acceleration in m/s2, rate of the road wheels' angle in rad/s."""
    ways, count = told.people.shape[:2]
    people = _linear(told.people.reshape(ways * count, PERSON), weights.person_in, weights.person_in_bias)
    people = _linear(people, weights.person_out, weights.person_out_bias).reshape(ways, count, EACH)
    pooled = (told.alone, people.max(axis=1, initial=0.0), people.sum(axis=1) * SUM_SHARE)
    hidden = _linear(np.concatenate(pooled, axis=1), weights.into, weights.into_bias)
    hidden = _linear(hidden, weights.through, weights.through_bias)
    said = np.tanh(hidden @ weights.out + weights.out_bias).reshape(-1, STEPS, 2) * OUT
    return np.asarray(said, np.float64)


def _linear(values: Singles, weights: Singles, bias: Singles) -> Singles:
    """With what is negative cut off."""
    return np.asarray(np.maximum(values @ weights + bias, np.float32(0.0)), np.float32)


@fast_kernel
def driven(start: Floats, inputs: Floats, wheelbase: float, angle_max: float, speed_max: float, states: Floats) -> None:
    """States (w, STEPS + 1, 6) from one start by inputs (w, STEPS, 2), cut in place where speed or angle would leave its bounds."""
    unused = np.empty((3, 5))
    for way in range(len(inputs)):
        states[way, 0] = start
        for k in range(STEPS):
            speed, angle = states[way, k, SPEED], states[way, k, ANGLE]
            inputs[way, k, 0] = (min(max(speed + inputs[way, k, 0] * STEP_S, 0.0), speed_max) - speed) / STEP_S
            inputs[way, k, 1] = (min(max(angle + inputs[way, k, 1] * STEP_S, -angle_max), angle_max) - angle) / STEP_S
            step(states[way, k], inputs[way, k, 0], inputs[way, k, 1], wheelbase, states[way, k + 1], unused)
