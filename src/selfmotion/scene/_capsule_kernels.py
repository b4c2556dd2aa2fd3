"""Kernels of links as capsules: where their ends are, how far they are from obstacles, and of cells what is sure.

A capsule moves with the frame after a joint. Everything is in space; a planar arm's plane is z = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray, IntArray
from selfmotion.scene._distance_kernels import segment_distance, segments_distance
from selfmotion.scene.kinds import CAPSULE, HALF_SPACE, POLYGON, SPHERE

PAD = 1e-13
SURE = 1e-9  # part of its coordinates that a difference must be, for its direction …
TURNED = 1e-6  # … to be turned by no more than this by rounding


class Capsules(NamedTuple):
    """The links of an arm: its chain, and capsules with their `ends` (c, 2, 3) in the frame after joint `frame` (c,).

    A frame of −1 stands still. Of `levers` (c, 2, n), entry j bounds how far an end is from the axis of joint j, or is
    1 where that slides, or 0 where the joint does not move it. The first `first` joints slide.
    """

    turns: FloatArray
    shifts: FloatArray
    first: int
    frame: IntArray
    ends: FloatArray
    radius: FloatArray
    levers: FloatArray


class Shapes(NamedTuple):
    """Obstacles: the kind of each (m,) and its numbers, those from first[k] to first[k + 1]."""

    kinds: IntArray
    first: IntArray
    numbers: FloatArray


class Pairs(NamedTuple):
    """What must keep clear of what: capsule `link` (p,) of shape `other` ≥ 0, or of capsule −1 − `other`.

    `needed` (p,) is the distance that there must be between shape and axis, or axis and axis.
    """

    link: IntArray
    other: IntArray
    needed: FloatArray


@kernel
def place(capsules: Capsules, q: FloatArray, axes: FloatArray, centers: FloatArray, points: FloatArray) -> None:
    """Fill in the joints' axes and points on them (n, 3), and the capsules' ends (c, 2, 3), all in the world."""
    n = len(q)
    turns, shifts = capsules.turns, capsules.shifts
    rotation, origin, column = turns[0].copy(), shifts[0].copy(), np.empty(3)
    for c in range(len(capsules.frame)):
        if capsules.frame[c] < 0:
            points[c] = capsules.ends[c]
    for j in range(n):
        axes[j] = rotation[:, 2]
        centers[j] = origin
        if j < capsules.first:
            for i in range(3):
                origin[i] += rotation[i, 2] * q[j]
        else:
            cosine, sine = np.cos(q[j]), np.sin(q[j])
            for i in range(3):
                one, two = rotation[i, 0], rotation[i, 1]
                rotation[i, 0], rotation[i, 1] = cosine * one + sine * two, cosine * two - sine * one
        for c in range(len(capsules.frame)):
            if capsules.frame[c] == j:
                for e in range(2):
                    for i in range(3):
                        points[c, e, i] = origin[i] + (
                            rotation[i, 0] * capsules.ends[c, e, 0]
                            + rotation[i, 1] * capsules.ends[c, e, 1]
                            + rotation[i, 2] * capsules.ends[c, e, 2]
                        )
        for i in range(3):
            origin[i] += (
                rotation[i, 0] * shifts[j + 1, 0]
                + rotation[i, 1] * shifts[j + 1, 1]
                + rotation[i, 2] * shifts[j + 1, 2]
            )
        for i in range(3):
            for k in range(3):
                column[k] = (
                    rotation[i, 0] * turns[j + 1, 0, k]
                    + rotation[i, 1] * turns[j + 1, 1, k]
                    + rotation[i, 2] * turns[j + 1, 2, k]
                )
            rotation[i] = column


@kernel
def margin(shapes: Shapes, pairs: Pairs, p: int, points: FloatArray, at: FloatArray, normal: FloatArray) -> float:
    """Return what is left of the distance that pair p needs; see :func:`segment_distance` for `at` and `normal`.

    `at` (2, 3) is where it is least, on the link and on the other link if the pair has one.
    """
    c, other = pairs.link[p], pairs.other[p]
    if other >= 0:
        kind, start = shapes.kinds[other], shapes.first[other]
        distance = segment_distance(kind, shapes.numbers, start, points[c, 0], points[c, 1], at[0], normal)
    else:
        d = -1 - other
        distance = segments_distance(points[c, 0], points[c, 1], points[d, 0], points[d, 1], at[0], at[1], normal)
    return distance - pairs.needed[p]


@kernel
def margins_all(capsules: Capsules, shapes: Shapes, pairs: Pairs, q: FloatArray, found: FloatArray) -> None:
    """Fill in the margins (k, p) of postures (k, n)."""
    n, c = q.shape[1], len(capsules.frame)
    axes, centers, points = np.empty((n, 3)), np.empty((n, 3)), np.empty((c, 2, 3))
    at, normal = np.empty((2, 3)), np.empty(3)
    for k in range(len(q)):
        place(capsules, q[k], axes, centers, points)
        for p in range(len(pairs.link)):
            found[k, p] = margin(shapes, pairs, p, points, at, normal)


@kernel
def least_all(
    capsules: Capsules,
    shapes: Shapes,
    pairs: Pairs,
    balls: FloatArray,
    q: FloatArray,
    found: FloatArray,
    which: IntArray,
) -> None:
    """Fill in the least margin (k,) of postures (k, n), and the pair that it is of.

    Shape m lies in the ball `balls` (m, 4) of a centre and a radius: what that keeps away is not looked at closer.
    """
    n, c = q.shape[1], len(capsules.frame)
    axes, centers, points = np.empty((n, 3)), np.empty((n, 3)), np.empty((c, 2, 3))
    at, normal = np.empty((2, 3)), np.empty(3)
    for k in range(len(q)):
        place(capsules, q[k], axes, centers, points)
        found[k], which[k] = np.inf, 0
        for p in range(len(pairs.link)):
            if not _is_farther(pairs, p, points, balls, found[k]):
                here = margin(shapes, pairs, p, points, at, normal)
                if here < found[k]:
                    found[k], which[k] = here, p


@kernel
def _is_farther(pairs: Pairs, p: int, points: FloatArray, balls: FloatArray, margin: float) -> bool:
    """Return whether pair p surely has more than `margin`, as the balls about its two parts tell."""
    c, other = pairs.link[p], pairs.other[p]
    square, radius, half = 0.0, pairs.needed[p] + margin, 0.0
    for i in range(3):
        middle = 0.5 * (points[c, 0, i] + points[c, 1, i])
        half += (points[c, 1, i] - middle) ** 2
        if other >= 0:
            square += (middle - balls[other, i]) ** 2
        else:
            square += (middle - 0.5 * (points[-1 - other, 0, i] + points[-1 - other, 1, i])) ** 2
    radius += np.sqrt(half)
    if other >= 0:
        radius += balls[other, 3]
    else:
        half = 0.0
        for i in range(3):
            half += (0.5 * (points[-1 - other, 1, i] - points[-1 - other, 0, i])) ** 2
        radius += np.sqrt(half)
    return radius < 0.0 or square > radius * radius


@kernel
def gradients_all(
    capsules: Capsules, shapes: Shapes, pairs: Pairs, q: FloatArray, found: FloatArray, gradient: FloatArray
) -> None:
    """Fill in the margins (k, p) of postures (k, n), and their derivatives by the joints (k, p, n)."""
    n, c = q.shape[1], len(capsules.frame)
    axes, centers, points = np.empty((n, 3)), np.empty((n, 3)), np.empty((c, 2, 3))
    at, normal = np.empty((2, 3)), np.empty(3)
    for k in range(len(q)):
        place(capsules, q[k], axes, centers, points)
        for p in range(len(pairs.link)):
            found[k, p] = margin(shapes, pairs, p, points, at, normal)
            gradient[k, p] = 0.0
            add_rates(capsules, axes, centers, capsules.frame[pairs.link[p]], at[0], normal, 1.0, gradient[k, p])
            if pairs.other[p] < 0:
                frame = capsules.frame[-1 - pairs.other[p]]
                add_rates(capsules, axes, centers, frame, at[1], normal, -1.0, gradient[k, p])


@kernel
def add_rates(
    capsules: Capsules, axes: FloatArray, centers: FloatArray, frame: int, point: FloatArray, normal: FloatArray,
    sign: float, rates: FloatArray,
) -> None:  # fmt: skip
    """Add how fast a point that moves with a frame goes along `normal`, by each joint's rate (n,)."""
    for j in range(frame + 1):
        if j < capsules.first:
            rates[j] += sign * (axes[j, 0] * normal[0] + axes[j, 1] * normal[1] + axes[j, 2] * normal[2])
            continue
        x, y, z = point[0] - centers[j, 0], point[1] - centers[j, 1], point[2] - centers[j, 2]
        rates[j] += sign * (
            (axes[j, 1] * z - axes[j, 2] * y) * normal[0]
            + (axes[j, 2] * x - axes[j, 0] * z) * normal[1]
            + (axes[j, 0] * y - axes[j, 1] * x) * normal[2]
        )


@kernel
def rates_at(
    capsules: Capsules, q: FloatArray, frames: IntArray, at: FloatArray, normal: FloatArray, rates: FloatArray
) -> None:
    """Add to `rates` (k, p, n) how fast points (k, p, 3) that move with frames (p,) go along directions (k, p, 3)."""
    n, c = q.shape[1], len(capsules.frame)
    axes, centers, points = np.empty((n, 3)), np.empty((n, 3)), np.empty((c, 2, 3))
    for k in range(len(q)):
        place(capsules, q[k], axes, centers, points)
        for p in range(len(frames)):
            add_rates(capsules, axes, centers, frames[p], at[k, p], normal[k, p], 1.0, rates[k, p])


@kernel
def place_all(capsules: Capsules, q: FloatArray, points: FloatArray) -> None:
    """Fill in the capsules' ends (k, c, 2, 3) in postures (k, n)."""
    axes, centers = np.empty((q.shape[1], 3)), np.empty((q.shape[1], 3))
    for k in range(len(q)):
        place(capsules, q[k], axes, centers, points[k])


@kernel
def hulls_of_cells(
    capsules: Capsules, a: FloatArray, b: FloatArray, dev: FloatArray, points: FloatArray, half: FloatArray,
    rest: FloatArray,
) -> None:  # fmt: skip
    """Enclose where the ends of capsules are in cells (m, n): within `rest` (m, c, 2) of the lines points ± half.

    These are (m, c, 2, 3). On its chord an end of a capsule is within ``⅛ Σ_jk |Δ_j| |Δ_k| lever_max(j,k)`` of the
    straight line between its two places, since that bounds its second derivative; off the chord by at most
    ``Σ_j lever_j dev_j`` more. Both ends of a capsule are at the same place of their lines at the same time.
    """
    n, count = a.shape[1], len(capsules.frame)
    axes, centers = np.empty((n, 3)), np.empty((n, 3))
    one, two = np.empty((count, 2, 3)), np.empty((count, 2, 3))
    for k in range(len(a)):
        place(capsules, a[k], axes, centers, one)
        place(capsules, b[k], axes, centers, two)
        for c in range(count):
            for e in range(2):
                size = 0.0
                for i in range(3):
                    points[k, c, e, i] = 0.5 * (one[c, e, i] + two[c, e, i])
                    half[k, c, e, i] = 0.5 * (two[c, e, i] - one[c, e, i])
                    size += abs(one[c, e, i]) + abs(two[c, e, i])
                inner, bent, off = 0.0, 0.0, 0.0
                for j in range(capsules.frame[c] + 1):
                    step, lever = abs(b[k, j] - a[k, j]), capsules.levers[c, e, j]
                    bent += lever * step * (2.0 * inner + step)
                    inner += step
                    off += lever * dev[k, j]
                    size += lever
                rest[k, c, e] = 0.125 * bent + off + PAD * size


@kernel
def hulls_of_boxes(
    capsules: Capsules, low: FloatArray, high: FloatArray, points: FloatArray, half: FloatArray, rest: FloatArray
) -> None:
    """Do the same for boxes of joint angles (m, n): a joint moves an end by no more than its lever for its step."""
    n = low.shape[1]
    axes, centers = np.empty((n, 3)), np.empty((n, 3))
    for k in range(len(low)):
        place(capsules, 0.5 * (low[k] + high[k]), axes, centers, points[k])
        half[k] = 0.0
        for c in range(len(capsules.frame)):
            for e in range(2):
                move, size = 0.0, np.abs(points[k, c, e]).sum()
                for j in range(capsules.frame[c] + 1):
                    move += capsules.levers[c, e, j] * 0.5 * (high[k, j] - low[k, j])
                    size += capsules.levers[c, e, j]
                rest[k, c, e] = move + PAD * size


@kernel
def farthest(half: FloatArray, rest: FloatArray) -> float:
    """Return how far a capsule's ends get from the middles of their lines (2, 3), in any direction."""
    one = np.sqrt(half[0, 0] ** 2 + half[0, 1] ** 2 + half[0, 2] ** 2)
    two = np.sqrt(half[1, 0] ** 2 + half[1, 1] ** 2 + half[1, 2] ** 2)
    return max(one + rest[0], two + rest[1])


@kernel
def moved_at(points: FloatArray, half: FloatArray, rest: FloatArray, at: FloatArray) -> float:
    """Return how far the point of a capsule that is `at` in the middle moves: no more than its ends do, in parts."""
    length = part = size = one = two = 0.0
    for i in range(3):
        along = points[1, i] - points[0, i]
        length += along * along
        part += along * (at[i] - points[0, i])
        size += abs(points[0, i]) + abs(points[1, i])
        one += half[0, i] ** 2
        two += half[1, i] ** 2
    one, two = np.sqrt(one) + rest[0], np.sqrt(two) + rest[1]
    if length <= (TURNED * size) ** 2:
        return max(one, two)
    part = min(max(part / length, 0.0), 1.0)
    return one + part * (two - one) + SURE * abs(two - one)


@kernel
def lowest(
    points: FloatArray, half: FloatArray, rest: FloatArray, at: FloatArray, normal: FloatArray, sign: float,
    known: float,
) -> float:  # fmt: skip
    """Return how far ahead of a plane through `at`, along ± its normal, both ends of a capsule stay at least.

    The normal is the direction of something of length `known`, which tells how far rounding may turn it.
    """
    least, size = np.inf, 0.0
    for e in range(2):
        size += abs(points[e, 0]) + abs(points[e, 1]) + abs(points[e, 2])
    for e in range(2):
        ahead = move = length = 0.0
        for i in range(3):
            off = points[e, i] - at[i]
            ahead += sign * normal[i] * off
            length += abs(off)
            move += half[e, i] * normal[i]
        if ahead > 0.0:
            ahead = max(ahead - TURNED * length, 0.0) if known > SURE * size else 0.0
        least = min(least, ahead - abs(move) - rest[e])
    return least


@kernel
def beside_polygon(
    corners: FloatArray, count: int, points: FloatArray, half: FloatArray, rest: FloatArray, needed: float,
    at: FloatArray, normal: FloatArray,
) -> bool:  # fmt: skip
    """Return whether a capsule surely stays beyond `needed` of a line along an edge with all of a polygon behind it."""
    normal[2] = at[2] = 0.0
    for k in range(count):
        after = (k + 1) % count
        x, y = corners[2 * after] - corners[2 * k], corners[2 * after + 1] - corners[2 * k + 1]
        size = np.hypot(x, y)
        if size == 0.0:
            continue
        normal[0], normal[1] = y / size, -x / size
        at[0], at[1] = corners[2 * k], corners[2 * k + 1]
        behind = 0.0
        for i in range(count):
            x, y = corners[2 * i] - at[0], corners[2 * i + 1] - at[1]
            behind = max(behind, normal[0] * x + normal[1] * y)
        if lowest(points, half, rest, at, normal, 1.0, np.inf) > needed + behind:
            return True
    return False


@kernel
def keeps_clear(
    shapes: Shapes, pairs: Pairs, p: int, points: FloatArray, half: FloatArray, rest: FloatArray, left: float,
    forgiven: float, at: FloatArray, normal: FloatArray,
) -> bool:  # fmt: skip
    """Return whether a pair with margin `left` in the middle surely keeps its distance, less `forgiven`, all along.

    The distance d from a convex body is a convex function: of every point p' it is ``d(p') ≥ d(p) + n·(p' − p)``, p
    being the link's point that is nearest in the middle and n the direction away from the body there. What is linear is
    least at an end of the link; so an end that stands still may be as near as it likes. Of two links each keeps to its
    side of a plane between them. A polygon is its edges, as long as the link does not come to lie across one of them;
    of one that is touched in the middle, as where the arm's base is on its edge, see :func:`beside_polygon`.
    """
    c, other = pairs.link[p], pairs.other[p]
    distance = left + pairs.needed[p]
    if other < 0:
        if distance <= 0.0:
            return False
        d = -1 - other
        ahead = lowest(points[c], half[c], rest[c], at[0], normal, 1.0, distance)
        return left + forgiven + ahead + lowest(points[d], half[d], rest[d], at[1], normal, -1.0, distance) > 0.0
    kind, start = shapes.kinds[other], shapes.first[other]
    if kind != POLYGON:
        known = distance  # of round bodies n is the direction from their middle, of half-spaces it is given
        if kind == SPHERE:
            known += shapes.numbers[start + 3]
        elif kind == CAPSULE:
            known += shapes.numbers[start + 6]
        elif kind == HALF_SPACE:
            known = np.inf
        if known <= 0.0:
            return False
        return left + forgiven + lowest(points[c], half[c], rest[c], at[0], normal, 1.0, known) > 0.0
    count, corners = int(shapes.numbers[start]), shapes.numbers[start + 1 : shapes.first[other + 1]]
    if distance <= SURE * np.abs(points[c]).sum():
        return beside_polygon(corners, count, points[c], half[c], rest[c], pairs.needed[p] - forgiven, at[0], normal)
    one, two = np.zeros(3), np.zeros(3)
    for k in range(count):
        after = (k + 1) % count
        one[0], one[1] = corners[2 * k], corners[2 * k + 1]
        two[0], two[1] = corners[2 * after], corners[2 * after + 1]
        distance = segments_distance(points[c, 0], points[c, 1], one, two, at[0], at[1], normal)
        distance += lowest(points[c], half[c], rest[c], at[0], normal, 1.0, distance)
        if not (distance > 0.0 and distance - pairs.needed[p] + forgiven > 0.0):  # nor of no number
            return False
    return True


@kernel
def is_blocked(
    pairs: Pairs, p: int, points: FloatArray, half: FloatArray, rest: FloatArray, at: FloatArray, left: float
) -> bool:
    """Return whether a pair always lacks some of its distance that lacks −`left` at `at` (2, 3) in the middle."""
    c, d = pairs.link[p], -1 - pairs.other[p]
    move = moved_at(points[c], half[c], rest[c], at[0])
    if d >= 0:
        move += moved_at(points[d], half[d], rest[d], at[1])
    return left < -move


@kernel
def verdicts(
    shapes: Shapes, pairs: Pairs, points: FloatArray, half: FloatArray, rest: FloatArray, slack: float,
    forgiven: float, state: IntArray, by: IntArray,
) -> None:  # fmt: skip
    """Say what is sure of links whose ends are where :func:`hulls_of_cells` says.

    Free (1) if every pair keeps its distance, less what is `forgiven`, wherever they are; blocked (−1) if some pair
    `by` lacks more than `slack` of it wherever they are, else undecided (0); `by` is then the first such pair.
    """
    at, normal = np.empty((2, 3)), np.empty(3)
    for k in range(len(points)):
        state[k], by[k] = 1, -1
        for p in range(len(pairs.link)):
            move = farthest(half[k, pairs.link[p]], rest[k, pairs.link[p]])
            if pairs.other[p] < 0:
                move += farthest(half[k, -1 - pairs.other[p]], rest[k, -1 - pairs.other[p]])
            left = margin(shapes, pairs, p, points[k], at, normal)
            if left < -slack and is_blocked(pairs, p, points[k], half[k], rest[k], at, left + slack):
                state[k], by[k] = -1, p
                break
            if state[k] != 1 or left + forgiven > move:
                continue
            if not keeps_clear(shapes, pairs, p, points[k], half[k], rest[k], left, forgiven, at, normal):
                state[k], by[k] = 0, p
