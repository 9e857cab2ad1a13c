"""The weights that are shipped, and their file: an .npz of half-precision arrays. How they were made: weights.md beside them."""

from functools import cache
from pathlib import Path

import numpy as np

from autonomy.planning.learned.network import SHAPES, Weights

SHIPPED = Path(__file__).with_name("weights.npz")


@cache
def shipped_weights() -> Weights | None:
    return read(SHIPPED)


def read(file: Path) -> Weights | None:
    """None for a file that is not there, or holds anything else: then nothing was learned."""
    try:
        with np.load(file, allow_pickle=False) as kept:
            weights = Weights(*(np.asarray(kept[name], np.float32) for name in SHAPES))
    except Exception:  # noqa: BLE001 - a damaged archive may say anything, down to an error of the tokenizer for array headers
        return None
    fits = all(array.shape == SHAPES[name] for name, array in weights._asdict().items())
    return weights if fits and all(np.isfinite(array).all() for array in weights) else None


def write(file: Path, weights: Weights) -> None:
    with file.open("wb") as out:
        np.savez_compressed(out, **{name: array.astype(np.float16) for name, array in weights._asdict().items()})
