"""Kernels that enclose self-motions of chains as curves in joint space.

With F(q) = 0 the task and c a posture near it, let ``τ`` solve ``DF(c) τ = 0, g·τ = 1`` for a direction g. Near c the
self-motion is a curve ``q(s) = c + s τ + ½ s² κ + z(s)``, s = g·(q − c), whether it folds in the redundancy parameter
or not. How far z may go, that there is only one such curve in a tube around the parabola, and how far q'' is from κ
follow from the first two derivatives of F at c and bounds of its second and third ones on the tube: a joint turns
everything beyond it, so no derivative of the tool's position exceeds the lever arm of the last joint concerned, and no
derivative of its rotation 1. A base that slides moves the tool linearly, so that only first derivatives know of it.
Formulas and proofs: docs/mathematics. The tasks are the three of position and ``turning`` of rotation, three or the two
of the tool's axis; n is one more than there are tasks.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray
from selfmotion.arms._chain_kernels import bend, frames, moving

TAU = 2 * np.pi
PAD = 1e-13
_ROUNDING = 8e-15  # of the tool's position by its reach, and of its rotation
_MORE = 1.0 + 1e-9  # covers the rounding of what bounds are computed from
_WIDER = 1.1  # tubes are tried this much wider than the last iterate asks for
_UNIQUE = 0.98  # contraction
_ITERATIONS = 12
_WIDENINGS = 6
_LOOSE = 0.5  # how much a slope may differ from the parabola's, for what is proved to be of use
_STEEPEST = 1e7  # |τ|
_NEWTON = 12
_CLOSE = 1e-8  # a step after which the next one is below rounding [rad]


class Chain(NamedTuple):
    """A chain: fixed turns (n + 1, 3, 3) and shifts (n + 1, 3), levers (n,) from each joint to the tool at most.

    Joints before `first` slide, the others turn.
    """

    turns: FloatArray
    shifts: FloatArray
    levers: FloatArray
    first: int = 0


class Task(NamedTuple):
    """What the tool must do: its rotation (3, 3), its position (3,), and in how many of the rotation's directions."""

    rotation: FloatArray
    position: FloatArray
    turning: int


class Chart(NamedTuple):
    """Workspace: the linearised task at ``center`` (n,), and what was proved of the curve there."""

    axes: FloatArray
    centers: FloatArray
    rotation: FloatArray
    position: FloatArray
    spin: FloatArray
    drift: FloatArray
    rate: FloatArray
    matrix: FloatArray  # (n, n): the Jacobian, and g
    inverse: FloatArray  # (n, n)
    mixed: FloatArray  # (n, n): C H[τ, ·]
    center: FloatArray
    direction: FloatArray  # g
    residual: FloatArray  # (n,): F, and 0
    offset: FloatArray  # −C F
    tangent: FloatArray  # τ
    curvature: FloatArray  # κ
    by_position: FloatArray  # norms of the rows of C that positions enter by
    by_rotation: FloatArray
    levers: FloatArray
    tube: FloatArray  # bound on |z|
    spread: FloatArray  # bound on |q'' − κ|
    y: FloatArray
    delta: FloatArray
    local: FloatArray
    slope: FloatArray
    trial: FloatArray


@kernel
def chart_for(n: int) -> Chart:
    """Return an empty workspace."""
    return Chart(
        np.empty((n, 3)), np.empty((n, 3)), np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3)),
        np.empty((6, n)), np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty(n), np.empty(n), np.empty(n),
        np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n),
        np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty(n),
    )  # fmt: skip


@kernel
def invert(matrix: FloatArray, inverse: FloatArray) -> bool:
    """Invert a small matrix, which is lost, by Gauss-Jordan elimination with row pivots; return whether it could be."""
    n = len(matrix)
    for i in range(n):
        for j in range(n):
            inverse[i, j] = 1.0 if i == j else 0.0
    for k in range(n):
        best, size = k, abs(matrix[k, k])
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > size:
                best, size = i, abs(matrix[i, k])
        if not size > 1e-12:
            return False
        if best != k:
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
                inverse[k, j], inverse[best, j] = inverse[best, j], inverse[k, j]
        scale = 1.0 / matrix[k, k]
        for j in range(n):
            matrix[k, j] *= scale
            inverse[k, j] *= scale
        for i in range(n):
            factor = matrix[i, k]
            if i != k and factor != 0.0:
                for j in range(n):
                    matrix[i, j] -= factor * matrix[k, j]
                    inverse[i, j] -= factor * inverse[k, j]
    return True


@kernel
def jacobian_at(chain: Chain, task: Task, q: FloatArray, chart: Chart) -> bool:
    """Fill in Jacobian and residual of the task at q; return whether the tool points about where it should."""
    frames(chain.turns, chain.shifts, chain.first, q, chart.axes, chart.centers, chart.rotation, chart.position)
    n = len(q)
    p, r, w, m = chart.position, chart.rotation, task.rotation, chart.matrix
    for j in range(n):
        z0, z1, z2 = chart.axes[j, 0], chart.axes[j, 1], chart.axes[j, 2]
        d0, d1, d2 = p[0] - chart.centers[j, 0], p[1] - chart.centers[j, 1], p[2] - chart.centers[j, 2]
        if j < chain.first:
            m[0, j], m[1, j], m[2, j] = z0, z1, z2
            for i in range(task.turning):
                m[3 + i, j] = 0.0
            continue
        m[0, j], m[1, j], m[2, j] = z1 * d2 - z2 * d1, z2 * d0 - z0 * d2, z0 * d1 - z1 * d0
        for i in range(task.turning):
            m[3 + i, j] = w[0, i] * z0 + w[1, i] * z1 + w[2, i] * z2
    for i in range(3):
        chart.residual[i] = p[i] - task.position[i]
    e00 = w[0, 0] * r[0, 0] + w[1, 0] * r[1, 0] + w[2, 0] * r[2, 0]
    e02 = w[0, 0] * r[0, 2] + w[1, 0] * r[1, 2] + w[2, 0] * r[2, 2]
    e11 = w[0, 1] * r[0, 1] + w[1, 1] * r[1, 1] + w[2, 1] * r[2, 1]
    e12 = w[0, 1] * r[0, 2] + w[1, 1] * r[1, 2] + w[2, 1] * r[2, 2]
    e22 = w[0, 2] * r[0, 2] + w[1, 2] * r[1, 2] + w[2, 2] * r[2, 2]
    if task.turning == 2:
        chart.residual[3], chart.residual[4] = -e12, e02
        return e22 > 0.0
    e01 = w[0, 0] * r[0, 1] + w[1, 0] * r[1, 1] + w[2, 0] * r[2, 1]
    e10 = w[0, 1] * r[0, 0] + w[1, 1] * r[1, 0] + w[2, 1] * r[2, 0]
    e20 = w[0, 2] * r[0, 0] + w[1, 2] * r[1, 0] + w[2, 2] * r[2, 0]
    e21 = w[0, 2] * r[0, 1] + w[1, 2] * r[1, 1] + w[2, 2] * r[2, 1]
    chart.residual[3], chart.residual[4], chart.residual[5] = 0.5 * (e21 - e12), 0.5 * (e02 - e20), 0.5 * (e10 - e01)
    return e00 + e11 + e22 > 0.0


@kernel
def linearise(chain: Chain, task: Task, q: FloatArray, direction: FloatArray, chart: Chart) -> bool:
    """Fill in the inverse of the Jacobian with g as its last row, and the step −C F; return whether there is one."""
    n = len(q)
    if not jacobian_at(chain, task, q, chart):
        return False
    chart.residual[n - 1] = 0.0
    for j in range(n):
        chart.matrix[n - 1, j] = direction[j]
    if not invert(chart.matrix, chart.inverse):
        return False
    for i in range(n):
        total = 0.0
        for k in range(n - 1):
            total -= chart.inverse[i, k] * chart.residual[k]
        chart.offset[i] = total
    return True


@kernel
def settle(chain: Chain, task: Task, q: FloatArray, direction: FloatArray, farthest: float, chart: Chart) -> float:
    """Move q onto the task, g·q standing still; return its error, negative if it went `farthest` or got nowhere."""
    n = len(q)
    gone = 0.0
    for _ in range(_NEWTON):
        if not linearise(chain, task, q, direction, chart):
            return -1.0
        step = 0.0
        for i in range(n):
            step = max(step, abs(chart.offset[i]))
        gone += step
        if not gone <= farthest:
            return -1.0
        for i in range(n):
            q[i] += chart.offset[i]
        if step <= _CLOSE:
            size = 0.0
            for i in range(n):
                for k in range(n - 1):
                    size = max(size, abs(chart.inverse[i, k]))
            reach = 1.0 + chain.levers[0]
            return float(n * size * (2.0 * _ROUNDING * reach + 0.5 * n * n * reach * step * step))
    return -1.0


@kernel
def null_direction(chain: Chain, task: Task, q: FloatArray, chart: Chart, direction: FloatArray) -> bool:
    """Fill in the unit tangent of the self-motion through q; return whether the tool can be moved in all its tasks."""
    n = len(q)
    if not jacobian_at(chain, task, q, chart):
        return False
    m, order = chart.matrix, np.arange(n)
    rows = n - 1
    for k in range(rows):
        best_i, best_j, size = k, k, 0.0
        for i in range(k, rows):
            for j in range(k, n):
                if abs(m[i, j]) > size:
                    best_i, best_j, size = i, j, abs(m[i, j])
        if not size > 1e-9:
            return False
        for j in range(n):
            m[k, j], m[best_i, j] = m[best_i, j], m[k, j]
        for i in range(rows):
            m[i, k], m[i, best_j] = m[i, best_j], m[i, k]
        order[k], order[best_j] = order[best_j], order[k]
        scale = 1.0 / m[k, k]
        for j in range(k, n):
            m[k, j] *= scale
        for i in range(rows):
            if i != k and m[i, k] != 0.0:
                factor = m[i, k]
                for j in range(k, n):
                    m[i, j] -= factor * m[k, j]
    total = 1.0
    for k in range(rows):
        total += m[k, n - 1] ** 2
    scale = 1.0 / np.sqrt(total)
    direction[order[n - 1]] = scale
    for k in range(rows):
        direction[order[k]] = -scale * m[k, n - 1]
    return True


@kernel
def prepare(chain: Chain, task: Task, q: FloatArray, direction: FloatArray, chart: Chart) -> bool:
    """Fill in all that is known of the curve at the center q: τ, κ, C H[τ, ·] and norms."""
    n = len(q)
    if not linearise(chain, task, q, direction, chart):
        return False
    tasks = n - 1
    c, rate, w = chart.inverse, chart.rate, task.rotation
    for i in range(n):
        chart.center[i], chart.direction[i] = q[i], direction[i]
        chart.tangent[i] = c[i, n - 1]
        if not abs(c[i, n - 1]) < _STEEPEST:
            return False
    v = moving(chart.axes, chart.centers, chart.position, chain.first, chart.tangent, chart.spin, chart.drift)
    bend(chart.axes, chart.centers, chart.position, chain.first, chart.spin, chart.drift, v, rate)
    for j in range(n):
        r0, r1, r2 = rate[3, j], rate[4, j], rate[5, j]
        for i in range(task.turning):
            rate[3 + i, j] = w[0, i] * r0 + w[1, i] * r1 + w[2, i] * r2
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(tasks):
                total += c[i, k] * rate[k, j]
            chart.mixed[i, j] = total
        bent = 0.0
        for j in range(n):
            bent -= chart.mixed[i, j] * chart.tangent[j]
        chart.curvature[i] = bent
        chart.by_position[i] = np.sqrt(c[i, 0] ** 2 + c[i, 1] ** 2 + c[i, 2] ** 2)
        around = 0.0
        for k in range(3, tasks):
            around += c[i, k] ** 2
        chart.by_rotation[i] = np.sqrt(around)
    p = chart.position
    for j in range(n):
        z0, z1, z2 = chart.axes[j, 0], chart.axes[j, 1], chart.axes[j, 2]
        d0, d1, d2 = p[0] - chart.centers[j, 0], p[1] - chart.centers[j, 1], p[2] - chart.centers[j, 2]
        chart.levers[j] = np.sqrt((z1 * d2 - z2 * d1) ** 2 + (z2 * d0 - z0 * d2) ** 2 + (z0 * d1 - z1 * d0) ** 2)
    return True


@kernel
def turning(first: int, a: FloatArray) -> float:
    """Return the sum of a over the joints that turn, which are those from `first` on."""
    total = 0.0
    for j in range(first, len(a)):
        total += a[j]
    return total


@kernel
def curled(levers: FloatArray, first: int, a: FloatArray, b: FloatArray) -> float:
    """Return ``Σ lever(max(i, j)) a_i b_j``, which no second derivative of a position in a and b exceeds.

    The sum is over the joints that turn: the others are before them, and move the tool linearly.
    """
    total, sum_a, sum_b = 0.0, 0.0, 0.0
    for j in range(first, len(levers)):
        total += levers[j] * (a[j] * sum_b + b[j] * sum_a + a[j] * b[j])
        sum_a += a[j]
        sum_b += b[j]
    return total


@kernel
def around(chain: Chain, chart: Chart, half: float, z: FloatArray) -> float:
    """Fill in how far postures of a tube are from parabola's tangent and from the center, and levers; return Σ |δ|.

    The sum is over the joints that turn.
    """
    n = len(z)
    beyond = 0.0
    for k in range(n):
        i = n - 1 - k
        chart.y[i] = 0.5 * half * half * abs(chart.curvature[i]) + z[i]
        chart.delta[i] = half * abs(chart.tangent[i]) + chart.y[i]
        if i >= chain.first:
            beyond += chart.delta[i]
        chart.local[i] = min(chain.levers[i], (chart.levers[i] + PAD) + chain.levers[i] * beyond)
        if k > 0:  # never less than a later one: third derivatives are bounded through second ones
            chart.local[i] = max(chart.local[i], chart.local[i + 1])
    return beyond


@kernel
def is_tube(chain: Chain, chart: Chart, half: float, z: FloatArray, tried: FloatArray) -> bool:
    """Fill in what |z| is bounded by if it is at most z; return whether that is no more, so that the curve is there."""
    first, total = chain.first, around(chain, chart, half, z)
    y, delta = chart.y, chart.delta
    second, sum_y = curled(chart.local, first, y, y), turning(first, y)
    third = total * curled(chart.local, first, delta, delta) / 6.0
    by_position, by_rotation = 0.5 * second + third, 0.5 * sum_y * sum_y + total * total * total / 6.0
    inside = True
    for i in range(len(z)):
        bent = 0.0
        for j in range(len(z)):
            bent += abs(chart.mixed[i, j]) * y[j]
        tried[i] = (
            abs(chart.offset[i]) + half * bent + chart.by_position[i] * by_position + chart.by_rotation[i] * by_rotation
        ) * _MORE + PAD * (1.0 + (chart.by_position[i] + chart.by_rotation[i]) * (1.0 + chain.levers[0]))
        inside = inside and tried[i] <= z[i]
    return inside


@kernel
def is_only_one(chain: Chain, chart: Chart, half: float, z: FloatArray) -> bool:
    """Return whether no two postures of the task with the same s are in the tube of width z, which may be widened."""
    for _ in range(_WIDENINGS):
        if contracts(chain, chart, half, z):
            return True
        for i in range(len(z)):  # joints that others move must have the room for it
            z[i] = max(z[i], _WIDER * chart.trial[i])
    return contracts(chain, chart, half, z)


@kernel
def contracts(chain: Chain, chart: Chart, half: float, z: FloatArray) -> bool:
    """Return whether Newton's map brings all postures of the tube of width z closer; fill in to what width."""
    first, total = chain.first, around(chain, chart, half, z)
    second, sum_y, sum_z = curled(chart.local, first, chart.y, z), turning(first, chart.y), turning(first, z)
    third = 0.5 * total * curled(chart.local, first, chart.delta, z)
    less = True
    for i in range(len(z)):
        bent = 0.0
        for j in range(len(z)):
            bent += abs(chart.mixed[i, j]) * z[j]
        apart = (
            half * bent
            + chart.by_position[i] * (second + third)
            + chart.by_rotation[i] * (sum_y * sum_z + 0.5 * total * total * sum_z)
        ) * _MORE
        chart.trial[i] = apart
        less = less and apart + 1e-9 * z[i] < _UNIQUE * z[i]
    return less


@kernel
def enclose_curve(chain: Chain, chart: Chart, half: float) -> bool:
    """Prove that over |s| ≤ half the self-motion near the parabola is one curve; fill in ``tube`` and ``spread``."""
    n = len(chart.center)
    z, tried = chart.tube, chart.trial
    for i in range(n):
        z[i] = 0.0
    is_tube(chain, chart, half, z, tried)
    found = False
    for _ in range(_ITERATIONS):
        widest = 0.0
        for i in range(n):
            widest = max(widest, tried[i])
        for i in range(n):
            z[i] = max(_WIDER * tried[i], 1e-2 * widest)
        if is_tube(chain, chart, half, z, tried):
            found = True
            break
        if not widest < 0.5:
            return False
    if not found:
        return False
    for i in range(n):
        chart.slope[i] = z[i]
    if not is_only_one(chain, chart, half, chart.slope):
        return False
    return bound_bending(chain, chart, half)


@kernel
def bound_bending(chain: Chain, chart: Chart, half: float) -> bool:
    """Fill in ``spread``, a bound on |q'' − κ| on the proved tube."""
    n = len(chart.center)
    first, total = chain.first, around(chain, chart, half, chart.tube)
    steep = np.abs(chart.tangent)
    sum_y, sum_steep = turning(first, chart.y), turning(first, steep)
    # q' = τ + w with w = −C (ΔJ τ + ΔJ w).
    slope, tried = chart.slope, chart.trial
    third = 0.5 * total * curled(chart.local, first, chart.delta, steep)
    for i in range(n):
        slope[i] = 0.0
    for round_ in range(_ITERATIONS):
        with_y, with_delta = curled(chart.local, first, chart.y, slope), curled(chart.local, first, chart.delta, slope)
        sum_slope = turning(first, slope)
        inside = True
        for i in range(n):
            bent = 0.0
            for j in range(n):
                bent += abs(chart.mixed[i, j]) * (chart.y[j] + half * slope[j])
            tried[i] = (
                half * abs(chart.curvature[i])
                + bent
                + chart.by_position[i] * (third + with_y + 0.5 * total * with_delta)
                + chart.by_rotation[i]
                * (0.5 * total * total * sum_steep + sum_y * sum_slope + 0.5 * total * total * sum_slope)
            ) * _MORE + PAD
            inside = inside and tried[i] <= slope[i]
        if inside:
            break
        if round_ == _ITERATIONS - 1:
            return False
        for i in range(n):
            slope[i] = _WIDER * tried[i]
    # q'' = −C (H(q)[q', q'] + ΔJ q'').
    speed = steep + slope
    sum_speed, sum_slope = turning(first, speed), turning(first, slope)
    fixed_position = curled(chart.local, first, slope, slope) + total * curled(chart.local, first, speed, speed)
    fixed_rotation = sum_slope * sum_slope + total * sum_speed * sum_speed
    bend_, spread = np.abs(chart.curvature), chart.spread
    for i in range(n):
        spread[i] = 0.0
    for _ in range(_ITERATIONS):
        for j in range(n):
            tried[j] = bend_[j] + spread[j]
        with_y, with_delta = curled(chart.local, first, chart.y, tried), curled(chart.local, first, chart.delta, tried)
        sum_bend = turning(first, tried)
        inside = True
        largest = 0.0
        for i in range(n):
            bent = 0.0
            for j in range(n):
                bent += abs(chart.mixed[i, j]) * (2.0 * slope[j] + half * tried[j])
            now = (
                bent
                + chart.by_position[i] * (fixed_position + with_y + 0.5 * total * with_delta)
                + chart.by_rotation[i] * (fixed_rotation + sum_y * sum_bend + 0.5 * total * total * sum_bend)
            ) * _MORE + PAD * (1.0 + bend_[i])
            inside = inside and now <= spread[i]
            speed[i] = now
            largest = max(largest, now)
        if not half * largest < _LOOSE:
            return False
        if inside:
            return True
        for i in range(n):
            spread[i] = _WIDER * speed[i]
    return False


@kernel
def is_on_curve(chart: Chart, q: FloatArray, half: float, room: float) -> bool:
    """Return whether a posture of the task is on the proved curve, that is in its tube."""
    s = 0.0
    for i in range(len(q)):
        s += chart.direction[i] * (q[i] - chart.center[i])
    if abs(s) > half * (1.0 + 1e-9) + room:
        return False
    for i in range(len(q)):
        z = q[i] - chart.center[i] - s * chart.tangent[i] - 0.5 * s * s * chart.curvature[i]
        if abs(z) > chart.tube[i] + room:
            return False
    return True
