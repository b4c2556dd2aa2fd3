"""Inverse kinematics of arms with spherical shoulder, hinged elbow and spherical wrist, on plain arrays.

Joint frames are those of the KUKA LBR iiwa's public URDF: joint k turns about z after the fixed rotation

    1, Rz(π)Rx(π/2), Rz(π)Rx(π/2), Rx(π/2), Rz(π)Rx(π/2), Rx(π/2), Rz(π)Rx(π/2),

which alternates ±π/2 about x and multiplies out to

    R07 = Rz(q1) Ry(q2) Rz(q3) · Ry(−q4) · Rz(q5) Ry(q6) Rz(q7).

With d_bs from base to shoulder S, d_se to the elbow E and d_ew to the wrist centre W, the arm stands along z at q = 0.
Flange and tool are the caller's: a pose is R07 and W. A *geometry* is [d_bs, d_se, d_ew, v], with a fixed vector v.

The parameter is the arm angle ψ (Shimizu et al. 2008): with n from S to W, b = n×v/|n×v| and a = b×n, the elbow bends
from the line SW towards m = a cos ψ + b sin ψ. ψ is smooth in the pose wherever n is not parallel to v; which v suits
is a matter of the path. With k = n×m and the angles α at S and β at W of the triangle SEW,

    z3 = n cos α + m sin α,   x3 = m cos α − n sin α,   y3 = k = y4,
    z4 = n cos β − m sin β,   x4 = m cos β + n sin β,

which holds for q4 ≥ 0. All else is symmetry: q4 changes its sign with q3, q5 turned by π, q2 with q1, q3, and q6 with
q5, q7. Branch 4 (q4 < 0) + 2 (q6 < 0) + (q2 < 0) has these signs.

As the frames turn with the elbow about n at speed 1,

    q1' = sin α cos q3/sin q2,   q2' = −sin α sin q3,   q3' = cos α − q1' cos q2,

and so for the wrist, whose Rz(π − q7) Ry(q6) Rz(π − q5) is R74, with −β for α.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._elementary_kernels import arctan2, sincos
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._jet_kernels import (
    Range,
    down,
    range_angle,
    range_cosine_sine,
    range_product,
    range_quotient,
    range_square,
    range_sum,
    up,
)
from selfmotion.arms._range_kernels import meet
from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR

TAU = 2 * np.pi
PI_UP = 3.1415926535897936  # π, rounded up
# Bit b of entry j: joint j of branch b is half a turn from that of branch 0.
_TURNED_BY = (0b10101010, 0, 0b01011010, 0, 0b00111100, 0, 0b11001100)
_REACH = 1e-14  # part of the reach by which rounding may leave it
_ROUGH = 1e-15  # rounding in a sum of three products of unit vectors' components, or two of numbers up to 1, is less
_SQUARE = 1e-15  # what the entries of a rotation may be off by rounding


@kernel
def flip(q: FloatArray, branch: int, out: FloatArray) -> None:
    """Fill in the posture of a branch from that of branch 0."""
    elbow, wrist, shoulder = branch & 4 != 0, branch & 2 != 0, branch & 1 != 0
    for j in range(7):
        out[j] = q[j]
    if shoulder:
        out[0] -= np.copysign(np.pi, q[0])
        out[1] = -q[1]
    if shoulder != elbow:
        out[2] -= np.copysign(np.pi, q[2])
    if elbow:
        out[3] = -q[3]
    if elbow != wrist:
        out[4] -= np.copysign(np.pi, q[4])
    if wrist:
        out[5] = -q[5]
        out[6] -= np.copysign(np.pi, q[6])


@kernel
def posture(geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray) -> bool:
    """Fill in the posture of branch 0 at the arm angle u; return whether the arm reaches (and n is not parallel to v).

    Where q2 = 0, q1 is 0, and where q6 = 0, q5 is; near there q3 and q7 make good for what rounding does to them.
    """
    upper, fore = geometry[1], geometry[2]
    nx, ny, nz = position[0], position[1], position[2] - geometry[0]
    d = np.sqrt(nx * nx + ny * ny + nz * nz)
    outer, inner = upper + fore, abs(upper - fore)
    if not inner - _REACH * outer <= d <= outer + _REACH * outer or d == 0.0:
        return False
    nx, ny, nz = nx / d, ny / d, nz / d
    bx = ny * geometry[5] - nz * geometry[4]
    by = nz * geometry[3] - nx * geometry[5]
    bz = nx * geometry[4] - ny * geometry[3]
    r = np.sqrt(bx * bx + by * by + bz * bz)
    if r == 0.0:
        return False
    bx, by, bz = bx / r, by / r, bz / r
    ax, ay, az = by * nz - bz * ny, bz * nx - bx * nz, bx * ny - by * nx
    bx, by, bz = ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax  # square to n and a also where r is tiny
    s, c = sincos(u)
    mx, my, mz = c * ax + s * bx, c * ay + s * by, c * az + s * bz
    kx, ky, kz = c * bx - s * ax, c * by - s * ay, c * bz - s * az

    top, bottom = np.sqrt(max((outer - d) * (outer + d), 0.0)), np.sqrt(max((d - inner) * (d + inner), 0.0))
    q[3] = 2.0 * arctan2(top, bottom)
    product, square, skew = top * bottom, d * d, (upper - fore) * outer
    c, s = (square + skew) / (2.0 * upper * d), product / (2.0 * upper * d)
    zx, zy, zz = c * nx + s * mx, c * ny + s * my, c * nz + s * mz
    r = np.sqrt(zx * zx + zy * zy)
    q[0], c1, s1 = 0.0, 1.0, 0.0
    if r > 0.0:
        q[0], c1, s1 = arctan2(zy, zx), zx / r, zy / r
    q[1] = arctan2(r, zz)
    q[2] = arctan2(c1 * (c * my - s * ny) - s1 * (c * mx - s * nx), c1 * ky - s1 * kx)

    c, s = (square - skew) / (2.0 * fore * d), product / (2.0 * fore * d)
    zx, zy, zz = c * nx - s * mx, c * ny - s * my, c * nz - s * mz
    xx, xy, xz = c * mx + s * nx, c * my + s * ny, c * mz + s * nz
    sx = xx * rotation[0, 2] + xy * rotation[1, 2] + xz * rotation[2, 2]
    sy = kx * rotation[0, 2] + ky * rotation[1, 2] + kz * rotation[2, 2]
    r = np.sqrt(sx * sx + sy * sy)
    q[4], c1, s1 = 0.0, 1.0, 0.0
    if r > 0.0:
        q[4], c1, s1 = arctan2(sy, sx), sx / r, sy / r
    q[5] = arctan2(r, zx * rotation[0, 2] + zy * rotation[1, 2] + zz * rotation[2, 2])
    yx, yy, yz = c1 * kx - s1 * xx, c1 * ky - s1 * xy, c1 * kz - s1 * xz
    q[6] = arctan2(
        yx * rotation[0, 0] + yy * rotation[1, 0] + yz * rotation[2, 0],
        yx * rotation[0, 1] + yy * rotation[1, 1] + yz * rotation[2, 1],
    )
    return True


@kernel
def solve(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray, ok: BoolArray
) -> None:
    """Fill in the postures q (8, 7) of all branches at the arm angle u, angles in [−π, π], and whether they exist."""
    found = posture(geometry, rotation, position, u, q[0])
    ok[:] = found
    if not found:
        return
    for b in range(1, 8):
        q[b, 1] = -q[0, 1] if b & 1 else q[0, 1]
        q[b, 3] = -q[0, 3] if b & 4 else q[0, 3]
        q[b, 5] = -q[0, 5] if b & 2 else q[0, 5]
    for j in (0, 2, 4, 6):
        same = q[0, j]
        turned = same - np.copysign(np.pi, same)
        mask = _TURNED_BY[j]
        for b in range(1, 8):
            q[b, j] = turned if mask >> b & 1 else same


@kernel
def solve_one(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, branch: int, q: FloatArray
) -> bool:
    """Fill in the posture q (7,) of one branch at the arm angle u; return whether it exists."""
    found = posture(geometry, rotation, position, u, q)
    if found and branch != 0:
        flip(q, branch, q)
    return found


@kernel
def branch_of(geometry: FloatArray, q: FloatArray) -> int:
    """Return the branch of a posture with q2, q4, q6 in [−π, π]; a zero counts as positive unless it is −0."""
    return (
        4 * int(np.copysign(1.0, q[3]) < 0.0)
        + 2 * int(np.copysign(1.0, q[5]) < 0.0)
        + int(np.copysign(1.0, q[1]) < 0.0)
    )


@kernel
def arm_angle(geometry: FloatArray, q: FloatArray) -> float:
    """Return the arm angle in [−π, π] of a posture, reading q4 = 0 as on the side of its sign bit."""
    upper, fore = geometry[1], geometry[2]
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    c3, s3, c4, s4 = np.cos(q[2]), np.sin(q[2]), np.cos(q[3]), np.sin(q[3])
    # x3, y3, z3, each times the component along v
    hx, hy = c1 * c2 * c3 - s1 * s3, s1 * c2 * c3 + c1 * s3
    x = hx * geometry[3] + hy * geometry[4] - s2 * c3 * geometry[5]
    hx, hy = -c1 * c2 * s3 - s1 * c3, -s1 * c2 * s3 + c1 * c3
    y = hx * geometry[3] + hy * geometry[4] + s2 * s3 * geometry[5]
    z = c1 * s2 * geometry[3] + s1 * s2 * geometry[4] + c2 * geometry[5]
    along, across = upper + fore * c4, fore * s4
    d = np.sqrt(along * along + across * across)
    side = np.copysign(1.0, q[3])
    return np.arctan2(-side * y * d, side * (along * x + across * z))


@kernel
def range_root(low: float, high: float) -> Range:
    """Return the range of √x for x in [low, high], of which only what is not negative counts."""
    return max(down(np.sqrt(max(low, 0.0))), 0.0), up(np.sqrt(max(high, 0.0)))


@kernel
def range_share(low: float, high: float, least: float, most: float) -> Range:
    """Return the range of x/√(x² + s) for x in [low, high] and s in [least, most]: it grows with x."""
    one, two = 0.0, 0.0
    if low > 0.0:
        one = down(down(low / np.sqrt(up(up(low * low) + most))))
    elif low < 0.0:
        one = down(down(low / np.sqrt(down(down(low * low) + least))))
    if high > 0.0:
        two = up(up(high / np.sqrt(down(down(high * high) + least))))
    elif high < 0.0:
        two = up(up(high / np.sqrt(up(up(high * high) + most))))
    # Where squares underflow, nothing is known.
    return -1.0 if np.isnan(one) else max(one, -1.0), 1.0 if np.isnan(two) else min(two, 1.0)


@kernel
def both(one: Range, two: Range) -> Range:
    """Return what two ranges have in common."""
    return max(one[0], two[0]), min(one[1], two[1])


@kernel
def mixed(c: Range, x: Range, s: Range, y: Range) -> Range:
    """Return the range of c x + s y, where none of these numbers is above 1 in size."""
    a, b, e, f = c[0] * x[0], c[0] * x[1], c[1] * x[0], c[1] * x[1]
    low, high = min(a, b, e, f), max(a, b, e, f)
    a, b, e, f = s[0] * y[0], s[0] * y[1], s[1] * y[0], s[1] * y[1]
    low, high = low + min(a, b, e, f) - _ROUGH, high + max(a, b, e, f) + _ROUGH
    return max(low, -1.0), min(high, 1.0)


@kernel
def cross(one: FloatArray, two: FloatArray, out: FloatArray) -> None:
    """Fill in the vector product of two vectors (3, 2) of ranges."""
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        a = range_product(one[j, 0], one[j, 1], two[k, 0], two[k, 1])
        b = range_product(one[k, 0], one[k, 1], two[j, 0], two[j, 1])
        out[i, 0], out[i, 1] = range_sum(a[0], a[1], -b[1], -b[0])


@kernel
def normalize(vector: FloatArray) -> Range:
    """Divide a vector (3, 2) of ranges by its length; return the range of that."""
    x = range_square(vector[0, 0], vector[0, 1])
    y = range_square(vector[1, 0], vector[1, 1])
    z = range_square(vector[2, 0], vector[2, 1])
    xy, yz, zx = range_sum(x[0], x[1], y[0], y[1]), range_sum(y[0], y[1], z[0], z[1]), range_sum(z[0], z[1], x[0], x[1])
    vector[0, 0], vector[0, 1] = range_share(vector[0, 0], vector[0, 1], max(yz[0], 0.0), yz[1])
    vector[1, 0], vector[1, 1] = range_share(vector[1, 0], vector[1, 1], max(zx[0], 0.0), zx[1])
    vector[2, 0], vector[2, 1] = range_share(vector[2, 0], vector[2, 1], max(xy[0], 0.0), xy[1])
    square = range_sum(xy[0], xy[1], z[0], z[1])
    return range_root(square[0], square[1])


@kernel
def shoulder_frame(geometry: FloatArray, position: FloatArray, u: float, frame: FloatArray) -> Range:
    """Enclose n, and m and k at the arm angle u, in `frame` (3, 3, 2); return the range of the distance SW."""
    for i in range(3):
        frame[0, i, 0], frame[0, i, 1] = position[i, 0], position[i, 1]
        frame[1, i, 0], frame[1, i, 1] = geometry[3 + i], geometry[3 + i]
    frame[0, 2, 0], frame[0, 2, 1] = range_sum(position[2, 0], position[2, 1], -geometry[0], -geometry[0])
    cross(frame[0], frame[1], frame[2])
    normalize(frame[2])
    distance = normalize(frame[0])
    cross(frame[2], frame[0], frame[1])
    cl, ch, sl, sh = range_cosine_sine(u, u)
    for i in range(3):
        a, b = (frame[1, i, 0], frame[1, i, 1]), (frame[2, i, 0], frame[2, i, 1])
        frame[1, i, 0], frame[1, i, 1] = mixed((cl, ch), a, (sl, sh), b)
        frame[2, i, 0], frame[2, i, 1] = mixed((cl, ch), b, (-sh, -sl), a)
    return distance


@kernel
def wrist_frame(rotation: FloatArray, frame: FloatArray, out: FloatArray) -> None:
    """Express n, m and k in the coordinates of frame 7, for all rotations within rounding of the one given."""
    for v in range(3):
        for j in range(3):
            low, high = -_ROUGH, _ROUGH
            for i in range(3):
                one, two = max(rotation[i, j, 0] - _SQUARE, -1.0), min(rotation[i, j, 1] + _SQUARE, 1.0)
                a, b, e, f = one * frame[v, i, 0], one * frame[v, i, 1], two * frame[v, i, 0], two * frame[v, i, 1]
                low, high = low + min(a, b, e, f), high + max(a, b, e, f)
            out[v, j, 0], out[v, j, 1] = max(low, -1.0), min(high, 1.0)


@kernel
def triangle(upper: float, fore: float, d: Range) -> tuple[Range, Range, Range, Range, Range]:
    """Return the ranges of q4, cos α, sin α, cos β, sin β for the distance d, clipped to the reach."""
    outer, inner = range_sum(upper, upper, fore, fore), range_sum(upper, upper, -fore, -fore)
    if inner[0] < 0.0:
        inner = (-inner[1], -inner[0])
    skew = range_product(upper - fore, upper - fore, outer[0], outer[1])
    skew = (down(skew[0]), up(skew[1]))  # as the difference was rounded
    a, b = range_sum(outer[0], outer[1], -d[1], -d[0]), range_sum(outer[0], outer[1], d[0], d[1])
    top = range_product(max(a[0], 0.0), max(a[1], 0.0), b[0], b[1])
    a, b = range_sum(d[0], d[1], -inner[1], -inner[0]), range_sum(d[0], d[1], inner[0], inner[1])
    bottom = range_product(max(a[0], 0.0), max(a[1], 0.0), b[0], b[1])
    top, bottom = range_root(top[0], top[1]), range_root(bottom[0], bottom[1])
    half = both(range_angle(top[0], top[1], bottom[0], bottom[1]), (0.0, 0.5 * PI_UP))
    product, square = range_product(top[0], top[1], bottom[0], bottom[1]), range_square(d[0], d[1])
    near, far = range_product(2.0 * upper, 2.0 * upper, d[0], d[1]), range_product(2.0 * fore, 2.0 * fore, d[0], d[1])
    sine_alpha = both(range_quotient(product[0], product[1], near[0], near[1]), (0.0, 1.0))
    sine_beta = both(range_quotient(product[0], product[1], far[0], far[1]), (0.0, 1.0))
    a, b = range_sum(square[0], square[1], skew[0], skew[1]), range_sum(square[0], square[1], -skew[1], -skew[0])
    cosine_alpha = both(range_quotient(a[0], a[1], near[0], near[1]), (-1.0, 1.0))
    cosine_beta = both(range_quotient(b[0], b[1], far[0], far[1]), (-1.0, 1.0))
    return (2.0 * half[0], 2.0 * half[1]), cosine_alpha, sine_alpha, cosine_beta, sine_beta


@kernel
def sweep(frame: FloatArray, cosine: Range, sine: Range, c: Range, s: Range, field: FloatArray) -> None:
    """Enclose z = n c + m s, x = m c − n s and k in `field` (3, 3, 2), for arm angles around the frame's own."""
    for i in range(3):
        n, m, k = (frame[0, i, 0], frame[0, i, 1]), (frame[1, i, 0], frame[1, i, 1]), (frame[2, i, 0], frame[2, i, 1])
        moved = mixed(cosine, m, sine, k)
        field[2, i, 0], field[2, i, 1] = mixed(cosine, k, (-sine[1], -sine[0]), m)
        field[0, i, 0], field[0, i, 1] = mixed(c, n, s, moved)
        field[1, i, 0], field[1, i, 1] = mixed(c, moved, (-s[1], -s[0]), n)


@kernel
def around(u0: float, u1: float, middle: float) -> tuple[float, Range, Range]:
    """Return how far [u0, u1] reaches from its middle, and the ranges of cosine and sine of the way there."""
    half = up(max(u1 - middle, middle - u0))
    cl, ch, sl, sh = range_cosine_sine(-half, half)
    return half, (cl, ch), (sl, sh)


@kernel
def sphere(field: FloatArray, c: Range, s: Range, box: FloatArray, rate: FloatArray) -> bool:
    """Enclose the angles (t1, t2 ≥ 0, t3) of Rz(t1) Ry(t2) Rz(t3) with the columns x, k, z, and their rates.

    Return whether t2 keeps clear of 0 and π; if not, t1 and t3 may be anything, and the rate of t2 is that of ±t2.
    """
    zx, zy, zz = (field[0, 0, 0], field[0, 0, 1]), (field[0, 1, 0], field[0, 1, 1]), (field[0, 2, 0], field[0, 2, 1])
    xz, kz = (field[1, 2, 0], field[1, 2, 1]), (field[2, 2, 0], field[2, 2, 1])
    a, b = range_square(zx[0], zx[1]), range_square(zy[0], zy[1])
    square = range_sum(a[0], a[1], b[0], b[1])
    a, b = range_square(xz[0], xz[1]), range_square(kz[0], kz[1])
    square = both(square, range_sum(a[0], a[1], b[0], b[1]))
    a = range_square(zz[0], zz[1])
    square = both(square, range_sum(1.0, 1.0, -a[1], -a[0]))
    square = (max(square[0], 0.0), square[1])
    t = range_root(square[0], square[1])
    box[1, 0], box[1, 1] = both(range_angle(t[0], t[1], zz[0], zz[1]), (0.0, PI_UP))
    one = zx[0] > 0.0 or zx[1] < 0.0 or zy[0] > 0.0 or zy[1] < 0.0
    two = xz[0] > 0.0 or xz[1] < 0.0 or kz[0] > 0.0 or kz[1] < 0.0
    box[2, 0], box[2, 1] = range_angle(kz[0], kz[1], -xz[1], -xz[0])
    if one:
        box[0, 0], box[0, 1] = range_angle(zy[0], zy[1], zx[0], zx[1])
    else:  # from x sin t3 + k cos t3 = (−sin t1, cos t1, 0): over an interval, z moves across and k_z, x_z along
        cl, ch, sl, sh = range_cosine_sine(box[2, 0], box[2, 1])
        a = mixed((sl, sh), (field[1, 0, 0], field[1, 0, 1]), (cl, ch), (field[2, 0, 0], field[2, 0, 1]))
        b = mixed((sl, sh), (field[1, 1, 0], field[1, 1, 1]), (cl, ch), (field[2, 1, 0], field[2, 1, 1]))
        box[0, 0], box[0, 1] = range_angle(-a[1], -a[0], b[0], b[1])
    if not (two and t[0] > 0.0) or box[0, 1] - box[0, 0] >= TAU:
        for j in (0, 2):
            box[j, 0], box[j, 1] = -PI_UP, PI_UP
            rate[j, 0], rate[j, 1] = -np.inf, np.inf
        rate[1, 1] = max(abs(s[0]), abs(s[1]))
        rate[1, 0] = -rate[1, 1]
        return False
    a = range_product(s[0], s[1], -xz[1], -xz[0])
    rate[0, 0], rate[0, 1] = range_quotient(a[0], a[1], square[0], square[1])
    a = range_product(s[0], s[1], -kz[1], -kz[0])
    rate[1, 0], rate[1, 1] = range_quotient(a[0], a[1], t[0], t[1])
    a = range_product(zz[0], zz[1], rate[0, 0], rate[0, 1])
    rate[2, 0], rate[2, 1] = range_sum(c[0], c[1], -a[1], -a[0])
    return True


@kernel
def tighten(box: FloatArray, rate: FloatArray, middle: FloatArray, half: float) -> None:
    """Narrow a box by the mean value theorem, from the box in the middle, known up to whole turns."""
    for j in range(3):
        swing = up(max(abs(rate[j, 0]), abs(rate[j, 1])) * half)
        turn = TAU * np.rint((box[j, 0] + box[j, 1] - middle[j, 0] - middle[j, 1]) / (2.0 * TAU))
        room = 0.0 if turn == 0.0 else 1e-15
        box[j, 0] = max(box[j, 0], down(down(middle[j, 0] - swing) + turn) - room)
        box[j, 1] = min(box[j, 1], up(up(middle[j, 1] + swing) + turn) + room)


@kernel
def place(
    low: float, high: float, dlow: float, dhigh: float, turned: bool, mirrored: bool, box: FloatArray, rate: FloatArray
) -> None:
    """Write a range of angles and rates, turned by π or mirrored, with its middle in [−π, π]."""
    if mirrored:
        low, high, dlow, dhigh = -high, -low, -dhigh, -dlow
    middle = 0.5 * (low + high)
    turns = -TAU * np.rint(middle / TAU)
    if turned:
        turns -= np.copysign(np.pi, middle + turns)
    if turns != 0.0 and high - low < TAU:
        low, high = down(low + turns) - 1e-15, up(high + turns) + 1e-15
    box[0], box[1] = low, high
    rate[0], rate[1] = dlow, dhigh


@kernel
def both_signs(box: FloatArray) -> Range:
    """Return a range that holds [low, high] and its mirror image, around 0 or around π."""
    low, high = box[0], box[1]
    if high <= PI_UP - low:
        return -high, high
    return low, up(2.0 * PI_UP - low)


@kernel
def reaches(upper: float, fore: float, d: Range) -> int:
    """Return whether the elbow bridges the distance d: EMPTY if never, REGULAR if always, or FOLDED."""
    outer, inner = range_sum(upper, upper, fore, fore), range_sum(upper, upper, -fore, -fore)
    if inner[0] < 0.0:
        inner = (-inner[1], -inner[0])
    if d[0] > outer[1] or d[1] < inner[0]:
        return EMPTY
    return REGULAR if d[1] < outer[0] and d[0] > inner[1] else FOLDED


@kernel
def enclose(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, box: FloatArray,
    rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Enclose all postures with arm angle in [u0, u1] for a box of poses, branch by branch.

    Row b of `state` (8,) says what `box` and `rate` (8, 7, 2), the ranges of q and dq/du, hold of branch b:

    EMPTY     nothing: the wrist is out of reach; the rows are left alone;
    REGULAR   one posture for every u and pose, smooth in u;
    FOLDED    the same wherever the wrist is in reach, which it may not be everywhere, as the elbow stretches or folds.
              Branches with q4 of either sign meet there, but half a turn of u apart;
    SINGULAR  q2 or q6 may pass through 0 or π, also at a fold: where it does, q1 and q3, or q5 and q7, have the box
              [−π, π] and unbounded rates, and q2, or q6, has a box for both signs;
    MERGED    nothing: a SINGULAR branch of lower number holds it; the rows are left alone.

    `rotation` (3, 3, 2) and `position` (3, 2) are ranges; those of a single rotation, right to 1e-15, may have equal
    ends. Boxes hold up to whole turns, and rates at fixed pose.
    """
    upper, fore = geometry[1], geometry[2]
    work = np.empty((5, 3, 3, 2))
    frame, field, ball, speed, central, ignored = work[:2], work[2], work[3, :2], work[4, :2], work[3, 2], work[4, 2]
    middle = 0.5 * (u0 + u1)
    d = shoulder_frame(geometry, position, middle, frame[0])
    reach = reaches(upper, fore, d)
    if reach == EMPTY:
        state[:] = EMPTY
        return
    wrist_frame(rotation, frame[0], frame[1])
    q4, cosine_alpha, sine_alpha, cosine_beta, sine_beta = triangle(upper, fore, d)
    half, cosine, sine = around(u0, u1, middle)
    clear = np.empty(2, np.bool_)
    for side in range(2):
        c, s = (cosine_alpha, sine_alpha) if side == 0 else (cosine_beta, (-sine_beta[1], -sine_beta[0]))
        sweep(frame[side], cosine, sine, c, s, field)
        clear[side] = sphere(field, c, s, ball[side], speed[side])
        if clear[side]:
            sweep(frame[side], (1.0, 1.0), (0.0, 0.0), c, s, field)
            sphere(field, c, s, central, ignored)
            tighten(ball[side], speed[side], central, half)
        else:
            ball[side, 1, 0], ball[side, 1, 1] = both_signs(ball[side, 1])
    for b in range(8):
        elbow, wrist, shoulder = b & 4 != 0, b & 2 != 0, b & 1 != 0
        if (shoulder and not clear[0]) or (wrist and not clear[1]):
            state[b] = MERGED
            continue
        state[b] = SINGULAR if not (clear[0] and clear[1]) else reach
        put, move = box[b], rate[b]
        for j in range(3):
            turned = (shoulder, False, shoulder != elbow)[j]
            t, v = ball[0, j], speed[0, j]
            place(t[0], t[1], v[0], v[1], turned, shoulder and j == 1, put[j], move[j])
            # q7, q6, q5 are π − t1, t2, π − t3.
            turned = (not wrist, False, elbow == wrist)[j]
            t, v = ball[1, j], speed[1, j]
            place(t[0], t[1], v[0], v[1], turned, j != 1 or wrist, put[6 - j], move[6 - j])
        place(q4[0], q4[1], 0.0, 0.0, False, elbow, put[3], move[3])


@kernel
def turned(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, branch: int, joint: int,
    low: float, high: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow the box (7, 2) of a SINGULAR branch to where q1 (joint 0) or q5 (joint 4) lies in [low, high].

    Of the box, q1, q2, q3 or q5, q6, q7 are narrowed, starting from what they are; the others are left alone. Return
    False if there is certainly no such posture. The box is right for any branch that was merged into this one.

    With t1 given, Rz(−t1) R = Ry(t2) Rz(t3) says the rest, and (t3 given) R Rz(−t3) = Rz(t1) Ry(t2): no division.
    """
    upper, fore = geometry[1], geometry[2]
    frame, field = np.empty((2, 3, 3, 2)), np.empty((3, 3, 2))
    middle = 0.5 * (u0 + u1)
    d = shoulder_frame(geometry, position, middle, frame[0])
    if reaches(upper, fore, d) == EMPTY:
        return False
    _, cosine_alpha, sine_alpha, cosine_beta, sine_beta = triangle(upper, fore, d)
    _, cosine, sine = around(u0, u1, middle)
    elbow = branch & 4 != 0
    cl, ch, sl, sh = range_cosine_sine(low, high)
    c, s, plus = (cl, ch), (sl, sh), (-sh, -sl)
    z, x, k = field[0], field[1], field[2]
    if joint == 0:
        for v in range(3):  # in coordinates along x1 = (cos t1, sin t1, 0), y1 and z
            one, two = (frame[0, v, 0, 0], frame[0, v, 0, 1]), (frame[0, v, 1, 0], frame[0, v, 1, 1])
            frame[1, v, 0, 0], frame[1, v, 0, 1] = mixed(c, one, s, two)
            frame[1, v, 1, 0], frame[1, v, 1, 1] = mixed(c, two, plus, one)
            frame[1, v, 2, 0], frame[1, v, 2, 1] = frame[0, v, 2, 0], frame[0, v, 2, 1]
        sweep(frame[1], cosine, sine, cosine_alpha, sine_alpha, field)
        if z[1, 0] > 0.0 or z[1, 1] < 0.0:
            return False
        sine_2, cosine_2 = (z[0, 0], z[0, 1]), (z[2, 0], z[2, 1])
        sine_3, cosine_3 = (x[1, 0], x[1, 1]), (k[1, 0], k[1, 1])
        first, second, third = 0, 1, 2
        if elbow:
            sine_3, cosine_3 = (-sine_3[1], -sine_3[0]), (-cosine_3[1], -cosine_3[0])
    else:
        wrist_frame(rotation, frame[0], frame[1])
        sweep(frame[1], cosine, sine, cosine_beta, (-sine_beta[1], -sine_beta[0]), field)
        if elbow:  # x4 and y4 of this branch are the negative of those with q4 > 0
            c, s, plus = (-c[1], -c[0]), (-s[1], -s[0]), (-plus[1], -plus[0])
        # y5 = −x4 sin q5 + y4 cos q5 is square to z7, and x5 = x4 cos q5 + y4 sin q5 is z7's other direction.
        zero = mixed(c, (k[2, 0], k[2, 1]), plus, (x[2, 0], x[2, 1]))
        if zero[0] > 0.0 or zero[1] < 0.0:
            return False
        sine_2, cosine_2 = mixed(c, (x[2, 0], x[2, 1]), s, (k[2, 0], k[2, 1])), (z[2, 0], z[2, 1])
        sine_3 = mixed(c, (k[0, 0], k[0, 1]), plus, (x[0, 0], x[0, 1]))
        cosine_3 = mixed(c, (k[1, 0], k[1, 1]), plus, (x[1, 0], x[1, 1]))
        first, second, third = 4, 5, 6
    one = range_angle(sine_2[0], sine_2[1], cosine_2[0], cosine_2[1])
    two = range_angle(sine_3[0], sine_3[1], cosine_3[0], cosine_3[1])
    return meet(box[first], low, high) and meet(box[second], one[0], one[1]) and meet(box[third], two[0], two[1])


@kernel
def parameter_of(geometry: FloatArray, q: FloatArray) -> float:
    """Return the arm angle."""
    return arm_angle(geometry, q)
