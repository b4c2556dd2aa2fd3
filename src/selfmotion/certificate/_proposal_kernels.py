"""Proposals of a value function on plain arrays: what is said here only makes the proof sharp, nothing rests on it."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate._chord_kernels import BLOCK, L1, TAU, blocks_of, chord, cost, distance, is_far

WORK = 10  # rows of the work arrays that are handed down
_CLOSE = 1e-4  # of a cell's length: a proposal that is off by so much in s is off by its square in value


@kernel
def best_along(
    kind: int, h: float, w: FloatArray, y: FloatArray, a: FloatArray, step: FloatArray, va: float, vb: float,
    sag: float, d: FloatArray, g: FloatArray, bend: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Minimise ``(1 − s) va + s vb − ½ sag s (1 − s) + c(y − a − s·step; h)`` over s in [0, 1]; return value and s."""
    n = len(y)
    best, at = np.inf, 0.0
    if kind == L1:
        for k in range(n + 2):
            if k < n and step[k] == 0.0:
                continue
            s = 0.0 if k == n else 1.0 if k > n else min(max((y[k] - a[k]) / step[k], 0.0), 1.0)
            for i in range(n):
                d[i] = y[i] - a[i] - s * step[i]
            value = va + s * (vb - va) + cost(kind, d, h, w)
            if value < best:
                best, at = value, s
    else:
        low, high, s = 0.0, 1.0, 0.5
        for _ in range(25):
            for i in range(n):
                d[i] = y[i] - a[i] - s * step[i]
            length, factor = chord(kind, d, h, w, g, bend)
            value = va + s * (vb - va) - 0.5 * sag * s * (1.0 - s) + length
            if value < best:
                best, at = value, s
            along, curved = 0.0, sag
            for i in range(n):
                along += g[i] * step[i]
                curved += bend[i] * step[i] * step[i]
            slope = vb - va - sag * (0.5 - s) - along
            curved -= factor * along * along
            if slope > 0.0:
                high = s
            else:
                low = s
            new = s - slope / curved if curved > 0.0 else (0.0 if slope > 0.0 else 1.0)
            new = min(max(new, 0.0), 1.0)
            if (new < low or new > high) or (new != 0.0 and new != 1.0 and abs(new - s) > 0.75):
                new = 0.5 * (low + high)
            if abs(new - s) <= _CLOSE:
                break
            s = new
    for i in range(n):
        d[i] = y[i] - a[i] - at * step[i]
    chord(kind, d, h, w, g, bend)
    return best, at


@kernel
def propose(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, a: FloatArray, b: FloatArray, v: FloatArray,
    sag: FloatArray, middle: FloatArray, room: FloatArray, lowest: FloatArray,
    y: FloatArray, near: int, g: FloatArray, work: FloatArray,
) -> tuple[float, int, float]:  # fmt: skip
    """Return the least value with which posture y can be reached from cells, the cell and its s; fill in ∇c there.

    Cell `near` is likely to be that cell. Blocks of cells (middle, room, lowest), and cells, that can do no better than
    what is found are not looked into.
    """
    m, n = a.shape
    d, step, shifted, trial, bend, none = work[0], work[1], work[2], work[3], work[4], work[5]
    halfway, half = work[6], work[7]
    still = 0.0
    for i in range(n):
        none[i] = 0.0
        still += w[i] * h
    result, cell, place = np.inf, near, 0.0
    for block in range(-1, len(lowest)):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, m)
        if block < 0:
            first, last = near, near + 1
        else:
            short, square = distance(y, y, none, middle[block], room[block], wraps, w, step, shifted)
            if is_far(kind, short, square, still, result - lowest[block]):
                continue
        for k in range(first, last):
            if block >= 0:
                if k == near:
                    continue
                for i in range(n):
                    halfway[i], half[i] = 0.5 * (a[k, i] + b[k, i]), 0.5 * abs(b[k, i] - a[k, i])
                short, square = distance(y, y, none, halfway, half, wraps, w, step, shifted)
                if is_far(kind, short, square, still, result - min(v[k, 0], v[k, 1]) + 0.125 * sag[k]):
                    continue
            for i in range(n):
                step[i] = b[k, i] - a[k, i]
                x = y[i] - 0.5 * (a[k, i] + b[k, i])
                shifted[i] = y[i] - (TAU * np.rint(x / TAU) if wraps[i] else 0.0)
            value, s = best_along(kind, h, w, shifted, a[k], step, v[k, 0], v[k, 1], sag[k], d, trial, bend)
            if value < result:
                result, cell, place = value, k, s
                for i in range(n):
                    g[i] = trial[i]
    return result, cell, place


@kernel
def extend(
    yjoined: BoolArray, ya: FloatArray, yb: FloatArray, cut: BoolArray, values: FloatArray, slopes: FloatArray,
    smooth: bool,
) -> None:  # fmt: skip
    """Lower values at nodes that are `cut` off from where they come from to those that go on from their neighbours.

    Arrays are by cell and end: cut and values (m, 2), slopes (m, 2, n). If `smooth`, slopes change on as they did. A
    proposal may be anything; this one bends so little that little of it is lost.
    """
    m, n = ya.shape
    for way in range(2):
        good, bad = way, 1 - way
        for j in range(m):
            k = j if way == 0 else m - 1 - j
            behind = k - 1 + 2 * way
            joined = 0 <= behind < m and yjoined[k + way]
            if joined and not cut[behind, bad]:
                values[k, good], cut[k, good] = values[behind, bad], False
                slopes[k, good] = slopes[behind, bad]
            if cut[k, good] or not cut[k, bad]:
                continue
            length, before, rise = 0.0, 0.0, 0.0
            for i in range(n):
                length += (yb[k, i] - ya[k, i]) ** 2
                if joined:
                    before += (yb[behind, i] - ya[behind, i]) ** 2
            part = np.sqrt(length / before) if smooth and before > 0.0 else 0.0
            for i in range(n):
                slope = slopes[k, good, i]
                slopes[k, bad, i] = slope + part * (slope - slopes[behind, good, i] if joined else 0.0)
                rise += 0.5 * (slope + slopes[k, bad, i]) * (yb[k, i] - ya[k, i]) * (1 - 2 * way)
            values[k, bad], cut[k, bad] = min(values[k, bad], values[k, good] + rise), False


@kernel
def source_of(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, a: FloatArray, b: FloatArray, v: FloatArray,
    sag: FloatArray, y: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Return the cell, and s in it, from which posture y is reached most cheaply."""
    m, n = a.shape
    blocks, zero = (m + BLOCK - 1) // BLOCK, np.zeros(m)
    middle, room, lowest, gain = np.empty((blocks, n)), np.empty((blocks, n)), np.empty(blocks), np.empty(blocks)
    blocks_of(wraps, a, b, np.zeros((m, n)), v, sag, np.zeros((m, n)), zero, middle, room, lowest, gain)
    _, cell, s = propose(kind, h, w, wraps, a, b, v, sag, middle, room, lowest, y, 0, np.empty(n), np.empty((WORK, n)))
    return cell, s
