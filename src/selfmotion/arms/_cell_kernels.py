"""Kernels that write cells: pieces of proved curves and boxes, in all turns and trimmed to what joint limits allow."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._cover_kernels import choices, off_chord
from selfmotion.arms._curve_kernels import PAD, TAU, Chain, Chart, Task, settle
from selfmotion.arms._slab_kernels import is_last

MOST_TURNS = 16  # of a joint that are told apart
_FAR = 1.0  # how far Newton's method may go [rad]


class Windows(NamedTuple):
    """Where joints may be: joint j in the intervals first[j] to first[j + 1], or anywhere if it wraps.

    Whole turns are multiples of the period (n,): 2π, but for joints that slide.
    """

    wraps: BoolArray
    ends: FloatArray
    first: IntArray
    period: FloatArray


class Found(NamedTuple):
    """The cells found: ends, bow, room around chord and parabola (m, n) each, and their pieces (m, 4)."""

    a: FloatArray
    b: FloatArray
    bow: FloatArray
    dev: FloatArray
    rest: FloatArray
    pieces: FloatArray
    origin: IntArray


@kernel
def plain(number: int) -> int:
    """Return a number that the compiler takes for one of many: what literals are handed to is compiled anew."""
    one = np.empty(1, np.int64)
    one[0] = number
    return one[0]


@kernel
def flag(yes: bool) -> bool:
    """Return a truth value that is no literal either."""
    one = np.empty(1, np.bool_)
    one[0] = yes
    return one[0]


@kernel
def has_options(windows: Windows, box: FloatArray) -> bool:
    """Return whether a box (n, 2), moved by whole turns, meets the windows."""
    for j in range(len(box)):
        if windows.wraps[j]:
            continue
        inside = False
        for w in range(windows.first[j], windows.first[j + 1]):
            turn = np.ceil((windows.ends[w, 0] - box[j, 1]) / windows.period[j] - PAD)
            inside = inside or turn <= np.floor((windows.ends[w, 1] - box[j, 0]) / windows.period[j] + PAD)
        if not inside:
            return False
    return True


@kernel
def turns_of(
    windows: Windows,
    extent: FloatArray,
    near: FloatArray,
    only_near: bool,
    shift: FloatArray,
    chosen: IntArray,
    many: IntArray,
) -> bool:
    """List each joint's whole turns with which its extent (n, 2) meets a window; return whether every joint has one."""
    for j in range(len(extent)):
        if windows.wraps[j]:
            target = near[j] if only_near else 0.0
            shift[j, 0] = TAU * np.rint((target - 0.5 * (extent[j, 0] + extent[j, 1])) / TAU)
            continue
        mine = windows.ends[windows.first[j] : windows.first[j + 1]]
        low, high = extent[j, 0], extent[j, 1]
        many[j] = choices(low, high, mine, near[j], only_near, windows.period[j], shift[j], chosen[j])
        if many[j] == 0:
            return False
    return True


@kernel
def point_on(chain: Chain, task: Task, chart: Chart, s: float, shift: FloatArray, q: FloatArray, spare: Chart) -> float:
    """Fill in the posture at s on the proved curve, moved by whole turns; return its error, negative if it is lost."""
    for i in range(len(q)):
        q[i] = chart.center[i] + s * chart.tangent[i] + 0.5 * s * s * chart.curvature[i]
    error = settle(chain, task, q, chart.direction, _FAR, spare)
    for i in range(len(q)):
        z = q[i] - chart.center[i] - s * chart.tangent[i] - 0.5 * s * s * chart.curvature[i]
        if error >= 0.0 and abs(z) > chart.tube[i] + error:
            error = -1.0
        q[i] += shift[i]
    return error


@kernel
def emit_curve(
    chain: Chain, task: Task, chart: Chart, spare: Chart, left: float, right: float, a: FloatArray, b: FloatArray,
    error: float, windows: Windows, near: FloatArray, only_near: bool, inside: FloatArray, boxed: bool,
    strand: float, low: float, high: float, found: Found, count: int, origin: int,
) -> int:  # fmt: skip
    """Write the proved curve from s = left to right, ends a and b, in all turns that the windows allow.

    If `boxed` only what is inside the box `inside` (n, 2) as well. Return the new count.
    """
    n = len(a)
    width, extent = right - left, np.empty((n, 2))
    for j in range(n):
        about = off_chord(0.125 * width * width * chart.spread[j] + error, chart.curvature[j], width)
        extent[j, 0], extent[j, 1] = min(a[j], b[j]) - about, max(a[j], b[j]) + about
        if boxed and (extent[j, 0] > inside[j, 1] or extent[j, 1] < inside[j, 0]):
            return count
    shift, chosen = np.zeros((n, MOST_TURNS)), np.full((n, MOST_TURNS), -1, np.int64)
    many, pick = np.ones(n, np.int64), np.zeros(n, np.int64)
    if not turns_of(windows, extent, near, only_near, shift, chosen, many):
        return count
    while True:
        count = emit_turned(
            chain, task, chart, spare, left, right, a, b, error, windows, shift, chosen, pick, inside, boxed,
            strand, low, high, found, count, origin,
        )  # fmt: skip
        if is_last(pick, many):
            return count


@kernel
def emit_turned(
    chain: Chain, task: Task, chart: Chart, spare: Chart, left: float, right: float, a: FloatArray, b: FloatArray,
    error: float, windows: Windows, shift: FloatArray, chosen: IntArray, pick: IntArray, inside: FloatArray,
    boxed: bool, strand: float, low: float, high: float, found: Found, count: int, origin: int,
) -> int:  # fmt: skip
    """Write one cell, trimmed to its windows; none if nothing of it is inside."""
    n = len(a)
    one, two, turn, node = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for j in range(n):
        turn[j] = shift[j, pick[j]]
        one[j], two[j] = a[j] + turn[j], b[j] + turn[j]
    start, stop = left, right
    for _ in range(4):
        width = stop - start
        first, last = 0.0, 1.0
        for j in range(n):
            about = off_chord(0.125 * width * width * chart.spread[j] + error, chart.curvature[j], width)
            floor, ceiling = -np.inf, np.inf
            if chosen[j, pick[j]] >= 0:
                w = windows.first[j] + chosen[j, pick[j]]
                floor, ceiling = windows.ends[w, 0], windows.ends[w, 1]
            if boxed:
                floor, ceiling = max(floor, inside[j, 0] + turn[j]), min(ceiling, inside[j, 1] + turn[j])
            floor, ceiling = floor - about, ceiling + about
            step = two[j] - one[j]
            if abs(step) < 1e-300:
                if one[j] < floor or one[j] > ceiling:
                    return count
                continue
            s, e = (floor - one[j]) / step, (ceiling - one[j]) / step
            first, last = max(first, min(s, e)), min(last, max(s, e))
        first, last = first - 1e-9 * (first > 0.0), last + 1e-9 * (last < 1.0)
        if first > last:
            return count
        first, last = max(first, 0.0), min(last, 1.0)
        if last - first > 0.999:
            break
        was_start, was_stop = start, stop
        if first > 0.0:
            off = point_on(chain, task, chart, start + width * first, turn, node, spare)
            if off >= 0.0:
                start, error = start + width * first, max(error, off)
                one[:] = node
        if last < 1.0:
            off = point_on(chain, task, chart, was_start + width * last, turn, node, spare)
            if off >= 0.0:
                stop, error = was_start + width * last, max(error, off)
                two[:] = node
        if stop - start > 0.95 * (was_stop - was_start):
            break
    if count < len(found.a):
        width = stop - start
        for j in range(n):
            room = 0.125 * width * width * chart.spread[j] * (1.0 + PAD) + error + PAD
            found.a[count, j], found.b[count, j], found.rest[count, j] = one[j], two[j], room
            found.bow[count, j] = -(width * width) * chart.curvature[j]
            found.dev[count, j] = off_chord(room, chart.curvature[j], width)
        span = (high - low) / (right - left) if right > left else 0.0
        found.pieces[count, 0], found.pieces[count, 1] = strand, 0.0
        found.pieces[count, 2] = low if start == left else low + span * (start - left)
        found.pieces[count, 3] = high if stop == right else low + span * (stop - left)
        found.origin[count] = origin
    return count + 1


@kernel
def emit_box(
    windows: Windows, box: FloatArray, near: FloatArray, only_near: bool, found: Found, count: int, origin: int
) -> int:
    """Write a box (n, 2) as a cell of which nothing is known, in all turns that the windows allow."""
    n = len(box)
    shift, chosen = np.zeros((n, MOST_TURNS)), np.full((n, MOST_TURNS), -1, np.int64)
    many, pick = np.ones(n, np.int64), np.zeros(n, np.int64)
    if not turns_of(windows, box, near, only_near, shift, chosen, many):
        return count
    while True:
        if count < len(found.a):
            for j in range(n):
                middle = 0.5 * (box[j, 0] + box[j, 1]) + shift[j, pick[j]]
                found.a[count, j], found.b[count, j], found.bow[count, j] = middle, middle, 0.0
                room = 0.5 * (box[j, 1] - box[j, 0]) * (1.0 + PAD) + PAD
                found.dev[count, j], found.rest[count, j] = room, room
            found.pieces[count, 0], found.pieces[count, 1] = -1.0, 1.0
            found.pieces[count, 2], found.pieces[count, 3] = 0.0, 0.0
            found.origin[count] = origin
        count += 1
        if is_last(pick, many):
            return count
