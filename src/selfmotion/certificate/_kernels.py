"""What is proved of a value function, on plain arrays: pair by pair of cells, nothing skipped that could matter.

:mod:`selfmotion.certificate.tube` says what the arrays are, docs/mathematics why the result is a bound. The proof is
:func:`shortfall` with :func:`carried_sag` and :func:`pair`; the tests that let a pair be skipped are in
``_chord_kernels``, and what lets a cell be dropped is :func:`least_to` and :func:`least_through`. What is proposed, in
``_proposal_kernels``, only makes it sharp. Work arrays are handed down: allocating them costs more than using them.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate._chord_kernels import (
    BLOCK,
    L1,
    ROUNDING,
    TAU,
    TRAVEL,
    blocks_of,
    chord,
    cost,
    distance,
    is_far,
)
from selfmotion.certificate._proposal_kernels import WORK, extend, propose

_CLOSER = 1e-7  # of a cell's length: a tangent plane is off by so much
_SAFELY = 1e-12  # relative, what second-order terms are lowered by: far more than their rounding
_LEAST_PART, _MOST_PART = 1e-3, 0.5  # of what c bends, given up so that deviations lose less


@kernel
def plane_least(value: float, by_s: float, by_t: float, s: float, t: float) -> float:
    """Return the least value on the unit square of the plane through `value` at (s, t)."""
    return value - max(by_s * s, by_s * (s - 1.0)) - max(by_t * t, by_t * (t - 1.0))


@kernel
def shortfall(
    kind: int, h: float, w: FloatArray, d0: FloatArray, stepa: FloatArray, stepb: FloatArray,
    va: float, vb: float, sag: float, wa: float, wb: float, sagging: float,
    ga: FloatArray, gb: FloatArray, deva: FloatArray, devb: FloatArray,
    enough: float, d: FloatArray, g: FloatArray, bend: FloatArray,
) -> float:  # fmt: skip
    """Return a lower bound of the residual of a pair of cells,

    ``V(s) + ga·e + c(d0 + t·stepb + f − s·stepa − e; h) − W(t) − gb·f``,

    over 0 ≤ s, t ≤ 1, |e| ≤ deva, |f| ≤ devb, with ``V(s) = (1 − s) va + s vb − ½ sag s (1 − s)`` and
    ``W(t) = (1 − t) wa + t wb − ½ sagging t (1 − t)``. As far as c bends more than W sags, it is convex in (s, t), so
    every tangent plane bounds it from below; Newton's method only looks for a good one. The rest of what W sags is
    dropped, which lowers the residual. The search ends where the bound is above `enough`.
    """
    n = len(d0)
    if kind == L1:
        return shortfall_l1(w, d0, stepa, stepb, va, vb, wa, wb, ga, gb, deva, devb) - (0.125 + ROUNDING) * sag
    sagging, loss = carried_sag(kind, h, w, d0, stepa, stepb, sag, sagging, deva, devb)
    s, t, best, before, trials = 0.5, 0.5, -np.inf, np.inf, 0
    s0, t0, ds, dt = s, t, 0.0, 0.0
    for _ in range(30):
        for i in range(n):
            d[i] = d0[i] + t * stepb[i] - s * stepa[i]
        length, factor = chord(kind, d, h, w, g, bend)
        value = va + s * (vb - va) - wa - t * (wb - wa) + length
        value += 0.5 * (sagging * t * (1.0 - t) - sag * s * (1.0 - s))
        along_a, along_b, lost = 0.0, 0.0, loss
        size = abs(va) + abs(vb) + abs(wa) + abs(wb) + length + sag + sagging + loss
        for i in range(n):
            along_a += g[i] * stepa[i]
            along_b += g[i] * stepb[i]
            lost += abs(g[i] - ga[i]) * deva[i] + abs(g[i] - gb[i]) * devb[i]
            size += abs(g[i]) * (abs(d0[i]) + abs(stepa[i]) + abs(stepb[i]))
        by_s, by_t = vb - va - sag * (0.5 - s) - along_a, wa - wb + sagging * (0.5 - t) + along_b
        bound = plane_least(value, by_s, by_t, s, t) - lost - ROUNDING * size
        best = max(best, bound)
        if best >= enough:
            return best
        if value > before + ROUNDING * size and trials < 8:  # too far: half the step
            ds, dt, trials = 0.5 * ds, 0.5 * dt, trials + 1
        else:
            s0, t0, before, trials = s, t, value, 0
            hss, hst = sag - factor * along_a * along_a, factor * along_a * along_b
            htt = -sagging - factor * along_b * along_b
            for i in range(n):
                hss += bend[i] * stepa[i] * stepa[i]
                hst -= bend[i] * stepa[i] * stepb[i]
                htt += bend[i] * stepb[i] * stepb[i]
            ds, dt = square_step(by_s, by_t, hss, hst, htt, s, t)
        if abs(ds) + abs(dt) < _CLOSER:
            break
        s, t = min(max(s0 + ds, 0.0), 1.0), min(max(t0 + dt, 0.0), 1.0)
    return best


@kernel
def carried_sag(
    kind: int, h: float, w: FloatArray, d0: FloatArray, stepa: FloatArray, stepb: FloatArray,
    sag: float, sagging: float, deva: FloatArray, devb: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Return how much of `sagging` the residual of :func:`shortfall` stays convex with, and what that costs it.

    With B ≤ ∇²c wherever d may be, ``c(d + x + ε) ≥ c(d) + ∇c(d)·(x + ε) + ½(1 − θ)|x|² − ½(1/θ − 1)|ε|²`` in the norm
    of B, for every θ in (0, 1]. In (s, t) the second-order terms are positive semidefinite as long as `sagging` is at
    most the Schur complement.
    """
    if kind != TRAVEL or sagging <= 0.0:
        return 0.0, 0.0
    hss, hst, htt, loose = 0.0, 0.0, 0.0, 0.0
    for i in range(len(d0)):
        low = d0[i] + min(stepb[i], 0.0) - max(stepa[i], 0.0)
        high = d0[i] + max(stepb[i], 0.0) - min(stepa[i], 0.0)
        off = deva[i] + devb[i]
        far = max(abs(low), abs(high)) + off
        square = h * h + far * far
        bend = (1.0 - _SAFELY) * w[i] * h * h / (square * np.sqrt(square))
        hss += bend * stepa[i] * stepa[i]
        hst -= bend * stepa[i] * stepb[i]
        htt += bend * stepb[i] * stepb[i]
        loose += bend * off * off
    part = min(max(2.0 * np.sqrt(loose * htt) / sagging, _LEAST_PART), _MOST_PART)  # θ: about where both lose least
    whole = (1.0 - part) * hss + sag
    schur = (1.0 - part) * (htt - ((1.0 - part) * hst * hst / whole if whole > 0.0 else 0.0))
    kept = min(sagging, schur - _SAFELY * htt)
    if kept <= 0.0:
        return 0.0, 0.0
    return kept, 0.5 * (1.0 / part - 1.0) * loose * (1.0 + _SAFELY)


@kernel
def square_step(
    by_s: float, by_t: float, hss: float, hst: float, htt: float, s: float, t: float
) -> tuple[float, float]:
    """Return the step from (s, t) to where a quadratic with this gradient and Hessian is least on the unit square."""
    det = hss * htt - hst * hst
    if det > 1e-12 * hss * htt:
        ds, dt = (by_t * hst - by_s * htt) / det, (by_s * hst - by_t * hss) / det
        if 0.0 <= s + ds <= 1.0 and 0.0 <= t + dt <= 1.0:
            return ds, dt
    least, best_s, best_t = np.inf, 0.0, 0.0
    for edge in range(4):
        if edge < 2:
            ds = edge - s
            slope = by_t + hst * ds
            dt = -slope / htt if htt > 0.0 else -np.sign(slope)
            dt = min(max(dt, -t), 1.0 - t)
        else:
            dt = edge - 2 - t
            slope = by_s + hst * dt
            ds = -slope / hss if hss > 0.0 else -np.sign(slope)
            ds = min(max(ds, -s), 1.0 - s)
        value = by_s * ds + by_t * dt + 0.5 * (hss * ds * ds + htt * dt * dt) + hst * ds * dt
        if value < least:
            least, best_s, best_t = value, ds, dt
    return best_s, best_t


@kernel
def shortfall_l1(
    w: FloatArray, d0: FloatArray, stepa: FloatArray, stepb: FloatArray, va: float, vb: float, wa: float, wb: float,
    ga: FloatArray, gb: FloatArray, deva: FloatArray, devb: FloatArray,
) -> float:  # fmt: skip
    """As :func:`shortfall` for l1: the residual is piecewise linear in s and t, so its least value is at a vertex."""
    n = len(d0)
    lost, size = 0.0, abs(va) + abs(vb) + abs(wa) + abs(wb)
    for i in range(n):
        low = d0[i] + min(stepb[i], 0.0) - max(stepa[i], 0.0) - deva[i] - devb[i]
        high = d0[i] + max(stepb[i], 0.0) - min(stepa[i], 0.0) + deva[i] + devb[i]
        if low > 0.0 or high < 0.0:
            slope = w[i] if low > 0.0 else -w[i]
            lost += abs(slope - ga[i]) * deva[i] + abs(slope - gb[i]) * devb[i]
        else:  # |d + e| ≥ |d| − |e|
            lost += (w[i] + abs(ga[i])) * deva[i] + (w[i] + abs(gb[i])) * devb[i]
        size += w[i] * (abs(d0[i]) + abs(stepa[i]) + abs(stepb[i]))
    least = np.inf
    # Lines: the n kinks, then s = 0, s = 1, t = 0, t = 1; as p·s + q·t = c.
    for one in range(n + 4):
        for two in range(one + 1, n + 4):
            p1, q1, c1 = line(one, n, d0, stepa, stepb)
            p2, q2, c2 = line(two, n, d0, stepa, stepb)
            det = p1 * q2 - p2 * q1
            if det == 0.0:
                continue
            s, t = (c1 * q2 - c2 * q1) / det, (p1 * c2 - p2 * c1) / det
            if not (-1e-9 <= s <= 1.0 + 1e-9 and -1e-9 <= t <= 1.0 + 1e-9):
                continue
            s, t = min(max(s, 0.0), 1.0), min(max(t, 0.0), 1.0)
            value = va + s * (vb - va) - wa - t * (wb - wa)
            for i in range(n):
                value += w[i] * abs(d0[i] + t * stepb[i] - s * stepa[i])
            least = min(least, value)
    return least - lost - ROUNDING * size


@kernel
def line(k: int, n: int, d0: FloatArray, stepa: FloatArray, stepb: FloatArray) -> tuple[float, float, float]:
    """Return p, q, c of line k of :func:`shortfall_l1`."""
    if k < n:
        return -stepa[k], stepb[k], -d0[k]
    if k < n + 2:
        return 1.0, 0.0, float(k - n)
    return 0.0, 1.0, float(k - n - 2)


@kernel
def pair(
    kind: int, h: float, w: FloatArray, wraps: BoolArray,
    a: FloatArray, b: FloatArray, dev: FloatArray, va: float, vb: float, sag: float, g: FloatArray, lost: float,
    ya: FloatArray, yb: FloatArray, ydev: FloatArray, wa: float, wb: float, sagging: float, slopes: FloatArray,
    worst: float, still: float, most: float, work: FloatArray,
) -> float:  # fmt: skip
    """Return the larger of `worst` and what the new cell must lose for the sake of an old one."""
    n = len(w)
    center, spread, halfway, around, d0, stepa, stepb = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    loose = 0.0
    for i in range(n):
        halfway[i] = 0.5 * (a[i] + b[i])
        around[i] = 0.5 * abs(b[i] - a[i]) + dev[i]
        loose += abs(g[i]) * dev[i]
    short, square = distance(ya, yb, ydev, halfway, around, wraps, w, center, spread)
    least = min(va, vb) - 0.125 * sag
    need = most - least + loose + lost - worst
    need += ROUNDING * (abs(most) + abs(least) + loose + abs(lost) + abs(worst))
    if is_far(kind, short, square, still, need):
        return worst
    # A free joint near half a turn may go either way round.
    ways = 1
    for i in range(n):
        if wraps[i] and abs(center[i]) + spread[i] >= np.pi:
            ways *= 2
    for way in range(ways):
        left = way
        for i in range(n):
            stepa[i], stepb[i] = b[i] - a[i], yb[i] - ya[i]
            x = center[i]
            if wraps[i] and abs(x) + spread[i] >= np.pi:
                x -= TAU * np.sign(x) * (left % 2)
                left //= 2
            d0[i] = x + 0.5 * (stepa[i] - stepb[i])
        found = shortfall(
            kind, h, w, d0, stepa, stepb, va, vb, sag, wa, wb, sagging, g, slopes, dev, ydev, lost - worst,
            work[7], work[8], work[9],
        )  # fmt: skip
        worst = max(worst, lost - found)
    return worst


@kernel
def lost_by(
    kind: int, h: float, w: FloatArray, wraps: BoolArray,
    a: FloatArray, b: FloatArray, dev: FloatArray, v: FloatArray, sag: FloatArray, g: FloatArray, lost: FloatArray,
    middle: FloatArray, room: FloatArray, gain: FloatArray, near: int,
    ya: FloatArray, yb: FloatArray, ydev: FloatArray, wa: float, wb: float, sagging: float, slopes: FloatArray,
    still: float, work: FloatArray,
) -> float:  # fmt: skip
    """Return what a new cell must lose for the sake of all old ones; `near` is likely to be the worst of them."""
    most = max(wa, wb)
    for i in range(len(w)):
        most += abs(slopes[i]) * ydev[i]
    most += ROUNDING * abs(most)
    worst = pair(
        kind, h, w, wraps, a[near], b[near], dev[near], v[near, 0], v[near, 1], sag[near], g[near], lost[near],
        ya, yb, ydev, wa, wb, sagging, slopes, -np.inf, still, most, work,
    )  # fmt: skip
    for block in range(len(gain)):
        need = (most + gain[block] - worst) + ROUNDING * (abs(gain[block]) + abs(worst))
        short, square = distance(ya, yb, ydev, middle[block], room[block], wraps, w, work[0], work[1])
        if is_far(kind, short, square, still, need):
            continue
        for j in range(block * BLOCK, min(block * BLOCK + BLOCK, len(a))):
            worst = pair(
                kind, h, w, wraps, a[j], b[j], dev[j], v[j, 0], v[j, 1], sag[j], g[j], lost[j],
                ya, yb, ydev, wa, wb, sagging, slopes, worst, still, most, work,
            )  # fmt: skip
    return worst


@kernel
def step_values(
    kind: int, h: float, w: FloatArray, wraps: BoolArray,
    a: FloatArray, b: FloatArray, dev: FloatArray, v: FloatArray, sag: FloatArray, g: FloatArray, lost: FloatArray,
    severed: BoolArray, extended: bool,
    ya: FloatArray, yb: FloatArray, ydev: FloatArray, yjoined: BoolArray,
    out: FloatArray, sagging: FloatArray, slopes: FloatArray, out_lost: FloatArray,
) -> None:  # fmt: skip
    """Carry values from the cells of one slice (a, b, dev, with v, sag, g, lost) to those of the next (ya, yb, ydev).

    Proposes values `out` (m, 2) at the ends of the new cells, how they sag between, `sagging` (m,), and `slopes`
    (m, n), and finds how much each cell must lose, `out_lost` (m,), so that no pair falls short: the proved value is
    the proposed one less what is lost. If `extended`, proposals go on smoothly where the tube is cut off, ends of cells
    where it goes on being `severed`.
    """
    m, n = a.shape
    count = len(ya)
    work = np.empty((WORK, n))
    blocks = (m + BLOCK - 1) // BLOCK
    middle, room, lowest, gain = np.empty((blocks, n)), np.empty((blocks, n)), np.empty(blocks), np.empty(blocks)
    blocks_of(wraps, a, b, dev, v, sag, g, lost, middle, room, lowest, gain)
    near, sources = 0, np.zeros(count, np.int64)
    ends, cut = np.empty((count, 2, n)), np.zeros((count, 2), np.bool_)
    for k in range(count):
        for end in range(2):
            if end == 0 and k > 0 and yjoined[k]:
                out[k, 0], cut[k, 0] = out[k - 1, 1], cut[k - 1, 1]
                ends[k, 0] = ends[k - 1, 1]
                continue
            out[k, end], near, s = propose(
                kind, h, w, wraps, a, b, v, sag, middle, room, lowest,
                ya[k] if end == 0 else yb[k], near, ends[k, end], work,
            )  # fmt: skip
            cut[k, end] = (s == 0.0 and severed[near, 0]) or (s == 1.0 and severed[near, 1])
        sources[k] = near
    if extended:
        extend(yjoined, ya, yb, cut, out, ends, kind == TRAVEL)
    still = w.sum() * h * (1.0 - ROUNDING)
    for k in range(count):
        sagging[k] = 0.0
        for i in range(n):
            slopes[k, i] = 0.5 * (ends[k, 0, i] + ends[k, 1, i])
            sagging[k] += (ends[k, 1, i] - ends[k, 0, i]) * (yb[k, i] - ya[k, i])
        sagging[k] = max(sagging[k], 0.0) if kind == TRAVEL else 0.0
        out_lost[k] = lost_by(
            kind, h, w, wraps, a, b, dev, v, sag, g, lost, middle, room, gain, sources[k],
            ya[k], yb[k], ydev[k], out[k, 0], out[k, 1], sagging[k], slopes[k], still, work,
        )  # fmt: skip


@kernel
def least_to(
    kind: int, h: float, w: FloatArray, wraps: BoolArray,
    a: FloatArray, b: FloatArray, dev: FloatArray, v: FloatArray, sag: FloatArray, g: FloatArray, lost: FloatArray,
    ya: FloatArray, yb: FloatArray, ydev: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in, per cell of the next slice, a bound on the cost of motions that arrive there: cells are boxes here.

    A cell's least value and the chord over the gaps between two boxes are less than what :func:`step_values` finds, at
    a small part of its cost.
    """
    m, n = a.shape
    middle, room, lowest, apart = np.empty((m, n)), np.empty((m, n)), np.empty(m), np.empty(n)
    for j in range(m):
        loose, size = 0.0, 0.0
        for i in range(n):
            middle[j, i], room[j, i] = 0.5 * (a[j, i] + b[j, i]), 0.5 * abs(b[j, i] - a[j, i]) + dev[j, i]
            loose += abs(g[j, i]) * dev[j, i]
        least = min(v[j, 0], v[j, 1])
        size = abs(least) + sag[j] + loose + abs(lost[j])
        lowest[j] = least - 0.125 * sag[j] - loose - lost[j] - ROUNDING * size
    for k in range(len(ya)):
        out[k] = np.inf
        for j in range(m):
            for i in range(n):
                x = 0.5 * (ya[k, i] + yb[k, i]) - middle[j, i]
                if wraps[i]:
                    x -= TAU * np.rint(x / TAU)
                apart[i] = max(abs(x) - (0.5 * abs(yb[k, i] - ya[k, i]) + ydev[k, i] + room[j, i]), 0.0)
            length = cost(kind, apart, h, w)
            out[k] = min(out[k], lowest[j] + length - ROUNDING * (abs(lowest[j]) + length))


@kernel
def least_through(
    dev: FloatArray, forward: FloatArray, sag: FloatArray, slopes: FloatArray, lost: FloatArray,
    backward: FloatArray, back_sag: FloatArray, back_slopes: FloatArray, back_lost: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in, per cell, the least cost of a motion through it: both values, where their sum is least, less losses."""
    m, n = slopes.shape
    for k in range(m):
        less, size = lost[k] + back_lost[k], abs(lost[k]) + abs(back_lost[k])
        for i in range(n):
            less += abs(slopes[k, i] + back_slopes[k, i]) * dev[k, i]
            size += (abs(slopes[k, i]) + abs(back_slopes[k, i])) * dev[k, i]
        at_a, at_b, both = forward[k, 0] + backward[k, 0], forward[k, 1] + backward[k, 1], sag[k] + back_sag[k]
        least, step = min(at_a, at_b), at_b - at_a
        if abs(step) < 0.5 * both:  # the parabola is least between the ends
            least = 0.5 * (at_a + at_b) - 0.125 * both - 0.5 * step * step / both
        out[k] = least - less - ROUNDING * (abs(at_a) + abs(at_b) + both + size)
