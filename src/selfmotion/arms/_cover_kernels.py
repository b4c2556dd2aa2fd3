"""Covers of the self-motion of three links by cells, on plain arrays; :mod:`selfmotion.arms.planar_cover` says why.

Directions φ1, φ2, φ3 of the links close the loop ``Σ l_m e(φ_m) = x``. Along the self-motion they move like

    t = (sin(φ3 − φ2)/l1, sin(φ1 − φ3)/l2, sin(φ2 − φ1)/l3),

and *chart* i takes φ_i as its parameter, with the sign of t_i telling its two solutions apart. A piece is a chart, a
sign and an interval of φ_i. Everything is enclosed: an interval is a middle and a radius, and radii are padded for
rounding.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray, IntArray

TAU = 2 * np.pi
# Relative and absolute room for rounding in what is computed from angles and sides in a few dozen operations.
PAD = 1e-13
DROP, SPLIT, REGULAR, ROUGH = 0, 1, 2, 3
_STEEPEST = 3.0  # dφ_j/dφ_i beyond which a piece is split


@kernel
def others(chart: int) -> tuple[int, int]:
    """Return the links j, k with (chart, j, k) in cyclic order: t_chart = sin(φ_k − φ_j)/l_chart."""
    return (chart + 1) % 3, (chart + 2) % 3


@kernel
def bend(near: float, far: float, d: float) -> float:
    """Return the angle in a triangle between sides `near` and d, `far` being opposite; all digits at folds."""
    top = max((far - d + near) * (far + d - near), 0.0)
    bottom = max((d + near - far) * (d + near + far), 0.0)
    return 2.0 * np.arctan2(np.sqrt(top), np.sqrt(bottom))


@kernel
def solve(links: FloatArray, x: float, y: float, chart: int, sign: float, angle: float, phi: FloatArray) -> float:
    """Fill in the directions at a chart's parameter; return by how much |w| stays inside its reach."""
    j, k = others(chart)
    wx, wy = x - links[chart] * np.cos(angle), y - links[chart] * np.sin(angle)
    d = np.hypot(wx, wy)
    omega = np.arctan2(wy, wx)
    phi[chart] = angle
    phi[j] = omega - sign * bend(links[j], links[k], d)
    phi[k] = omega + sign * bend(links[k], links[j], d)
    return min(links[j] + links[k] - d, d - abs(links[j] - links[k]))


@kernel
def bend_range(near: float, far: float, low: float, high: float) -> tuple[float, float]:
    """Return the range of :func:`bend` for d in [low, high], inside the reach of the two sides."""
    one, two = bend(near, far, low), bend(near, far, high)
    least, most = min(one, two), max(one, two)
    if near > far:  # largest where the far side is square to d
        critical = near * near - far * far
        if low * low < critical < high * high:
            most = max(most, np.arcsin(min(far / near, 1.0)))
    return least, most


@kernel
def cosine_range(low: float, high: float) -> tuple[float, float]:
    """Return the range of the cosine over [low, high]."""
    if high - low >= TAU:
        return -1.0, 1.0
    one, two = np.cos(low), np.cos(high)
    least, most = min(one, two), max(one, two)
    if np.floor(high / TAU) != np.floor(low / TAU) or low % TAU == 0.0:
        most = 1.0
    if np.floor((high - np.pi) / TAU) != np.floor((low - np.pi) / TAU):
        least = -1.0
    return least, most


@kernel
def enclose(
    links: FloatArray, x: float, y: float, rho: float, chart: int, sign: float, low: float, high: float,
    middle: FloatArray, radius: FloatArray,
) -> int:  # fmt: skip
    """Enclose the directions of a piece, for all task points in a disc; return DROP, or REGULAR if all of it reaches.

    ROUGH if it may leave its reach somewhere.
    """
    j, k = others(chart)
    li, lj, lk = links[chart], links[j], links[k]
    size = np.hypot(x, y) + li + lj + lk
    pad = PAD * size
    r, psi = np.hypot(x, y), np.arctan2(y, x)
    half, angle = 0.5 * (high - low), 0.5 * (low + high)
    least, most = cosine_range(low - psi - PAD, high - psi + PAD)
    # |w|² = (r − l)² + 2 r l (1 − cos v)
    shortest = np.sqrt((r - li) ** 2 + 2 * r * li * max(1.0 - most - PAD, 0.0)) - rho - pad
    longest = np.sqrt((r - li) ** 2 + 2 * r * li * (1.0 - least + PAD)) + rho + pad
    inner, outer = abs(lj - lk), lj + lk
    if longest < inner or shortest > outer:
        return DROP
    inside = shortest > inner + pad and longest < outer - pad
    shortest, longest = max(shortest, inner), min(longest, outer)
    wx, wy = x - li * np.cos(angle), y - li * np.sin(angle)
    d, omega = np.hypot(wx, wy), np.arctan2(wy, wx)
    swing = rho + li * half + pad
    turn = np.arcsin(swing / d) + PAD if swing < d else np.pi
    middle[chart], radius[chart] = angle, half
    for near, far, side in ((j, k, -sign), (k, j, sign)):
        small, large = bend_range(links[near], links[far], shortest, longest)
        # The bend is accurate to rounding of d, which at a fold is a square root away.
        middle[near] = omega + side * 0.5 * (small + large)
        radius[near] = turn + 0.5 * (large - small) + PAD * (1.0 + size / links[near])
    return REGULAR if inside else ROUGH


@kernel
def speeds(links: FloatArray, middle: FloatArray, radius: FloatArray, t: FloatArray, dt: FloatArray) -> None:
    """Enclose t and dt/dτ over a box of directions: t[m] = (middle, radius)."""
    cosines = np.empty((3, 2))
    for m in range(3):
        j, k = others(m)
        angle, spread = middle[k] - middle[j], radius[k] + radius[j]
        sine, cosine = np.sin(angle), np.cos(angle)
        t[m, 0] = sine / links[m]
        t[m, 1] = (min(abs(cosine) * spread + 0.5 * spread * spread, 1.0 + abs(sine)) + PAD) / links[m]
        cosines[m, 0] = cosine
        cosines[m, 1] = min(abs(sine) * spread + 0.5 * spread * spread, 1.0 + abs(cosine)) + PAD
    for m in range(3):
        j, k = others(m)
        rate, room = t[k, 0] - t[j, 0], t[k, 1] + t[j, 1]
        dt[m, 0] = cosines[m, 0] * rate / links[m]
        dt[m, 1] = (
            abs(cosines[m, 0]) * room + abs(rate) * cosines[m, 1] + cosines[m, 1] * room + PAD * (abs(rate) + 1.0)
        ) / links[m]


@kernel
def is_led(t: FloatArray, chart: int) -> bool:
    """Return whether another direction surely moves faster than the chart's own, so that the other's chart serves."""
    mine = abs(t[chart, 0]) + t[chart, 1]
    for m in range(3):
        if m != chart and abs(t[m, 0]) - t[m, 1] > mine:
            return True
    return False


@kernel
def classify(
    links: FloatArray, x: float, y: float, rho: float, chart: int, sign: float, low: float, high: float,
    middle: FloatArray, radius: FloatArray, bend: FloatArray, spread: FloatArray,
) -> int:  # fmt: skip
    """Enclose a piece and say what it is; of a REGULAR one also the joints' second derivatives by the parameter.

    These, φ_m'' − φ_{m−1}'', lie within bend ± spread. SPLIT means that nothing is known yet; the box is right
    nevertheless.
    """
    t, dt = np.empty((3, 2)), np.empty((3, 2))
    kind = enclose(links, x, y, rho, chart, sign, low, high, middle, radius)
    if kind == DROP:
        return DROP
    speeds(links, middle, radius, t, dt)
    if is_led(t, chart):
        return DROP
    if kind == ROUGH or abs(t[chart, 0]) <= 1.01 * t[chart, 1]:
        return SPLIT
    if rho == 0.0:
        # The mean value theorem, from the posture in the middle: narrower than the box by interval evaluation.
        half = 0.5 * (high - low)
        slowest = abs(t[chart, 0]) - t[chart, 1]
        exact = np.empty(3)
        solve(links, x, y, chart, sign, middle[chart], exact)
        for m in range(3):
            if m != chart:
                fastest = (abs(t[m, 0]) + t[m, 1]) / slowest
                room = fastest * half * (1.0 + PAD) + PAD * (
                    1.0 + (np.hypot(x, y) + links.sum()) / (links[m] * slowest * links[chart])
                )
                if room < radius[m]:
                    middle[m], radius[m] = exact[m], room
        speeds(links, middle, radius, t, dt)
        if is_led(t, chart):
            return DROP
        if abs(t[chart, 0]) <= 1.01 * t[chart, 1]:
            return SPLIT
    i = chart
    slowest = abs(t[i, 0]) - t[i, 1]
    before, around = 0.0, 0.0
    for m in range(3):
        if m == i:
            now, room = 0.0, 0.0
        else:
            if abs(t[m, 0]) + t[m, 1] > _STEEPEST * slowest:
                return SPLIT
            # φ_m'' = (t_m' t_i − t_m t_i')/t_i³
            one, other = dt[m, 0] * t[i, 0], t[m, 0] * dt[i, 0]
            top = one - other
            room = (
                abs(dt[m, 0]) * t[i, 1] + abs(t[i, 0]) * dt[m, 1] + dt[m, 1] * t[i, 1]
                + abs(t[m, 0]) * dt[i, 1] + abs(dt[i, 0]) * t[m, 1] + t[m, 1] * dt[i, 1]
                + PAD * (abs(one) + abs(other))
            )  # fmt: skip
            cube = abs(t[i, 0]) ** 3
            now = top / t[i, 0] ** 3
            room = room / slowest**3 + abs(top) * (1.0 / slowest**3 - 1.0 / cube) + PAD * abs(now)
        bend[m], spread[m] = now - before, (room + around) * (1.0 + PAD)
        before, around = now, room
    bend[3], spread[3] = -before, around
    return REGULAR


@kernel
def to_joints(phi: FloatArray, direction: float, q: FloatArray) -> None:
    """Fill in joint angles from the directions; a fourth joint keeps `direction`."""
    q[0], q[1], q[2] = phi[0], phi[1] - phi[0], phi[2] - phi[1]
    if len(q) == 4:
        q[3] = direction - phi[2]


@kernel
def choices(
    low: float, high: float, windows: FloatArray, near: float, only_near: bool, period: float, shift: FloatArray,
    chosen: IntArray,
) -> int:  # fmt: skip
    """List the whole periods and windows with which [low, high] may lie inside a window; return how many there are."""
    count = 0
    middle = 0.5 * (low + high)
    for w in range(len(windows)):
        first, last = np.ceil((windows[w, 0] - high) / period), np.floor((windows[w, 1] - low) / period)
        if only_near:
            turn = np.rint((near - middle) / period)
            first, last = max(first, turn), min(last, turn)
        turn = first
        while turn <= last and count < len(shift):
            shift[count], chosen[count] = period * turn, w
            count += 1
            turn += 1.0
    return count


@kernel
def off_chord(room: float, bend: float, width: float) -> float:
    """Return how far a curve is from its chord if it is within `room` of the parabola with second derivative `bend`."""
    return room + 0.125 * width**2 * abs(bend) * (1.0 + PAD)


@kernel
def cover(
    links: FloatArray, x: float, y: float, direction: float, wraps: IntArray, windows: FloatArray, first: IntArray,
    charts: IntArray, signs: FloatArray, lows: FloatArray, highs: FloatArray, near: FloatArray, only_near: bool,
    spacing: FloatArray, narrowest: float,
    a: FloatArray, b: FloatArray, bow: FloatArray, dev: FloatArray, rest: FloatArray, pieces: FloatArray,
    origin: IntArray,
) -> int:  # fmt: skip
    """Cover pieces of the self-motion at one task point by cells no longer than `spacing`; return how many there are.

    Row k of a, b (m, n) is the ends of cell k, of bow how it bends, of dev and rest its room around chord and parabola,
    of pieces (m, 4) its chart, sign and interval, and origin (m,) the piece that it is a part of. With more cells than
    rows, only the count goes on. Joint j may lie in windows[first[j]:first[j + 1]]; near (p, n) are angles whose turns
    are kept if `only_near`.
    """
    n = a.shape[1]
    capacity, count = len(a), 0
    size = np.hypot(x, y) + links.sum()
    stack = np.empty((2048, 2))
    middle, radius, bend, spread, phi = np.empty(3), np.empty(3), np.empty(4), np.empty(4), np.empty(3)
    qa, qb, room, box = np.empty(n), np.empty(n), np.empty(n), np.empty((n, 2))
    shift, chosen, many = np.empty((n, 16)), np.empty((n, 16), np.int64), np.ones(n, np.int64)
    pick, t, dt = np.zeros(n, np.int64), np.empty((3, 2)), np.empty((3, 2))
    for p in range(len(charts)):
        chart, sign = charts[p], signs[p]
        stack[0, 0], stack[0, 1] = lows[p], highs[p]
        depth = 1
        while depth > 0:
            depth -= 1
            low, high = stack[depth, 0], stack[depth, 1]
            kind = classify(links, x, y, 0.0, chart, sign, low, high, middle, radius, bend, spread)
            if kind == DROP:
                continue
            if kind == SPLIT and high - low > narrowest and depth + 2 <= len(stack):
                cut = 0.5 * (low + high)
                stack[depth, 0], stack[depth, 1] = cut, high
                stack[depth + 1, 0], stack[depth + 1, 1] = low, cut
                depth += 2
                continue
            if kind == SPLIT:
                to_joints(middle, direction, qa)
                qb[:] = qa
                error = 0.0
                bend[:] = 0.0
                room[0], room[1], room[2] = radius[0], radius[0] + radius[1], radius[1] + radius[2]
                if n == 4:
                    room[3] = radius[2]
            else:
                solve(links, x, y, chart, sign, low, phi)
                to_joints(phi, direction, qa)
                solve(links, x, y, chart, sign, high, phi)
                to_joints(phi, direction, qb)
                longest = 0.0
                for j in range(n):
                    qb[j] -= TAU * np.rint((qb[j] - qa[j]) / TAU)
                    longest = max(longest, abs(qb[j] - qa[j]))
                if longest > 1.3 * spacing[p] and high - low > narrowest and depth + 2 <= len(stack):
                    parts = int(min(np.ceil(longest / spacing[p]), len(stack) - depth, 64))
                    for k in range(parts - 1, -1, -1):
                        stack[depth, 0] = low + (high - low) * k / parts
                        stack[depth, 1] = high if k == parts - 1 else low + (high - low) * (k + 1) / parts
                        depth += 1
                    continue
                # Between two nodes a curve leaves its chord by at most 1/8 of its largest second derivative, and the
                # parabola of some second derivative by 1/8 of the largest difference from that.
                eighth = 0.125 * (high - low) ** 2
                speeds(links, middle, radius, t, dt)
                slowest = abs(t[chart, 0]) - t[chart, 1]
                error = PAD * (2.0 + size / (slowest * links[chart] * links.min()))
                for j in range(n):
                    room[j] = eighth * spread[j] * (1.0 + PAD) + error
            nothing = False
            for j in range(n):
                base = 0.5 * (qa[j] + qb[j])
                if wraps[j]:
                    target = near[p, j] if only_near else 0.0
                    shift[j, 0], chosen[j, 0] = TAU * np.rint((target - base) / TAU), -1
                    many[j] = 1
                else:
                    about = off_chord(room[j], bend[j], high - low)
                    box[j, 0], box[j, 1] = min(qa[j], qb[j]) - about, max(qa[j], qb[j]) + about
                    many[j] = choices(
                        box[j, 0],
                        box[j, 1],
                        windows[first[j] : first[j + 1]],
                        near[p, j],
                        only_near,
                        TAU,
                        shift[j],
                        chosen[j],
                    )
                nothing = nothing or many[j] == 0
            if nothing:
                continue
            pick[:] = 0
            while True:
                was = count
                count = emit(
                    links, x, y, direction, chart, sign, low, high, qa, qb, bend, room, error, kind == SPLIT, pick,
                    shift, chosen, windows, first, a, b, bow, dev, rest, pieces, count, capacity,
                )  # fmt: skip
                if was < count <= capacity:
                    origin[was] = p
                j = 0
                while j < n:
                    pick[j] += 1
                    if pick[j] < many[j]:
                        break
                    pick[j] = 0
                    j += 1
                if j == n:
                    break
    return count


@kernel
def emit(
    links: FloatArray, x: float, y: float, direction: float, chart: int, sign: float, low: float, high: float,
    qa: FloatArray, qb: FloatArray, bend: FloatArray, room: FloatArray, error: float, rough: bool, pick: IntArray,
    shift: FloatArray, chosen: IntArray, windows: FloatArray, first: IntArray, a: FloatArray, b: FloatArray,
    bow: FloatArray, dev: FloatArray, rest: FloatArray, pieces: FloatArray, count: int, capacity: int,
) -> int:  # fmt: skip
    """Write one cell, with its turns, trimmed to its windows; none if nothing of it is inside."""
    n = len(qa)
    one, two, around, phi, raw = np.empty(n), np.empty(n), np.empty(n), np.empty(3), np.empty(n)
    for j in range(n):
        one[j], two[j], around[j] = qa[j] + shift[j, pick[j]], qb[j] + shift[j, pick[j]], room[j]
    left, right = low, high
    if not rough:
        for _ in range(3):
            start, stop = 0.0, 1.0
            for j in range(n):
                if chosen[j, pick[j]] < 0:
                    continue
                w = first[j] + chosen[j, pick[j]]
                about = off_chord(around[j], bend[j], right - left)
                floor, ceiling = windows[w, 0] - about, windows[w, 1] + about
                step = two[j] - one[j]
                if abs(step) < 1e-300:
                    if one[j] < floor or one[j] > ceiling:
                        return count
                    continue
                s, e = (floor - one[j]) / step, (ceiling - one[j]) / step
                start, stop = max(start, min(s, e)), min(stop, max(s, e))
            start, stop = start - 1e-9 * (start > 0.0), stop + 1e-9 * (stop < 1.0)
            if start > stop:
                return count
            if start <= 0.0 and stop >= 1.0:
                break
            wide, was = right - left, right - left
            start, stop = max(start, 0.0), min(stop, 1.0)
            if stop - start > 0.95:
                break
            if start > 0.0:
                left += wide * start
            if stop < 1.0:
                right -= wide * (1.0 - stop)
            right = max(left, right)
            shrink = (right - left) / was if was > 0.0 else 1.0
            for side in range(2):
                solve(links, x, y, chart, sign, left if side == 0 else right, phi)
                to_joints(phi, direction, raw)
                for j in range(n):
                    if side == 0:
                        one[j] = raw[j] + TAU * np.rint((one[j] - raw[j]) / TAU)
                    else:
                        two[j] = raw[j] + TAU * np.rint((one[j] - raw[j]) / TAU)
            for j in range(n):
                around[j] = (around[j] - error) * shrink * shrink * (1.0 + PAD) + error
            if shrink > 0.9:
                break
    if count < capacity:
        a[count], b[count], rest[count] = one, two, around
        for j in range(n):
            bow[count, j] = -((right - left) ** 2) * bend[j]
            dev[count, j] = off_chord(around[j], bend[j], right - left)
        pieces[count, 0], pieces[count, 1], pieces[count, 2], pieces[count, 3] = chart, sign, left, right
    return count + 1
