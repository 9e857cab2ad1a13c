"""How much of the risk each person may have at each stage, so that the JOINT bound holds. Pure.

Wanted: P(the car meets anybody at any stage) <= risk. Boole's inequality: that probability is at most the sum over people and
stages of P(meets this one at this stage), whatever depends on whatever else - the errors of one person's stages certainly do.
Here each of those is bounded by keeping the person's mean a distance z s beyond a line that parts it from the whole car, with
s the deviation across that line: P <= Q(z), Gaussian. All discs of the car lie on one side of that ONE line (`outline.py`), so
they count once. The allocation gives every Q(z) a share, and the shares add up to the risk.

Shares grow with the deviation: share = risk s_max / (sum of s_max), s_max along the widest axis. That is nearly the cheapest
way: the least sum of distances z s under a fixed sum of Q(z) has s / phi(z) alike everywhere, and Q(z) ~ phi(z) / z. What is
known exactly needs no share. Shares are fixed before the trajectory is sought; if they followed it, the bound would still
hold, but the problem would be another one.

Not bounded here: what happens between two stages, beyond the horizon, and when the predictions' Gaussians are wrong.
"""

from math import erfc, exp, hypot, log, pi, sqrt

import numpy as np

from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel


@fast_kernel
def allocate(covariances_m2: Floats, risk: float) -> Floats:
    """(K, n, 2, 2) -> (K, n) shares of the risk; stage 0, which nobody can change, has none."""
    shares = np.zeros((covariances_m2.shape[0], covariances_m2.shape[1]))
    total = 0.0
    for k in range(1, shares.shape[0]):
        for j in range(shares.shape[1]):
            shares[k, j] = widest(covariances_m2[k, j])
            total += shares[k, j]
    return shares * (risk / total) if total > 0.0 else shares


@fast_kernel
def widest(covariance_m2: Floats) -> float:
    """Deviation along the widest axis: root of the larger eigenvalue of (2, 2)."""
    a, b, c = covariance_m2[0, 0], covariance_m2[0, 1], covariance_m2[1, 1]
    return sqrt(max((a + c) / 2.0 + hypot((a - c) / 2.0, b), 0.0))


@fast_kernel
def quantiles(shares: Floats) -> Floats:
    """z with Q(z) = share, for each (K, n); 0 where there is no share: nothing there is uncertain."""
    found = np.zeros_like(shares)
    share, z = 0.0, 0.0
    for k in range(shares.shape[0]):
        for j in range(shares.shape[1]):
            if shares[k, j] != share:  # most people of a stage are as uncertain as the one before
                share = shares[k, j]
                z = quantile(share) if share > 0.0 else 0.0
            found[k, j] = z
    return found


@fast_kernel
def quantile(share: float) -> float:
    """z >= 0 with P(N(0, 1) > z) = share in (0, 0.5]: Newton on the logarithm, which is concave, from above."""
    z = sqrt(max(-2.0 * log(2.0 * share), 0.0))  # Q(z) <= exp(-z^2 / 2) / 2
    for _ in range(8):
        tail = erfc(z / sqrt(2.0)) / 2.0
        if tail == 0.0:  # beyond 37 deviations there are no numbers for it
            break
        change = tail * log(tail / share) / (exp(-z * z / 2.0) / sqrt(2.0 * pi))
        z += change
        if abs(change) < 1e-10:
            break
    return max(z, 0.0)
