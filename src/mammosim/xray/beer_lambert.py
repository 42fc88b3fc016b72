"""What passes along rays of known lengths: sum_E w exp(-sum_m mu_m(E) L_m), many rays and energies."""

import numpy as np

from mammosim.io.compiled import njit

LOG2_E = 1.4426950408889634
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10  # their sum is ln 2
ROUNDING = 1.5 * 2.0**52  # a number plus this is rounded, with its integer in the lowest bits
DEEPEST = 690.0  # exp(-690) = 1e-300, the smallest that is told from zero
# 1/k! of the series of exp(r), |r| <= ln(2)/2: the first term left out is 2e-16
C = tuple(1.0 / float(np.prod(np.arange(1.0, k + 1))) for k in range(13))


@njit(cache=True)
def passed(
    lengths: np.ndarray, mu: np.ndarray, weights: np.ndarray, into: np.ndarray, work: np.ndarray
) -> None:
    """Adds to into (n_weight, n_ray) what passes; lengths (n_material, n_ray) mm, mu (n_material, n_energy).

    weights (n_weight, n_energy); work (2, n_ray) is overwritten.
    The exponential is exp(-x) = 2^n exp(r), written as plain loops over rays that compile to vectors.
    """
    n_material, n_energy = mu.shape
    n_ray = lengths.shape[1]
    x, power = work[0], work[1]
    bits = power.view(np.int64)
    for e in range(n_energy):
        mu_e = mu[0, e]
        for i in range(n_ray):
            x[i] = mu_e * lengths[0, i]
        for m in range(1, n_material):
            mu_e = mu[m, e]
            for i in range(n_ray):
                x[i] += mu_e * lengths[m, i]
        for i in range(n_ray):
            y = -min(x[i], DEEPEST)
            power[i] = y * LOG2_E + ROUNDING
            n = power[i] - ROUNDING
            r = (y - n * LN2_HIGH) - n * LN2_LOW
            s = C[12]
            s = s * r + C[11]
            s = s * r + C[10]
            s = s * r + C[9]
            s = s * r + C[8]
            s = s * r + C[7]
            s = s * r + C[6]
            s = s * r + C[5]
            s = s * r + C[4]
            s = s * r + C[3]
            s = s * r + C[2]
            s = s * r + 1.0
            x[i] = s * r + 1.0
        for i in range(n_ray):
            bits[i] = (bits[i] + 1023) << 52  # the bits of 2^n
        for i in range(n_ray):
            x[i] *= power[i]
        for w in range(len(weights)):
            weight = weights[w, e]
            for i in range(n_ray):
                into[w, i] += weight * x[i]
