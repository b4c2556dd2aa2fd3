"""Kernel that looks for places where a polygon's edges meet."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray, IntArray


@kernel
def _side(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Return which side of the line from a to b a point is on: 1 left, -1 right, 0 on it."""
    return np.sign((bx - ax) * (y - ay) - (by - ay) * (x - ax))


@kernel
def first_meeting(corners: FloatArray, order: IntArray, place: FloatArray) -> tuple[int, int]:
    """Return two edges that meet other than where one follows the other, or (-1, -1); fill in where (2,).

    Edge k is from corner k to the next. `order` has the edges by their least x: each is compared with those that begin
    before it ends.
    """
    n = len(corners)
    for position in range(n):
        i = order[position]
        a, b = corners[i], corners[(i + 1) % n]
        right = max(a[0], b[0])
        low, high = min(a[1], b[1]), max(a[1], b[1])
        for later in range(position + 1, n):
            j = order[later]
            c, d = corners[j], corners[(j + 1) % n]
            if min(c[0], d[0]) > right:
                break
            if min(c[1], d[1]) > high or max(c[1], d[1]) < low:
                continue
            if (i + 1) % n == j or (j + 1) % n == i:
                # One goes back along the other.
                before, corner, after = (a, b, d) if (i + 1) % n == j else (c, d, b)
                back = (corner[0] - before[0]) * (after[0] - corner[0]) + (corner[1] - before[1]) * (
                    after[1] - corner[1]
                )
                turn = _side(before[0], before[1], corner[0], corner[1], after[0], after[1])
                if turn == 0.0 and back < 0.0:
                    place[:] = corner
                    return i, j
                continue
            sides_c = _side(a[0], a[1], b[0], b[1], c[0], c[1])
            sides_d = _side(a[0], a[1], b[0], b[1], d[0], d[1])
            sides_a = _side(c[0], c[1], d[0], d[1], a[0], a[1])
            sides_b = _side(c[0], c[1], d[0], d[1], b[0], b[1])
            if sides_c * sides_d > 0.0 or sides_a * sides_b > 0.0:
                continue
            if sides_c == 0.0 and sides_d == 0.0:  # on one line, where the boxes around them overlap
                upright = abs(b[1] - a[1]) > abs(b[0] - a[0])
                axis = 1 if upright else 0
                last = max(min(a[axis], b[axis]), min(c[axis], d[axis]))
                if last > min(max(a[axis], b[axis]), max(c[axis], d[axis])):
                    continue
                for end in (a, b, c, d):
                    if end[axis] == last:
                        place[:] = end
                return i, j
            ex, ey, fx, fy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
            t = ((c[0] - a[0]) * fy - (c[1] - a[1]) * fx) / (ex * fy - ey * fx)
            place[0], place[1] = a[0] + t * ex, a[1] + t * ey
            return i, j
    return -1, -1
