"""Kernels that walk along self-motions: from given postures, by proved pieces of curves, as far as these go.

They go on outside the limits: what comes back inside is found however short it is there.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray
from selfmotion.arms._cell_kernels import Found, Windows, emit_box, emit_curve, flag, plain
from selfmotion.arms._curve_kernels import TAU, Chain, Chart, Task, chart_for, null_direction, settle
from selfmotion.arms._trace_kernels import between

_LONGEST = 200.0  # way along one curve after which it counts as lost [rad]
_MOST_PIECES = 50_000  # of all curves at a pose, after which what is left of them is left out
_LONGER = 1.6  # times the step before, what is tried next
_NEAR_START = 1.5  # times a step, how far from its start a curve may be to be closed
_OUTSIDE = 0.3  # how far joints may move in one step outside the windows [rad]
_BOX = 1e-3  # half the width of what is put where nothing more is proved [rad]
_SAME = 1e-7  # how far off a posture may be that is on a cell [rad]
_CLOSE = 1e-7  # how far a given posture may be from its task [rad]


@kernel
def settle_all(
    chain: Chain, rotations: FloatArray, positions: FloatArray, joint: int, farthest: float, q: FloatArray
) -> None:
    """Move postures (k, n) onto their tasks, one joint standing still; those that go `farthest` stay as they are."""
    n = q.shape[1]
    chart, direction, moved = chart_for(n), np.zeros(n), np.empty(n)
    direction[joint] = 1.0
    for k in range(len(q)):
        moved[:] = q[k]
        if settle(chain, Task(rotations[k], positions[k], 3), moved, direction, farthest, chart) >= 0.0:
            q[k] = moved


@kernel
def is_on_cell(found: Found, k: int, q: FloatArray) -> bool:
    """Return whether a posture, moved by whole turns, is on a cell."""
    n = len(q)
    for j in range(n):
        one, two = found.a[k, j], found.b[k, j]
        off = q[j] - 0.5 * (one + two)
        off -= TAU * np.rint(off / TAU)
        if abs(off) > 0.5 * abs(two - one) + found.dev[k, j] + _SAME:
            return False
    if found.pieces[k, 1] == 1.0:
        return True
    s = 0.5
    for _ in range(4):  # the nearest point of the parabola, as the chord is directed
        ahead, along = 0.0, 0.0
        for j in range(n):
            step = found.b[k, j] - found.a[k, j]
            off = q[j] - found.a[k, j] - s * step - 0.5 * s * (1.0 - s) * found.bow[k, j]
            off -= TAU * np.rint(off / TAU)
            ahead += step * off
            along += step * (step + (0.5 - s) * found.bow[k, j])
        if not along > 0.0:
            return False
        s += ahead / along
    if not -1e-3 <= s <= 1.0 + 1e-3:
        return False
    for j in range(n):
        step = found.b[k, j] - found.a[k, j]
        off = q[j] - found.a[k, j] - s * step - 0.5 * s * (1.0 - s) * found.bow[k, j]
        off -= TAU * np.rint(off / TAU)
        if abs(off) > found.rest[k, j] + _SAME:
            return False
    return True


@kernel
def is_known(found: Found, count: int, q: FloatArray) -> bool:
    """Return whether a posture is on one of the cells found so far."""
    for k in range(count - 1, -1, -1):  # the last ones are the likeliest
        if is_on_cell(found, k, q):
            return True
    return False


@kernel
def small_box(windows: Windows, q: FloatArray, found: Found, count: int) -> int:
    """Write a small box about a posture near which nothing is proved."""
    n = len(q)
    box, nothing = np.empty((n, 2)), np.zeros(n)
    for j in range(n):
        box[j, 0], box[j, 1] = q[j] - _BOX, q[j] + _BOX
    return emit_box(windows, box, nothing, flag(False), found, count, plain(0))


@kernel
def chord(a: FloatArray, b: FloatArray, direction: FloatArray) -> float:
    """Fill in the direction of a chord; return its length."""
    size = 0.0
    for j in range(len(a)):
        direction[j] = b[j] - a[j]
        size += direction[j] ** 2
    size = np.sqrt(size)
    for j in range(len(a)):
        direction[j] /= max(size, 1e-300)
    return size


@kernel
def tangent_at(
    chain: Chain, task: Task, q: FloatArray, onward: FloatArray, chart: Chart, direction: FloatArray
) -> bool:
    """Fill in the tangent at a posture, on the side of `onward`; return whether there is just one."""
    if not null_direction(chain, task, q, chart, direction):
        return False
    along = 0.0
    for j in range(len(q)):
        along += direction[j] * onward[j]
    if along < 0.0:
        for j in range(len(q)):
            direction[j] = -direction[j]
    return True


@kernel
def walk(
    chain: Chain, task: Task, chart: Chart, spare: Chart, start: FloatArray, error: float, way: FloatArray,
    windows: Windows, anywhere: Windows, spacing: float, narrowest: float, found: Found, count: int, seen: Found,
    passed: int,
) -> tuple[int, int, bool]:  # fmt: skip
    """Write cells from a posture along its self-motion, to the side of `way`, outside the windows too into `seen`.

    The walk ends where the curve is back at `start`, or where steps of `narrowest` are not proved. Return how many
    cells there are inside the windows and in all, and whether the curve closes.
    """
    n = len(start)
    a, b, c, goal, none = start.copy(), np.empty(n), np.empty(n), np.empty(n), np.empty((n, 2))
    onward, tangent, direction, middle = way.copy(), np.empty(n), np.empty(n), np.empty(n)
    nothing, no, whole = np.zeros(n), flag(False), plain(0)
    before, gone, wanted, longest = error, 0.0, spacing, spacing
    most = min(len(seen.a), _MOST_PIECES)
    while gone < _LONGEST and count <= len(found.a) and passed < most:
        fastest, left, right, after, back = 0.0, 0.0, 0.0, -1.0, False
        for j in range(n):
            fastest = max(fastest, abs(onward[j]))
        step = min(wanted, longest / fastest)
        while step >= narrowest:
            for j in range(n):
                c[j] = a[j] + 0.5 * step * onward[j]
            known = settle(chain, task, c, onward, 0.5 * step, spare) >= 0.0
            if known and tangent_at(chain, task, c, onward, chart, tangent):
                near, ahead = gone > 0.0, 0.0
                for j in range(n):
                    b[j] = a[j] + step * tangent[j]
                    goal[j] = start[j] + TAU * np.rint((a[j] - start[j]) / TAU)
                    near = near and abs(goal[j] - a[j]) <= _NEAR_START * step
                    ahead += (goal[j] - a[j]) * tangent[j]
                if near and ahead > 0.0:
                    size = chord(a, goal, direction)
                    for j in range(n):
                        middle[j] = 0.5 * (a[j] + goal[j])
                    if settle(chain, task, middle, direction, size, spare) >= 0.0:
                        left, right = between(chain, task, chart, a, goal, middle, direction, max(before, error))
                    if left < right:
                        b[:], after, back = goal, error, True
                        break
                after = settle(chain, task, b, tangent, 0.5 * step, spare)
                if after >= 0.0:
                    chord(a, b, direction)
                    left, right = between(chain, task, chart, a, b, c, direction, max(before, after))
                    if left < right:
                        break
            step *= 0.5
        if not left < right:
            return small_box(windows, a, found, count), small_box(anywhere, a, seen, passed), False
        so_far, room = count, max(before, after)
        count = emit_curve(
            chain, task, chart, spare, left, right, a, b, room, windows, nothing, no, none, no, 0.0, 0.0, 1.0,
            found, count, whole,
        )  # fmt: skip
        if count > so_far and longest > spacing:  # back inside, where steps are short
            count, longest, wanted = so_far, spacing, spacing
            continue
        passed = emit_curve(
            chain, task, chart, spare, left, right, a, b, room, anywhere, nothing, no, none, no, 0.0, 0.0, 1.0,
            seen, passed, whole,
        )  # fmt: skip
        if back:
            return count, passed, True
        gone += step
        longest = spacing if count > so_far else max(spacing, _OUTSIDE)
        wanted = _LONGER * step
        a[:], before = b, after
        if not tangent_at(chain, task, a, direction, chart, tangent):
            return small_box(windows, a, found, count), small_box(anywhere, a, seen, passed), False
        onward[:] = tangent
    return count, passed, False


@kernel
def trace_from(
    chain: Chain, task: Task, windows: Windows, seeds: FloatArray, spacing: float, narrowest: float, found: Found,
    seen: Found,
) -> int:  # fmt: skip
    """Cover the curves through given postures (m, n) inside the windows; return how many cells there are.

    If these are more than there is room for, or `seen`, where whole curves are remembered, has too little, it is only
    known that the room must be larger than now.
    """
    m, n = seeds.shape
    chart, spare, count, passed = chart_for(n), chart_for(n), plain(0), plain(0)
    anywhere = Windows(np.ones(n, np.bool_), np.empty((0, 2)), np.zeros(n + 1, np.int64), np.full(n, TAU))
    q, way = np.empty(n), np.empty(n)
    for k in range(m):
        q[:] = seeds[k]
        if is_known(seen, passed, q):
            continue
        error, closed = -1.0, False
        if null_direction(chain, task, q, chart, way):
            error = settle(chain, task, q, way, _CLOSE, spare)
        if error < 0.0:
            count = small_box(windows, seeds[k], found, count)
            passed = small_box(anywhere, seeds[k], seen, passed)
        for _ in range(2):
            if error >= 0.0 and not closed:
                count, passed, closed = walk(
                    chain, task, chart, spare, q, error, way, windows, anywhere, spacing, narrowest, found, count,
                    seen, passed,
                )  # fmt: skip
                way *= -1.0
        if passed >= _MOST_PIECES:
            break
        if count > len(found.a) or passed >= len(seen.a):
            return 2 * max(len(found.a), len(seen.a), count)
    return count
