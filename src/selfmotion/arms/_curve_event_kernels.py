"""Kernels that find where joints take given values on a self-motion that is known in short pieces.

A piece from a to b, whose tangents are known as well, is looked at as the cubic through both. That tells how often a
joint takes a value there. Where it does so is then found by Newton's method on the chain, the joint standing at that
value. Where a joint nearly turns about at the value, the place where it turns about is found first. Where the tool's
roll turns about, no joint need be at a value that is known: such places are found by bisection.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._curve_kernels import TAU, Chain, Chart, Task, chart_for, null_direction, prepare, settle

_NEAR = 1e-3  # the least by which a joint must pass a value for the cubic to be trusted in that [rad]
_TOUCH = 1e-13  # what a joint may miss a value by, and touch it [rad]
_BISECTIONS = 30
_NEWTON = 8
_OVER = 0.05  # how far beyond a piece its turning points are looked for, in parts of it
LOOKS = 4  # parts of a piece at whose ends it is looked at which way the tool rolls
_STILL = 1e-9  # by what the tool rolls, per radian of self-motion, where it counts as standing still


class Values(NamedTuple):
    """What is looked for: joint joints[p] at values[p], modulo 2π if turning[p]; shape (p,)."""

    joints: IntArray
    values: FloatArray
    turning: BoolArray


class Places(NamedTuple):
    """What is found: postures (m, n), and which of the values is taken there (m,)."""

    q: FloatArray
    which: IntArray


@kernel
def fill_tangents(chain: Chain, task: Task, a: FloatArray, b: FloatArray, chart: Chart, out: FloatArray) -> None:
    """Fill in the tangents (2, n) at both ends of a piece, of the chord's length; the chord where there are none."""
    n = len(a)
    length = 0.0
    for i in range(n):
        length += (b[i] - a[i]) ** 2
    length = np.sqrt(length)
    for end in range(2):
        known = null_direction(chain, task, a if end == 0 else b, chart, out[end])
        along = 0.0
        for i in range(n):
            along += out[end, i] * (b[i] - a[i])
        known = known and abs(along) > 0.5 * length
        for i in range(n):
            out[end, i] = np.copysign(length, along) * out[end, i] if known else b[i] - a[i]


@kernel
def cubic(a: FloatArray, b: FloatArray, tangents: FloatArray, s: float, q: FloatArray) -> None:
    """Fill in the point of a piece's cubic at s, 0 ≤ s ≤ 1."""
    t = 1.0 - s
    for i in range(len(a)):
        q[i] = (
            (1.0 + 2.0 * s) * t * t * a[i] + s * s * (3.0 - 2.0 * s) * b[i]
            + s * t * (t * tangents[0, i] - s * tangents[1, i])
        )  # fmt: skip


@kernel
def pinned(chain: Chain, task: Task, q: FloatArray, joint: int, value: float, farthest: float, chart: Chart) -> bool:
    """Move q to where the joint is at the value and the task is done; return whether that is near."""
    direction = np.zeros(len(q))
    direction[joint] = 1.0
    q[joint] = value
    return settle(chain, task, q, direction, farthest, chart) >= 0.0


@kernel
def turned_about(
    chain: Chain, task: Task, q: FloatArray, joint: int, farthest: float, tangent: FloatArray, chart: Chart
) -> float:
    """Move q along the curve to where the joint turns about, and fill in the tangent.

    Return the joint's second derivative by the arc length there, NaN if it does not turn about nearby.
    """
    n, gone = len(q), 0.0
    for _ in range(_NEWTON):
        if not null_direction(chain, task, q, chart, tangent) or settle(chain, task, q, tangent, farthest, chart) < 0.0:
            return np.nan
        if not null_direction(chain, task, q, chart, tangent) or not prepare(chain, task, q, tangent, chart):
            return np.nan
        bend = chart.curvature[joint]
        step = -tangent[joint] / bend if bend != 0.0 else np.inf
        gone += abs(step)
        if not gone <= farthest:
            return np.nan
        if abs(step) <= 1e-9:
            return float(bend)
        for i in range(n):
            q[i] += step * tangent[i] + 0.5 * step * step * chart.curvature[i]
    return np.nan


@kernel
def extremes(g0: float, g1: float, d0: float, d1: float, found: FloatArray) -> int:
    """List where the cubic with these values and slopes at 0 and 1 turns about, ascending; return how many."""
    c, b, a = d0, 2.0 * (3.0 * (g1 - g0) - 2.0 * d0 - d1), 3.0 * (2.0 * (g0 - g1) + d0 + d1)
    count = 0
    radicand = b * b - 4.0 * a * c
    if radicand < 0.0:
        return 0
    half = -0.5 * (b + np.copysign(np.sqrt(radicand), b))
    for top, bottom in ((half, a), (c, half)):
        if bottom != 0.0 and -_OVER * abs(bottom) <= top * np.sign(bottom) <= (1.0 + _OVER) * abs(bottom):
            found[count] = top / bottom
            count += 1
    if count == 2 and found[0] > found[1]:
        found[0], found[1] = found[1], found[0]
    return count


@kernel
def at(g0: float, g1: float, d0: float, d1: float, s: float) -> float:
    """Return the cubic with these values and slopes at 0 and 1."""
    t = 1.0 - s
    return (1.0 + 2.0 * s) * t * t * g0 + s * s * (3.0 - 2.0 * s) * g1 + s * t * (t * d0 - s * d1)


@kernel
def note(found: Places, count: int, q: FloatArray, which: int) -> int:
    """Append a place if there is room; return how many there are."""
    if count < len(found.q):
        found.q[count] = q
        found.which[count] = which
    return count + 1


@kernel
def about_turning(
    chain: Chain, task: Task, q: FloatArray, joint: int, value: float, which: int, farthest: float, chart: Chart,
    found: Places, count: int,
) -> int:  # fmt: skip
    """Append where, near q, the joint takes a value about which it nearly turns about: nowhere, once or twice."""
    n = len(q)
    tangent, start = np.empty(n), np.empty(n)
    bend = turned_about(chain, task, q, joint, farthest, tangent, chart)
    if np.isnan(bend):
        return count
    rest = value - q[joint]
    if abs(rest) <= _TOUCH:
        return note(found, count, q, which)
    if rest * bend <= 0.0:
        return count
    step = np.sqrt(2.0 * rest / bend)
    for side in (-1.0, 1.0):
        for i in range(n):
            start[i] = q[i] + side * step * tangent[i]
        if pinned(chain, task, start, joint, value, farthest, chart):
            count = note(found, count, start, which)
    return count


@kernel
def find_places(chain: Chain, task: Task, a: FloatArray, b: FloatArray, wanted: Values, found: Places) -> int:
    """List where on the pieces from a to b (k, n) joints take the values; return how many there are, maybe too many.

    A place at a common end of two pieces, or about which a joint turns about near one, is listed by both.
    """
    n = a.shape[1]
    chart, tangents = chart_for(n), np.empty((2, n))
    turns, stops, q = np.empty(2), np.empty(4), np.empty(n)
    count = 0
    for k in range(len(a)):
        fill_tangents(chain, task, a[k], b[k], chart, tangents)
        length = 0.0
        for i in range(n):
            length += abs(b[k, i] - a[k, i])
        for p in range(len(wanted.joints)):
            j, value = wanted.joints[p], wanted.values[p]
            if wanted.turning[p]:
                value += TAU * np.rint((0.5 * (a[k, j] + b[k, j]) - value) / TAU)
            g0, g1, d0, d1 = a[k, j] - value, b[k, j] - value, tangents[0, j], tangents[1, j]
            if min(abs(g0), abs(g1)) > abs(g1 - g0) + abs(d0) + abs(d1) + _NEAR:
                continue
            farthest = 2.0 * length + 1e-6
            stops[0], many = 0.0, 1
            near = False
            for t in range(extremes(g0, g1, d0, d1, turns)):
                if abs(at(g0, g1, d0, d1, turns[t])) <= _NEAR:
                    cubic(a[k], b[k], tangents, min(max(turns[t], 0.0), 1.0), q)
                    before = count
                    count = about_turning(chain, task, q, j, value, p, farthest, chart, found, count)
                    near = near or count > before
                if 0.0 < turns[t] < 1.0:
                    stops[many] = turns[t]
                    many += 1
            stops[many] = 1.0
            for t in range(many):
                low, high = stops[t], stops[t + 1]
                below, above = at(g0, g1, d0, d1, low), at(g0, g1, d0, d1, high)
                if below * above > 0.0 or (near and max(abs(below), abs(above)) <= _NEAR):
                    continue
                for _ in range(_BISECTIONS):
                    middle = 0.5 * (low + high)
                    if at(g0, g1, d0, d1, middle) * below > 0.0:
                        low = middle
                    else:
                        high = middle
                cubic(a[k], b[k], tangents, 0.5 * (low + high), q)
                if pinned(chain, task, q, j, value, farthest, chart):
                    count = note(found, count, q, p)
    return count


@kernel
def rolling(chain: Chain, task: Task, q: FloatArray, chord: FloatArray, tangent: FloatArray, chart: Chart) -> float:
    """Return how fast the tool turns about its z-axis along the self-motion through q, in the chord's sense."""
    if not null_direction(chain, task, q, chart, tangent):
        return 0.0
    along, turn = 0.0, 0.0
    for j in range(len(q)):
        along += tangent[j] * chord[j]
        for i in range(3):
            turn += chart.rotation[i, 2] * chart.axes[j, i] * tangent[j]
    return np.copysign(turn, turn * along)


@kernel
def find_turns(chain: Chain, task: Task, a: FloatArray, b: FloatArray, found: Places) -> int:
    """List where on the pieces from a to b (k, n) the tool's roll turns about; return how many there are."""
    n = a.shape[1]
    chart, tangents, tangent = chart_for(n), np.empty((2, n)), np.empty(n)
    q, chord, count = np.empty(n), np.empty(n), 0
    for k in range(len(a)):
        fill_tangents(chain, task, a[k], b[k], chart, tangents)
        length = 0.0
        for i in range(n):
            chord[i] = b[k, i] - a[k, i]
            length += chord[i] ** 2
        length = np.sqrt(length)
        if length == 0.0:
            continue
        for i in range(n):
            chord[i] /= length
        before = rolling(chain, task, a[k], chord, tangent, chart)
        for look in range(LOOKS):
            low, high = look / LOOKS, (look + 1) / LOOKS
            cubic(a[k], b[k], tangents, high, q)
            if settle(chain, task, q, chord, 2.0 * length + 1e-6, chart) < 0.0:
                break
            after = rolling(chain, task, q, chord, tangent, chart)
            if before * after < 0.0 and max(abs(before), abs(after)) > _STILL:
                there = True
                for _ in range(2 * _BISECTIONS):
                    middle = 0.5 * (low + high)
                    cubic(a[k], b[k], tangents, middle, q)
                    there = settle(chain, task, q, chord, 2.0 * length + 1e-6, chart) >= 0.0
                    if not there:
                        break
                    if rolling(chain, task, q, chord, tangent, chart) * before > 0.0:
                        low = middle
                    else:
                        high = middle
                if there:
                    count = note(found, count, q, 0)
            before = after
    return count
