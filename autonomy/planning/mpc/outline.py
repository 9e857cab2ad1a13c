"""The car as all discs of one radius whose middles lie on a piece of its centre line: a rectangle with round ends. Pure.

Every corner of the car lies inside (the argument is one line of Pythagoras, below), and so does all of it: both are convex.
Of these discs only the one nearest to an obstacle matters. With a the direction from its middle c to the obstacle, every other
middle q of the piece has a'(q - c) <= 0; so whoever keeps to a'(o - c) >= radius is clear of all discs at once (`risk.py`
counts them once, therefore).
"""

from math import hypot
from typing import NamedTuple

from autonomy.car_shape import CarShape

# Ours: a longer piece hugs the sides, a shorter one the ends. 0.4 adds 8 % of half the width beside and 68 % before and behind.
END_SHARE = 0.4  # of half the width: from bumper to the end of the piece


class Outline(NamedTuple):
    """Along the car from the rear axle, forward positive."""

    rear_m: float
    front_m: float
    radius_m: float


def outline(car: CarShape) -> Outline:
    """A corner is `inset` ahead of the end of the piece and half the width beside it, so this radius just reaches it."""
    inset = min(END_SHARE * car.half_width_m, (car.front_m + car.rear_m) / 2)
    return Outline(inset - car.rear_m, car.front_m - inset, hypot(inset, car.half_width_m))
