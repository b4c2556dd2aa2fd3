"""Six joints with a spherical wrist and parallel axes 2 and 3, the tool free to roll: in closed form and enclosed.

The frame after joint 6 is, with the lengths [a1, a2, b, c2, c3] of the ortho-parallel basis (Brandstötter, Angerer and
Hofbaur 2014; its c1 belongs to the base and its c4 to the tool, so that the wrist centre W is the origin),

    T = Rz(q1) Tx(a1) · Ry(q2) Tz(c2) · Ry(q3) Txyz(a2, b, c3) · Rz(q4) Ry(q5) Rz(q6).

The task leaves the tool free to turn about its own z axis, and the parameter is that angle u: T = X Rz(u) tool⁻¹, where
X is the pose, in the base of T. A *geometry* is the lengths, the rotation of tool⁻¹ row by row, and its position.
Over u, the arm follows a rigid turn about the line through X along its z.

With W = (x, y, z) and m = ±√(x² + y² − b²), the shoulder has Rz(−q1) W = (m, b, z). Upper arm c2 and forearm
k = √(a2² + c3²), bent by κ = ±|q3 + atan2(a2, c3)|, then reach (m − a1, z) in their plane. What is left of the rotation
is the wrist's. Branch 4 shoulder + 2 elbow + wrist has these bits where m < 0, κ < 0 and q5 < 0.

Shoulders meet at m = 0, elbows at κ = 0 and κ = π, wrists at sin q5 = 0, where q4 and q6 are free together. Where
b = 0, q1 is free at m = 0, and q4, q5, q6 with it; q2 and q3 are not.

Over intervals, the pose is any in a box, which is widened by PAD: what rounding did to the pose, and by what solutions
from :func:`solve` miss it, is inside. All else is rounded outwards. What the two families of arms with a free roll have
in common is written here.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._elementary_kernels import arctan2, sincos
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._jet_kernels import Range, range_cosine_sine, up
from selfmotion.arms._panda_kernels import (
    elbow_range,
    mirror,
    put_shoulder,
    put_shoulder_rates,
)
from selfmotion.arms._range_kernels import (
    angle_of,
    around,
    exactly,
    get,
    holds_zero,
    less,
    meet,
    narrowed,
    negative,
    opposite,
    plus,
    polar,
    product,
    put,
    quotient,
    root,
    squared,
    trigonometry,
    wrap,
)
from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR

LENGTHS = 5
SLACK = 1e-14  # of the reach: by how much a solution may miss the pose where branches meet
PAD = 2e-14  # of a pose: entries of the rotation, and the position over the reach
FULL = 6.28  # a joint's box at least this wide is a whole turn
_ROUGH = 2e-15  # rounding in a few sums of products of numbers up to 1 is less
_ALL = 3.1415926535897936  # π, rounded up

Frame = tuple[float, float, float, float, float, float, float, float, float, float, float, float]


@kernel
def flange(tool: FloatArray, rotation: FloatArray, position: FloatArray, u: float) -> Frame:
    """Return the frame after joint 6 at the roll u: its rotation row by row, and its position."""
    s, c = sincos(u)
    a, b, d = tool[9], tool[10], tool[11]
    x, y, z = rotation[0, 0] * c + rotation[0, 1] * s, rotation[0, 1] * c - rotation[0, 0] * s, rotation[0, 2]
    r00, r01 = x * tool[0] + y * tool[3] + z * tool[6], x * tool[1] + y * tool[4] + z * tool[7]
    r02, px = x * tool[2] + y * tool[5] + z * tool[8], position[0] + x * a + y * b + z * d
    x, y, z = rotation[1, 0] * c + rotation[1, 1] * s, rotation[1, 1] * c - rotation[1, 0] * s, rotation[1, 2]
    r10, r11 = x * tool[0] + y * tool[3] + z * tool[6], x * tool[1] + y * tool[4] + z * tool[7]
    r12, py = x * tool[2] + y * tool[5] + z * tool[8], position[1] + x * a + y * b + z * d
    x, y, z = rotation[2, 0] * c + rotation[2, 1] * s, rotation[2, 1] * c - rotation[2, 0] * s, rotation[2, 2]
    r20, r21 = x * tool[0] + y * tool[3] + z * tool[6], x * tool[1] + y * tool[4] + z * tool[7]
    r22, pz = x * tool[2] + y * tool[5] + z * tool[8], position[2] + x * a + y * b + z * d
    return r00, r01, r02, r10, r11, r12, r20, r21, r22, px, py, pz


@kernel
def turn(rotation: FloatArray, axis: int, angle: float) -> None:
    """Turn a rotation (3, 3) about one of its own axes."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    s, c = sincos(angle)
    for row in range(3):
        x, y = rotation[row, i], rotation[row, j]
        rotation[row, i], rotation[row, j] = c * x + s * y, c * y - s * x


@kernel
def roll_between(tool: FloatArray, rotation: FloatArray, flanged: FloatArray) -> float:
    """Return the angle u of R Rz(u) R_tool⁻¹ = F; of the nearest such F if the two axes differ."""
    sine, cosine = 0.0, 0.0
    for i in range(3):
        x, y = 0.0, 0.0
        for j in range(3):
            x += flanged[i, j] * tool[j]
            y += flanged[i, j] * tool[3 + j]
        cosine += rotation[i, 0] * x + rotation[i, 1] * y
        sine += rotation[i, 1] * x - rotation[i, 0] * y
    return arctan2(sine, cosine)


@kernel
def roll(geometry: FloatArray, rotation: FloatArray, q: FloatArray) -> float:
    """Return u in [−π, π] of a posture q (6,): the angle about z by which its tool is turned from the rotation (3, 3).

    Of a posture that does not do the task it is the roll that comes nearest to its tool's rotation.
    """
    flanged = np.eye(3)
    turn(flanged, 2, q[0])
    turn(flanged, 1, q[1] + q[2])
    turn(flanged, 2, q[3])
    turn(flanged, 1, q[4])
    turn(flanged, 2, q[5])
    return roll_between(geometry[LENGTHS:], rotation, flanged)


@kernel
def branch_of(geometry: FloatArray, q: FloatArray) -> int:
    """Return the branch of a posture."""
    a1, a2, c2, c3 = geometry[0], geometry[1], geometry[3], geometry[4]
    both = q[1] + q[2]
    m = a1 + c2 * np.sin(q[1]) + a2 * np.cos(both) + c3 * np.sin(both)
    bend = a2 * np.cos(q[2]) + c3 * np.sin(q[2])
    return 4 * int(m < 0.0) + 2 * int(bend < 0.0) + int(np.sin(q[4]) < 0.0)


@kernel
def solve(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray, ok: BoolArray
) -> None:
    """Fill in the postures q (8, 6) of all branches at the roll u, and whether they exist; q is NaN where not.

    Where q1 is free it is 0 or π, and where q4 is, 0 or π as well; where the forearm folds W onto axis 2, q2 is 0.
    """
    a1, a2, b, c2, c3 = geometry[0], geometry[1], geometry[2], geometry[3], geometry[4]
    k = np.sqrt(a2 * a2 + c3 * c3)
    slack = SLACK * (abs(a1) + abs(b) + c2 + k)
    r00, r01, r02, r10, r11, r12, r20, r21, r22, px, py, pz = flange(geometry[LENGTHS:], rotation, position, u)
    ok[:] = False
    q[:] = np.nan
    away, offset = np.sqrt(px * px + py * py), abs(b)
    if not away >= offset - slack:
        return
    size = np.sqrt(max((away - offset) * (away + offset), 0.0))
    phi, cp, sp = arctan2(a2, c3), c3 / k, a2 / k
    longest, shortest = c2 + k, abs(c2 - k)
    for shoulder in range(2):
        m = size if shoulder == 0 else -size
        x, y = m * px + b * py, m * py - b * px
        r = np.sqrt(x * x + y * y)
        c1, s1 = (x / r, y / r) if r > 0.0 else (1.0 - 2.0 * shoulder, 0.0)
        reach = m - a1
        d = np.sqrt(reach * reach + pz * pz)
        if not shortest - slack <= d <= longest + slack:
            continue
        outer, inner = max((longest - d) * (longest + d), 0.0), max((d - shortest) * (d + shortest), 0.0)
        top, bottom, total = np.sqrt(outer), np.sqrt(inner), outer + inner
        kappa, ck, sk = 2.0 * arctan2(top, bottom), (inner - outer) / total, 2.0 * top * bottom / total
        along, across = c2 + k * ck, k * sk
        q1 = arctan2(s1, c1)
        xx, xy, xz = c1 * r00 + s1 * r10, c1 * r01 + s1 * r11, c1 * r02 + s1 * r12
        yx, yy, yz = c1 * r10 - s1 * r00, c1 * r11 - s1 * r01, c1 * r12 - s1 * r02
        for elbow in range(2):
            side = 1.0 - 2.0 * elbow
            x, y = pz * along + reach * side * across, reach * along - pz * side * across
            r = np.sqrt(x * x + y * y)
            cu, su = (x / r, y / r) if r > 0.0 else (1.0, 0.0)
            cf, sf = cu * ck - su * side * sk, su * ck + cu * side * sk
            c, s = cf * cp + sf * sp, sf * cp - cf * sp  # of q2 + q3
            zx, zz = c * xz - s * r22, s * xz + c * r22
            r = np.sqrt(zx * zx + yz * yz)
            c4, s4 = (zx / r, yz / r) if r > 0.0 else (1.0, 0.0)
            # Rz(−q4) R36 has the second row (sin q6, cos q6, 0): accurate however small q5 is.
            q4, q5 = arctan2(s4, c4), arctan2(r, zz)
            q6 = arctan2(c4 * yx - s4 * (c * xx - s * r20), c4 * yy - s4 * (c * xy - s * r21))
            first = 4 * shoulder + 2 * elbow
            ok[first] = ok[first + 1] = True
            q2, q3 = arctan2(su, cu), wrap(side * kappa - phi)
            q[first, 0], q[first, 1], q[first, 2] = q1, q2, q3
            q[first, 3], q[first, 4], q[first, 5] = q4, q5, q6
            q[first + 1, 0], q[first + 1, 1], q[first + 1, 2] = q1, q2, q3
            q[first + 1, 3], q[first + 1, 4], q[first + 1, 5] = opposite(q4), -q5, opposite(q6)


@kernel
def blended(c: Range, x: Range, s: Range, y: Range) -> Range:
    """Return the range of c x + s y, where none of these numbers is above 1 in size."""
    a, b, e, f = c[0] * x[0], c[0] * x[1], c[1] * x[0], c[1] * x[1]
    low, high = min(a, b, e, f), max(a, b, e, f)
    a, b, e, f = s[0] * y[0], s[0] * y[1], s[1] * y[0], s[1] * y[1]
    low, high = low + min(a, b, e, f) - _ROUGH, high + max(a, b, e, f) + _ROUGH
    return max(low, -1.0), min(high, 1.0)


@kernel
def by(c: float, x: Range) -> Range:
    """Return the range of c x, rounding aside."""
    return (c * x[0], c * x[1]) if c >= 0.0 else (c * x[1], c * x[0])


@kernel
def sight(
    tool: FloatArray, rotation: FloatArray, position: FloatArray, lengths: float, u0: float, u1: float,
    rows: FloatArray, place: FloatArray, motion: FloatArray,
) -> float:  # fmt: skip
    """Enclose the frame after joint 6 in the middle of [u0, u1] and all over it; return how far its ends are.

    Rotations are rows (2, 3, 3, 2), positions place (2, 3, 2), and motion (3, 2) is how fast the latter moves.
    With the frame M of the tool in the middle, all is α + β cos δ + γ sin δ.
    """
    middle = 0.5 * (u0 + u1)
    half = up(max(u1 - middle, middle - u0))
    c_low, c_high, s_low, s_high = range_cosine_sine(middle, middle)
    cosine, sine, back = (c_low, c_high), (s_low, s_high), (-s_high, -s_low)
    c_low, c_high, s_low, s_high = range_cosine_sine(-half, half)
    size = abs(tool[9]) + abs(tool[10]) + abs(tool[11])
    pad, rough = PAD * (lengths + size), _ROUGH * size
    for i in range(3):
        x = max(rotation[i, 0, 0] - PAD, -1.0), min(rotation[i, 0, 1] + PAD, 1.0)
        y = max(rotation[i, 1, 0] - PAD, -1.0), min(rotation[i, 1, 1] + PAD, 1.0)
        z = max(rotation[i, 2, 0] - PAD, -1.0), min(rotation[i, 2, 1] + PAD, 1.0)
        x, y = blended(cosine, x, sine, y), blended(cosine, y, back, x)
        for j in range(4):
            if j < 3:
                t0, t1, t2, room = tool[j], tool[3 + j], tool[6 + j], _ROUGH
            else:
                t0, t1, t2, room = tool[9], tool[10], tool[11], rough
            a, b, e = by(t0, x), by(t1, y), by(t2, z)
            beta = a[0] + b[0], a[1] + b[1]
            a, b = by(t0, y), by(t1, x)
            gamma = a[0] - b[1], a[1] - b[0]
            low, high = min(beta[0] * c_low, beta[0] * c_high), max(beta[1] * c_low, beta[1] * c_high)
            swing = max(abs(gamma[0]), abs(gamma[1])) * s_high
            if j < 3:
                rows[0, i, j, 0], rows[0, i, j, 1] = (
                    max(beta[0] + e[0] - room, -1.0),
                    min(beta[1] + e[1] + room, 1.0),
                )
                rows[1, i, j, 0], rows[1, i, j, 1] = (
                    max(low - swing + e[0] - room, -1.0),
                    min(high + swing + e[1] + room, 1.0),
                )
                continue
            p = position[i, 0] - pad, position[i, 1] + pad
            put(place[0], i, plus(p, (beta[0] + e[0] - room, beta[1] + e[1] + room)))
            put(place[1], i, plus(p, (low - swing + e[0] - room, high + swing + e[1] + room)))
            low, high = min(gamma[0] * c_low, gamma[0] * c_high), max(gamma[1] * c_low, gamma[1] * c_high)
            swing = max(abs(beta[0]), abs(beta[1])) * s_high
            motion[i, 0], motion[i, 1] = low - swing - room, high + swing + room
    return half


@kernel
def first_joint(
    place: FloatArray, motion: FloatArray, b: float, shoulder: int, folds: bool, smooth: bool, half: float,
    q1_middle: Range, m_middle: Range, out: FloatArray, speed: FloatArray,
) -> None:  # fmt: skip
    """Enclose q1 and m, out (2, 2), and if `smooth` their rates, narrowed by what is known of the middle."""
    px, py = get(place, 0), get(place, 1)
    square = plus(squared(px), squared(py))
    size = root(less(square, squared(exactly(b))))
    m = size if shoulder == 0 else negative(size)
    if folds:
        m = -size[1], size[1]
    q1 = -_ALL, _ALL
    if not (folds and b == 0.0):
        q1 = less(angle_of(py, px), angle_of(exactly(b), m))
    if q1[1] - q1[0] >= FULL:
        q1 = -_ALL, _ALL
    if smooth:
        vx, vy = get(motion, 0), get(motion, 1)
        rate = quotient(plus(product(px, vx), product(py, vy)), m)
        turns = quotient(plus(less(product(px, vy), product(py, vx)), product(exactly(b), rate)), square)
        q1 = narrowed(q1, q1_middle, turns, half)
        m = around(m, m_middle, rate, half)
        put(speed, 0, turns)
        put(speed, 1, rate)
    put(out, 0, q1)
    put(out, 1, m)


@kernel
def two_links(
    upper: float, fore: Range, x: Range, y: Range, dx: Range, dy: Range, smooth: bool, out: FloatArray,
    speed: FloatArray,
) -> int:  # fmt: skip
    """Enclose the angles of two links that reach (x, y): out (2, 3, 2) for κ > 0 and κ < 0, of (first, κ, first + κ).

    Return EMPTY if they never reach, REGULAR if always and never stretched or closed, FOLDED otherwise; then the angles
    of both signs are in out[0]. If `smooth`, rates are worked out where REGULAR.
    """
    square = plus(squared(x), squared(y))
    outer = less(squared(plus(exactly(upper), fore)), square)
    inner = less(square, squared(less(exactly(upper), fore)))
    if outer[1] < 0.0 or inner[1] < 0.0:
        return EMPTY
    stretches, closes = outer[0] <= 0.0, inner[0] <= 0.0
    kappa = elbow_range(outer, inner)
    if stretches:
        kappa = (-_ALL, _ALL) if closes else (-kappa[1], kappa[1])
    elif closes:
        kappa = kappa[0], up(2.0 * _ALL - kappa[0])
    c, s = trigonometry(kappa)
    alpha = angle_of(product(fore, s), plus(exactly(upper), product(fore, c)))
    gamma = angle_of(product(exactly(upper), s), plus(fore, product(exactly(upper), c)))
    omega = angle_of(y, x)
    put(out[0], 0, less(omega, alpha))
    put(out[0], 1, kappa)
    put(out[0], 2, plus(omega, gamma))
    if stretches or closes:
        return FOLDED
    put(out[1], 0, plus(omega, alpha))
    put(out[1], 1, negative(kappa))
    put(out[1], 2, less(omega, gamma))
    if smooth:
        bend = plus(product(x, dx), product(y, dy))
        bend = quotient(product(exactly(-2.0), bend), product(root(outer), root(inner)))
        turns = quotient(less(product(x, dy), product(y, dx)), square)
        share = quotient(less(squared(fore), squared(exactly(upper))), square)
        near = product(product(exactly(0.5), bend), plus(exactly(1.0), share))
        far = product(product(exactly(0.5), bend), less(exactly(1.0), share))
        put(speed[0], 0, less(turns, near))
        put(speed[0], 1, bend)
        put(speed[0], 2, plus(turns, far))
        put(speed[1], 0, plus(turns, near))
        put(speed[1], 1, negative(bend))
        put(speed[1], 2, less(turns, far))
    return REGULAR


@kernel
def level(rows: FloatArray, q1: Range, out: FloatArray) -> None:
    """Enclose the x and y axes of the arm's plane, turned by q1, in the last frame: out (2, 3, 2)."""
    c, s = trigonometry(q1)
    for j in range(3):
        put(out[0], j, blended(c, get(rows[0], j), s, get(rows[1], j)))
        put(out[1], j, blended(c, get(rows[1], j), negative(s), get(rows[0], j)))


@kernel
def wrist_axes(rows: FloatArray, plane: FloatArray, q23: Range, axes: FloatArray) -> None:
    """Enclose R36 in axes (3, 3, 2)."""
    c, s = trigonometry(q23)
    for j in range(3):
        x, z = get(plane[0], j), get(rows[2], j)
        put(axes[0], j, blended(c, x, negative(s), z))
        put(axes[1], j, get(plane[1], j))
        put(axes[2], j, blended(s, x, c, z))


@kernel
def home(state: IntArray, branch: int) -> int:
    """Return the branch whose box holds the solutions of a branch that is MERGED; itself if it is not."""
    if state[branch] != MERGED:
        return branch
    bit = 4
    while bit > 0:
        if branch & bit:
            start = branch - branch % bit
            alone = False
            for b in range(start, start + bit):
                alone = alone or (state[b] != MERGED and state[b] != EMPTY)
            if not alone:
                branch -= bit
        bit //= 2
    return branch


@kernel
def follow(
    geometry: FloatArray, spin: FloatArray, rows: FloatArray, place: FloatArray, motion: FloatArray, half: float,
    is_middle: bool, notes: FloatArray, box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Do what :func:`enclose` says for frames of which rows, place and motion are known, and `spin` (3,).

    The latter is how fast they turn as u grows, seen from themselves.

    In the middle of an interval `notes` (8, 8, 2) are taken: the joints, m and q2 + q3. They narrow what is found for
    all of it. A shoulder's q1 and m are noted with its first branch.
    """
    a1, b, c2 = geometry[0], geometry[2], geometry[3]
    fore, phi = polar(exactly(geometry[4]), exactly(geometry[1]))
    anything = (-np.inf, np.inf)
    state[:] = EMPTY
    px, py, pz, dz = get(place, 0), get(place, 1), get(place, 2), get(motion, 2)
    radicand = less(plus(squared(px), squared(py)), squared(exactly(b)))
    if radicand[1] < 0.0:
        return
    folds = radicand[0] <= 0.0
    base, base_speed = np.empty((2, 2)), np.empty((2, 2))
    planar, planar_speed = np.empty((2, 3, 2)), np.empty((2, 3, 2))
    plane, axes = np.empty((2, 3, 2)), np.empty((3, 3, 2))
    for shoulder in range(2):
        first = 4 * shoulder
        if folds and shoulder == 1:
            for i in range(4):
                state[4 + i] = EMPTY if state[i] == EMPTY else MERGED
            break
        helped = not (is_middle or folds)
        base_speed[:, 0], base_speed[:, 1] = -np.inf, np.inf
        was = notes[first]
        first_joint(place, motion, b, shoulder, folds, helped, half, get(was, 0), get(was, 6), base, base_speed)
        q1, m = get(base, 0), get(base, 1)
        if is_middle:
            put(was, 0, q1)
            put(was, 6, m)
        kind = two_links(
            c2, fore, pz, less(m, exactly(a1)), dz, get(base_speed, 1), helped, planar, planar_speed
        )  # fmt: skip
        if kind == EMPTY:
            continue
        level(rows, q1, plane)
        smooth = helped and kind == REGULAR
        for elbow in range(2):
            w = first + 2 * elbow
            if kind == FOLDED and elbow == 1:
                for i in range(2):
                    state[w + i] = EMPTY if state[w - 2 + i] == EMPTY else MERGED
                break
            mine, speed, was = box[w], rate[w], notes[w]
            speed[:, 0], speed[:, 1] = -np.inf, np.inf
            q2, bend, q23 = get(planar[elbow], 0), get(planar[elbow], 1), less(get(planar[elbow], 2), phi)
            q3, r1, r23 = less(bend, phi), get(base_speed, 0), anything
            if smooth:
                r2, r3, r23 = get(planar_speed[elbow], 0), get(planar_speed[elbow], 1), get(planar_speed[elbow], 2)
                q2 = narrowed(q2, get(was, 1), r2, half)
                q3 = narrowed(q3, get(was, 2), r3, half)
                q23 = narrowed(q23, get(was, 7), r23, half)
                put(speed, 0, r1)
                put(speed, 1, r2)
                put(speed, 2, r3)
            put(mine, 0, q1)
            put(mine, 1, q2)
            put(mine, 2, q3)
            wrist_axes(rows, plane, q23, axes)
            sine = put_shoulder(axes, mine[3:])
            if is_middle:
                was[1:6] = mine[1:6]
                put(was, 7, q23)
            if sine[0] <= 0.0:
                state[w], state[w + 1] = SINGULAR, MERGED
                continue
            state[w] = FOLDED if folds or kind == FOLDED else REGULAR
            if folds and b == 0.0:
                state[w] = SINGULAR
            if smooth:
                omega_x = less(less(exactly(spin[0]), product(r1, get(rows[2], 0))), product(r23, get(plane[1], 0)))
                omega_y = less(less(exactly(spin[1]), product(r1, get(rows[2], 1))), product(r23, get(plane[1], 1)))
                omega_z = less(less(exactly(spin[2]), product(r1, get(rows[2], 2))), product(r23, get(plane[1], 2)))
                put_shoulder_rates(axes, (omega_x, omega_y, omega_z), sine, speed[3:])
                for j in range(3, 6):
                    put(mine, j, narrowed(get(mine, j), get(was, j), get(speed, j), half))
            state[w + 1] = state[w]
            box[w + 1, :3], rate[w + 1, :3] = mine[:3], speed[:3]
            mirror(mine[3:], speed[3:], box[w + 1, 3:], rate[w + 1, 3:])


@kernel
def size_of(geometry: FloatArray) -> float:
    """Return how long the arm is, without its base and its tool."""
    return abs(geometry[0]) + abs(geometry[1]) + abs(geometry[2]) + abs(geometry[3]) + abs(geometry[4])


@kernel
def follow_frames(
    geometry: FloatArray, spin: FloatArray, rows: FloatArray, place: FloatArray, motion: FloatArray, half: float,
    box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Do what :func:`enclose` says for frames that :func:`sight` enclosed: in the middle, then all over."""
    notes = np.empty((8, 8, 2))
    notes[:, :, 0], notes[:, :, 1] = -np.inf, np.inf
    follow(geometry, spin, rows[0], place[0], motion, 0.0, True, notes, box, rate, state)
    follow(geometry, spin, rows[1], place[1], motion, half, False, notes, box, rate, state)


@kernel
def enclose(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float,
    box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Enclose the postures of all branches, box (8, 6, 2), for u in [u0, u1] and the poses in a box of poses.

    Rotation (3, 3, 2) and position (3, 2) are lowest and highest entries of X. A box holds one continuous choice of
    angles, up to whole turns. By state (8,),

    - EMPTY: no pose has a solution of this branch;
    - REGULAR: at each pose the branch is smooth, and dq/du at fixed X lies in rate (8, 6, 2);
    - FOLDED: shoulders or elbows may meet, and the box holds the solutions of all that do;
    - SINGULAR: sin q5 may be 0, q4 and q6 have the box [−π, π] and q5 is of both signs; or b = 0 and W may be on axis
      1, q1 has the box [−π, π] and shoulders are one (and branches may meet as well); :func:`turned` tells more;
    - MERGED: the box of its :func:`home`, a FOLDED or SINGULAR branch, holds what this has.

    Of FOLDED and SINGULAR branches rates are infinite unless known; what is in the rows of
    EMPTY and MERGED ones means nothing.
    """
    rows, place, motion = np.empty((2, 3, 3, 2)), np.empty((2, 3, 2)), np.empty((3, 2))
    half = sight(geometry[LENGTHS:], rotation, position, size_of(geometry), u0, u1, rows, place, motion)
    follow_frames(geometry, geometry[LENGTHS + 6 : LENGTHS + 9], rows, place, motion, half, box, rate, state)


@kernel
def side_of(angle: Range) -> int:
    """Return the sign of the sine over a range of angles, 0 if it has both: then two branches are in one box."""
    half_turn = np.floor(angle[0] / np.pi)
    if np.floor(angle[1] / np.pi) != half_turn:
        return 0
    return 1 if half_turn == 2.0 * np.floor(0.5 * half_turn) else -1


@kernel
def both_elbows(angles: FloatArray) -> None:
    """Widen the angles of κ > 0 that :func:`two_links` gave to those of both signs."""
    for j in range(3):
        one, two = get(angles[0], j), get(angles[1], j)
        if j != 1:
            angles[0, j, 0], angles[0, j, 1] = min(one[0], two[0]), max(one[1], two[1])
        elif one[1] <= _ALL - one[0]:  # across 0, or across π: whichever is narrower
            angles[0, j, 0], angles[0, j, 1] = -one[1], one[1]
        else:
            angles[0, j, 0], angles[0, j, 1] = one[0], up(2.0 * _ALL - one[0])


@kernel
def turned(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, branch: int, joint: int,
    low: float, high: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow the box (6, 2) of a SINGULAR branch to where q1 (joint 0) or q4 (joint 3) lies in [low, high].

    The box is narrowed from what it is, and stays right for any branch that was merged into this one. Return False if
    there is certainly no such posture. Where both joints are free, little is known before joint 0 is given. With q4
    given, Rz(−q4) R36 = Ry(q5) Rz(q6) says the rest without a division.
    """
    rows, place, motion = np.empty((2, 3, 3, 2)), np.empty((2, 3, 2)), np.empty((3, 2))
    sight(geometry[LENGTHS:], rotation, position, size_of(geometry), u0, u1, rows, place, motion)
    return turned_frames(geometry, rows[1], place[1], branch, joint, low, high, box)


@kernel
def turned_frames(
    geometry: FloatArray, rows: FloatArray, place: FloatArray, branch: int, joint: int, low: float, high: float,
    box: FloatArray,
) -> bool:  # fmt: skip
    """Do what :func:`turned` says for frames after joint 6 of which rows and place are known."""
    b, c2 = geometry[2], geometry[3]
    plane, axes, found = np.empty((2, 3, 2)), np.empty((3, 3, 2)), np.empty((3, 2))
    if not meet(box[joint], low, high):
        return False
    if joint == 0:
        fore, phi = polar(exactly(geometry[4]), exactly(geometry[1]))
        planar = np.empty((2, 3, 2))
        c, s = trigonometry(get(box, 0))
        px, py, pz = get(place, 0), get(place, 1), get(place, 2)
        m, beside = plus(product(c, px), product(s, py)), less(product(c, py), product(s, px))
        if not holds_zero(less(beside, exactly(b))):
            return False
        kind = two_links(c2, fore, pz, less(m, exactly(geometry[0])), pz, pz, False, planar, planar)
        if kind == EMPTY:
            return False
        elbow = (branch >> 1) & 1
        if kind == REGULAR and side_of(plus(get(box, 2), phi)) == 0:
            both_elbows(planar)
            elbow = 0
        if kind == FOLDED:
            elbow = 0
        bend = less(get(planar[elbow], 1), phi)
        if not (meet(box[1], planar[elbow, 0, 0], planar[elbow, 0, 1]) and meet(box[2], bend[0], bend[1])):
            return False
    level(rows, get(box, 0), plane)
    wrist_axes(rows, plane, plus(get(box, 1), get(box, 2)), axes)
    if joint == 0:
        side, sine = side_of(get(box, 4)), put_shoulder(axes, found)
        if side == 0:
            return meet(box[4], -found[1, 1], found[1, 1]) if found[1, 1] < _ALL else True
        if sine[0] <= 0.0:
            return True
        if side < 0:
            mirror(found, found, found, plane[0])
        return (
            meet(box[3], found[0, 0], found[0, 1])
            and meet(box[4], found[1, 0], found[1, 1])
            and meet(box[5], found[2, 0], found[2, 1])
        )
    c, s = trigonometry(get(box, 3))
    zero = blended(c, get(axes[1], 2), negative(s), get(axes[0], 2))
    if not holds_zero(zero):
        return False
    five = angle_of(blended(c, get(axes[0], 2), s, get(axes[1], 2)), get(axes[2], 2))
    sine_6 = blended(c, get(axes[1], 0), negative(s), get(axes[0], 0))
    cosine_6 = blended(c, get(axes[1], 1), negative(s), get(axes[0], 1))
    six = angle_of(sine_6, cosine_6)
    return meet(box[4], five[0], five[1]) and meet(box[5], six[0], six[1])


@kernel
def parameter_of(geometry: FloatArray, q: FloatArray) -> float:
    """Return NaN: a roll is counted from a frame that the posture's tool decides."""
    return np.nan
