"""Kernels of distances: a segment against the shapes of a scene, and two segments.

A shape is a kind and numbers in a row, which may be one of many shapes' numbers:

- ``SPHERE``: centre (3), radius; a circle of the plane is one too;
- ``HALF_SPACE``: n (3) of unit length, d: all p with n·p ≤ d;
- ``BOX``: centre (3), half sizes (3), rotation (9) from the box to the world, row by row;
- ``CAPSULE``: both ends (6), radius;
- ``POLYGON``: number of corners, then x y of each, counter-clockwise, in the plane z = 0.

The signed distance of a point is that from the shape, or minus the depth inside of it; it changes at most as fast as
the point moves. Of a segment disjoint from the shape the kernels give the least distance, of any other minus the depth
of one of its points: never less than the least signed distance, so that both signs bound what is near. Spheres,
half-spaces, capsules and boxes are convex, and their depth is the deepest. What is computed is off by a few roundings
of the coordinates; which point is inside of a polygon is told by counts that do not contradict each other.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray
from selfmotion.scene.kinds import BOX, CAPSULE, HALF_SPACE, POLYGON, SPHERE

_SEARCHES = 8  # looks for a deeper point of a segment in a polygon
_ROUNDED = 1e-14  # of the coordinates: distances whose direction is rounding


@kernel
def segment_distance(
    kind: int, numbers: FloatArray, start: int, p: FloatArray, q: FloatArray, at: FloatArray, normal: FloatArray
) -> float:
    """Return the signed distance of the segment from p to q (3,) from a shape.

    Fills `at` (3,), the point of the segment that it is of, and `normal` (3,), the unit direction in which moving that
    point raises it. The shape's numbers begin at `start`. Not for `MESH`.
    """
    if kind == SPHERE:
        return _sphere(numbers, start, p, q, at, normal)
    if kind == HALF_SPACE:
        return _half_space(numbers, start, p, q, at, normal)
    if kind == BOX:
        return _box(numbers, start, p, q, at, normal)
    if kind == CAPSULE:
        return _capsule(numbers, start, p, q, at, normal)
    if kind == POLYGON:
        return _polygon(numbers, start, p, q, at, normal)
    return np.nan


@kernel
def segments_distance(
    p: FloatArray, q: FloatArray, u: FloatArray, v: FloatArray, at: FloatArray, other: FloatArray, normal: FloatArray
) -> float:
    """Return the least distance of the segments from p to q and from u to v (3,), zero or more.

    Fills the nearest points `at` of the first and `other` of the second (3,), and the unit `normal` (3,) from `other`
    to `at`. Where the two meet, it is a direction across both; in the plane z = 0 it is across the second, to the side
    on which more of the first is.
    """
    return _segments(
        p[0], p[1], p[2], q[0], q[1], q[2], u[0], u[1], u[2], v[0], v[1], v[2], at, other, normal
    )  # fmt: skip


@kernel
def _clamped(t: float) -> float:
    """Return t within [0, 1]."""
    return min(max(t, 0.0), 1.0)


@kernel
def _place(wx: float, wy: float, wz: float, dx: float, dy: float, dz: float) -> float:
    """Return the t in [0, 1] for which t·d is nearest to w."""
    square = dx * dx + dy * dy + dz * dz
    return _clamped((wx * dx + wy * dy + wz * dz) / square) if square > 0.0 else 0.0


@kernel
def _on(p: FloatArray, q: FloatArray, t: float, at: FloatArray) -> None:
    """Fill in the point at t of a segment; its ends are themselves."""
    for i in range(3):
        at[i] = p[i] + t * (q[i] - p[i]) if t < 1.0 else q[i]


@kernel
def _across(dx: float, dy: float, normal: FloatArray) -> None:
    """Fill in a unit direction across d, in the plane z = 0."""
    size = np.hypot(dx, dy)
    normal[0], normal[1], normal[2] = (-dy / size, dx / size, 0.0) if size > 0.0 else (1.0, 0.0, 0.0)


@kernel
def _towards(dx: float, dy: float, dz: float, normal: FloatArray) -> float:
    """Fill in the direction of d and return its length; at length zero nothing is filled in."""
    largest = max(abs(dx), abs(dy), abs(dz))
    if largest == 0.0:
        return 0.0
    x, y, z = dx / largest, dy / largest, dz / largest  # squares of tiny numbers would be none
    size = np.sqrt(x * x + y * y + z * z)
    normal[0], normal[1], normal[2] = x / size, y / size, z / size
    return largest * size


@kernel
def _sphere(
    numbers: FloatArray, k: int, p: FloatArray, q: FloatArray, at: FloatArray, normal: FloatArray
) -> float:  # fmt: skip
    cx, cy, cz, radius = numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3]
    t = _place(cx - p[0], cy - p[1], cz - p[2], q[0] - p[0], q[1] - p[1], q[2] - p[2])
    _on(p, q, t, at)
    away = _towards(at[0] - cx, at[1] - cy, at[2] - cz, normal)
    if away == 0.0:
        _across(q[0] - p[0], q[1] - p[1], normal)
    return away - radius


@kernel
def _half_space(
    numbers: FloatArray, k: int, p: FloatArray, q: FloatArray, at: FloatArray, normal: FloatArray
) -> float:  # fmt: skip
    x, y, z, d = numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3]
    normal[0], normal[1], normal[2] = x, y, z
    first, last = x * p[0] + y * p[1] + z * p[2] - d, x * q[0] + y * q[1] + z * q[2] - d
    _on(p, q, 0.0 if first <= last else 1.0, at)
    return min(first, last)


@kernel
def _capsule(
    numbers: FloatArray, k: int, p: FloatArray, q: FloatArray, at: FloatArray, normal: FloatArray
) -> float:  # fmt: skip
    ux, uy, uz, vx, vy, vz = (
        numbers[k], numbers[k + 1], numbers[k + 2], numbers[k + 3], numbers[k + 4], numbers[k + 5]
    )  # fmt: skip
    away = _segments(p[0], p[1], p[2], q[0], q[1], q[2], ux, uy, uz, vx, vy, vz, at, at, normal)
    return away - numbers[k + 6]


@kernel
def _segments(
    px: float, py: float, pz: float, qx: float, qy: float, qz: float, ux: float, uy: float, uz: float, vx: float,
    vy: float, vz: float, at: FloatArray, other: FloatArray, normal: FloatArray,
) -> float:  # fmt: skip
    """Do what :func:`segments_distance` does; `at` may be `other`, and then is filled in last.

    The nearest pair has an end in it, or stands across both segments. The latter is found by their cross product, which
    keeps its digits where they are nearly parallel; and being far off along them then hardly changes the distance.
    """
    dx, dy, dz = qx - px, qy - py, qz - pz
    ex, ey, ez = vx - ux, vy - uy, vz - uz
    wx, wy, wz = ux - px, uy - py, uz - pz
    dd, ee = dx * dx + dy * dy + dz * dz, ex * ex + ey * ey + ez * ez
    # An end of one against the other.
    s, t, least = 0.0, 0.0, np.inf
    for pair in range(4):
        if pair == 0:
            a, b = 0.0, _place(-wx, -wy, -wz, ex, ey, ez)
        elif pair == 1:
            a, b = 1.0, _place(dx - wx, dy - wy, dz - wz, ex, ey, ez)
        elif pair == 2:
            a, b = _place(wx, wy, wz, dx, dy, dz), 0.0
        else:
            a, b = _place(wx + ex, wy + ey, wz + ez, dx, dy, dz), 1.0
        x, y, z = wx + b * ex - a * dx, wy + b * ey - a * dy, wz + b * ez - a * dz
        square = x * x + y * y + z * z
        if square < least:
            s, t, least = a, b, square
    nn = nx = ny = nz = 0.0
    if dd > 0.0 and ee > 0.0:
        d, e = 1.0 / np.sqrt(dd), 1.0 / np.sqrt(ee)
        fx, fy, fz, gx, gy, gz = d * dx, d * dy, d * dz, e * ex, e * ey, e * ez
        nx, ny, nz = fy * gz - fz * gy, fz * gx - fx * gz, fx * gy - fy * gx
        nn = nx * nx + ny * ny + nz * nz
        if nn > 0.0:
            a = ((wy * gz - wz * gy) * nx + (wz * gx - wx * gz) * ny + (wx * gy - wy * gx) * nz) / nn * d
            if 0.0 < a < 1.0:
                b = _place(a * dx - wx, a * dy - wy, a * dz - wz, ex, ey, ez)
                a = _place(wx + b * ex, wy + b * ey, wz + b * ez, dx, dy, dz)
                x, y, z = wx + b * ex - a * dx, wy + b * ey - a * dy, wz + b * ez - a * dz
                square = x * x + y * y + z * z
                if square < least:
                    s, t, least = a, b, square
    x, y, z = s * dx - (wx + t * ex), s * dy - (wy + t * ey), s * dz - (wz + t * ez)
    if least > (_ROUNDED * (np.sqrt(max(dd, ee)) + abs(px) + abs(py) + abs(pz))) ** 2:
        away = _towards(x, y, z, normal)
    else:
        away = np.sqrt(x * x + y * y + z * z)
        if nx == 0.0 and ny == 0.0 and (nz == 0.0 or dz == 0.0):
            # In the plane: to the side of the second on which more of the first is.
            before, after = wx * ey - wy * ex, (wx - dx) * ey - (wy - dy) * ex
            sign = 1.0 if (before if abs(before) > abs(after) else after) >= 0.0 else -1.0
            _across(sign * (ex if ee > 0.0 else dx), sign * (ey if ee > 0.0 else dy), normal)
        else:
            _towards(nx, ny, nz, normal)
    other[0], other[1], other[2] = (ux + t * ex, uy + t * ey, uz + t * ez) if t < 1.0 else (vx, vy, vz)
    at[0], at[1], at[2] = (px + s * dx, py + s * dy, pz + s * dz) if s < 1.0 else (qx, qy, qz)
    return away


@kernel
def _excess(x: float, half: float) -> float:
    """Return by how much x is beyond [-half, half], with its sign."""
    return x - half if x > half else (x + half if x < -half else 0.0)


@kernel
def _box(
    numbers: FloatArray, k: int, p: FloatArray, q: FloatArray, at: FloatArray, normal: FloatArray
) -> float:  # fmt: skip
    """Do it in the box's frame, where the squared distance along the segment is convex and quadratic piece by piece.

    Its slope, the sum of excess times direction, is looked at where the segment passes the planes of the faces; between
    two of these it is linear.
    """
    wx, wy, wz = p[0] - numbers[k], p[1] - numbers[k + 1], p[2] - numbers[k + 2]
    vx, vy, vz = q[0] - p[0], q[1] - p[1], q[2] - p[2]
    h0, h1, h2 = numbers[k + 3], numbers[k + 4], numbers[k + 5]
    a = k + 6
    x0 = numbers[a] * wx + numbers[a + 3] * wy + numbers[a + 6] * wz
    x1 = numbers[a + 1] * wx + numbers[a + 4] * wy + numbers[a + 7] * wz
    x2 = numbers[a + 2] * wx + numbers[a + 5] * wy + numbers[a + 8] * wz
    d0 = numbers[a] * vx + numbers[a + 3] * vy + numbers[a + 6] * vz
    d1 = numbers[a + 1] * vx + numbers[a + 4] * vy + numbers[a + 7] * vz
    d2 = numbers[a + 2] * vx + numbers[a + 5] * vy + numbers[a + 8] * vz
    t = 0.0
    if _excess(x0, h0) * d0 + _excess(x1, h1) * d1 + _excess(x2, h2) * d2 < 0.0:
        low, high = 0.0, 1.0
        for plane in range(6):
            axis = plane >> 1
            x, d, h = (x0, d0, h0) if axis == 0 else ((x1, d1, h1) if axis == 1 else (x2, d2, h2))
            s = ((h if plane & 1 else -h) - x) / d if d != 0.0 else -1.0
            if low < s < high:
                slope = _excess(x0 + s * d0, h0) * d0 + _excess(x1 + s * d1, h1) * d1 + _excess(x2 + s * d2, h2) * d2
                if slope < 0.0:
                    low = s
                else:
                    high = s
        # Which faces it is beyond does not change between low and high.
        s = 0.5 * (low + high)
        e0, e1, e2 = _excess(x0 + s * d0, h0), _excess(x1 + s * d1, h1), _excess(x2 + s * d2, h2)
        above = below = 0.0
        if e0 != 0.0:
            above, below = above - e0 * d0, below + d0 * d0
        if e1 != 0.0:
            above, below = above - e1 * d1, below + d1 * d1
        if e2 != 0.0:
            above, below = above - e2 * d2, below + d2 * d2
        t = min(max(s + above / below, low), high) if below > 0.0 else s
    e0, e1, e2 = _excess(x0 + t * d0, h0), _excess(x1 + t * d1, h1), _excess(x2 + t * d2, h2)
    away = _towards(e0, e1, e2, at)
    deep, s, face = 1.0, 0.0, 0
    if away <= _ROUNDED * (max(abs(x0), abs(x1), abs(x2)) + max(abs(d0), abs(d1), abs(d2))):
        s, deep, face = _deepest_in_box(x0, x1, x2, d0, d1, d2, h0, h1, h2)
    if away > 0.0 and deep > 0.0:
        e0, e1, e2 = at[0], at[1], at[2]
    else:
        t, away = s, min(deep, 0.0)
        side, axis = 1.0 if face & 1 else -1.0, face >> 1
        e0, e1, e2 = side if axis == 0 else 0.0, side if axis == 1 else 0.0, side if axis == 2 else 0.0
    normal[0] = numbers[a] * e0 + numbers[a + 1] * e1 + numbers[a + 2] * e2
    normal[1] = numbers[a + 3] * e0 + numbers[a + 4] * e1 + numbers[a + 5] * e2
    normal[2] = numbers[a + 6] * e0 + numbers[a + 7] * e1 + numbers[a + 8] * e2
    _on(p, q, t, at)
    return away


@kernel
def _nearest_face(x0: float, x1: float, x2: float, h0: float, h1: float, h2: float) -> tuple[float, int]:
    """Return the signed distance of a point in a box from its nearest face, and that: twice the axis, 1 more above."""
    away, face = abs(x0) - h0, 1 if x0 >= 0.0 else 0
    if abs(x1) - h1 > away:
        away, face = abs(x1) - h1, 3 if x1 >= 0.0 else 2
    if abs(x2) - h2 > away:
        away, face = abs(x2) - h2, 5 if x2 >= 0.0 else 4
    return away, face


@kernel
def _deepest_in_box(
    x0: float, x1: float, x2: float, d0: float, d1: float, d2: float, h0: float, h1: float, h2: float
) -> tuple[float, float, int]:  # fmt: skip
    """Return t, signed distance and face of a segment's deepest point in a box.

    The greatest of six linear functions of t is least where two of them meet: each step has the two that are the
    greatest on either side, and comes upon another one or ends.
    """
    low, high = 0.0, 1.0
    at_low, face_low = _nearest_face(x0, x1, x2, h0, h1, h2)
    at_high, face_high = _nearest_face(x0 + d0, x1 + d1, x2 + d2, h0, h1, h2)
    t, best, face = (low, at_low, face_low) if at_low <= at_high else (high, at_high, face_high)
    for _ in range(6):
        up, down = _outward(face_low, d0, d1, d2), _outward(face_high, d0, d1, d2)
        if not (up < 0.0 < down):
            break
        s = (at_high - at_low + up * low - down * high) / (up - down)
        if not low < s < high:
            break
        value, side = _nearest_face(x0 + s * d0, x1 + s * d1, x2 + s * d2, h0, h1, h2)
        if value < best:
            t, best, face = s, value, side
        if side in (face_low, face_high):
            break
        if _outward(side, d0, d1, d2) < 0.0:
            low, at_low, face_low = s, value, side
        else:
            high, at_high, face_high = s, value, side
    return t, best, face


@kernel
def _outward(face: int, d0: float, d1: float, d2: float) -> float:
    """Return how fast a segment of direction d goes out through a face."""
    axis = face >> 1
    d = d0 if axis == 0 else (d1 if axis == 1 else d2)
    return d if face & 1 else -d


@kernel
def _polygon(
    numbers: FloatArray, k: int, p: FloatArray, q: FloatArray, at: FloatArray, normal: FloatArray
) -> float:  # fmt: skip
    """Return the least distance from the edges, or minus the depth of a point of the segment inside.

    Which stretches of the segment's line are inside is told by the edges that cross it, those whose ends are on
    different sides of it: there is an even number of them, however the sides were rounded, so that what is inside comes
    in pairs. A segment with one point counts along x.
    """
    corners, k = int(numbers[k]), k + 1
    px, py, qx, qy = p[0], p[1], q[0], q[1]
    dx, dy = qx - px, qy - py
    square = dx * dx + dy * dy
    point = square == 0.0
    per = 0.0 if point else 1.0 / square
    ux, uy = (1.0, 0.0) if point else (dx, dy)
    last = k + 2 * (corners - 1)
    ax, ay = numbers[last] - px, numbers[last + 1] - py
    side_a = ux * ay - uy * ax
    least, fx, fy, gx, gy, ex, ey = np.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0  # f on the segment, g on the edge, from p
    before = crossings = 0
    for i in range(corners):
        bx, by = numbers[k + 2 * i] - px, numbers[k + 2 * i + 1] - py
        side_b = ux * by - uy * bx
        cx, cy = bx - ax, by - ay
        if (side_a > 0.0) != (side_b > 0.0):
            s = side_a / (side_a - side_b)
            along = (ax + s * cx) * ux + (ay + s * cy) * uy
            if along <= 0.0:
                before += 1
            elif along < square:
                crossings += 1
        edge = cx * cx + cy * cy
        per_edge = 1.0 / edge if edge > 0.0 else 0.0
        s = min(max(-(ax * cx + ay * cy) * per_edge, 0.0), 1.0)
        x, y = ax + s * cx, ay + s * cy
        found = x * x + y * y
        if found < least:
            least, fx, fy, gx, gy, ex, ey = found, 0.0, 0.0, x, y, cx, cy
        if not point:
            s = min(max(((dx - ax) * cx + (dy - ay) * cy) * per_edge, 0.0), 1.0)
            x, y = ax + s * cx, ay + s * cy
            found = (x - dx) * (x - dx) + (y - dy) * (y - dy)
            if found < least:
                least, fx, fy, gx, gy, ex, ey = found, dx, dy, x, y, cx, cy
            s = min(max((bx * dx + by * dy) * per, 0.0), 1.0)
            x, y = s * dx, s * dy
            found = (x - bx) * (x - bx) + (y - by) * (y - by)
            if found < least:
                least, fx, fy, gx, gy, ex, ey = found, x, y, bx, by, cx, cy
        ax, ay, side_a = bx, by, side_b
    if crossings == 0 and before % 2 == 0:
        at[0], at[1], at[2] = px + fx, py + fy, 0.0
        away = _towards(fx - gx, fy - gy, 0.0, normal)
        if away <= _ROUNDED * (abs(px) + abs(py) + abs(gx) + abs(gy)):
            _across(-ex, -ey, normal)
        return away
    return _depth_in_polygon(numbers, k, corners, px, py, dx, dy, before % 2 == 1, crossings, at, normal)


@kernel
def _depth_in_polygon(
    numbers: FloatArray, k: int, corners: int, px: float, py: float, dx: float, dy: float, inside: bool, crossings: int,
    at: FloatArray, normal: FloatArray,
) -> float:  # fmt: skip
    """Return minus the depth of the deepest point found on a segment that is partly inside; see :func:`_polygon`.

    Looked at are the ends that are inside and the middles of all stretches that are; then further points around the
    deepest of them, each where the nearest edges on either side of it are as far.
    """
    cuts = np.empty(crossings + 2)
    count = 0
    if inside:
        cuts[0], count = 0.0, 1
    if crossings > 0:
        square = dx * dx + dy * dy
        ax, ay = numbers[k + 2 * (corners - 1)] - px, numbers[k + 2 * (corners - 1) + 1] - py
        side_a = dx * ay - dy * ax
        for i in range(corners):
            bx, by = numbers[k + 2 * i] - px, numbers[k + 2 * i + 1] - py
            side_b = dx * by - dy * bx
            if (side_a > 0.0) != (side_b > 0.0):
                s = side_a / (side_a - side_b)
                along = (ax + s * (bx - ax)) * dx + (ay + s * (by - ay)) * dy
                if 0.0 < along < square:
                    cuts[count] = along / square
                    count += 1
            ax, ay, side_a = bx, by, side_b
    if count % 2 == 1:
        cuts[count] = 1.0
        count += 1
    cuts[:count].sort()
    best, t, low, high = -1.0, 0.0, 0.0, 1.0
    for i in range(0, count, 2):
        for s in (cuts[i], 0.5 * (cuts[i] + cuts[i + 1]), cuts[i + 1]):
            if s in (0.0, 1.0) or cuts[i] < s < cuts[i + 1]:
                depth = _from_boundary(numbers, k, corners, px + s * dx, py + s * dy, normal)
                if depth > best:
                    best, t, low, high = depth, s, cuts[i], cuts[i + 1]
    if best < 0.0:  # stretches of no length
        t = low = high = cuts[0]
        best = _from_boundary(numbers, k, corners, px + t * dx, py + t * dy, normal)
    # Depth has slope -normal·d; `up` is the slope at low and `down` the one at high where they are known.
    s, depth, up, down, at_low, at_high = t, best, 0.0, 0.0, 0.0, 0.0
    best = _from_boundary(numbers, k, corners, px + t * dx, py + t * dy, normal)
    nx, ny = normal[0], normal[1]
    for _ in range(_SEARCHES):
        slope = -(normal[0] * dx + normal[1] * dy)
        if slope > 0.0:
            low, at_low, up = s, depth, slope
        elif slope < 0.0:
            high, at_high, down = s, depth, slope
        else:
            break
        s = 0.5 * (low + high)
        if up > 0.0 and down < 0.0:
            meet = (at_high - at_low + up * low - down * high) / (up - down)
            s = meet if low < meet < high else s
        if not low < s < high:
            break
        depth = _from_boundary(numbers, k, corners, px + s * dx, py + s * dy, normal)
        if depth > best:
            best, t, nx, ny = depth, s, normal[0], normal[1]
    at[0], at[1], at[2] = px + t * dx, py + t * dy, 0.0
    normal[0], normal[1], normal[2] = nx, ny, 0.0
    return -best


@kernel
def _from_boundary(
    numbers: FloatArray, k: int, corners: int, x: float, y: float, normal: FloatArray
) -> float:  # fmt: skip
    """Return the distance of a point inside from a polygon's edges, and fill in the direction to the nearest place."""
    ax, ay = numbers[k + 2 * (corners - 1)] - x, numbers[k + 2 * (corners - 1) + 1] - y
    least, gx, gy, ex, ey = np.inf, 0.0, 0.0, 0.0, 0.0
    for i in range(corners):
        bx, by = numbers[k + 2 * i] - x, numbers[k + 2 * i + 1] - y
        cx, cy = bx - ax, by - ay
        edge = cx * cx + cy * cy
        s = min(max(-(ax * cx + ay * cy) / edge, 0.0), 1.0) if edge > 0.0 else 0.0
        fx, fy = ax + s * cx, ay + s * cy
        found = fx * fx + fy * fy
        if found < least:
            least, gx, gy, ex, ey = found, fx, fy, cx, cy
        ax, ay = bx, by
    away = _towards(gx, gy, 0.0, normal)
    if away <= _ROUNDED * (abs(x) + abs(y) + abs(ex) + abs(ey)):
        _across(-ex, -ey, normal)
    return away
