"""A topology as half-spaces: on which side of everybody a guidance trajectory passes, stage by stage. Pure.

For a person at o and the guidance at g, the rear axle stays before the line through o across the way from g to o: with
a = (o - g) / |o - g|, a'p <= a'o. Says nothing about distance: that is the business of the people's own rows. Source: T-MPC
(the paper's [17]), one half-space per obstacle and stage.
"""

import numpy as np

from autonomy.planning.horizon import Floats, Predictions


def half_spaces(places_m: Floats, predictions: Predictions) -> Floats:
    """places (STEPS + 1, 2) of the rear axle -> (STEPS + 1, n, 3): x * a + y * b <= c. Where the two meet: none (zeros, c = 1)."""
    people = predictions.positions_m
    way = people - places_m[:, None, :]
    distance = np.hypot(way[..., 0], way[..., 1])
    apart = distance > 1e-6
    normal = np.where(apart[..., None], way / np.where(apart, distance, 1.0)[..., None], 0.0)
    return np.concatenate((normal, np.where(apart, (normal * people).sum(axis=-1), 1.0)[..., None]), axis=-1)
