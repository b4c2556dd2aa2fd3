"""How far one joint of a sampled motion leaves its limits, whole turns being free, as :class:`.limits.JointLimits`."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import fast_kernel
from selfmotion._elementary_kernels import wrapped
from selfmotion._types import FloatArray

_TAU = 2.0 * np.pi


@fast_kernel
def least_overrun(angles: FloatArray, k: int, lower: float, upper: float) -> float:
    """Return at most what :func:`overrun` finds, for samples that may be too few to count turns by.

    Each one is moved by the turns that suit it best; a joint that is limited on one side can always be.
    """
    if not (np.isfinite(lower) and np.isfinite(upper)):
        return 0.0
    middle, half, worst = 0.5 * (lower + upper), 0.5 * (upper - lower), 0.0
    for i in range(k):
        off = abs(wrapped(angles[i] - middle)) - half
        worst = off if off > worst else worst
    return worst


@fast_kernel
def extend(angles: FloatArray, k: int, extent: FloatArray, is_first: bool) -> None:
    """Go on along a joint's samples (k,), modulo 2π, made continuous.

    `extent` holds the first angle, the last one, the least and the largest.
    """
    if is_first:
        extent[0] = extent[1] = extent[2] = extent[3] = wrapped(angles[0])
    here, low, high = extent[1], extent[2], extent[3]
    for i in range(k):
        here = angles[i] - _TAU * np.rint((angles[i] - here) / _TAU)
        low = here if here < low else low
        high = here if here > high else high
    extent[1], extent[2], extent[3] = here, low, high


@fast_kernel
def overrun(extent: FloatArray, lower: float, upper: float, start: float) -> float:
    """Return by how much a joint with this extent leaves [lower, upper].

    The turns are those of `start`, the joint's angle at the first sample; if it is NaN, the ones that leave least.
    """
    first, low, high = extent[0], extent[2], extent[3]
    if np.isnan(start):
        least, most = np.ceil((lower - low) / _TAU), np.floor((upper - high) / _TAU)
        if least <= most:
            return 0.0
        turns = np.rint((lower + upper - low - high) / (2.0 * _TAU))
    else:
        turns = np.rint((start - first) / _TAU)
    return max(lower - (low + _TAU * turns), 0.0) + max(high + _TAU * turns - upper, 0.0)
