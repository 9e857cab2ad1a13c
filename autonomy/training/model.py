"""The network of `planning/learned/network.py` once more, as JAX can differentiate it, and what it is to make small.

A test holds the two against each other. The decoder integrates as the local planner does (`mpc/bicycle.py`), so what is compared
with the optimised trajectory is what the car would drive. Wants the extra `train`.
"""

import jax
import jax.numpy as jnp
from jax import Array, lax

from autonomy.planning.horizon import STEP_S, STEPS
from autonomy.planning.learned.network import OUT, SUM_SHARE, Weights
from autonomy.training.batches import Batch

jax.config.update("jax_platforms", "cpu")  # else it tells what other hardware it looked for and did not find
ANGLE_MAX_RAD = 0.55  # reference, motion-planner.md: Prius
WHEELBASE_M = 2.79
H = STEP_S
# Of squared deviations, summed over the horizon's stages: metres, rad, m/s, rad; m/s2, rad/s. Chosen so that each matters.
STATE_WEIGHTS = jnp.array((1.0, 1.0, 4.0, 1.0, 4.0))
INPUT_WEIGHTS = jnp.array((0.3, 1.0))


def inputs(weights: Weights, batch: Batch) -> Array:
    """(b, STEPS, 2)"""
    people = jax.nn.relu(batch.people @ weights.person_in + weights.person_in_bias)
    people = jax.nn.relu(people @ weights.person_out + weights.person_out_bias) * batch.there[..., None]
    pooled = (batch.alone, people.max(axis=1), people.sum(axis=1) * SUM_SHARE)
    hidden = jax.nn.relu(jnp.concatenate(pooled, axis=1) @ weights.into + weights.into_bias)
    hidden = jax.nn.relu(hidden @ weights.through + weights.through_bias)
    return jnp.tanh(hidden @ weights.out + weights.out_bias).reshape(-1, STEPS, 2) * OUT


def driven(start: Array, asked: Array) -> tuple[Array, Array]:
    """States (b, STEPS + 1, 5) from starts (b, 5), and the inputs cut where speed or angle would leave their bounds."""

    def one(state: Array, wanted: Array) -> tuple[Array, tuple[Array, Array]]:
        x, y, heading, speed, angle = state.T
        acceleration = (jnp.maximum(speed + wanted[:, 0] * H, 0.0) - speed) / H
        rate = (jnp.clip(angle + wanted[:, 1] * H, -ANGLE_MAX_RAD, ANGLE_MAX_RAD) - angle) / H
        begin, middle, end = (
            (speed + t * acceleration) * jnp.tan(angle + t * rate) / WHEELBASE_M for t in (0.0, H / 2, H)
        )  # turning rates
        looks = ((1.0, 0.0, begin), (2.0, H / 2, begin), (2.0, H / 2, middle), (1.0, H, middle))
        ahead = sum(share * (speed + t * acceleration) * jnp.cos(heading + t * turn) for share, t, turn in looks)
        aside = sum(share * (speed + t * acceleration) * jnp.sin(heading + t * turn) for share, t, turn in looks)
        turned = heading + H / 6 * (begin + 4.0 * middle + end)
        after = jnp.stack((x + H / 6 * ahead, y + H / 6 * aside, turned, speed + H * acceleration, angle + H * rate), axis=1)
        return after, (after, jnp.stack((acceleration, rate), axis=1))

    _, (states, used) = lax.scan(one, start, asked.swapaxes(0, 1))
    return jnp.concatenate((start[:, None], states.swapaxes(0, 1)), axis=1), used.swapaxes(0, 1)


def loss(weights: Weights, batch: Batch) -> Array:
    states, used = driven(batch.states[:, 0], inputs(weights, batch))
    of_states = (jnp.square(states - batch.states) * STATE_WEIGHTS).sum(axis=(1, 2))
    of_inputs = (jnp.square(used - batch.inputs) * INPUT_WEIGHTS).sum(axis=(1, 2))
    return jnp.sqrt(1.0 + (of_states + of_inputs) / STEPS).mean() - 1.0  # far off counts as far, not as its square
