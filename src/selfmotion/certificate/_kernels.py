"""The certificate on plain arrays: proposals of a value function, and what is proved of them pair by pair.

:mod:`selfmotion.certificate` says what the arrays are, docs/mathematics why the result is a bound. What carries the
proof is :func:`shortfall`; everything else only makes it sharp.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray

TAU = 2 * np.pi
TRAVEL, L1, L2 = 0, 1, 2
# Each value is a sum of some forty products; this part of the sum of their sizes is far more than rounding makes of it.
ROUNDING = 2e-14


@kernel
def chord(kind: int, d: FloatArray, h: float, w: FloatArray, g: FloatArray) -> float:
    """Return the cost c(d; h) of a chord and fill in a subgradient."""
    total = 0.0
    if kind == TRAVEL:
        for i in range(len(d)):
            length = np.sqrt(h * h + d[i] * d[i])
            total += w[i] * length
            g[i] = w[i] * d[i] / length
    elif kind == L1:
        for i in range(len(d)):
            total += w[i] * abs(d[i])
            g[i] = w[i] * np.sign(d[i])
    else:
        for i in range(len(d)):
            total += (w[i] * d[i]) ** 2
        total = np.sqrt(total)
        for i in range(len(d)):
            g[i] = w[i] * w[i] * d[i] / total if total > 0.0 else 0.0
    return total


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
def curvature(kind: int, d: FloatArray, h: float, w: FloatArray, g: FloatArray, u: FloatArray, v: FloatArray) -> float:
    """Return uᵀHv for the Hessian H of c at d, of which g is the gradient."""
    total = 0.0
    if kind == TRAVEL:
        for i in range(len(d)):
            length = np.sqrt(h * h + d[i] * d[i])
            total += w[i] * h * h / length**3 * u[i] * v[i]
    elif kind == L2:
        size, one, two = 0.0, 0.0, 0.0
        for i in range(len(d)):
            size += (w[i] * d[i]) ** 2
            total += w[i] * w[i] * u[i] * v[i]
            one += g[i] * u[i]
            two += g[i] * v[i]
        total = (total - one * two) / max(np.sqrt(size), 1e-300)
    return total


@kernel
def best_along(
    kind: int, h: float, w: FloatArray, y: FloatArray, a: FloatArray, step: FloatArray, va: float, vb: float,
    first: float, last: float, g: FloatArray,
) -> tuple[float, float]:  # fmt: skip
    """Minimise ``(1 − s) va + s vb + c(y − a − s·step; h)`` over s in [first, last]; return the least value and its s."""
    n = len(y)
    d = np.empty(n)
    if kind == L1:
        best, at = np.inf, first
        for k in range(n + 2):
            if k < n:
                if step[k] == 0.0:
                    continue
                s = min(max((y[k] - a[k]) / step[k], first), last)
            else:
                s = first if k == n else last
            for i in range(n):
                d[i] = y[i] - a[i] - s * step[i]
            value = va + s * (vb - va) + cost(kind, d, h, w)
            if value < best:
                best, at = value, s
        for i in range(n):
            d[i] = y[i] - a[i] - at * step[i]
        chord(kind, d, h, w, g)
        return best, at
    low, high = first, last
    s = min(max(0.5, first), last)
    value, best, at = 0.0, np.inf, s
    for _ in range(25):
        for i in range(n):
            d[i] = y[i] - a[i] - s * step[i]
        value = va + s * (vb - va) + chord(kind, d, h, w, g)
        if value < best:
            best, at = value, s
        slope = vb - va
        for i in range(n):
            slope -= g[i] * step[i]
        if slope > 0.0:
            high = s
        else:
            low = s
        bend = curvature(kind, d, h, w, g, step, step)
        new = s - slope / bend if bend > 0.0 else (first if slope > 0.0 else last)
        new = min(max(new, first), last)
        if not low <= new <= high or abs(new - s) > 0.75 * (last - first):
            new = 0.5 * (low + high) if new != first and new != last else new
        if abs(new - s) <= 1e-9:
            break
        s = new
    for i in range(n):
        d[i] = y[i] - a[i] - at * step[i]
    chord(kind, d, h, w, g)
    return best, at


@kernel
def nearest_shift(wraps: BoolArray, d: FloatArray, shift: FloatArray) -> None:
    """Fill in the whole turns that bring free joints' differences into [−π, π]."""
    for i in range(len(d)):
        shift[i] = TAU * np.rint(d[i] / TAU) if wraps[i] else 0.0


@kernel
def propose(
    kind: int, h: float, w: FloatArray, wraps: BoolArray, a: FloatArray, b: FloatArray, v: FloatArray,
    joined: BoolArray, reach: FloatArray, y: FloatArray, g: FloatArray,
) -> tuple[float, int, float]:  # fmt: skip
    """Return the least value with which posture y can be reached from cells, the cell and its s; fill in ∇c there.

    ``reach[k]`` are the s to which cell k may be prolonged (below 0, above 1) where it ends without need.
    """
    m, n = a.shape
    d, step, shifted, trial = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    best, at = np.inf, -1
    end = 0
    for k in range(m):
        for side in range(2):
            if side == 1 and k + 1 < m and joined[k + 1]:
                continue
            for i in range(n):
                x = a[k, i] if side == 0 else b[k, i]
                d[i] = y[i] - x
                if wraps[i]:
                    d[i] -= TAU * np.rint(d[i] / TAU)
            value = v[k, side] + cost(kind, d, h, w)
            if value < best:
                best, at, end = value, k, side
    result, cell, place = np.inf, at, 0.0
    for other in range(2):
        k = at
        if other == 1:
            if end == 0 and joined[at]:
                k = at - 1
            else:
                break
        for i in range(n):
            step[i] = b[k, i] - a[k, i]
            d[i] = y[i] - 0.5 * (a[k, i] + b[k, i])
            shifted[i] = y[i] - (TAU * np.rint(d[i] / TAU) if wraps[i] else 0.0)
        value, s = best_along(kind, h, w, shifted, a[k], step, v[k, 0], v[k, 1], reach[k, 0], reach[k, 1], trial)
        if value < result:
            result, cell, place = value, k, s
            g[:] = trial
    return result, cell, place


@kernel
def plane_least(value: float, by_s: float, by_t: float, s: float, t: float) -> float:
    """Return the least value on the unit square of the plane through `value` at (s, t)."""
    return value - max(by_s * s, by_s * (s - 1.0)) - max(by_t * t, by_t * (t - 1.0))


@kernel
def shortfall(
    kind: int, h: float, w: FloatArray, d0: FloatArray, stepa: FloatArray, stepb: FloatArray,
    va: float, vb: float, wa: float, wb: float, ga: FloatArray, gb: FloatArray, deva: FloatArray, devb: FloatArray,
    enough: float,
) -> float:  # fmt: skip
    """Return a lower bound of the residual of a pair of cells,

    ``(1 − s) va + s vb + ga·e + c(d0 + t·stepb + f − s·stepa − e; h) − (1 − t) wa − t wb − gb·f``,

    over 0 ≤ s, t ≤ 1, |e| ≤ deva, |f| ≤ devb. It is convex in all of them, so every tangent plane bounds it from below;
    Newton's method only looks for a good one. The search ends where the bound is above `enough`.
    """
    n = len(d0)
    d, g = np.empty(n), np.empty(n)
    if kind == L1:
        return shortfall_l1(w, d0, stepa, stepb, va, vb, wa, wb, ga, gb, deva, devb)
    s, t, best, before, trials = 0.5, 0.5, -np.inf, np.inf, 0
    s0, t0, ds, dt = s, t, 0.0, 0.0
    for _ in range(30):
        for i in range(n):
            d[i] = d0[i] + t * stepb[i] - s * stepa[i]
        length = chord(kind, d, h, w, g)
        value = va + s * (vb - va) - wa - t * (wb - wa) + length
        by_s, by_t, lost = vb - va, wa - wb, 0.0
        size = abs(va) + abs(vb) + abs(wa) + abs(wb) + length
        for i in range(n):
            by_s -= g[i] * stepa[i]
            by_t += g[i] * stepb[i]
            lost += abs(g[i] - ga[i]) * deva[i] + abs(g[i] - gb[i]) * devb[i]
            size += abs(g[i]) * (abs(d0[i]) + abs(stepa[i]) + abs(stepb[i]))
        bound = plane_least(value, by_s, by_t, s, t) - lost - ROUNDING * size
        if bound > best:
            best = bound
        if best >= enough:
            return best
        if value > before + ROUNDING * size and trials < 8:  # too far: half the step
            ds, dt, trials = 0.5 * ds, 0.5 * dt, trials + 1
        else:
            s0, t0, before, trials = s, t, value, 0
            ds, dt = square_step(
                by_s, by_t, curvature(kind, d, h, w, g, stepa, stepa), -curvature(kind, d, h, w, g, stepa, stepb),
                curvature(kind, d, h, w, g, stepb, stepb), s, t,
            )  # fmt: skip
        if abs(ds) + abs(dt) < 1e-9:
            break
        s, t = min(max(s0 + ds, 0.0), 1.0), min(max(t0 + dt, 0.0), 1.0)
    return best


@kernel
def square_step(by_s: float, by_t: float, hss: float, hst: float, htt: float, s: float, t: float) -> tuple[float, float]:
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
def step_values(
    kind: int, h: float, w: FloatArray, wraps: BoolArray,
    a: FloatArray, b: FloatArray, dev: FloatArray, v: FloatArray, g: FloatArray, lost: FloatArray,
    joined: BoolArray, reach: FloatArray,
    ya: FloatArray, yb: FloatArray, ydev: FloatArray, yjoined: BoolArray,
    out: FloatArray, slopes: FloatArray, out_lost: FloatArray,
) -> None:  # fmt: skip
    """Carry a value function from the cells of one slice (a, b, dev, with v, g) to those of the next (ya, yb, ydev).

    Proposes values `out` (m, 2) at the ends of the new cells, with `slopes` (m, n), and finds how much each cell must
    lose, `out_lost` (m,), so that no pair falls short: the proved value is the proposed one less what is lost.
    """
    m, n = a.shape
    count = len(ya)
    one, two = np.empty(n), np.empty(n)
    near = np.zeros(count, np.int64)
    for k in range(count):
        if k > 0 and yjoined[k]:
            out[k, 0] = out[k - 1, 1]
            one[:] = two
        else:
            out[k, 0], near[k], _ = propose(kind, h, w, wraps, a, b, v, joined, reach, ya[k], one)
        out[k, 1], near[k], _ = propose(kind, h, w, wraps, a, b, v, joined, reach, yb[k], two)
        for i in range(n):
            slopes[k, i] = 0.5 * (one[i] + two[i])
    total = 0.0
    for i in range(n):
        total += w[i]
    d0, stepa, stepb, center = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    other = np.zeros(n, np.int64)
    for k in range(count):
        worst = -np.inf
        most = max(out[k, 0], out[k, 1])
        given = 0.0
        for i in range(n):
            given += abs(slopes[k, i]) * ydev[k, i]
        for turn in range(m):
            # The pair that is likely to lose most comes first.
            j = turn if turn > 0 else near[k]
            if turn > 0 and j == near[k]:
                j = 0
            # Whatever s, t, e and f are, the chord is at least this long.
            short = 0.0
            square = 0.0
            room = given
            for i in range(n):
                x = 0.5 * (ya[k, i] + yb[k, i] - a[j, i] - b[j, i])
                if wraps[i]:
                    x -= TAU * np.rint(x / TAU)
                center[i] = x
                spread = 0.5 * (abs(yb[k, i] - ya[k, i]) + abs(b[j, i] - a[j, i])) + ydev[k, i] + dev[j, i]
                x = max(abs(x) - spread, 0.0) * w[i]
                short += x
                square += x * x
                room += abs(g[j, i]) * dev[j, i]
            least = min(v[j, 0], v[j, 1])
            need = most - least + room + lost[j] - worst
            need += ROUNDING * (abs(most) + abs(least) + room + abs(lost[j]) + abs(worst))
            if kind == TRAVEL:
                if need <= 0.0 or short * short + (total * h) ** 2 > need * need:
                    continue
            elif kind == L1:
                if short > need:
                    continue
            elif need <= 0.0 or square > need * need:
                continue
            # A free joint near half a turn may go either way round.
            ways = 1
            for i in range(n):
                other[i] = 0
                spread = 0.5 * (abs(yb[k, i] - ya[k, i]) + abs(b[j, i] - a[j, i])) + ydev[k, i] + dev[j, i]
                if wraps[i] and abs(center[i]) + spread >= np.pi:
                    other[i] = ways
                    ways *= 2
            for way in range(ways):
                for i in range(n):
                    stepa[i], stepb[i] = b[j, i] - a[j, i], yb[k, i] - ya[k, i]
                    x = center[i]
                    if other[i] > 0 and (way // other[i]) % 2 == 1:
                        x -= TAU * np.sign(x)
                    d0[i] = x + 0.5 * (stepa[i] - stepb[i])
                found = shortfall(
                    kind, h, w, d0, stepa, stepb, v[j, 0], v[j, 1], out[k, 0], out[k, 1],
                    g[j], slopes[k], dev[j], ydev[k], lost[j] - worst,
                )  # fmt: skip
                worst = max(worst, lost[j] - found)
        out_lost[k] = worst


@kernel
def least_through(
    dev: FloatArray, forward: FloatArray, slopes: FloatArray, lost: FloatArray,
    backward: FloatArray, back_slopes: FloatArray, back_lost: FloatArray, out: FloatArray,
) -> None:  # fmt: skip
    """Fill in, per cell, the least cost of a motion through it: both values at its ends, less what is lost."""
    m, n = slopes.shape
    for k in range(m):
        less, size = lost[k] + back_lost[k], abs(lost[k]) + abs(back_lost[k])
        for i in range(n):
            less += abs(slopes[k, i] + back_slopes[k, i]) * dev[k, i]
            size += (abs(slopes[k, i]) + abs(back_slopes[k, i])) * dev[k, i]
        at_a, at_b = forward[k, 0] + backward[k, 0], forward[k, 1] + backward[k, 1]
        out[k] = min(at_a, at_b) - less - ROUNDING * (abs(at_a) + abs(at_b) + size)


@kernel
def trace_back(
    kind: int, r: FloatArray, w: FloatArray, wraps: BoolArray, offsets: IntArray, a: FloatArray, b: FloatArray,
    joined: BoolArray, v: FloatArray, last: FloatArray, cells: IntArray, places: FloatArray, q: FloatArray,
) -> None:  # fmt: skip
    """Follow the cheapest chords back from posture `last` on the last slice; fill in cells, places s and postures."""
    slices, n = len(r), a.shape[1]
    g = np.empty(n)
    q[slices - 1] = last
    for k in range(slices - 2, -1, -1):
        f, l = offsets[k], offsets[k + 1]
        reach = np.zeros((l - f, 2))
        reach[:, 1] = 1.0
        _, cell, s = propose(
            kind, r[k + 1] - r[k], w, wraps, a[f:l], b[f:l], v[f:l], joined[f:l], reach, q[k + 1], g
        )
        cells[k], places[k] = f + cell, s
        for i in range(n):
            x = a[f + cell, i] + s * (b[f + cell, i] - a[f + cell, i])
            q[k, i] = x + (TAU * np.rint((q[k + 1, i] - x) / TAU) if wraps[i] else 0.0)
