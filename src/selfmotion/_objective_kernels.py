"""The objectives of :mod:`selfmotion.objectives` on sampled motions, one row of a sheet per joint."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import fast_kernel
from selfmotion._elementary_kernels import wrapped
from selfmotion._types import FloatArray

JOINT_TRAVEL, L1, L2 = 0, 1, 2
KINDS = {"joint_travel": JOINT_TRAVEL, "l1": L1, "l2": L2}
"""What kernels call the objectives."""


@fast_kernel
def chord_sum(
    kind: int, runs: FloatArray, weights: FloatArray, k: int, sheet: FloatArray, joints: int, scratch: int
) -> float:
    """Return the cost of the k chords that end in k samples of joints modulo 2π.

    The joints are the rows of `sheet` from `joints` on, the sample before the first one in column 0; row `scratch` is
    one to work in. `runs` (k,) are the steps in r that lead to the samples.
    """
    total, sums = 0.0, sheet[scratch]
    if kind == L2:
        for i in range(k):
            sums[i] = 0.0
        for j in range(len(weights)):
            here, later, square = sheet[joints + j], sheet[joints + j][1:], weights[j] * weights[j]
            for i in range(k):
                step = wrapped(later[i] - here[i])
                sums[i] += square * step * step
        for i in range(k):
            total += np.sqrt(sums[i])
        return total
    for j in range(len(weights)):
        here, later, part = sheet[joints + j], sheet[joints + j][1:], 0.0
        if kind == JOINT_TRAVEL:
            for i in range(k):
                step = wrapped(later[i] - here[i])
                part += np.sqrt(runs[i] * runs[i] + step * step)
        else:
            for i in range(k):
                part += abs(wrapped(later[i] - here[i]))
        total += weights[j] * part
    return total


@fast_kernel
def densities(kind: int, weights: FloatArray, k: int, sheet: FloatArray, joints: int, into: int) -> None:
    """Fill row `into` of `sheet` with the cost per unit of r of k rates, in the rows from `joints` on."""
    density = sheet[into]
    for i in range(k):
        density[i] = 0.0
    for j in range(len(weights)):
        weight, rate = weights[j], sheet[joints + j][1:]
        if kind == JOINT_TRAVEL:
            for i in range(k):
                density[i] += weight * np.sqrt(1.0 + rate[i] * rate[i])
        elif kind == L1:
            for i in range(k):
                density[i] += weight * abs(rate[i])
        else:
            for i in range(k):
                density[i] += weight * weight * rate[i] * rate[i]
    if kind == L2:
        for i in range(k):
            density[i] = np.sqrt(density[i])
