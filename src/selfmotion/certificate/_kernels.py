"""What is proved of a value function, on plain arrays: pair by pair of cells, nothing skipped that could matter.

:mod:`selfmotion.certificate._arrays` says what the arrays are, docs/mathematics why the result is a bound. The proof is
:func:`shortfall` with :func:`bound_at` and :func:`kept_sag`, and :func:`pair`; the tests that let a pair be skipped are
in ``_chord_kernels``, and what lets a cell be dropped is :func:`least_to` and :func:`least_through`. What is proposed,
in ``_proposal_kernels``, only makes it sharp. Work arrays are handed down: allocating them costs more than using them.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.certificate._arrays import Arcs, Boxes, Values
from selfmotion.certificate._chord_kernels import (
    ANGLES,
    BLOCK,
    L1,
    L2,
    ROUNDING,
    TAU,
    TRAVEL,
    boxes_of,
    chord,
    cost,
    distance,
    is_far,
    loose,
)
from selfmotion.certificate._proposal_kernels import WORK, extend, propose

_CLOSER = 1e-7  # of a cell's length: a tangent plane is off by so much
_TRIALS = 30
_DAMPING = 0.01  # of a residual's second derivatives: what is added where a step did not lower it
_SAFELY = 1e-12  # relative, what second-order terms are lowered by: far more than their rounding
_LEAST_PART, _MOST_PART = 1e-6, 0.5  # of what c bends, given up so that deviations lose less


@kernel
def plane_least(value: float, by_s: float, by_t: float, s: float, t: float) -> float:
    """Return the least value on the unit square of the plane through `value` at (s, t)."""
    return value - max(by_s * s, by_s * (s - 1.0)) - max(by_t * t, by_t * (t - 1.0))


@kernel
def shortfall(
    kind: int, h: float, w: FloatArray, d0: FloatArray, old: Arcs, values: Values, j: int,
    new: Arcs, proposed: Values, k: int, enough: float, work: FloatArray,
) -> float:  # fmt: skip
    """Return a lower bound of the residual of old cell j, with values V, and new cell k, with proposed values W,

    ``V(s) + g·e + c(d0 + y(t) + f − x(s) − e; h) − W(t) − g'·f``,

    over 0 ≤ s, t ≤ 1, |e| ≤ rest, |f| ≤ rest', x and y being the cells' parabolas from their ends a on. The search ends
    where the bound is above `enough`; Newton's method only looks for a good plane.
    """
    n = len(w)
    if kind == L1:
        return shortfall_l1(w, d0, old, values, j, new, proposed, k)
    d, g, bend, least_bend = work[3], work[4], work[5], work[6]
    angles = rounded_angles(w, old, j, new, k)
    va, rise, sag = values.v[j, 0], values.v[j, 1] - values.v[j, 0], values.sag[j]
    wa, climb, sagging = proposed.v[k, 0], proposed.v[k, 1] - proposed.v[k, 0], proposed.sag[k]
    s, t, best, before, damping = 0.5, 0.5, -np.inf, np.inf, 0.0
    s0, t0, ds, dt, last = s, t, 0.0, 0.0, False
    slope_s, slope_t, bend_s, bend_st, bend_t = 0.0, 0.0, 0.0, 0.0, 0.0
    for trial in range(_TRIALS):
        for i in range(n):
            at_x = s * (old.b[j, i] - old.a[j, i]) + 0.5 * s * (1.0 - s) * old.bow[j, i]
            at_y = t * (new.b[k, i] - new.a[k, i]) + 0.5 * t * (1.0 - t) * new.bow[k, i]
            d[i] = d0[i] + at_y - at_x
        length, factor = chord(kind, d, h, w, g, bend)
        value = va + s * rise - wa - t * climb + length + 0.5 * (sagging * t * (1.0 - t) - sag * s * (1.0 - s))
        along_a, along_b, lost = 0.0, 0.0, angles
        hss, hst, htt = sag, 0.0, -sagging
        size = abs(va) + abs(rise) + abs(wa) + abs(climb) + length + abs(sag) + abs(sagging)
        for i in range(n):
            one = old.b[j, i] - old.a[j, i] + (0.5 - s) * old.bow[j, i]
            two = new.b[k, i] - new.a[k, i] + (0.5 - t) * new.bow[k, i]
            along_a += g[i] * one
            along_b += g[i] * two
            hss += bend[i] * one * one + g[i] * old.bow[j, i]
            hst -= bend[i] * one * two
            htt += bend[i] * two * two - g[i] * new.bow[k, i]
            lost += abs(g[i] - values.g[j, i]) * old.rest[j, i] + abs(g[i] - proposed.g[k, i]) * new.rest[k, i]
            size += abs(g[i]) * (abs(d0[i]) + abs(one) + abs(two) + abs(old.bow[j, i]) + abs(new.bow[k, i]))
        by_s, by_t = rise - sag * (0.5 - s) - along_a, -climb + sagging * (0.5 - t) + along_b
        if last or plane_least(value, by_s, by_t, s, t) - lost - ROUNDING * size >= enough:
            fill_least_bend(kind, h, w, d0, d, old, j, new, k, least_bend)
            bound = bound_at(value, by_s, by_t, s, t, old, values, j, new, proposed, k, g, least_bend)
            best = max(best, bound - lost - ROUNDING * size)
            if last or best >= enough:
                break
        if value > before + ROUNDING * size:  # too far
            damping = max(10.0 * damping, _DAMPING * (bend_s + abs(bend_t)))
        else:
            s0, t0, before, damping, slope_s, slope_t = s, t, value, 0.1 * damping, by_s, by_t
            bend_s, bend_st = hss - factor * along_a**2, hst + factor * along_a * along_b
            bend_t = htt - factor * along_b**2
        ds, dt = square_step(slope_s, slope_t, bend_s + damping, bend_st, bend_t + damping, s0, t0)
        last = abs(ds) + abs(dt) < _CLOSER
        if trial == _TRIALS - 2:
            last, ds, dt = True, 0.0, 0.0
        s, t = min(max(s0 + ds, 0.0), 1.0), min(max(t0 + dt, 0.0), 1.0)
    return best


@kernel
def rounded_angles(w: FloatArray, old: Arcs, j: int, new: Arcs, k: int) -> float:
    """Return what the cost of a chord between two cells is off by because their difference d0 is rounded."""
    total = 0.0
    for i in range(len(w)):
        size = abs(old.a[j, i]) + abs(old.b[j, i]) + abs(new.a[k, i]) + abs(new.b[k, i]) + TAU
        total += 2.0 * w[i] * ANGLES * size
    return total


@kernel
def fill_least_bend(
    kind: int, h: float, w: FloatArray, d0: FloatArray, d: FloatArray, old: Arcs, j: int, new: Arcs, k: int,
    least_bend: FloatArray,
) -> None:  # fmt: skip
    """Fill in β (n,) with ``c(d + z) ≥ c(d) + ∇c(d)·z + ½ Σ β_i z_i²`` for all d + z that the pair can have.

    One joint's ``2 (c(d + z) − c(d) − c'(d) z)/z²`` is ``2 w h²/(A (A B + A² + d z))``, A and B being the lengths
    ``(h² + d²)^½`` and ``(h² + (d + z)²)^½``. The denominator is convex in z: largest at an end.
    """
    for i in range(len(w)):
        least_bend[i] = 0.0
        if kind != TRAVEL:
            continue
        stepa, stepb = old.b[j, i] - old.a[j, i], new.b[k, i] - new.a[k, i]
        off = old.dev[j, i] + new.dev[k, i]
        low, high = d0[i] + min(stepb, 0.0) - max(stepa, 0.0) - off, d0[i] + max(stepb, 0.0) - min(stepa, 0.0) + off
        most, here = 0.0, np.sqrt(h * h + d[i] * d[i])
        for end in range(2):
            x = low if end == 0 else high
            there = np.sqrt(h * h + x * x)
            below = here * (here * there + h * h + d[i] * x)
            most = max(most, below + ROUNDING * here * (here * there + h * h + abs(d[i] * x)))
        least_bend[i] = (1.0 - _SAFELY) * 2.0 * w[i] * h * h / most


@kernel
def bound_at(
    value: float, by_s: float, by_t: float, s: float, t: float, old: Arcs, values: Values, j: int,
    new: Arcs, proposed: Values, k: int, g: FloatArray, least_bend: FloatArray,
) -> float:  # fmt: skip
    """Return a bound of the residual of a pair from its value and derivatives at (s, t), as if slopes were right.

    In second order it bends up in s by ``sag + g·bow`` and down in t by ``sagging + g·bow'``; what c bends makes it
    convex, as far as W sags no more than :func:`kept_sag` says, so that the tangent plane is below it. The rest of what
    W sags is dropped, which lowers the residual.
    """
    up, down, size = values.sag[j], proposed.sag[k], abs(values.sag[j]) + abs(proposed.sag[k])
    for i in range(len(g)):
        up += g[i] * old.bow[j, i]
        down += g[i] * new.bow[k, i]
    wide = max(s, 1.0 - s)
    kept, loss = min(down, 0.0), 0.5 * max(-up, 0.0) * wide * wide
    if down > 0.0 or up < 0.0:
        carried, lost = kept_sag(up, down, s, t, old, j, new, k, least_bend)
        if 0.125 * carried - lost > 0.125 * kept - loss:
            kept, loss = carried, lost
    dropped = down - kept
    plane = plane_least(value - 0.5 * dropped * t * (1.0 - t), by_s, by_t - dropped * (0.5 - t), s, t)
    return plane - loss - ROUNDING * (size + abs(up) + abs(down) + loss)


@kernel
def kept_sag(
    up: float, down: float, s: float, t: float, old: Arcs, j: int, new: Arcs, k: int, least_bend: FloatArray
) -> tuple[float, float]:
    """Return how much of `down` what c bends makes up for, and what that costs.

    docs/mathematics, "Values", with its letters: x is the linear part of what d differs by from the plane's point, and
    what both cells bend, together with their deviations, is at most r|x| + E in the norm of `least_bend`.
    """
    n = len(least_bend)
    aa, ab, bb, off = 0.0, 0.0, 0.0, 0.0
    for i in range(n):
        one = old.b[j, i] - old.a[j, i] + (0.5 - s) * old.bow[j, i]
        two = new.b[k, i] - new.a[k, i] + (0.5 - t) * new.bow[k, i]
        aa += least_bend[i] * one * one
        ab += least_bend[i] * one * two
        bb += least_bend[i] * two * two
        off += least_bend[i] * (old.rest[j, i] + new.rest[k, i]) ** 2
    if bb <= 0.0:
        return -np.inf, 0.0
    # Both cells bend like one curve as far as their curvatures agree; lengths and directions need not.
    mean, differ, alone = 0.0, 0.0, 0.0
    for i in range(n):
        curve = new.bow[k, i] / bb
        other = old.bow[j, i] / aa if aa > 0.0 else curve
        mean += least_bend[i] * (0.5 * (curve + other)) ** 2
        differ += least_bend[i] * (curve - other) ** 2
        alone += least_bend[i] * old.bow[j, i] ** 2
    reach_a, reach_b = np.sqrt(aa) * max(s, 1.0 - s), np.sqrt(bb) * max(t, 1.0 - t)
    r = 0.5 * (reach_a + reach_b) * np.sqrt(mean)
    e = 0.25 * (reach_a**2 + reach_b**2) * np.sqrt(differ) + np.sqrt(off)
    if aa == 0.0:  # an old cell that stands still in first order may bend all the same
        e += 0.5 * max(s, 1.0 - s) ** 2 * np.sqrt(alone)
    r, e = r * (1.0 + _SAFELY), e * (1.0 + _SAFELY)
    part = np.sqrt(2.0 * r * r + 8.0 * e * e * bb / max(up * up, down * down))  # about where both losses are least
    part = min(max(part, _LEAST_PART), _MOST_PART)
    keep = 1.0 - part - 2.0 * (1.0 / part - 1.0) * r * r - _SAFELY
    whole = up + keep * aa
    if keep <= 0.0 or whole < 0.1 * keep * aa:
        return -np.inf, 0.0
    schur = keep * (bb - (keep * ab * ab / whole if whole > 0.0 else 0.0))
    return min(down, schur - _SAFELY * bb), (1.0 / part - 1.0) * e * e * (1.0 + _SAFELY)


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
    w: FloatArray, d0: FloatArray, old: Arcs, values: Values, j: int, new: Arcs, proposed: Values, k: int
) -> float:
    """As :func:`shortfall` for l1: the residual is piecewise linear in s and t, so its least value is at a vertex.

    What cells bend and values sag is lost.
    """
    n = len(w)
    stepa, stepb = old.b[j] - old.a[j], new.b[k] - new.a[k]
    va, vb, wa, wb = values.v[j, 0], values.v[j, 1], proposed.v[k, 0], proposed.v[k, 1]
    lost = 0.125 * (max(values.sag[j], 0.0) + max(-proposed.sag[k], 0.0)) + rounded_angles(w, old, j, new, k)
    size = abs(va) + abs(vb) + abs(wa) + abs(wb)
    for i in range(n):
        ga, gb, resta, restb = values.g[j, i], proposed.g[k, i], old.rest[j, i], new.rest[k, i]
        off = old.dev[j, i] + new.dev[k, i]
        low, high = d0[i] + min(stepb[i], 0.0) - max(stepa[i], 0.0), d0[i] + max(stepb[i], 0.0) - min(stepa[i], 0.0)
        lost += 0.125 * w[i] * (abs(old.bow[j, i]) + abs(new.bow[k, i]))
        if low - off > 0.0 or high + off < 0.0:
            slope = w[i] if low - off > 0.0 else -w[i]
            lost += abs(slope - ga) * resta + abs(slope - gb) * restb
        else:  # |d + e| ≥ |d| − |e|
            lost += (w[i] + abs(ga)) * resta + (w[i] + abs(gb)) * restb
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
    return least - lost - ROUNDING * (size + lost)


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
    kind: int, h: float, w: FloatArray, wraps: BoolArray, old: Arcs, values: Values, boxes: Boxes, j: int,
    new: Arcs, proposed: Values, k: int, worst: float, still: float, most: float, work: FloatArray,
) -> float:  # fmt: skip
    """Return the larger of `worst` and what new cell k must lose for the sake of old cell j, whose box is given."""
    n = len(w)
    center, spread, d0 = work[0], work[1], work[2]
    short, square = distance(new, k, boxes, j, wraps, w, center, spread)
    deepest, lost = boxes.deepest[j], values.lost[j]
    need = (most + deepest - worst) + ROUNDING * (abs(most) + abs(deepest) + abs(worst))
    if is_far(kind, short, square, still, need):
        return worst
    for i in range(n):
        if wraps[i] and spread[i] >= np.pi:  # any way round: these are boxes, as beside singular postures
            length = short if kind == L1 else np.sqrt(square) if kind == L2 else np.sqrt(short * short + still * still)
            return max(worst, most + deepest - length + ROUNDING * (abs(most) + abs(deepest) + length))
    # A free joint near half a turn may go either way round.
    ways = 1
    for i in range(n):
        if wraps[i] and abs(center[i]) + spread[i] >= np.pi:
            ways *= 2
    for way in range(ways):
        left = way
        for i in range(n):
            x = center[i]
            if wraps[i] and abs(x) + spread[i] >= np.pi:
                x -= TAU * np.sign(x) * (left % 2)
                left //= 2
            d0[i] = x + 0.5 * (old.b[j, i] - old.a[j, i] - (new.b[k, i] - new.a[k, i]))
        worst = max(worst, lost - shortfall(kind, h, w, d0, old, values, j, new, proposed, k, lost - worst, work))
    return worst


@kernel
def lost_by(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, old: Arcs, values: Values, blocks: Boxes, boxes: Boxes,
    near: int, new: Arcs, proposed: Values, k: int, still: float, work: FloatArray,
) -> float:  # fmt: skip
    """Return what new cell k must lose for the sake of all old ones; `near` is likely to be the worst of them."""
    most = max(proposed.v[k, 0], proposed.v[k, 1]) + 0.125 * max(-proposed.sag[k], 0.0) + loose(proposed, new, k)
    most += ROUNDING * (abs(most) + abs(proposed.sag[k]))
    worst = pair(kind, h, w, wraps, old, values, boxes, near, new, proposed, k, -np.inf, still, most, work)
    for block in range(len(blocks.deepest)):
        deepest = blocks.deepest[block]
        need = (most + deepest - worst) + ROUNDING * (abs(most) + abs(deepest) + abs(worst))
        short, square = distance(new, k, blocks, block, wraps, w, work[0], work[1])
        if is_far(kind, short, square, still, need):
            continue
        for j in range(block * BLOCK, min(block * BLOCK + BLOCK, len(old.a))):
            if j != near:
                worst = pair(kind, h, w, wraps, old, values, boxes, j, new, proposed, k, worst, still, most, work)
    return worst


@kernel
def step_values(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, old: Arcs, values: Values, severed: BoolArray,
    new: Arcs, joined: BoolArray, found: Values,
) -> None:  # fmt: skip
    """Carry values from the cells of one slice to those of the next, `found`.

    Proposes values at the ends of the new cells, how they sag between, and slopes, and finds how much each cell must
    lose so that no pair falls short: the proved value is the proposed one less what is lost. Proposals are made as if
    old cells went on beyond their `severed` (m, 2) ends. New cells that are `joined` (k,) begin where the one before
    ends.
    """
    n = old.a.shape[1]
    count = len(new.a)
    work = np.empty((WORK, n))
    blocks, boxes = boxes_of(wraps, old, values, BLOCK), boxes_of(wraps, old, values, 1)
    near, sources = 0, np.zeros(count, np.int64)
    ends, cut = np.empty((count, 2, n)), np.zeros((count, 2), np.bool_)
    for k in range(count):
        for end in range(2):
            if end == 0 and k > 0 and joined[k]:
                found.v[k, 0], cut[k, 0] = found.v[k - 1, 1], cut[k - 1, 1]
                ends[k, 0] = ends[k - 1, 1]
                continue
            found.v[k, end], near, _, cut[k, end] = propose(
                kind, h, w, wraps, old, values, severed, blocks, boxes, new.a[k] if end == 0 else new.b[k], near,
                ends[k, end], work,
            )  # fmt: skip
        sources[k] = near
    extend(new, joined, cut, found.v, ends, kind == TRAVEL)
    for k in range(count):
        sag, along = 0.0, 0.0
        for i in range(n):
            found.g[k, i] = 0.5 * (ends[k, 0, i] + ends[k, 1, i])
            sag += (ends[k, 1, i] - ends[k, 0, i]) * (new.b[k, i] - new.a[k, i])
            along += found.g[k, i] * new.bow[k, i]
        found.sag[k] = sag - along if kind == TRAVEL else 0.0
    still = w.sum() * h * (1.0 - ROUNDING)
    for k in range(count):
        found.lost[k] = lost_by(
            kind, h, w, wraps, old, values, blocks, boxes, sources[k], new, found, k, still, work
        )  # fmt: skip


@kernel
def least_to(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, old: Arcs, values: Values, new: Arcs, out: FloatArray
) -> None:
    """Fill in, per cell of the next slice, a bound on the cost of motions that arrive there: cells are boxes here.

    A cell's least value and the chord over the gaps between two boxes are less than what :func:`step_values` finds, at
    a small part of its cost.
    """
    boxes, n = boxes_of(wraps, old, values, 1), len(w)
    center, apart = np.empty(n), np.empty(n)
    for k in range(len(new.a)):
        out[k] = np.inf
        for j in range(len(old.a)):
            distance(new, k, boxes, j, wraps, w, center, apart)
            for i in range(n):
                apart[i] = max(abs(center[i]) - apart[i], 0.0)
            length = cost(kind, apart, h, w)
            out[k] = min(out[k], length - boxes.deepest[j] - ROUNDING * (abs(boxes.deepest[j]) + length))


@kernel
def least_through(cells: Arcs, one: Values, two: Values, out: FloatArray) -> None:
    """Fill in, per cell, the least cost of a motion through it: both values, where their sum is least, less losses."""
    m, n = cells.a.shape
    for k in range(m):
        less, size = one.lost[k] + two.lost[k], abs(one.lost[k]) + abs(two.lost[k])
        for i in range(n):
            less += abs(one.g[k, i] + two.g[k, i]) * cells.rest[k, i]
            size += (abs(one.g[k, i]) + abs(two.g[k, i])) * cells.rest[k, i]
        at_a, at_b, both = one.v[k, 0] + two.v[k, 0], one.v[k, 1] + two.v[k, 1], one.sag[k] + two.sag[k]
        least, step = min(at_a, at_b), at_b - at_a
        if abs(step) < 0.5 * both:  # the parabola is least between the ends
            least = 0.5 * (at_a + at_b) - 0.125 * both - 0.5 * step * step / both
        size += abs(at_a) + abs(at_b) + abs(one.sag[k]) + abs(two.sag[k])
        out[k] = least - less - ROUNDING * size
