"""Chords on plain arrays: what they cost, and which are too long to matter."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate._arrays import Arcs, Values

TAU = 2 * np.pi
TRAVEL, L1, L2 = 0, 1, 2
# Each value is a sum of some forty products; this part of the sum of their sizes is far more than rounding makes of it.
ROUNDING = 2e-14
ANGLES = 1e-15  # of all angles' sizes: more than differences of middles of cells, by turns too, are off by
BLOCK = 16  # cells that are looked at together before each by itself


@kernel
def cost(kind: int, d: FloatArray, h: float, w: FloatArray) -> float:
    """Return the cost c(d; h) of a chord."""
    total = 0.0
    if kind == TRAVEL:
        for i in range(len(d)):
            total += w[i] * np.sqrt(h * h + d[i] * d[i])
        return total
    if kind == L1:
        for i in range(len(d)):
            total += w[i] * abs(d[i])
        return total
    for i in range(len(d)):
        total += (w[i] * d[i]) ** 2
    return np.sqrt(total)


@kernel
def chord(kind: int, d: FloatArray, h: float, w: FloatArray, g: FloatArray, bend: FloatArray) -> tuple[float, float]:
    """Return the cost c(d; h) of a chord and a factor f; fill in a subgradient g and `bend`.

    The Hessian is ``diag(bend) − f g gᵀ``.
    """
    total = 0.0
    if kind == TRAVEL:
        for i in range(len(d)):
            square = h * h + d[i] * d[i]
            length = np.sqrt(square)
            total += w[i] * length
            g[i] = w[i] * d[i] / length
            bend[i] = w[i] * h * h / (square * length)
        return total, 0.0
    if kind == L1:
        for i in range(len(d)):
            total += w[i] * abs(d[i])
            g[i] = w[i] * np.sign(d[i])
            bend[i] = 0.0
        return total, 0.0
    for i in range(len(d)):
        total += (w[i] * d[i]) ** 2
    total = np.sqrt(total)
    factor = 1.0 / total if total > 1e-300 else 0.0
    for i in range(len(d)):
        bend[i] = w[i] * w[i] * factor
        g[i] = bend[i] * d[i]
    return total, factor


@kernel
def distance(
    ya: FloatArray, yb: FloatArray, ydev: FloatArray, middle: FloatArray, room: FloatArray, wraps: BoolArray,
    w: FloatArray, center: FloatArray, spread: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Return the least weighted l1 distance of a cell and a box, and the least squared l2 distance.

    Fills in how the middles differ, free joints by half a turn at most, and by how much postures may differ from that.
    """
    short, square = 0.0, 0.0
    for i in range(len(w)):
        x = 0.5 * (ya[i] + yb[i]) - middle[i]
        if wraps[i]:
            x -= TAU * np.rint(x / TAU)
        center[i] = x
        spread[i] = 0.5 * abs(yb[i] - ya[i]) + ydev[i] + room[i]
        spread[i] += ANGLES * (abs(ya[i]) + abs(yb[i]) + abs(middle[i]) + TAU)
        x = max(abs(x) - spread[i], 0.0) * w[i]
        short += x
        square += x * x
    return short, square


@kernel
def is_far(kind: int, short: float, square: float, still: float, need: float) -> bool:
    """Return whether a chord of at least these lengths costs more than `need`; `still` is what it costs not to move."""
    if kind == L1:
        return short > need
    return need <= 0.0 or (square if kind == L2 else short * short + still * still) > need * need


@kernel
def least_of(values: Values, k: int) -> float:
    """Return the least proposed value on a cell, between its ends."""
    return min(values.v[k, 0], values.v[k, 1]) - 0.125 * max(values.sag[k], 0.0)


@kernel
def loose(values: Values, cells: Arcs, k: int) -> float:
    """Return how far the value of a posture may be from that on its cell's parabola."""
    total = 0.0
    for i in range(cells.a.shape[1]):
        total += abs(values.g[k, i]) * cells.rest[k, i]
    return total


@kernel
def blocks_of(
    wraps: BoolArray, cells: Arcs, values: Values,
    middle: FloatArray, room: FloatArray, lowest: FloatArray, gain: FloatArray,
) -> None:  # fmt: skip
    """Box every BLOCK cells: middle ± room (blocks, n), their lowest value, and by how much one could undercut."""
    a, b, dev = cells.a, cells.b, cells.dev
    m, n = a.shape
    for block in range(len(gain)):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, m)
        gain[block], lowest[block] = -np.inf, np.inf
        for i in range(n):
            middle[block, i], room[block, i] = 0.5 * (a[first, i] + b[first, i]), 0.0
        for k in range(first, last):
            for i in range(n):
                x = 0.5 * (a[k, i] + b[k, i]) - middle[block, i]
                if wraps[i]:
                    x -= TAU * np.rint(x / TAU)
                room[block, i] = max(room[block, i], abs(x) + 0.5 * abs(b[k, i] - a[k, i]) + dev[k, i])
            least, off, lost = least_of(values, k), loose(values, cells, k), values.lost[k]
            lowest[block] = min(lowest[block], least)
            gain[block] = max(gain[block], lost + off - least + ROUNDING * (abs(least) + abs(lost) + off))
        for i in range(n):
            room[block, i] *= 1.0 + ROUNDING
