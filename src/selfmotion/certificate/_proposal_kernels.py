"""Proposals of a value function on plain arrays: what is said here only makes the proof sharp, nothing rests on it."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate._arrays import Arcs, Boxes, Values
from selfmotion.certificate._chord_kernels import BLOCK, L1, TAU, boxes_of, chord, cost, is_far

WORK = 7  # rows of the work arrays that are handed down
_BEYOND = 2.0  # how far cells at the ends of a tube are thought to go on, in slab widths [rad]
_STEPS = 30
_CLOSE = 1e-8  # of a cell: what a value bends comes from differences of slopes, which are off by as much as the source


@kernel
def best_along(
    kind: int, h: float, w: FloatArray, y: FloatArray, cells: Arcs, values: Values, k: int, first: float, last: float,
    d: FloatArray, g: FloatArray, bend: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Minimise the value at s of cell k and the chord from there to y over first ≤ s ≤ last; return it and s.

    Fills in ∇c of the chord in g.
    """
    n = len(y)
    a, b, bow, sag = cells.a[k], cells.b[k], cells.bow[k], values.sag[k]
    va, rise = values.v[k, 0], values.v[k, 1] - values.v[k, 0]
    best, at = np.inf, first
    if kind == L1:
        for j in range(n + 2):
            if j < n and b[j] == a[j]:
                continue
            s = first if j == n else last if j > n else min(max((y[j] - a[j]) / (b[j] - a[j]), first), last)
            for i in range(n):
                d[i] = y[i] - a[i] - s * (b[i] - a[i])
            value = va + s * rise + cost(kind, d, h, w)
            if value < best:
                best, at = value, s
    else:
        low, high, s, seen_low, seen_high = first, last, 0.5, False, False
        step, before = np.inf, np.inf
        for _ in range(_STEPS):
            for i in range(n):
                d[i] = y[i] - a[i] - s * (b[i] - a[i]) - 0.5 * s * (1.0 - s) * bow[i]
            length, factor = chord(kind, d, h, w, g, bend)
            value = va + s * rise - 0.5 * sag * s * (1.0 - s) + length
            if value < best:
                best, at = value, s
            along, curved = 0.0, sag
            for i in range(n):
                tangent = b[i] - a[i] + (0.5 - s) * bow[i]
                along += g[i] * tangent
                curved += bend[i] * tangent * tangent + g[i] * bow[i]
            slope = rise - sag * (0.5 - s) - along
            curved -= factor * along * along
            if slope > 0.0:
                high, seen_high = s, True
            else:
                low, seen_low = s, True
            new = s - slope / curved if curved > 0.0 else (first if slope > 0.0 else last)
            if new >= high:  # an end is looked at once; beyond what was looked at, halving is safe
                new = 0.5 * (low + high) if seen_high else high
            elif new <= low:
                new = 0.5 * (low + high) if seen_low else low
            elif seen_low and seen_high and abs(new - s) > 0.5 * before:  # Newton's method goes to and fro
                new = 0.5 * (low + high)
            if abs(new - s) <= _CLOSE:
                break
            s, step, before = new, abs(new - s), step
    for i in range(n):
        d[i] = y[i] - a[i] - at * (b[i] - a[i]) - 0.5 * at * (1.0 - at) * bow[i]
    chord(kind, d, h, w, g, bend)
    return best, at


@kernel
def is_out_of_reach(
    kind: int, wraps: BoolArray, w: FloatArray, y: FloatArray, boxes: Boxes, j: int, still: float, most: float
) -> bool:
    """Return whether posture y is reached from box j for more than `most` only."""
    short, square = 0.0, 0.0
    for i in range(len(w)):
        x = y[i] - boxes.middle[j, i]
        if wraps[i]:
            x -= TAU * np.rint(x / TAU)
        x = max(abs(x) - boxes.room[j, i], 0.0) * w[i]
        short += x
        square += x * x
    return is_far(kind, short, square, still, most - boxes.lowest[j])


@kernel
def propose(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, cells: Arcs, values: Values, severed: BoolArray,
    blocks: Boxes, boxes: Boxes, y: FloatArray, near: int, g: FloatArray, work: FloatArray,
) -> tuple[float, int, float, bool]:  # fmt: skip
    """Return the least value with which posture y can be reached from cells, the cell and its s; fill in ∇c there.

    Cells are thought to go on beyond `severed` (m, 2) ends, though not for ever; the last is whether y may come from
    further away. Cell `near` is likely to be the one. `blocks` of cells, and `boxes` of single ones, that can do no
    better than what is found are not looked into.
    """
    a, b = cells.a, cells.b
    m, n = a.shape
    cut = False
    d, shifted, trial, bend = work[0], work[1], work[2], work[3]
    still = w.sum() * h
    result, cell, place = np.inf, near, 0.0
    for block in range(-1, len(blocks.lowest)):
        first, last = block * BLOCK, min(block * BLOCK + BLOCK, m)
        if block < 0:
            first, last = near, near + 1
        elif is_out_of_reach(kind, wraps, w, y, blocks, block, still, result):
            continue
        for k in range(first, last):
            if block >= 0 and (k == near or is_out_of_reach(kind, wraps, w, y, boxes, k, still, result)):
                continue
            length = 0.0
            for i in range(n):
                length = max(length, abs(b[k, i] - a[k, i]))
                x = y[i] - boxes.middle[k, i]
                shifted[i] = y[i] - (TAU * np.rint(x / TAU) if wraps[i] else 0.0)
            beyond = _BEYOND * h / length if length > 0.0 else 0.0
            value, s = best_along(
                kind, h, w, shifted, cells, values, k, -beyond * severed[k, 0], 1.0 + beyond * severed[k, 1],
                d, trial, bend,
            )  # fmt: skip
            if value < result:
                result, cell, place = value, k, s
                cut = (s == -beyond and severed[k, 0]) or (s == 1.0 + beyond and severed[k, 1])
                for i in range(n):
                    g[i] = trial[i]
    return result, cell, place, cut


@kernel
def extend(new: Arcs, joined: BoolArray, cut: BoolArray, values: FloatArray, slopes: FloatArray, bent: bool) -> None:
    """Lower values at nodes that are `cut` off from where they come from to those that go on from their neighbours.

    Arrays are by cell and end: cut and values (m, 2), slopes (m, 2, n). If `bent`, slopes change on as they did. A
    proposal may be anything; this one bends so little that little of it is lost.
    """
    m, n = new.a.shape
    for way in range(2):
        good, bad = way, 1 - way
        for j in range(m):
            k = j if way == 0 else m - 1 - j
            behind = k - 1 + 2 * way
            follows = 0 <= behind < m and joined[k + way]
            if follows and not cut[behind, bad]:
                values[k, good], cut[k, good] = values[behind, bad], False
                slopes[k, good] = slopes[behind, bad]
            if cut[k, good] or not cut[k, bad]:
                continue
            length, before, rise = 0.0, 0.0, 0.0
            for i in range(n):
                length += (new.b[k, i] - new.a[k, i]) ** 2
                if follows:
                    before += (new.b[behind, i] - new.a[behind, i]) ** 2
            part = np.sqrt(length / before) if bent and before > 0.0 else 0.0
            for i in range(n):
                slope = slopes[k, good, i]
                slopes[k, bad, i] = slope + part * (slope - slopes[behind, good, i] if follows else 0.0)
                along = new.b[k, i] - new.a[k, i]
                rise += (0.5 * (slope + slopes[k, bad, i]) * along) * (1 - 2 * way)
                rise -= (slopes[k, bad, i] - slope) * new.bow[k, i] / 12.0
            values[k, bad], cut[k, bad] = min(values[k, bad], values[k, good] + rise), False


@kernel
def source_of(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, cells: Arcs, values: Values, y: FloatArray,
) -> tuple[int, float]:  # fmt: skip
    """Return the cell, and s in it, from which posture y is reached most cheaply."""
    m, n = cells.a.shape
    blocks, boxes = boxes_of(wraps, cells, values, BLOCK), boxes_of(wraps, cells, values, 1)
    _, cell, s, _ = propose(
        kind, h, w, wraps, cells, values, np.zeros((m, 2), np.bool_), blocks, boxes, y, 0, np.empty(n),
        np.empty((WORK, n)),
    )  # fmt: skip
    return cell, s
