"""Kernels that cover the postures of spatial arms for a box of poses by boxes of joint angles."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import Handed
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._cell_kernels import Windows, has_options
from selfmotion.arms._family_kernels import BRANCHES, ENCLOSE, TURNED, Enclose, Turned
from selfmotion.arms._roots import EMPTY, MERGED, REGULAR
from selfmotion.arms._slab_kernels import all_options, is_last
from selfmotion.arms._trace_kernels import concerns, is_free, merged_among

COLUMNS = 7
"""Of a piece: ends of its interval of u, bits of its branches, ends of the sectors of a free shoulder and wrist."""

_THIN = 0.3  # a box is not cut in u where that would take less than this part of its radius away
_THINNEST = 0.2  # where its rate is not known: u against the radius wanted
_DEEPEST = 512  # pieces that wait to be looked at
_OPTIONS = 32  # turns of a joint that are told apart


def _boxes_of_slab(
    enclose: Enclose, turned: Turned, free_joints: IntArray, geometry: FloatArray, root: FloatArray,
    origin: FloatArray, windows: Windows, pieces: FloatArray,
    inside_low: FloatArray, inside_high: FloatArray, size: FloatArray, narrowest: float,
    low: FloatArray, high: FloatArray, clean: BoolArray, found: FloatArray, parent: IntArray,
) -> int:  # fmt: skip
    """Cover pieces (p, 7) of the self-motion of a box of poses by boxes; return how many, perhaps more than rows.

    `root` (3, 3, 2) and `origin` (3, 2) are the poses. Limited joints stay in [inside_low, inside_high] (p, n) as well.
    """
    n, capacity, count = low.shape[1], len(low), 0
    wraps, ends, first, period = windows
    stack = np.empty((_DEEPEST, COLUMNS))
    all_boxes, rate = np.empty((BRANCHES, n, 2)), np.empty((BRANCHES, n, 2))
    state, box, now = np.empty(BRANCHES, np.int64), np.empty((n, 2)), np.empty(COLUMNS)
    many, pick, ways = np.ones(n, np.int64), np.zeros(n, np.int64), np.empty((n, _OPTIONS, 3))
    for p in range(len(pieces)):
        stack[0] = pieces[p]
        depth = 1
        while depth > 0:
            depth -= 1
            now[:] = stack[depth]
            start, stop = now[0], now[1]
            enclose(geometry, root, origin, start, stop, all_boxes, rate, state)
            mask, merged = int(now[2]), merged_among(state, int(now[2]))
            for b in range(BRANCHES):
                kind = state[b]
                if kind in (EMPTY, MERGED) or not concerns(kind, b, mask, merged):
                    continue
                mine = float(1 << b | (0 if kind == REGULAR else merged))
                box[:] = all_boxes[b]
                free = 0
                inside = True
                for which in range(2):
                    if not is_free(box, free_joints[which]):
                        continue
                    one, two = now[3 + 2 * which], now[4 + 2 * which]
                    if two - one < 0.5:
                        inside = inside and turned(
                            geometry, root, origin, start, stop, b, free_joints[which], one, two, box
                        )
                    else:
                        free += 1
                if not inside or not has_options(windows, box):
                    continue
                if not all_options(box, wraps, ends, first, period, inside_low[p], inside_high[p], ways, many):
                    continue
                longest, by_u = 0.0, 0.0
                for j in range(n):
                    longest = max(longest, 0.5 * (box[j, 1] - box[j, 0]))
                    by_u = max(by_u, 0.5 * (stop - start) * max(abs(rate[b, j, 0]), abs(rate[b, j, 1])))
                wide = by_u > _THIN * longest if kind == REGULAR else stop - start > _THINNEST * size[p]
                room = depth + 2 <= _DEEPEST
                if longest > size[p] and wide and stop - start > narrowest and room:
                    cut = 0.5 * (start + stop)
                    for half in range(2):
                        stack[depth] = now
                        stack[depth, half] = cut
                        stack[depth, 2] = mine
                        depth += 1
                    continue
                sector = -1
                for which in range(2):
                    joint = free_joints[which]
                    if is_free(all_boxes[b], joint) and box[joint, 1] - box[joint, 0] > 2.0 * size[p]:
                        sector = which
                if sector >= 0 and room:
                    joint = free_joints[sector]
                    one, two = max(box[joint, 0], now[3 + 2 * sector]), min(box[joint, 1], now[4 + 2 * sector])
                    if two - one > 2.0 * size[p]:
                        cut = 0.5 * (one + two)
                        for half in range(2):
                            stack[depth] = now
                            stack[depth, 2] = mine
                            stack[depth, 3 + 2 * sector], stack[depth, 4 + 2 * sector] = one, two
                            stack[depth, 3 + 2 * sector + (1 - half)] = cut
                            depth += 1
                        continue
                pick[:] = 0
                while True:
                    if count < capacity:
                        clean[count], parent[count] = kind == REGULAR, p
                        for j in range(n):
                            low[count, j], high[count, j] = ways[j, pick[j], 0], ways[j, pick[j], 1]
                            clean[count] = clean[count] and ways[j, pick[j], 2] > 0.0
                        found[count] = now
                        found[count, 2] = mine
                    count += 1
                    if is_last(pick, many):
                        break
    return count


boxes_of_slab = Handed(_boxes_of_slab, [ENCLOSE, TURNED])
