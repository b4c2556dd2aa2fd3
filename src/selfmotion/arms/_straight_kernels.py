"""Kernels that cover self-motions of arms whose tool lies along the last joint's axis: that joint alone turns.

With T(u) = X Rz(u) tool⁻¹ the last frame, and tool⁻¹ a turn about z and a shift along it, perhaps after a half turn
about x, T(u) = T(0) Rz(±u): the postures at all rolls are those at one, with the last joint anywhere. So self-motions
are straight lines, which the closed form encloses at one roll as exactly as the pose is known, however near a
singularity is. At a singularity another joint is free as well; the postures are a surface then, and are covered by
boxes no smaller than a sector of a turn.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import Handed, kernel
from selfmotion._types import FloatArray, IntArray
from selfmotion.arms._cell_kernels import MOST_TURNS, Found, Windows, emit_box, flag, plain, turns_of
from selfmotion.arms._curve_kernels import PAD, TAU
from selfmotion.arms._family_kernels import BRANCHES, ENCLOSE, SOLVE, TURNED, Enclose, Solve, Turned
from selfmotion.arms._roots import EMPTY, MERGED, REGULAR
from selfmotion.arms._slab_kernels import is_last
from selfmotion.arms._trace_kernels import is_free

_SECTORS = 48  # of a joint that is free besides the last one, and of that one's turn there, at most
_FEW_SECTORS = 12  # where two are


@kernel
def emit_line(
    windows: Windows, a: FloatArray, b: FloatArray, room: FloatArray, near: FloatArray, only_near: bool, strand: float,
    low: float, high: float, found: Found, count: int, origin: int,
) -> int:  # fmt: skip
    """Write the cell from a to b (n,), postures being within `room` of it, in all turns, trimmed to the windows."""
    n = len(a)
    extent = np.empty((n, 2))
    for j in range(n):
        extent[j, 0], extent[j, 1] = min(a[j], b[j]) - room[j], max(a[j], b[j]) + room[j]
    shift, chosen = np.zeros((n, MOST_TURNS)), np.full((n, MOST_TURNS), -1, np.int64)
    many, pick = np.ones(n, np.int64), np.zeros(n, np.int64)
    if not turns_of(windows, extent, near, only_near, shift, chosen, many):
        return count
    while True:
        start, stop = 0.0, 1.0
        for j in range(n):
            if chosen[j, pick[j]] < 0 or a[j] == b[j]:
                continue
            w, step = windows.first[j] + chosen[j, pick[j]], b[j] - a[j]
            floor = windows.ends[w, 0] - room[j] - a[j] - shift[j, pick[j]]
            ceiling = windows.ends[w, 1] + room[j] - a[j] - shift[j, pick[j]]
            one, two = floor / step, ceiling / step
            start, stop = max(start, min(one, two) - 1e-9), min(stop, max(one, two) + 1e-9)
        if start <= stop:
            if count < len(found.a):
                for j in range(n):
                    moved = shift[j, pick[j]]
                    found.a[count, j] = moved + (a[j] if start == 0.0 else a[j] + start * (b[j] - a[j]))
                    found.b[count, j] = moved + (b[j] if stop == 1.0 else a[j] + stop * (b[j] - a[j]))
                    found.bow[count, j] = 0.0
                    found.rest[count, j] = room[j] + PAD
                    found.dev[count, j] = room[j] + PAD
                found.pieces[count, 0], found.pieces[count, 1] = strand, 0.0
                found.pieces[count, 2], found.pieces[count, 3] = low + start * (high - low), low + stop * (high - low)
                found.origin[count] = origin
            count += 1
        if is_last(pick, many):
            return count


@kernel
def emit_resting(windows: Windows, box: FloatArray, found: Found, count: int, origin: int) -> int:
    """Write a box (n, 2) as cells of which nothing is known, the last joint anywhere in each of its windows."""
    n, last = len(box), len(box) - 1
    wraps = windows.wraps.copy()
    wraps[last] = True
    others = Windows(wraps, windows.ends, windows.first, windows.period)
    shift, chosen = np.zeros((n, MOST_TURNS)), np.full((n, MOST_TURNS), -1, np.int64)
    many, pick = np.ones(n, np.int64), np.zeros(n, np.int64)
    if not turns_of(others, box, np.zeros(n), flag(False), shift, chosen, many):
        return count
    whole = windows.wraps[last]
    while True:
        for w in range(1 if whole else windows.first[last + 1] - windows.first[last]):
            if count < len(found.a):
                for j in range(n):
                    low, high = box[j, 0] + shift[j, pick[j]], box[j, 1] + shift[j, pick[j]]
                    if j == last:
                        low, high = -np.pi, np.pi
                        if not whole:
                            low, high = windows.ends[windows.first[j] + w, 0], windows.ends[windows.first[j] + w, 1]
                    middle, room = 0.5 * (low + high), 0.5 * (high - low) * (1.0 + PAD) + PAD
                    found.a[count, j], found.b[count, j], found.bow[count, j] = middle, middle, 0.0
                    found.dev[count, j], found.rest[count, j] = room, room
                found.pieces[count, 0], found.pieces[count, 1] = -1.0, 1.0
                found.pieces[count, 2], found.pieces[count, 3] = 0.0, 0.0
                found.origin[count] = origin
            count += 1
        if is_last(pick, many):
            return count


def _trace_lines(
    solve: Solve, enclose: Enclose, turned: Turned, free: IntArray, geometry: FloatArray, root: FloatArray,
    origin: FloatArray, start: FloatArray, windows: Windows, spacing: float, rests: bool, found: Found,
) -> int:  # fmt: skip
    """Cover the whole self-motion at one pose; return how many cells there are, which may be more than there is room.

    `root` (3, 3, 2) and `origin` (3, 2) are the poses that the closed form starts from, `start` (4, 3) the one in their
    middle, rotation over position. If the last joint `rests` cells are not cut along it.
    """
    n, last = found.a.shape[1], found.a.shape[1] - 1
    count, whole, no, nothing = plain(0), plain(0), flag(False), np.zeros(n)
    box, rate, state = np.empty((BRANCHES, n, 2)), np.empty((BRANCHES, n, 2)), np.empty(BRANCHES, np.int64)
    q, there, here = np.empty((BRANCHES, n)), np.empty(BRANCHES, np.bool_), np.empty((n, 2))
    a, b, room = np.empty(n), np.empty(n), np.empty(n)
    enclose(geometry, root, origin, 0.0, 0.0, box, rate, state)
    solve(geometry, start[:3], start[3], 0.0, q, there)
    for branch in range(BRANCHES):
        if state[branch] in (EMPTY, MERGED):
            continue
        one_line = state[branch] == REGULAR and there[branch]
        free_shoulder, free_wrist = is_free(box[branch], free[0]), is_free(box[branch], free[1])
        most = _FEW_SECTORS if free_shoulder and free_wrist else _SECTORS
        parts = int(np.ceil(TAU / spacing))
        if not one_line:
            parts = min(parts, most)
        sectors, others = parts if free_shoulder else 1, parts if free_wrist else 1
        for i in range(sectors * others):
            here[:] = box[branch]
            if free_shoulder:
                low = -np.pi + TAU * (i % sectors) / sectors
                if not turned(
                    geometry, root, origin, 0.0, 0.0, branch, free[0], low, low + (1.0 + PAD) * TAU / sectors, here
                ):
                    continue
            if free_wrist:
                low = -np.pi + TAU * (i // sectors) / others
                if not turned(
                    geometry, root, origin, 0.0, 0.0, branch, free[1], low, low + (1.0 + PAD) * TAU / others, here
                ):
                    continue
            if rests:
                count = emit_resting(windows, here, found, count, whole)
                continue
            for j in range(n):
                middle = 0.5 * (here[j, 0] + here[j, 1])
                a[j] = q[branch, j] - TAU * np.rint((q[branch, j] - middle) / TAU) if one_line else middle
                room[j] = max(here[j, 1] - a[j], a[j] - here[j, 0]) + 4.0 * PAD
            first = a[last] - np.pi
            for k in range(parts):
                a[last] = first + TAU * k / parts
                b[:] = a
                b[last] = first + TAU * (k + 1) / parts
                if one_line:
                    count = emit_line(
                        windows, a, b, room, nothing, no, float(branch), float(k), k + 1.0, found, count, whole
                    )
                    continue
                for j in range(n):
                    here[j, 0], here[j, 1] = min(a[j], b[j]) - room[j], max(a[j], b[j]) + room[j]
                count = emit_box(windows, here, nothing, no, found, count, whole)
    return count


trace_lines = Handed(_trace_lines, [SOLVE, ENCLOSE, TURNED])


@kernel
def divide_lines(windows: Windows, cells: Found, spacing: FloatArray, found: Found) -> int:
    """Cover cells by shorter ones of the same lines; return how many there are. Boxes stay as they are."""
    p, n = cells.a.shape
    count, yes, a, b, box = plain(0), flag(True), np.empty(n), np.empty(n), np.empty((n, 2))
    for k in range(p):
        if cells.pieces[k, 1] == 1.0:
            for j in range(n):
                box[j, 0], box[j, 1] = cells.a[k, j] - cells.dev[k, j], cells.a[k, j] + cells.dev[k, j]
            count = emit_box(windows, box, cells.a[k], yes, found, count, k)
            continue
        low, high = cells.pieces[k, 2], cells.pieces[k, 3]
        longest = np.abs(cells.b[k] - cells.a[k]).max()
        parts = max(int(np.ceil(longest / spacing[k])), 1)
        b[:] = cells.a[k]
        for i in range(1, parts + 1):
            a[:] = b
            for j in range(n):
                b[j] = cells.b[k, j] if i == parts else cells.a[k, j] + (cells.b[k, j] - cells.a[k, j]) * i / parts
            start, stop = low + (high - low) * (i - 1) / parts, high if i == parts else low + (high - low) * i / parts
            count = emit_line(
                windows, a, b, cells.rest[k], a, yes, cells.pieces[k, 0], start, stop, found, count, k
            )  # fmt: skip
    return count
