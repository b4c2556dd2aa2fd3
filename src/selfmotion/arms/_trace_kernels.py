"""Kernels that cover a self-motion by cells: pieces of proved curves, and boxes where nothing is proved of it.

What the closed form of an arm encloses as one smooth branch is cut until each part is one proved curve. At folds and
where a joint is free it gives boxes that hold all solutions; these are cut until each is empty or crossed by one proved
curve, which is as regular there as anywhere.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import Handed, kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._cell_kernels import Found, Windows, emit_box, emit_curve, flag, has_options, plain, point_on
from selfmotion.arms._curve_kernels import (
    PAD,
    TAU,
    Chain,
    Chart,
    Task,
    chart_for,
    curled,
    enclose_curve,
    is_on_curve,
    is_only_one,
    null_direction,
    prepare,
    settle,
)
from selfmotion.arms._family_kernels import BRANCHES, ENCLOSE, SOLVE, TURNED, Enclose, Solve, Turned
from selfmotion.arms._roots import EMPTY, MERGED, REGULAR, SINGULAR

_TOO_LONG = 1.3  # times the spacing
_DEEP = 64
_FULL = 6.28  # a joint's box at least this wide is a whole turn [rad]
_FOLDED = 0.03  # width of the box about a fold below which it is looked at in joint space [rad]
_SINGULAR = 3e-4  # width in u of what is left of a singularity before it is
_SECTORS = 48  # in which a free joint's turn is looked at …
_FEW_SECTORS = 12  # … and the turns of two
_BOXES = 600  # that a box may be cut into before what is left is taken as it is
_CLOSE = 1e-7  # how far off a closed form may be near its folds [rad]


@kernel
def narrowed(chain: Chain, chart: Chart, middle: FloatArray, radius: FloatArray) -> bool:
    """Narrow a box to where its postures can do the task, linearised in its middle; return whether any can."""
    n = len(middle)
    along = 0.0
    for j in range(n):
        along += abs(chart.direction[j]) * radius[j]
    beyond = 0.0
    for k in range(n):
        i = n - 1 - k
        if i >= chain.first:
            beyond += radius[i]
        chart.local[i] = min(chain.levers[i], chart.levers[i] + PAD + chain.levers[i] * beyond)
    by_position, by_rotation = 0.5 * curled(chart.local, chain.first, radius, radius), 0.5 * beyond * beyond
    for i in range(n):
        room = (
            along * abs(chart.tangent[i]) + chart.by_position[i] * by_position + chart.by_rotation[i] * by_rotation
        ) * (1.0 + 1e-9) + PAD * (1.0 + (chart.by_position[i] + chart.by_rotation[i]) * (1.0 + chain.levers[0]))
        low, high = max(chart.offset[i] - room, -radius[i]), min(chart.offset[i] + room, radius[i])
        if low > high:
            return False
        middle[i] += 0.5 * (low + high)
        radius[i] = 0.5 * (high - low) * (1.0 + PAD)
    return True


@kernel
def holds_box(chain: Chain, chart: Chart, middle: FloatArray, radius: FloatArray) -> float:
    """Return half the length of a proved curve beside which no posture of a box does the task; negative if none is."""
    n = len(middle)
    half, s0 = 0.0, 0.0
    for j in range(n):
        half += abs(chart.direction[j]) * radius[j]
        s0 += chart.direction[j] * (middle[j] - chart.center[j])
    half = (half + abs(s0)) * (1.0 + 1e-9)
    if not half < 0.5 or not enclose_curve(chain, chart, half):
        return -1.0
    wide = chart.slope
    for i in range(n):
        room = 0.0
        for j in range(n):
            e = (1.0 if i == j else 0.0) - chart.tangent[i] * chart.direction[j]
            room += abs(e) * (radius[j] + abs(middle[j] - chart.center[j]))
        wide[i] = max(chart.tube[i], (room + 0.5 * half * half * abs(chart.curvature[i])) * (1.0 + 1e-9))
    return half if is_only_one(chain, chart, half, wide) else -1.0


@kernel
def resolve(
    chain: Chain, task: Task, chart: Chart, spare: Chart, box: FloatArray, windows: Windows, near: FloatArray,
    only_near: bool, narrowest: float, strand: float, found: Found, count: int, origin: int,
) -> int:  # fmt: skip
    """Cut a box (n, 2) until each part holds nothing, one proved curve, or is too narrow; write what is there."""
    n = len(box)
    stack = np.empty((_DEEP, n, 2))
    stack[0] = box
    middle, radius, direction, q = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    a, b, none, now = np.empty(n), np.empty(n), np.zeros(n), np.empty((n, 2))
    depth, looked_at, yes = 1, 0, flag(True)
    while depth > 0:
        depth -= 1
        looked_at += 1
        now[:] = stack[depth]
        if not has_options(windows, now):
            continue
        for j in range(n):
            middle[j], radius[j] = 0.5 * (now[j, 0] + now[j, 1]), 0.5 * (now[j, 1] - now[j, 0]) * (1.0 + PAD)
        known = null_direction(chain, task, middle, chart, direction)
        known = known and prepare(chain, task, middle, direction, chart)
        if known:
            gone = False
            for _ in range(3):
                before = radius.sum()
                if not narrowed(chain, chart, middle, radius):
                    gone = True
                    break
                if radius.sum() > 0.8 * before or not prepare(chain, task, middle, direction, chart):
                    break
            if gone:
                continue
            for j in range(n):
                now[j, 0] = max(now[j, 0], middle[j] - radius[j] * (1.0 + 1e-9) - PAD)
                now[j, 1] = min(now[j, 1], middle[j] + radius[j] * (1.0 + 1e-9) + PAD)
                q[j] = middle[j]
        if known and settle(chain, task, q, direction, 4.0 * radius.max() + 1e-6, spare) >= 0.0:
            half = -1.0
            if null_direction(chain, task, q, chart, direction) and prepare(chain, task, q, direction, chart):
                half = holds_box(chain, chart, middle, radius)
            if half >= 0.0:
                off = point_on(chain, task, chart, -half, none, a, spare)
                error = point_on(chain, task, chart, half, none, b, spare)
                if min(off, error) >= 0.0:
                    error = max(off, error)
                    count = emit_curve(
                        chain, task, chart, spare, -half, half, a, b, error, windows, near, only_near, now, yes,
                        strand + looked_at * 1e-6, 0.0, 1.0, found, count, origin,
                    )  # fmt: skip
                    continue
        widest, longest = 0, -1.0
        for j in range(n):
            if now[j, 1] - now[j, 0] > longest:
                widest, longest = j, now[j, 1] - now[j, 0]
        if longest <= narrowest or depth + 2 > _DEEP or looked_at > _BOXES:
            count = emit_box(windows, now, near, only_near, found, count, origin)
            continue
        cut = 0.5 * (now[widest, 0] + now[widest, 1])
        stack[depth], stack[depth + 1] = now, now
        stack[depth, widest, 0], stack[depth + 1, widest, 1] = cut, cut
        depth += 2
    return count


@kernel
def between(
    chain: Chain,
    task: Task,
    chart: Chart,
    a: FloatArray,
    b: FloatArray,
    c: FloatArray,
    direction: FloatArray,
    error: float,
) -> tuple[float, float]:
    """Prove that a, c and b are on one curve; return the s of a and b on the chart at c, (0, 0) if it cannot be."""
    if not prepare(chain, task, c, direction, chart):
        return 0.0, 0.0
    left, right = 0.0, 0.0
    for j in range(len(a)):
        left += direction[j] * (a[j] - c[j])
        right += direction[j] * (b[j] - c[j])
    half = max(-left, right) * (1.0 + 1e-9)
    proved = left < 0.0 < right and enclose_curve(chain, chart, half)
    if proved and is_on_curve(chart, a, half, error) and is_on_curve(chart, b, half, error):
        return left, right
    return 0.0, 0.0


@kernel
def follow(
    solve: Solve, enclose: Enclose, geometry: FloatArray, root: FloatArray, origin: FloatArray, low: float,
    high: float, branch: int, chain: Chain, task: Task, chart: Chart, spare: Chart, windows: Windows, spacing: float,
    narrowest: float, strand: float, found: Found, count: int,
) -> int:  # fmt: skip
    """Cover a branch that is smooth over [low, high] by cells in their order; return the new count."""
    n = len(chain.levers)
    ends, nodes, errors = np.empty((_DEEP, 2)), np.empty((_DEEP, 2, n)), np.empty((_DEEP, 2))
    all_q, ok = np.empty((BRANCHES, n)), np.empty(BRANCHES, np.bool_)
    a, b, c, direction = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    nothing, none = np.zeros(n), np.empty((n, 2))
    box, rate, state = np.empty((BRANCHES, n, 2)), np.empty((BRANCHES, n, 2)), np.empty(BRANCHES, np.int64)
    whole, no = plain(0), flag(False)
    rotation, position = np.ascontiguousarray(root[:, :, 0]), np.ascontiguousarray(origin[:, 0])
    for end in range(2):
        solve(geometry, rotation, position, low if end == 0 else high, all_q, ok)
        nodes[0, end] = all_q[branch]
        errors[0, end] = -1.0
        if null_direction(chain, task, nodes[0, end], chart, direction):
            errors[0, end] = settle(chain, task, nodes[0, end], direction, _CLOSE, spare)
    ends[0, 0], ends[0, 1] = low, high
    depth = 1
    while depth > 0:
        depth -= 1
        start, stop = ends[depth, 0], ends[depth, 1]
        a[:], b[:] = nodes[depth, 0], nodes[depth, 1]
        middle = 0.5 * (start + stop)
        solve(geometry, rotation, position, middle, all_q, ok)
        longest, size = 0.0, 0.0
        for j in range(n):
            c[j] = all_q[branch, j]
            a[j] -= TAU * np.rint((a[j] - c[j]) / TAU)
            b[j] -= TAU * np.rint((b[j] - c[j]) / TAU)
            longest = max(longest, abs(b[j] - c[j]), abs(c[j] - a[j]))
            direction[j] = b[j] - a[j]
            size += direction[j] ** 2
        size = np.sqrt(size)
        off = -1.0
        for j in range(n):
            direction[j] /= max(size, 1e-300)
        if size > 0.0:
            off = settle(chain, task, c, direction, _CLOSE, spare)
        error = max(errors[depth, 0], errors[depth, 1])
        known = min(errors[depth, 0], errors[depth, 1], off) >= 0.0
        divided = 2.0 * longest > _TOO_LONG * spacing
        if not divided:
            divided = True
            if known:
                left, right = between(chain, task, chart, a, b, c, direction, error)
                if left < right:
                    count = emit_curve(
                        chain, task, chart, spare, left, right, a, b, error, windows, nothing, no, none, no,
                        strand, start, stop, found, count, whole,
                    )  # fmt: skip
                    divided = False
        if not divided:
            continue
        if stop - start > narrowest and depth + 2 <= _DEEP:
            ends[depth, 0], ends[depth, 1] = middle, stop
            ends[depth + 1, 0], ends[depth + 1, 1] = start, middle
            nodes[depth, 0], nodes[depth, 1], nodes[depth + 1, 0], nodes[depth + 1, 1] = c, b, a, c
            errors[depth + 1, 0], errors[depth + 1, 1] = errors[depth, 0], off
            errors[depth, 0] = off
            depth += 2
            continue
        enclose(geometry, root, origin, start, stop, box, rate, state)
        for home in range(BRANCHES):
            mine = home == branch or (state[branch] == MERGED and state[home] != REGULAR)
            if mine and state[home] != EMPTY and state[home] != MERGED:
                count = resolve(
                    chain, task, chart, spare, box[home], windows, nothing, no, narrowest, strand + 0.5, found,
                    count, whole,
                )  # fmt: skip
    return count


@kernel
def is_free(box: FloatArray, joint: int) -> bool:
    """Return whether a joint, if it is one, may be anywhere."""
    return joint >= 0 and bool(box[joint, 1] - box[joint, 0] > _FULL)


@kernel
def merged_among(state: IntArray, mask: int) -> int:
    """Return the bits of the branches of a mask that are merged into others."""
    found = 0
    for branch in range(BRANCHES):
        if state[branch] == MERGED and mask & (1 << branch):
            found |= 1 << branch
    return found


@kernel
def concerns(kind: int, branch: int, mask: int, merged: int) -> bool:
    """Return whether a branch's box may hold postures of the branches of a mask, of which `merged` are merged.

    Into which branches these are merged may change from an interval to a part of it, so all that others merge into do.
    """
    return bool(mask & (1 << branch)) or (kind != REGULAR and merged != 0)


def _trace(
    solve: Solve, enclose: Enclose, turned: Turned, free: IntArray, geometry: FloatArray, root: FloatArray,
    origin: FloatArray, edges: FloatArray, chain: Chain, task: Task, windows: Windows, spacing: float,
    narrowest: float, found: Found,
) -> int:  # fmt: skip
    """Cover the whole self-motion at one pose; return how many cells there are, which may be more than there is room.

    `root` (3, 3, 2) and `origin` (3, 2) are the pose that the closed form starts from, `edges` (k,) the parameters to
    begin with.
    """
    n = len(chain.levers)
    chart, spare, count, whole, no = chart_for(n), chart_for(n), plain(0), plain(0), flag(False)
    box, rate, state = np.empty((BRANCHES, n, 2)), np.empty((BRANCHES, n, 2)), np.empty(BRANCHES, np.int64)
    ends, masks = np.empty((_DEEP, 2)), np.empty(_DEEP, np.int64)
    nothing, part, strand = np.zeros(n), np.empty((n, 2)), 0.0
    for k in range(len(edges) - 1):
        ends[0, 0], ends[0, 1], masks[0] = edges[k], edges[k + 1], (1 << BRANCHES) - 1
        depth = 1
        while depth > 0:
            depth -= 1
            low, high, mask = ends[depth, 0], ends[depth, 1], masks[depth]
            enclose(geometry, root, origin, low, high, box, rate, state)
            again, merged = 0, merged_among(state, mask)
            for branch in range(BRANCHES):
                kind = state[branch]
                if kind in (EMPTY, MERGED) or not concerns(kind, branch, mask, merged):
                    continue
                if not has_options(windows, box[branch]):
                    continue
                if kind == REGULAR:
                    strand += 1.0
                    count = follow(
                        solve, enclose, geometry, root, origin, low, high, branch, chain, task, chart, spare, windows,
                        spacing, narrowest, strand, found, count,
                    )  # fmt: skip
                    continue
                if kind == SINGULAR:
                    wide = high - low > _SINGULAR
                else:
                    wide = (box[branch, :, 1] - box[branch, :, 0]).max() > _FOLDED and high - low > narrowest
                if wide and depth + 2 <= _DEEP:
                    again |= 1 << branch
                    continue
                strand += 1.0
                shoulder, wrist = free
                most = _FEW_SECTORS if is_free(box[branch], shoulder) and is_free(box[branch], wrist) else _SECTORS
                sectors = most if is_free(box[branch], shoulder) else 1
                others = most if is_free(box[branch], wrist) else 1
                for i in range(sectors * others):
                    part[:] = box[branch]
                    one, two = -np.pi + TAU * (i % sectors) / sectors, -np.pi + TAU * (i // sectors) / others
                    inside = sectors == 1 or turned(
                        geometry, root, origin, low, high, branch, shoulder, one, one + TAU / sectors, part
                    )
                    if inside and others > 1:
                        inside = turned(geometry, root, origin, low, high, branch, wrist, two, two + TAU / others, part)
                    if inside:
                        strand += 1.0
                        count = resolve(
                            chain, task, chart, spare, part, windows, nothing, no, narrowest, strand, found, count,
                            whole,
                        )  # fmt: skip
            if again:
                middle = 0.5 * (low + high)
                ends[depth, 0], ends[depth, 1], masks[depth] = middle, high, again | merged
                ends[depth + 1, 0], ends[depth + 1, 1], masks[depth + 1] = low, middle, again | merged
                depth += 2
    return count


trace = Handed(_trace, [SOLVE, ENCLOSE, TURNED])


@kernel
def divide(
    chain: Chain, task: Task, windows: Windows, cells: Found, spacing: FloatArray, narrowest: float, found: Found
) -> int:
    """Cover cells by shorter ones of the same curves; return how many there are."""
    p, n = cells.a.shape
    chart, spare, count, yes, no = chart_for(n), chart_for(n), plain(0), flag(True), flag(False)
    ends, nodes, errors = np.empty((_DEEP, 2)), np.empty((_DEEP, 2, n)), np.empty((_DEEP, 2))
    a, b, c, direction, box = np.empty(n), np.empty(n), np.empty(n), np.empty(n), np.empty((n, 2))
    for k in range(p):
        low, high = cells.pieces[k, 2], cells.pieces[k, 3]
        if cells.pieces[k, 1] == 1.0:
            for j in range(n):
                box[j, 0], box[j, 1] = cells.a[k, j] - cells.dev[k, j], cells.a[k, j] + cells.dev[k, j]
            count = emit_box(windows, box, cells.a[k], yes, found, count, k)
            continue
        ends[0, 0], ends[0, 1] = 0.0, 1.0
        nodes[0, 0], nodes[0, 1] = cells.a[k], cells.b[k]
        errors[0, 0], errors[0, 1] = -1.0, -1.0  # of the ends themselves: part of what the cell was given room for
        for end in range(2):
            for j in range(n):
                direction[j] = cells.b[k, j] - cells.a[k, j]
            size = np.sqrt((direction * direction).sum())
            if size > 0.0:
                for j in range(n):
                    direction[j] /= size
                c[:] = nodes[0, end]
                errors[0, end] = settle(chain, task, c, direction, _CLOSE, spare)
                for j in range(n):  # the node stays, so that neighbours share it; how far it is off is known now
                    if errors[0, end] >= 0.0:
                        errors[0, end] += abs(c[j] - nodes[0, end, j])
        steps, bent, apart = 0.0, 0.0, 0.0
        for j in range(n):
            apart = max(apart, cells.rest[k, j])
            if abs(cells.b[k, j] - cells.a[k, j]) > steps:
                steps, bent = abs(cells.b[k, j] - cells.a[k, j]), abs(cells.bow[k, j])
        apart = 4.0 * apart + 1e-9
        depth = 1
        while depth > 0:
            depth -= 1
            start, stop = ends[depth, 0], ends[depth, 1]
            a[:], b[:] = nodes[depth, 0], nodes[depth, 1]
            middle, width = 0.5 * (start + stop), stop - start
            longest, size = 0.0, 0.0
            for j in range(n):
                direction[j] = b[j] - a[j]
                size += direction[j] ** 2
                longest = max(longest, abs(direction[j]))
                c[j] = 0.5 * (a[j] + b[j]) + 0.125 * width * width * cells.bow[k, j]
            size = np.sqrt(size)
            for j in range(n):
                direction[j] /= max(size, 1e-300)
            off = -1.0
            if size > 0.0:
                off = settle(chain, task, c, direction, max(_CLOSE, size), spare)
            for j in range(n):  # still on the curve of the cell?
                on_parabola = (
                    (1.0 - middle) * cells.a[k, j] + middle * cells.b[k, j]
                    + 0.5 * middle * (1.0 - middle) * cells.bow[k, j]
                )  # fmt: skip
                if abs(c[j] - on_parabola) > apart:
                    off = -1.0
            known = min(errors[depth, 0], errors[depth, 1], off) >= 0.0
            if known and longest <= _TOO_LONG * spacing[k]:
                error = max(errors[depth, 0], errors[depth, 1])
                left, right = between(chain, task, chart, a, b, c, direction, error)
                if left < right:
                    count = emit_curve(
                        chain, task, chart, spare, left, right, a, b, error, windows, c, yes, box, no,
                        cells.pieces[k, 0], low + (high - low) * start, low + (high - low) * stop, found, count, k,
                    )  # fmt: skip
                    continue
            if known and depth + 2 <= _DEEP and width > 1e-6:
                ends[depth, 0], ends[depth, 1], ends[depth + 1, 0], ends[depth + 1, 1] = middle, stop, start, middle
                nodes[depth, 0], nodes[depth, 1], nodes[depth + 1, 0], nodes[depth + 1, 1] = c, b, a, c
                errors[depth + 1, 0], errors[depth + 1, 1] = errors[depth, 0], off
                errors[depth, 0] = off
                depth += 2
                continue
            # What was proved of the whole cell holds of this part, and of as much more as nodes may be elsewhere in it.
            spare_s = 1.0 if bent > 0.5 * steps else min(4.0 * apart / max(steps, 1e-300), 1.0)
            start, stop = max(start - spare_s, 0.0), min(stop + spare_s, 1.0)
            width = stop - start
            if count < len(found.a):
                for j in range(n):
                    one, two = cells.a[k, j], cells.b[k, j]
                    found.a[count, j] = (
                        (1.0 - start) * one + start * two + 0.5 * start * (1.0 - start) * cells.bow[k, j]
                    )
                    found.b[count, j] = (1.0 - stop) * one + stop * two + 0.5 * stop * (1.0 - stop) * cells.bow[k, j]
                    found.bow[count, j] = width * width * cells.bow[k, j]
                    found.rest[count, j] = cells.rest[k, j] * (1.0 + PAD) + PAD
                    found.dev[count, j] = found.rest[count, j] + 0.125 * abs(found.bow[count, j]) * (1.0 + PAD)
                found.pieces[count, 0], found.pieces[count, 1] = cells.pieces[k, 0], 0.0
                found.pieces[count, 2] = low if start == 0.0 else low + (high - low) * start
                found.pieces[count, 3] = high if stop == 1.0 else low + (high - low) * stop
                found.origin[count] = k
            count += 1
    return count


@kernel
def order_along(
    a: FloatArray,
    b: FloatArray,
    wraps: BoolArray,
    keys: FloatArray,
    order: IntArray,
    turned: BoolArray,
    strand: IntArray,
) -> int:
    """Order cells so that each begins where the one before ends, some of them turned about; return how many strands.

    `keys` (2 m,) is any function of the ends, first all a, then all b, that tells them apart; `strand` (m,) in the new
    order.
    """
    m, n = a.shape
    by_key = np.argsort(keys)
    partner = np.full(2 * m, -1)
    for i in range(2 * m):
        one = by_key[i]
        if partner[one] >= 0:
            continue
        for k in range(i + 1, 2 * m):
            two = by_key[k]
            if keys[two] - keys[one] > 1e-7:
                break
            if partner[two] >= 0 or two % m == one % m:
                continue
            far = 0.0
            for j in range(n):
                step = (a[one, j] if one < m else b[one - m, j]) - (a[two, j] if two < m else b[two - m, j])
                if wraps[j]:
                    step -= TAU * np.rint(step / TAU)
                far = max(far, abs(step))
            if far < 5e-10:
                partner[one], partner[two] = two, one
                break
    used = np.zeros(m, np.bool_)
    count, strands = 0, 0
    for sweep in range(2):  # strands with ends first, then closed ones
        for cell in range(m):
            if used[cell]:
                continue
            if sweep == 0:
                if partner[cell] >= 0 and partner[m + cell] >= 0:
                    continue
                entry = cell if partner[cell] < 0 else m + cell
            else:
                entry = cell
            while entry >= 0 and not used[entry % m]:
                here = entry % m
                used[here] = True
                order[count], turned[count], strand[count] = here, entry >= m, strands
                count += 1
                entry = partner[here] if entry >= m else partner[m + here]
            strands += 1
    return strands
