"""From samples to weights: Adam with a falling step, so many times through all of them. The same samples and seed, the same weights
on the same machine. Wants the extra `train`. Source of the rule: Kingma, Ba, 2015, with its own constants."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jax import Array

from autonomy.planning.learned.network import SHAPES, Weights
from autonomy.training.batches import Batch, batches
from autonomy.training.model import driven, inputs, loss

jax.config.update("jax_platforms", "cpu")
SIZE = 256  # samples a batch
STEP, LAST_SHARE = 2e-3, 0.01  # of the first step's length is the last one's
DECAY, DECAY_SQUARE, SMALL = 0.9, 0.999, 1e-8
LONGEST = 1.0  # norm of a gradient


def trained(learned: Batch, rounds: int, tell: Callable[[int, Weights], None], seed: int = 0) -> Weights:
    """Tell: hears the weights after each round."""
    random = np.random.default_rng(seed)
    weights = at_first(random)
    mean = square = Weights(*(jnp.zeros_like(each) for each in weights))
    steps = rounds * (len(learned.alone) // SIZE)
    step = 0
    for number in range(rounds):
        for batch in batches(learned, SIZE, random):
            length = STEP * (LAST_SHARE + (1.0 - LAST_SHARE) * 0.5 * (1.0 + np.cos(np.pi * step / steps)))
            step += 1
            weights, mean, square = improved(weights, mean, square, batch, length, step)
        tell(number, weights)
    return Weights(*(np.asarray(each, np.float32) for each in weights))


def at_first(random: np.random.Generator) -> Weights:
    """He's: as loud behind a layer as before it; the last one quiet, so that the first guess is to roll on."""
    made = {
        name: random.normal(0.0, np.sqrt(2.0 / shape[0]), shape) if len(shape) == 2 else np.zeros(shape)
        for name, shape in SHAPES.items()
    }
    weights = Weights(**{name: each.astype(np.float32) for name, each in made.items()})
    return weights._replace(out=weights.out * np.float32(0.1))


def _improved(
    weights: Weights, mean: Weights, square: Weights, batch: Batch, length: float, step: int
) -> tuple[Weights, Weights, Weights]:
    slope = jax.grad(loss)(weights, batch)
    norm = jnp.sqrt(sum(jnp.sum(each * each) for each in slope))
    slope = jax.tree.map(lambda each: each * jnp.minimum(1.0, LONGEST / (norm + SMALL)), slope)
    mean = jax.tree.map(lambda old, new: DECAY * old + (1.0 - DECAY) * new, mean, slope)
    square = jax.tree.map(lambda old, new: DECAY_SQUARE * old + (1.0 - DECAY_SQUARE) * new * new, square, slope)

    def moved(weight: Array, first: Array, second: Array) -> Array:
        second_root = jnp.sqrt(second / (1.0 - DECAY_SQUARE**step))
        return weight - length * (first / (1.0 - DECAY**step)) / (second_root + SMALL)

    return jax.tree.map(moved, weights, mean, square), mean, square


def _judged(weights: Weights, batch: Batch) -> tuple[Array, Array]:
    """Loss, and metres from the optimised place at each sample's last stage."""
    states, _ = driven(batch.states[:, 0], inputs(weights, batch))
    return loss(weights, batch), jnp.linalg.norm(states[:, -1, :2] - batch.states[:, -1, :2], axis=1)


improved, judged = jax.jit(_improved), jax.jit(_judged)
