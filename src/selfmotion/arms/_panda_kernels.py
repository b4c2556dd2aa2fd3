"""Closed-form inverse kinematics of arms like the Franka Panda with joint 7 locked, at one angle and over intervals.

The parameter is u = q7. Geometry is [d1, d3, a4, d5, a5, a7], and the joint transforms Rx(α) Tx(a) Rz(q) Tz(d) have

    (a, d, α) = (0, d1, 0), (0, 0, −π/2), (0, d3, π/2), (a4, 0, π/2), (a5, d5, −π/2), (0, 0, π/2), (a7, 0, π/2).

Joints 1–3 meet in the shoulder S = (0, 0, d1), joints 5 and 6 in the wrist W. With δ = Rᵀ (S − p) and (ρ, β) the polar
form of (δx, δy), the shoulder seen from W in frame 6 is

    v = (a7 + ρ cos(u + β), −δz, ρ sin(u + β)),   |v|² = e² + f² + 2 e f cos κ,   q4 = η − φ ± κ,

where e, η and f, φ are the polar forms of (a4, d3) and (a5, d5). Seen from W before joint 5 turns, the shoulder is at
(h, 0, k) = (−a5 − e cos θ, 0, e sin θ − d5) with θ = q4 − η, so that, with m = h cos q5,

    h sin q5 = v_z,   m = ±√(h² − v_z²),   q6 = arg(m, k) − arg(v_x, v_y),

and joints 1–3 are what is left: Rz(q1) Ry(q2) Rz(q3) = R03. (The geometric idea is that of He and Liu, "Analytical
inverse kinematics for Franka Emika Panda", 2021.)

Branch b = 4 elbow + 2 wrist + shoulder: elbow 1 if q4 is above the stretched angle η − φ (less than half a turn),
wrist 1 if cos q5 < 0, shoulder 1 if q2 < 0. Elbows meet at κ = 0 (stretched) and κ = π, wrists at cos q5 = 0 and at
h = 0, shoulders at sin q2 = 0.

Over intervals, the pose is any in a box, which is widened by PAD: what rounding did to the pose, and by what solutions
from :func:`solve` miss it, is inside. All else is rounded outwards.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._jet_kernels import Range, down, up
from selfmotion.arms._range_kernels import (
    angle_of,
    around,
    common,
    exactly,
    get,
    holds_zero,
    less,
    narrowed,
    negative,
    opposite,
    plus,
    polar,
    product,
    put,
    quotient,
    root,
    rotated,
    squared,
    swept,
    trigonometry,
    widened,
    within,
    wrap,
)

TAU = 2 * np.pi
EMPTY, REGULAR, FOLDED, SINGULAR, MERGED = 0, 1, 2, 3, 4
SLACK = 1e-14  # of the reach: by how much a solution may miss the pose where branches meet
PAD = 2e-14  # of a pose: entries of the rotation, and the position over the reach
_ALL = 3.1415926535897936


@kernel
def branch_of(geometry: FloatArray, q: FloatArray) -> int:
    """Return the branch of a posture."""
    stretched = np.arctan2(geometry[1], geometry[2]) - np.arctan2(geometry[3], geometry[4])
    branch = 4 if np.sin(q[3] - stretched) > 0.0 else 0
    branch += 2 if np.cos(q[4]) < 0.0 else 0
    return branch + (1 if np.sin(q[1]) < 0.0 else 0)


@kernel
def solve(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray, ok: BoolArray
) -> None:
    """Fill in the postures q (8, 7) of all branches at q7 = u, and whether they exist; q is NaN where not.

    Where axes 1 and 3 coincide q1 is 0; q2 is of the sign of its branch.
    """
    d1, d3, a4, d5, a5, a7 = geometry[0], geometry[1], geometry[2], geometry[3], geometry[4], geometry[5]
    e, f = np.sqrt(a4 * a4 + d3 * d3), np.sqrt(a5 * a5 + d5 * d5)
    x, y, z = -position[0], -position[1], d1 - position[2]
    dx = rotation[0, 0] * x + rotation[1, 0] * y + rotation[2, 0] * z
    dy = rotation[0, 1] * x + rotation[1, 1] * y + rotation[2, 1] * z
    c, s = np.cos(u), np.sin(u)
    vx, vz = a7 + dx * c - dy * s, dx * s + dy * c
    vy = -(rotation[0, 2] * x + rotation[1, 2] * y + rotation[2, 2] * z)
    square = vx * vx + vy * vy + vz * vz
    slack = SLACK * (e + f)
    outer, inner = (e + f) ** 2 - square, square - (e - f) ** 2
    ok[:] = False
    q[:] = np.nan
    if not (outer >= -2.0 * slack * (e + f) and inner >= -2.0 * slack * abs(e - f)):
        return
    outer, inner = max(outer, 0.0), max(inner, 0.0)
    stretched = np.arctan2(d3, a4) - np.arctan2(d5, a5)
    kappa = 2.0 * np.arctan2(np.sqrt(outer), np.sqrt(inner))
    cosine, sine = (inner - outer) / (inner + outer), 2.0 * np.sqrt(inner * outer) / (inner + outer)
    away = np.sqrt(vx * vx + vy * vy)
    cv, sv = (vx / away, vy / away) if away > 0.0 else (1.0, 0.0)
    omega = np.arctan2(vy, vx)
    x6x, x6y = rotation[0, 0] * c - rotation[0, 1] * s, rotation[1, 0] * c - rotation[1, 1] * s
    z6x, z6y = rotation[0, 0] * s + rotation[0, 1] * c, rotation[1, 0] * s + rotation[1, 1] * c
    y6x, y6y = -rotation[0, 2], -rotation[1, 2]
    x6z, y6z, z6z = rotation[2, 0] * c - rotation[2, 1] * s, -rotation[2, 2], rotation[2, 0] * s + rotation[2, 1] * c
    for elbow in range(2):
        side = 1.0 if elbow == 1 else -1.0
        # θ = q4 − η = ±κ − φ
        ct = (a5 * cosine + side * d5 * sine) / f
        st = (side * a5 * sine - d5 * cosine) / f
        h, k = -a5 - e * ct, e * st - d5
        c4, s4 = (a4 * ct - d3 * st) / e, (a4 * st + d3 * ct) / e
        radicand, bend = (h - vz) * (h + vz), kappa
        if radicand < 0.0 and not abs(vz) - abs(h) <= slack:
            # Where elbows meet as well, rounding of |v|² moves κ, and h with it, by much more.
            shift = (abs(vz) - abs(h)) / (e * st * side * (-1.0 if h < 0.0 else 1.0))
            if not e * f * abs(shift) * (2.0 * sine + abs(shift)) <= 2.0 * slack * (e + f):
                continue
            bend += shift
            theta = side * bend - np.arctan2(d5, a5)
            ct, st = np.cos(theta), np.sin(theta)
            h, k = -a5 - e * ct, e * st - d5
            c4, s4 = (a4 * ct - d3 * st) / e, (a4 * st + d3 * ct) / e
            radicand = 0.0
        m = np.sqrt(max(radicand, 0.0))
        around, beside = np.sqrt(vz * vz + m * m), np.sqrt(k * k + m * m)
        s5, c5 = (abs(vz) / around, m / around) if around > 0.0 else (0.0, 1.0)
        sm, cm = (k / beside, m / beside) if beside > 0.0 else (0.0, 1.0)
        turn = -1.0 if h < 0.0 else 1.0
        s5 = s5 if (vz < 0.0) == (h < 0.0) else -s5
        q4, q5, q6 = wrap(stretched + side * bend), np.arctan2(turn * vz, m), np.arctan2(k, m)
        for wrist in range(2):
            first = 4 * elbow + 2 * wrist
            # m has the sign of h for wrist 0
            sign = turn if wrist == 0 else -turn
            c6, s6 = sign * cm * cv + sm * sv, sm * cv - sign * cm * sv
            # Frame 3 in frame 6, then in the world.
            along = c5 if wrist == 0 else -c5
            zx, zy, zz = c6 * s4 * along + s6 * c4, c6 * c4 - s6 * s4 * along, s4 * s5
            xx, xy, xz = c6 * c4 * along - s6 * s4, -s6 * c4 * along - c6 * s4, c4 * s5
            yx, yy, yz = c6 * s5, -s6 * s5, -along
            z3x, z3y = zx * x6x + zy * y6x + zz * z6x, zx * x6y + zy * y6y + zz * z6y
            z3z = zx * x6z + zy * y6z + zz * z6z
            x3x, x3y = xx * x6x + xy * y6x + xz * z6x, xx * x6y + xy * y6y + xz * z6y
            y3x, y3y = yx * x6x + yy * y6x + yz * z6x, yx * x6y + yy * y6y + yz * z6y
            s2 = np.sqrt(z3x * z3x + z3y * z3y)
            c1, s1 = (z3x / s2, z3y / s2) if s2 > 0.0 else (1.0, 0.0)
            # Rz(−q1) R03 has the second row (sin q3, cos q3, 0): accurate however small q2 is.
            q1, q2 = np.arctan2(s1, c1), np.arctan2(s2, z3z)
            q3 = np.arctan2(c1 * x3y - s1 * x3x, c1 * y3y - s1 * y3x)
            now5 = q5 if wrist == 0 else (np.pi - q5 if q5 > 0.0 else -np.pi - q5)
            now6 = wrap((q6 if sign > 0.0 else np.pi - q6) - omega)
            for shoulder in range(2):
                b = first + shoulder
                ok[b] = True
                q[b, 0] = q1 if shoulder == 0 else opposite(q1)
                q[b, 1] = q2 if shoulder == 0 else -q2
                q[b, 2] = q3 if shoulder == 0 else opposite(q3)
                q[b, 3], q[b, 4], q[b, 5], q[b, 6] = q4, now5, now6, u


@kernel
def sight(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, rows: FloatArray
) -> tuple[Range, Range, Range, Range]:
    """Enclose the shoulder seen from the wrist, v, and |v|²; fill in the world's axes in frame 6, rows (3, 3, 2)."""
    a7 = geometry[5]
    reach = abs(geometry[0]) + abs(geometry[1]) + abs(geometry[2]) + abs(geometry[3]) + abs(geometry[4]) + abs(a7)
    x = negative(widened(position[0], PAD * reach))
    y = negative(widened(position[1], PAD * reach))
    z = less(exactly(geometry[0]), widened(position[2], PAD * reach))
    columns = np.empty((3, 2))
    for j in range(3):
        put(
            columns,
            j,
            plus(
                plus(product(widened(rotation[0, j], PAD), x), product(widened(rotation[1, j], PAD), y)),
                product(widened(rotation[2, j], PAD), z),
            ),
        )
    across, vz = swept(get(columns, 0), get(columns, 1), u0, u1)
    vx, vy = plus(across, exactly(a7)), negative(get(columns, 2))
    far = plus(plus(squared(x), squared(y)), plus(squared(z), squared(exactly(a7))))
    square = plus(far, product(exactly(2.0 * a7), across))
    for i in range(3):
        one, two = swept(widened(rotation[i, 0], PAD), widened(rotation[i, 1], PAD), u0, u1)
        put(rows[i], 0, one)
        put(rows[i], 1, negative(widened(rotation[i, 2], PAD)))
        put(rows[i], 2, two)
    return vx, vy, vz, square


@kernel
def frame_three(
    rows: FloatArray, four: tuple[Range, Range], five: tuple[Range, Range], six: tuple[Range, Range], axes: FloatArray
) -> None:
    """Enclose the rotation R03, axes (3, 3, 2), from the world in frame 6 and (cos, sin) of the joints between."""
    for i in range(3):
        x, y = rotated(six[0], six[1], get(rows[i], 0), get(rows[i], 1))
        z, x = rotated(five[0], five[1], get(rows[i], 2), x)  # c5 z − s5 x, c5 x + s5 z
        x, y = rotated(four[0], four[1], x, y)
        put(axes[i], 0, within(x, -1.0, 1.0))
        put(axes[i], 1, within(negative(z), -1.0, 1.0))
        put(axes[i], 2, within(y, -1.0, 1.0))


@kernel
def spin(
    four: tuple[Range, Range], five: tuple[Range, Range], six: tuple[Range, Range], r4: Range, r5: Range, r6: Range
) -> tuple[Range, Range, Range]:
    """Enclose the angular velocity Ω of frame 3, in frame 3, that keeps frame 7 at rest while q7 moves at speed 1."""
    c4, s4 = four
    c5, s5 = five
    c6, s6 = six
    one, both = less(r5, c6), plus(product(c5, s6), product(s5, r6))
    x = less(product(s4, one), product(c4, both))
    y = plus(less(r4, product(s5, s6)), product(c5, r6))
    return x, y, negative(plus(product(s4, both), product(c4, one)))


@kernel
def cross(a: Range, b: Range, c: Range, d: Range) -> Range:
    """Return the range of a d − b c."""
    return less(product(a, d), product(b, c))


@kernel
def narrow_axes(axes: FloatArray, middle: FloatArray, omega: tuple[Range, Range, Range], half: float) -> None:
    """Narrow the last row and column of R03 by the mean value theorem, with R03' = R03 [Ω]×."""
    x, y, z = omega
    for i in range(3):
        one, two, three = get(axes[i], 0), get(axes[i], 1), get(axes[i], 2)
        put(axes[i], 2, around(three, get(middle[i], 2), cross(y, x, two, one), half))
        if i == 2:
            put(axes[i], 0, around(one, get(middle[i], 0), cross(z, y, three, two), half))
            put(axes[i], 1, around(two, get(middle[i], 1), cross(x, z, one, three), half))


@kernel
def put_shoulder(axes: FloatArray, box: FloatArray) -> Range:
    """Write joints 1–3 of shoulder 0; return the range of |sin q2|; q1 and q3 are free where it may be 0."""
    x, y, z = get(axes[0], 2), get(axes[1], 2), get(axes[2], 2)
    above, beside = get(axes[2], 0), get(axes[2], 1)
    sine = common(root(plus(squared(x), squared(y))), root(plus(squared(above), squared(beside))))
    if sine[0] <= 0.0 or (holds_zero(x) and holds_zero(y)) or (holds_zero(above) and holds_zero(beside)):
        put(box, 0, (-_ALL, _ALL))
        put(box, 1, angle_of((-sine[1], sine[1]), z))
        put(box, 2, (-_ALL, _ALL))
        return 0.0, sine[1]
    put(box, 0, angle_of(y, x))
    put(box, 1, angle_of(sine, z))
    put(box, 2, angle_of(beside, negative(above)))
    return sine


@kernel
def put_shoulder_rates(axes: FloatArray, omega: tuple[Range, Range, Range], sine: Range, rate: FloatArray) -> None:
    """Write the rates of joints 1–3 of shoulder 0."""
    x, y, z = omega
    # −cos q3, sin q3
    a = within(quotient(get(axes[2], 0), sine), -1.0, 1.0)
    b = within(quotient(get(axes[2], 1), sine), -1.0, 1.0)
    first = quotient(plus(product(a, x), product(b, y)), sine)
    put(rate, 0, first)
    put(rate, 1, cross(b, a, y, x))
    put(rate, 2, less(z, product(get(axes[2], 2), first)))


@kernel
def mirror(box: FloatArray, rate: FloatArray, other: FloatArray, speed: FloatArray) -> None:
    """Write box and rate of shoulder 1 from those of shoulder 0: (q1 ± π, −q2, q3 ± π)."""
    other[:] = box
    speed[:] = rate
    for j in range(0, 3, 2):
        turn = -np.pi if box[j, 0] + box[j, 1] > 0.0 else np.pi
        other[j, 0], other[j, 1] = down(box[j, 0] + turn) - 1e-15, up(box[j, 1] + turn) + 1e-15
    put(other, 1, negative(get(box, 1)))
    put(speed, 1, negative(get(rate, 1)))


@kernel
def elbow_range(outer: Range, inner: Range) -> Range:
    """Return the range of κ, which grows with (e + f)² − |v|² and falls with |v|² − (e − f)²."""
    low = np.arctan2(np.sqrt(max(outer[0], 0.0)), np.sqrt(max(inner[1], 0.0)))
    high = np.arctan2(np.sqrt(max(outer[1], 0.0)), np.sqrt(max(inner[0], 0.0)))
    return max(down(down(2.0 * low)), 0.0), min(up(up(2.0 * high)), _ALL)


@kernel
def follow(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, only: int,
    middle: FloatArray, middle_axes: FloatArray, known: IntArray, is_middle: bool,
    box: FloatArray, rate: FloatArray, axes: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Do what :func:`enclose` says, with R03 of elbow and wrist in axes (4, 3, 3, 2).

    What is `known` of the middle of [u0, u1], its boxes and R03, narrows the result; rates of the middle are not asked
    for. If `only` is not negative, only that elbow and wrist is looked at.
    """
    d3, a4, d5, a5, a7 = geometry[1], geometry[2], geometry[3], geometry[4], geometry[5]
    rows = np.empty((3, 3, 2))
    half = up(max(u1 - 0.5 * (u0 + u1), 0.5 * (u0 + u1) - u0))
    anything = (-np.inf, np.inf)
    state[:] = EMPTY
    vx, vy, vz, square = sight(geometry, rotation, position, u0, u1, rows)
    e, eta = polar(exactly(a4), exactly(d3))
    f, phi = polar(exactly(a5), exactly(d5))
    outer, inner = less(squared(plus(e, f)), square), less(square, squared(less(e, f)))
    if outer[1] < 0.0 or inner[1] < 0.0:
        return
    kappa = elbow_range(outer, inner)
    stretches, closes = outer[0] <= 0.0, inner[0] <= 0.0
    swing = anything
    if not (stretches or closes or is_middle):
        swing = quotient(product(exactly(2.0 * a7), vz), product(root(outer), root(inner)))
    away, omega, stretched = plus(squared(vx), squared(vy)), angle_of(vy, vx), less(eta, phi)
    for elbow in range(2):
        if (stretches or closes) and elbow == 1:
            for b in range(4):
                state[4 + b] = EMPTY if state[b] == EMPTY else MERGED
            break
        bend, r4 = (kappa, swing) if elbow == 1 else (negative(kappa), negative(swing))
        if stretches:
            bend = (-_ALL, _ALL) if closes else (-kappa[1], kappa[1])
        elif closes:
            bend = kappa[0], up(2 * _ALL - kappa[0])
        q4 = plus(stretched, bend)
        four, theta = trigonometry(q4), trigonometry(less(bend, phi))
        ct, st = product(e, theta[0]), product(e, theta[1])
        h, k = negative(plus(exactly(a5), ct)), less(st, exactly(d5))
        radicand = common(product(less(h, vz), plus(h, vz)), less(away, squared(k)))
        if radicand[1] < 0.0:
            continue
        folds = radicand[0] <= 0.0 or holds_zero(h)
        size = root(radicand)
        smooth = not (stretches or closes or folds)
        for wrist in range(2):
            w = 2 * elbow + wrist
            if folds and wrist == 1:
                for b in range(2 * w, 2 * w + 2):
                    state[b] = EMPTY if state[b - 2] == EMPTY else MERGED
                break
            if only not in (-1, w):
                continue
            m = size if (h[0] > 0.0) == (wrist == 0) else negative(size)
            if folds:
                m = -size[1], size[1]
            q5 = (-_ALL, _ALL)
            if h[0] > 0.0:
                q5 = angle_of(vz, m)
            elif h[1] < 0.0:
                q5 = angle_of(negative(vz), negative(m))
            q6 = less(angle_of(k, m), omega)
            r5, r6 = anything, anything
            helped = known[2 * w] == REGULAR or known[2 * w] == SINGULAR
            if smooth and not is_middle:
                s5 = within(quotient(vz, h), -1.0, 1.0)
                r5 = quotient(less(less(vx, exactly(a7)), product(s5, product(st, r4))), m)
                r6 = quotient(plus(product(ct, r4), product(quotient(k, away), product(vx, vz))), m)
                r6 = less(r6, quotient(product(vy, vz), away))
                if helped:
                    q5 = narrowed(q5, get(middle[2 * w], 4), r5, half)
                    q6 = narrowed(q6, get(middle[2 * w], 5), r6, half)
            five, six = trigonometry(q5), trigonometry(q6)
            frame_three(rows, four, five, six, axes[w])
            turns = spin(four, five, six, r4, r5, r6) if smooth and not is_middle else (anything, anything, anything)
            if helped and smooth:
                narrow_axes(axes[w], middle_axes[w], turns, half)
            mine, speed = box[2 * w], rate[2 * w]
            speed[:, 0], speed[:, 1], speed[6, :] = -np.inf, np.inf, 1.0
            put(mine, 3, q4)
            put(mine, 4, q5)
            put(mine, 5, q6)
            put(mine, 6, (u0, u1))
            put(speed, 3, r4)
            put(speed, 4, r5)
            put(speed, 5, r6)
            sine = put_shoulder(axes[w], mine)
            if sine[0] <= 0.0:
                state[2 * w], state[2 * w + 1] = SINGULAR, MERGED
                continue
            state[2 * w] = REGULAR if smooth else FOLDED
            if smooth and not is_middle:
                put_shoulder_rates(axes[w], turns, sine, speed)
                if known[2 * w] == REGULAR:
                    for j in range(3):
                        put(mine, j, narrowed(get(mine, j), get(middle[2 * w], j), get(speed, j), half))
            state[2 * w + 1] = state[2 * w]
            mirror(mine, speed, box[2 * w + 1], rate[2 * w + 1])


@kernel
def follow_twice(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, only: int,
    box: FloatArray, rate: FloatArray, axes: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Do :func:`follow` in the middle of [u0, u1], and with what that tells over all of it."""
    middle, middle_axes, known = np.empty((8, 7, 2)), np.empty((4, 3, 3, 2)), np.zeros(8, np.int64)
    u = 0.5 * (u0 + u1)
    for turn in range(0 if u0 < u1 else 1, 2):
        first = turn == 0
        low, high = (u, u) if first else (u0, u1)
        follow(
            geometry, rotation, position, low, high, only, middle, middle_axes, known, first, box, rate, axes, state
        )  # fmt: skip
        if first:
            middle[:], middle_axes[:] = box, axes
            for b in range(0, 8, 2):
                known[b] = EMPTY if state[b] == FOLDED else state[b]


@kernel
def home(state: IntArray, branch: int) -> int:
    """Return the branch whose box holds the solutions of a branch that is MERGED; itself if it is not."""
    if branch >= 4 and state[4] == MERGED:
        branch -= 4
    if branch & 2 and state[(branch & 4) + 2] == MERGED:
        branch -= 2
    return branch - 1 if branch & 1 and state[branch] == MERGED else branch


@kernel
def enclose(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float,
    box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Enclose the postures of all branches, box (8, 7, 2), for q7 in [u0, u1] and the poses in a box of poses.

    The pose is that of frame 7, rotation (3, 3, 2) and position (3, 2) being lowest and highest entries. A box holds
    one continuous choice of angles, which may reach beyond π. By state (8,),

    - EMPTY: no pose has a solution of this branch;
    - REGULAR: at each pose the branch is smooth, and dq/du lies in rate (8, 7, 2);
    - FOLDED: elbows or wrists may meet, and the box holds the solutions of all that do;
    - SINGULAR: axes 1 and 3 may coincide, q1 and q3 may be anything and q2 is of both signs (and elbows or wrists may
      meet as well); :func:`shoulder` tells more, once q1 is given;
    - MERGED: the box of its :func:`home`, a FOLDED or SINGULAR branch, holds what this has.

    Of FOLDED and SINGULAR branches rates are infinite unless known; of EMPTY and MERGED ones nothing is filled in.
    """
    axes = np.empty((4, 3, 3, 2))
    follow_twice(geometry, rotation, position, u0, u1, -1, box, rate, axes, state)


@kernel
def shoulder(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, branch: int,
    q1_low: float, q1_high: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Enclose the postures of a branch with q1 in [q1_low, q1_high], box (7, 2); return False if there is surely none.

    Made for what :func:`enclose` calls SINGULAR; a MERGED branch is taken for its home. Rz(−q1) R03 = Ry(q2) Rz(q3).
    """
    boxes, rates, state = np.empty((8, 7, 2)), np.empty((8, 7, 2)), np.empty(8, np.int64)
    all_axes = np.empty((4, 3, 3, 2))
    follow_twice(geometry, rotation, position, u0, u1, branch // 2, boxes, rates, all_axes, state)
    if state[branch] == EMPTY or state[branch] == MERGED:
        follow_twice(geometry, rotation, position, u0, u1, -1, boxes, rates, all_axes, state)
        branch = home(state, branch)
        if state[branch] == EMPTY:
            return False
    axes = all_axes[branch // 2]
    box[:] = boxes[branch]
    put(box, 0, (q1_low, q1_high))
    c, s = trigonometry((q1_low, q1_high))
    sine, level = rotated(c, negative(s), get(axes[0], 2), get(axes[1], 2))
    if state[branch] != SINGULAR:
        sine = common(sine, (0.0, 1.0) if branch % 2 == 0 else (-1.0, 0.0))
        if sine[0] > sine[1]:
            return False
    _, one = rotated(c, negative(s), get(axes[0], 0), get(axes[1], 0))
    _, two = rotated(c, negative(s), get(axes[0], 1), get(axes[1], 1))
    if not holds_zero(level) or one[0] > 1.0 or one[1] < -1.0 or two[0] > 1.0 or two[1] < -1.0:
        return False
    put(box, 1, angle_of(sine, get(axes[2], 2)))
    put(box, 2, angle_of(one, two))
    return True


@kernel
def turned(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, branch: int, joint: int,
    low: float, high: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow the box of a branch to where q1, the only joint it can be asked for, lies in [low, high]."""
    return shoulder(geometry, rotation, position, u0, u1, branch, low, high, box)


@kernel
def parameter_of(geometry: FloatArray, q: FloatArray) -> float:
    """Return q7."""
    return q[6]
