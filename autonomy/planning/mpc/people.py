"""The predictions as the kernels read them, and whether they can be read at all. Pure."""

import numpy as np

from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.risk import allocate, quantiles

PERSON_X, PERSON_Y, XX, XY, YY, QUANTILE, CLEARANCE, OF_PERSON = range(8)  # mean, covariance, z, from a disc's middle
REACH_M = 1e6  # as `Position` of wire: beyond it nothing is a place
ROUNDING = 1e-9  # of a covariance
FLAWS = ("", "predictions are no numbers", "a predicted radius is negative", "a predicted covariance is not symmetric and positive")


@fast_kernel
def flaw(positions: Floats, covariances: Floats, radii: Floats) -> int:
    """Number of the first flaw, in the order of FLAWS."""
    for j in range(radii.shape[0]):
        if not 0.0 <= radii[j] <= REACH_M:
            return 2 if radii[j] < 0.0 else 1
    for k in range(positions.shape[0]):
        for j in range(positions.shape[1]):
            xx, xy, yx, yy = covariances[k, j, 0, 0], covariances[k, j, 0, 1], covariances[k, j, 1, 0], covariances[k, j, 1, 1]
            for value in (positions[k, j, 0], positions[k, j, 1], xx, xy, yx, yy):
                if not abs(value) <= REACH_M:  # as NaN is not
                    return 1
            scale = 1.0 + abs(xx) + abs(yy)
            rounding = ROUNDING * scale
            if min(xx, yy) < -rounding or abs(xy - yx) > rounding or xx * yy - xy * yx < -rounding * scale:
                return 3
    return 0


@fast_kernel
def person_table(positions: Floats, covariances: Floats, radii: Floats, kept_off: float, risk: float) -> Floats:
    """(K, n, 7) with the quantiles that the risk's allocation asks for."""
    z = quantiles(allocate(covariances, risk))
    rows = np.empty((positions.shape[0], positions.shape[1], OF_PERSON))
    for k in range(rows.shape[0]):
        for j in range(rows.shape[1]):
            rows[k, j, PERSON_X], rows[k, j, PERSON_Y] = positions[k, j, 0], positions[k, j, 1]
            rows[k, j, XX], rows[k, j, XY], rows[k, j, YY] = (
                covariances[k, j, 0, 0],
                covariances[k, j, 0, 1],
                covariances[k, j, 1, 1],
            )
            rows[k, j, QUANTILE], rows[k, j, CLEARANCE] = z[k, j], radii[j] + kept_off
    return rows
