"""Chords on plain arrays: what they cost, and which are too long to matter."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate._arrays import Arcs, Boxes, Values

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
    cells: Arcs, k: int, boxes: Boxes, j: int, wraps: BoolArray, w: FloatArray, center: FloatArray, spread: FloatArray
) -> tuple[float, float]:
    """Return the least weighted l1 distance of cell k and box j, and the least squared l2 distance.

    Fills in how the middles differ, free joints by half a turn at most, and by how much postures may differ from that.
    """
    short, square = 0.0, 0.0
    for i in range(len(w)):
        a, b, middle = cells.a[k, i], cells.b[k, i], boxes.middle[j, i]
        x = 0.5 * (a + b) - middle
        if wraps[i]:
            x -= TAU * np.rint(x / TAU)
        around = 0.5 * abs(b - a) + cells.dev[k, i] + boxes.room[j, i]
        around += ANGLES * (abs(a) + abs(b) + abs(middle) + TAU)
        center[i], spread[i] = x, around
        x = max(abs(x) - around, 0.0) * w[i]
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
def boxes_of(wraps: BoolArray, cells: Arcs, values: Values, many: int) -> Boxes:
    """Box every `many` cells together."""
    a, b, dev = cells.a, cells.b, cells.dev
    m, n = a.shape
    count = (m + many - 1) // many
    boxes = Boxes(np.empty((count, n)), np.zeros((count, n)), np.full(count, np.inf), np.full(count, -np.inf))
    for j in range(count):
        first, last = j * many, min(j * many + many, m)
        for i in range(n):
            boxes.middle[j, i] = 0.5 * (a[first, i] + b[first, i])
        for k in range(first, last):
            for i in range(n):
                x = 0.5 * (a[k, i] + b[k, i]) - boxes.middle[j, i]
                if wraps[i]:
                    x -= TAU * np.rint(x / TAU)
                boxes.room[j, i] = max(boxes.room[j, i], abs(x) + 0.5 * abs(b[k, i] - a[k, i]) + dev[k, i])
            least, off, lost = least_of(values, k), loose(values, cells, k), values.lost[k]
            deep = lost + off - least + ROUNDING * (abs(least) + abs(values.sag[k]) + abs(lost) + off)
            boxes.lowest[j], boxes.deepest[j] = min(boxes.lowest[j], least), max(boxes.deepest[j], deep)
        for i in range(n):
            boxes.room[j, i] *= 1.0 + ROUNDING
    return boxes
