"""Planar inverse kinematics for many samples of one motion, a SIMD loop per step.

The formulas are those of :mod:`selfmotion.arms._kernels`, which stays the oracle in plain numpy. What is computed
stands on a *sheet*, one array whose rows are contiguous: only those are loaded as vectors, and one array is passed on
faster than ten. Loops run along the first k columns. Long motions are taken in pieces, a
sheet at a time. Angles are left as they come, modulo 2π.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import fast_kernel
from selfmotion._elementary_kernels import arctan2, sincos
from selfmotion._types import FloatArray

WX, WY, MARGIN, U = 0, 1, 2, 3
"""Rows of a sheet: the target of the first two links; their margin, or what else there is one number of per sample; and
from U on the n − 2 directions u, then as many rows du/dr, then the n joints or their rates. Joints stand a column to
the right of what else there is of a sample: column 0 is for the sample before the piece."""
LENGTH = 1024
"""Samples that a sheet holds."""


@fast_kernel
def turns_row(n: int) -> int:
    """Return the first row of du/dr."""
    return U + n - 2


@fast_kernel
def joints_row(n: int) -> int:
    """Return the first row of the joints, or of their rates."""
    return U + 2 * (n - 2)


@fast_kernel
def blank_sheet(n: int) -> FloatArray:
    """Return a sheet for n links."""
    return np.empty((joints_row(n) + n, LENGTH + 1))


@fast_kernel
def postures(links: FloatArray, sign: float, x: FloatArray, y: FloatArray, k: int, sheet: FloatArray) -> None:
    """Fill the joints and what :func:`margins` does, for tool positions x and y (k,) and the directions u.

    With ``s² = (l1 + l2)² − |w|²`` and ``c² = |w|² − (l1 − l2)²``, whose sum is 4 l1 l2, θ2 is the angle of
    (c² − s², ±2 s c): a root less than two arctangents of s and c take, and as accurate. What is meant by the angles of
    a posture out of reach is left open.
    """
    n = len(links)
    joints = joints_row(n)
    margin, first, second, third = sheet[MARGIN], sheet[joints][1:], sheet[joints + 1][1:], sheet[joints + 2][1:]
    wx, wy, towards, spare = sheet[WX], sheet[WY], sheet[U], sheet[turns_row(n)]
    _targets(links, x, y, k, sheet)
    l1, l2 = links[0], links[1]
    outer, inner, quarter = (l1 + l2) ** 2, (l1 - l2) ** 2, 0.25 / l1
    for i in range(k):
        dd = wx[i] * wx[i] + wy[i] * wy[i]
        ss, cc = outer - dd, dd - inner
        margin[i] = ss if ss < cc else cc
        sine, cosine = 2.0 * sign * np.sqrt(max(ss * cc, 0.0)), cc - ss
        along, across = l1 + quarter * cosine, quarter * sine
        first[i], spare[i] = along * wy[i] - across * wx[i], along * wx[i] + across * wy[i]
        second[i], third[i] = sine, cosine
    # One arctangent per loop: bodies so short overlap in the processor, longer ones wait for themselves.
    for i in range(k):
        first[i] = arctan2(first[i], spare[i])
    for i in range(k):
        second[i] = arctan2(second[i], third[i])
    for i in range(k):
        third[i] = towards[i] - first[i] - second[i]
    for j in range(3, n):
        joint, here, before = sheet[joints + j][1:], sheet[U + j - 2], sheet[U + j - 3]
        for i in range(k):
            joint[i] = here[i] - before[i]


@fast_kernel
def margins(links: FloatArray, x: FloatArray, y: FloatArray, k: int, sheet: FloatArray) -> None:
    """Fill the margins ``min((l1 + l2)² − |w|², |w|² − (l1 − l2)²)`` and the targets w.

    Divided by 2 (l1 + l2) a margin has the sign of the distance of the two-link target to the edge of its annulus, and
    inside is no larger.
    """
    _targets(links, x, y, k, sheet)
    margin, wx, wy = sheet[MARGIN], sheet[WX], sheet[WY]
    outer, inner = (links[0] + links[1]) ** 2, (links[0] - links[1]) ** 2
    for i in range(k):
        dd = wx[i] * wx[i] + wy[i] * wy[i]
        ss, cc = outer - dd, dd - inner
        margin[i] = ss if ss < cc else cc


@fast_kernel
def shortfall(links: FloatArray, k: int, sheet: FloatArray) -> float:
    """Return the largest distance of the two-link targets from their annulus, zero if all are inside."""
    margin, wx, wy = sheet[MARGIN], sheet[WX], sheet[WY]
    outside = 0
    for i in range(k):
        outside += 1 if margin[i] < 0.0 else 0
    worst = 0.0
    if outside:
        total, rest = links[0] + links[1], abs(links[0] - links[1])
        for i in range(k):
            d = np.sqrt(wx[i] * wx[i] + wy[i] * wy[i])
            worst = max(worst, d - total, rest - d)
    return worst


@fast_kernel
def _targets(links: FloatArray, x: FloatArray, y: FloatArray, k: int, sheet: FloatArray) -> None:
    """Fill the targets of the first two links, ``w = x − Σ_{j≥3} l_j e(u_j)``."""
    wx, wy = sheet[WX], sheet[WY]
    for i in range(k):
        wx[i], wy[i] = x[i], y[i]
    for j in range(2, len(links)):
        length, towards = links[j], sheet[U + j - 2]
        for i in range(k):
            sine, cosine = sincos(towards[i])
            wx[i] -= length * cosine
            wy[i] -= length * sine


@fast_kernel
def rates(
    links: FloatArray,
    sign: float,
    x: FloatArray,
    y: FloatArray,
    dx: FloatArray,
    dy: FloatArray,
    k: int,
    sheet: FloatArray,
) -> None:
    """Fill the joint rates for tool positions and rates x, y, dx, dy (k,) and the rows u and du/dr.

    Algebraic in sin u and cos u: θ2' = −(w·w')/(l1 l2 sin θ2), θ1' = ((w×w') − (l2² + l1 l2 cos θ2) θ2')/|w|².
    Infinite or NaN at a fold and beyond reach.
    """
    n = len(links)
    joints, turns = joints_row(n), turns_row(n)
    wx, wy = sheet[WX], sheet[WY]
    first, second, third = sheet[joints][1:], sheet[joints + 1][1:], sheet[joints + 2][1:]
    for i in range(k):
        wx[i], wy[i], first[i], second[i] = x[i], y[i], dx[i], dy[i]
    for j in range(2, n):
        length, towards, turning = links[j], sheet[U + j - 2], sheet[turns + j - 2]
        for i in range(k):
            sine, cosine = sincos(towards[i])
            wx[i] -= length * cosine
            wy[i] -= length * sine
            first[i] += length * sine * turning[i]
            second[i] -= length * cosine * turning[i]
    l1, l2 = links[0], links[1]
    outer, inner, difference = (l1 + l2) ** 2, (l1 - l2) ** 2, (l2 - l1) * (l2 + l1)
    turn = sheet[turns]
    for i in range(k):
        vx, vy = first[i], second[i]
        dd = wx[i] * wx[i] + wy[i] * wy[i]
        # 2 l1 l2 |sin θ2|, a product of what vanishes at the folds: NaN beyond them.
        area = np.sqrt((outer - dd) * (dd - inner))
        inverse = 1.0 / (area * dd)
        turn2 = -2.0 * sign * (wx[i] * vx + wy[i] * vy) * (dd * inverse)
        first[i] = (wx[i] * vy - wy[i] * vx - 0.5 * (dd + difference) * turn2) * (area * inverse)
        second[i] = turn2
        third[i] = turn[i] - first[i] - turn2
    for j in range(3, n):
        joint, here, before = sheet[joints + j][1:], sheet[turns + j - 2], sheet[turns + j - 3]
        for i in range(k):
            joint[i] = here[i] - before[i]
