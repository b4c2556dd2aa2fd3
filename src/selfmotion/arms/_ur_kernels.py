"""Six joints like Universal Robots' arms, axes 2, 3 and 4 parallel, the tool free to roll: closed form and enclosed.

The frame after joint 6 is, with the lengths [a2, a3, d4, d5] of the published Denavit–Hartenberg parameters (a2 and a3
taken as positive; d1 belongs to the base and d6 to the tool),

    T = Rz(q1) Rx(π/2) · Rz(q2) Tx(a2) · Rz(q3) Tx(a3) · Rz(q4) Tz(d4) Rx(π/2) · Rz(q5) Tz(d5) Rx(−π/2) · Rz(q6).

The task leaves the tool free to turn about its own z axis, and the
parameter is that angle u: T = X Rz(u) tool⁻¹, where X is the pose, in the base of T. A *geometry* is the lengths, the
rotation of tool⁻¹ row by row, and its position.

With the origin W = (x, y, z) of T and m = ±√(x² + y² − d4²), Rz(−q1) W = (m, −d4, z). In coordinates along the plane of
the arm and across it, the rotation is Rz(φ) Ry(−q5) Rz(q6), φ = q2 + q3 + q4, which gives these angles, and a2 and a3,
bent by q3, reach (m − d5 sin φ, z + d5 cos φ). Branch 4 shoulder + 2 wrist + elbow has these bits where m, sin q5 and
sin q3 are negative.

Shoulders meet at m = 0, elbows at q3 = 0 and q3 = π, wrists at sin q5 = 0, where q6, and q2, q3, q4 with it, are free.

Over intervals, the pose is widened and rounding is outwards as in the arms with a spherical wrist.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._elementary_kernels import arctan2
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms._jet_kernels import Range
from selfmotion.arms._panda_kernels import (
    mirror,
    put_shoulder,
    put_shoulder_rates,
)
from selfmotion.arms._range_kernels import (
    angle_of,
    exactly,
    get,
    holds_zero,
    less,
    meet,
    narrowed,
    negative,
    opposite,
    plus,
    product,
    put,
    squared,
    trigonometry,
    wrap,
)
from selfmotion.arms._roots import EMPTY, FOLDED, MERGED, REGULAR, SINGULAR
from selfmotion.arms._wrist_kernels import (
    SLACK,
    blended,
    both_elbows,
    first_joint,
    flange,
    home,
    level,
    roll_between,
    side_of,
    sight,
    turn,
    two_links,
)

__all__ = ["LENGTHS", "branch_of", "enclose", "home", "roll", "solve", "turned"]

LENGTHS = 4
_ALL = 3.1415926535897936  # π, rounded up


@kernel
def roll(geometry: FloatArray, rotation: FloatArray, q: FloatArray) -> float:
    """Return u in [−π, π] of a posture q (6,): the angle about z by which its tool is turned from the rotation (3, 3).

    Of a posture that does not do the task it is the roll that comes nearest to its tool's rotation.
    """
    flanged = np.eye(3)
    turn(flanged, 2, q[0])
    turn(flanged, 0, 0.5 * np.pi)
    turn(flanged, 2, q[1] + q[2] + q[3])
    turn(flanged, 1, -q[4])
    turn(flanged, 2, q[5])
    return roll_between(geometry[LENGTHS:], rotation, flanged)


@kernel
def branch_of(geometry: FloatArray, q: FloatArray) -> int:
    """Return the branch of a posture."""
    m = geometry[0] * np.cos(q[1]) + geometry[1] * np.cos(q[1] + q[2]) + geometry[3] * np.sin(q[1] + q[2] + q[3])
    return 4 * int(m < 0.0) + 2 * int(np.sin(q[4]) < 0.0) + int(np.sin(q[2]) < 0.0)


@kernel
def solve(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray, ok: BoolArray
) -> None:
    """Fill in the postures q (8, 6) of all branches at the roll u, and whether they exist; q is NaN where not.

    Where q5 = 0 or π exactly, the posture is that with q2 + q3 + q4 = 0 or π, if there is one.
    """
    a2, a3, d4, d5 = geometry[0], geometry[1], geometry[2], geometry[3]
    slack = SLACK * (a2 + a3 + abs(d4) + abs(d5))
    r00, r01, r02, r10, r11, r12, r20, r21, r22, px, py, pz = flange(geometry[LENGTHS:], rotation, position, u)
    ok[:] = False
    q[:] = np.nan
    away, offset = np.sqrt(px * px + py * py), abs(d4)
    if not away >= offset - slack:
        return
    size = np.sqrt(max((away - offset) * (away + offset), 0.0))
    longest, shortest = a2 + a3, abs(a2 - a3)
    for shoulder in range(2):
        m = size if shoulder == 0 else -size
        x, y = m * px - d4 * py, m * py + d4 * px
        r = np.sqrt(x * x + y * y)
        c1, s1 = (x / r, y / r) if r > 0.0 else (1.0 - 2.0 * shoulder, 0.0)
        q1 = arctan2(s1, c1)
        xx, xy, xz = c1 * r00 + s1 * r10, c1 * r01 + s1 * r11, c1 * r02 + s1 * r12
        yz = c1 * r12 - s1 * r02
        # Rz(φ) Ry(−q5) Rz(q6) has the rows (xx, xy, xz), (r20, r21, r22) and (·, ·, −yz).
        r = np.sqrt(xz * xz + r22 * r22)
        c, s = (-xz / r, -r22 / r) if r > 0.0 else (1.0, 0.0)
        phi, q5 = arctan2(s, c), arctan2(r, -yz)
        # Rz(−φ) times that, with q5 for −q5, has the second row (sin q6, cos q6, 0): accurate however small q5 is.
        q6 = arctan2(c * r20 - s * xx, c * r21 - s * xy)
        for wrist in range(2):
            side5 = 1.0 - 2.0 * wrist
            if wrist == 1:
                phi, q5, q6 = opposite(phi), -q5, opposite(q6)
            x, y = m - d5 * side5 * s, pz + d5 * side5 * c
            d = np.sqrt(x * x + y * y)
            if not shortest - slack <= d <= longest + slack:
                continue
            outer, inner = max((longest - d) * (longest + d), 0.0), max((d - shortest) * (d + shortest), 0.0)
            top, bottom, total = np.sqrt(outer), np.sqrt(inner), outer + inner
            kappa, ck, sk = 2.0 * arctan2(top, bottom), (inner - outer) / total, 2.0 * top * bottom / total
            along, across = a2 + a3 * ck, a3 * sk
            for elbow in range(2):
                side = 1.0 - 2.0 * elbow
                b = 4 * shoulder + 2 * wrist + elbow
                q2 = arctan2(y * along - x * side * across, x * along + y * side * across)
                q3 = side * kappa
                ok[b] = True
                q[b, 0], q[b, 1], q[b, 2] = q1, q2, q3
                q[b, 3], q[b, 4], q[b, 5] = wrap(phi - q2 - q3), q5, q6


@kernel
def wrist_axes(rows: FloatArray, q1: Range, plane: FloatArray, axes: FloatArray) -> None:
    """Enclose Rz(φ) Ry(q5) Rz(q6) in axes (3, 3, 2): the frame in the arm's plane, with x and y turned about."""
    level(rows, q1, plane)
    for j in range(3):
        put(axes[0], j, get(plane[0], j) if j < 2 else negative(get(plane[0], j)))
        put(axes[1], j, get(rows[2], j) if j < 2 else negative(get(rows[2], j)))
        put(axes[2], j, get(plane[1], j) if j < 2 else negative(get(plane[1], j)))


@kernel
def target(m: Range, z: Range, d5: float, phi: Range) -> tuple[Range, Range, Range, Range]:
    """Enclose what a2 and a3 have to reach, and d5 cos φ and d5 sin φ."""
    c, s = trigonometry(phi)
    c, s = product(exactly(d5), c), product(exactly(d5), s)
    return less(m, s), plus(z, c), c, s


@kernel
def follow(
    geometry: FloatArray, spin: FloatArray, rows: FloatArray, place: FloatArray, motion: FloatArray, half: float,
    is_middle: bool, notes: FloatArray, box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Do what :func:`enclose` says for frames of which rows, place and motion are known, and `spin` (3,).

    The latter is how fast they turn as u grows, seen from themselves.

    In the middle of an interval `notes` (8, 9, 2) are taken: the joints, m, φ and q2 + q3. They narrow what is found
    for all of it. A shoulder's q1, m, φ, q5 and q6 are noted with its first branch.
    """
    a2, a3, d4, d5 = geometry[0], geometry[1], geometry[2], geometry[3]
    anything = (-np.inf, np.inf)
    state[:] = EMPTY
    px, py, pz = get(place, 0), get(place, 1), get(place, 2)
    radicand = less(plus(squared(px), squared(py)), squared(exactly(d4)))
    if radicand[1] < 0.0:
        return
    folds = radicand[0] <= 0.0
    base, base_speed = np.empty((2, 2)), np.empty((2, 2))
    planar, planar_speed = np.empty((2, 3, 2)), np.empty((2, 3, 2))
    plane, axes = np.empty((2, 3, 2)), np.empty((3, 3, 2))
    turns, spins = np.empty((2, 3, 2)), np.empty((2, 3, 2))
    for shoulder in range(2):
        first = 4 * shoulder
        if folds and shoulder == 1:
            for b in range(4):
                state[4 + b] = EMPTY if state[b] == EMPTY else MERGED
            break
        helped = not (is_middle or folds)
        base_speed[:, 0], base_speed[:, 1] = -np.inf, np.inf
        spins[:, :, 0], spins[:, :, 1] = -np.inf, np.inf
        was = notes[first]
        first_joint(place, motion, -d4, shoulder, folds, helped, half, get(was, 0), get(was, 6), base, base_speed)
        q1, m, r1, rm = get(base, 0), get(base, 1), get(base_speed, 0), get(base_speed, 1)
        wrist_axes(rows, q1, plane, axes)
        sine = put_shoulder(axes, turns[0])
        free = sine[0] <= 0.0
        if helped and not free:
            omega_x = less(product(r1, get(rows[2], 0)), exactly(spin[0]))
            omega_y = less(product(r1, get(rows[2], 1)), exactly(spin[1]))
            omega_z = less(exactly(spin[2]), product(r1, get(rows[2], 2)))
            put_shoulder_rates(axes, (omega_x, omega_y, omega_z), sine, spins[0])
            put(turns[0], 0, narrowed(get(turns[0], 0), get(was, 7), get(spins[0], 0), half))
            put(turns[0], 1, narrowed(get(turns[0], 1), get(was, 4), get(spins[0], 1), half))
            put(turns[0], 2, narrowed(get(turns[0], 2), get(was, 5), get(spins[0], 2), half))
        if is_middle:
            put(was, 0, q1)
            put(was, 6, m)
            put(was, 7, get(turns[0], 0))
            put(was, 4, get(turns[0], 1))
            put(was, 5, get(turns[0], 2))
        mirror(turns[0], spins[0], turns[1], spins[1])
        for wrist in range(2):
            w = first + 2 * wrist
            if free and wrist == 1:
                for b in range(2):
                    state[w + b] = EMPTY if state[first + b] == EMPTY else MERGED
                break
            phi, r = get(turns[wrist], 0), get(spins[wrist], 0)
            x, y, c, s = target(m, pz, d5, phi)
            smooth = helped and not free
            dx, dy = anything, anything
            if smooth:
                dx, dy = less(rm, product(c, r)), less(get(motion, 2), product(s, r))
            kind = two_links(a2, exactly(a3), x, y, dx, dy, smooth, planar, planar_speed)
            for elbow in range(2):
                b = w + elbow
                if kind == EMPTY:
                    break
                if kind == FOLDED and elbow == 1:
                    state[b] = MERGED
                    break
                mine, speed, was = box[b], rate[b], notes[b]
                speed[:, 0], speed[:, 1] = -np.inf, np.inf
                state[b] = SINGULAR if free or (folds and d4 == 0.0) else FOLDED if folds or kind == FOLDED else REGULAR
                q2, q3, q23 = get(planar[elbow], 0), get(planar[elbow], 1), get(planar[elbow], 2)
                q4 = (-_ALL, _ALL) if free else less(phi, q23)
                if smooth:
                    put(speed, 0, r1)
                    put(speed, 4, get(spins[wrist], 1))
                    put(speed, 5, get(spins[wrist], 2))
                if smooth and kind == REGULAR:
                    r2, r3, r23 = get(planar_speed[elbow], 0), get(planar_speed[elbow], 1), get(planar_speed[elbow], 2)
                    q2 = narrowed(q2, get(was, 1), r2, half)
                    q3 = narrowed(q3, get(was, 2), r3, half)
                    q23 = narrowed(q23, get(was, 8), r23, half)
                    r4 = less(r, r23)
                    q4 = narrowed(less(phi, q23), get(was, 3), r4, half)
                    put(speed, 1, r2)
                    put(speed, 2, r3)
                    put(speed, 3, r4)
                put(mine, 0, q1)
                put(mine, 1, q2)
                put(mine, 2, q3)
                put(mine, 3, q4)
                put(mine, 4, get(turns[wrist], 1))
                put(mine, 5, get(turns[wrist], 2))
                if is_middle:
                    was[1:4] = mine[1:4]
                    put(was, 8, q23)


@kernel
def size_of(geometry: FloatArray) -> float:
    """Return how long the arm is, without its base and its tool."""
    return geometry[0] + geometry[1] + abs(geometry[2]) + abs(geometry[3])


@kernel
def follow_frames(
    geometry: FloatArray, spin: FloatArray, rows: FloatArray, place: FloatArray, motion: FloatArray, half: float,
    box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Do what :func:`enclose` says for frames that :func:`sight` enclosed: in the middle, then all over."""
    notes = np.empty((8, 9, 2))
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
    - SINGULAR: sin q5 may be 0: q4 and q6 have the box [−π, π], q5 is of both signs, and q2 and q3 hold what any q6
      makes of them (and branches may meet as well); :func:`turned` tells more, once q6 is given;
    - MERGED: the box of its :func:`home`, a FOLDED or SINGULAR branch, holds what this has.

    Of FOLDED and SINGULAR branches rates are infinite unless known; what is in the rows of
    EMPTY and MERGED ones means nothing.
    """
    rows, place, motion = np.empty((2, 3, 3, 2)), np.empty((2, 3, 2)), np.empty((3, 2))
    half = sight(geometry[LENGTHS:], rotation, position, size_of(geometry), u0, u1, rows, place, motion)
    follow_frames(geometry, geometry[LENGTHS + 6 : LENGTHS + 9], rows, place, motion, half, box, rate, state)


@kernel
def turned(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, u0: float, u1: float, branch: int, joint: int,
    low: float, high: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow the box (6, 2) of a SINGULAR branch to where q6 (joint 5) lies in [low, high].

    The box is narrowed from what it is, and stays right for any branch that was merged into this one. Return False if
    there is certainly no such posture. With q6 given, Rz(φ) Ry(q5) says φ and q5 without a division, and the upper arm
    and forearm reach what they then must. Given any other joint, that joint is narrowed only.
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
    if not meet(box[joint], low, high):
        return False
    if joint != 5:
        return True
    plane, axes, planar = np.empty((2, 3, 2)), np.empty((3, 3, 2)), np.empty((2, 3, 2))
    wrist_axes(rows, get(box, 0), plane, axes)
    c, s = trigonometry(get(box, 5))
    zero = blended(c, get(axes[2], 1), s, get(axes[2], 0))
    if not holds_zero(zero):
        return False
    sine_5, cosine_5 = blended(s, get(axes[2], 1), negative(c), get(axes[2], 0)), get(axes[2], 2)
    sine = blended(negative(c), get(axes[0], 1), negative(s), get(axes[0], 0))
    five, phi = angle_of(sine_5, cosine_5), angle_of(sine, blended(c, get(axes[1], 1), s, get(axes[1], 0)))
    if not meet(box[4], five[0], five[1]):
        return False
    c, s = trigonometry(get(box, 0))
    px, py, pz = get(place, 0), get(place, 1), get(place, 2)
    x, y, c, s = target(plus(product(c, px), product(s, py)), pz, geometry[3], phi)
    kind = two_links(geometry[0], exactly(geometry[1]), x, y, x, y, False, planar, planar)
    if kind == EMPTY:
        return False
    elbow = branch & 1
    if kind == REGULAR and side_of(get(box, 2)) == 0:
        both_elbows(planar)
        elbow = 0
    if kind == FOLDED:
        elbow = 0
    q4 = less(phi, get(planar[elbow], 2))
    return (
        meet(box[1], planar[elbow, 0, 0], planar[elbow, 0, 1])
        and meet(box[2], planar[elbow, 1, 0], planar[elbow, 1, 1])
        and meet(box[3], q4[0], q4[1])
    )


@kernel
def parameter_of(geometry: FloatArray, q: FloatArray) -> float:
    """Return NaN: a roll is counted from a frame that the posture's tool decides."""
    return np.nan
