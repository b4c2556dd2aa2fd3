"""The feasible arm angles of one branch of an S-R-S arm as arcs whose ends are exact (Shimizu et al. 2008).

A joint meets a limit where ``a cos ψ + b sin ψ + c = 0``, and so does a shoulder or wrist pass its singularity.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms._srs_kernels import TAU, posture, solve_one

_TANGENT = 2e-15  # what the equation of a limit, of terms of at most 1, may be missed by and count as touched
_NEAREST = 1e-12  # arm angles that count as one
_ROOM, _ROUNDING = 1e-9, 2e-15  # what a joint may be outside its limits by at an isolated point, and elsewhere
_ROOTS = 40  # the most ends of feasible arcs: 4 of each of six joints, 2 singular points of shoulder and wrist
_CUT = 1e-11  # sine of q2 or q6 below which a curve counts as passing through the singularity


@kernel
def add_roots(a: float, b: float, c: float, cut: bool, roots: FloatArray, cuts: BoolArray, count: int) -> int:
    """Append the solutions ψ of a cos ψ + b sin ψ + c = 0, a double one twice; return how many there are now."""
    r = np.hypot(a, b)
    if abs(c) > r + _TANGENT or r == 0.0:
        return count
    center, half = np.arctan2(b, a), 2.0 * np.arctan2(np.sqrt(max(r + c, 0.0)), np.sqrt(max(r - c, 0.0)))
    for side in (-1.0, 1.0):
        root = center + side * half
        roots[count], cuts[count] = root - TAU * np.floor((root + np.pi) / TAU), cut
        count += 1
    return count


@kernel
def joint_fits(angle: float, low: float, high: float, room: float) -> bool:
    """Return whether the angle, moved by whole turns, lies in [low, high], give or take `room`."""
    if high - low >= TAU:
        return True
    return angle + TAU * np.ceil((low - room - angle) / TAU) <= high + room


@kernel
def fits(q: FloatArray, lower: FloatArray, upper: FloatArray, room: float, shoulder: bool, wrist: bool) -> bool:
    """Return whether a posture is within its limits; at a singular shoulder or wrist, whether one of the line is."""
    for side in range(2):
        i, j, k = (0, 1, 2) if side == 0 else (4, 5, 6)
        if not joint_fits(q[j], lower[j], upper[j], room):
            return False
        if not (wrist if side == 1 else shoulder):
            if not (joint_fits(q[i], lower[i], upper[i], room) and joint_fits(q[k], lower[k], upper[k], room)):
                return False
        elif abs(q[j]) < 1.0:  # the sum of the two stays
            if not joint_fits(q[i] + q[k], lower[i] + lower[k], upper[i] + upper[k], room):
                return False
        elif not joint_fits(q[i] - q[k], lower[i] - upper[k], upper[i] - lower[k], room):
            return False
    return joint_fits(q[3], lower[3], upper[3], room)


@kernel
def limit_roots(
    basis: FloatArray, c: float, s: float, lower: FloatArray, upper: FloatArray, wrist: bool, roots: FloatArray,
    cuts: BoolArray, count: int,
) -> int:  # fmt: skip
    """Append where the angles t1, t2, t3 of shoulder or wrist meet a limit, and where t2 is 0 or π."""
    n, a, b = basis[0], basis[1], basis[2]
    for j in range(3):
        joint = 6 - j if wrist else j
        if upper[joint] - lower[joint] >= TAU:
            continue
        for side in range(2):
            limit = lower[joint] if side == 0 else upper[joint]
            if not np.isfinite(limit):
                continue
            cosine, sine = np.cos(limit), -np.sin(limit) if wrist else np.sin(limit)
            if j == 0:  # z across (cos t1, sin t1)
                p, r, constant = (
                    s * (a[1] * cosine - a[0] * sine),
                    s * (b[1] * cosine - b[0] * sine),
                    c * (n[1] * cosine - n[0] * sine),
                )
            elif j == 1:
                p, r, constant = s * a[2], s * b[2], c * n[2] - cosine
            else:  # k_z cos t3 + x_z sin t3
                p, r, constant = (
                    b[2] * cosine + c * a[2] * sine,
                    c * b[2] * sine - a[2] * cosine,
                    -s * n[2] * sine,
                )
            count = add_roots(p, r, constant, False, roots, cuts, count)
    peak = np.arctan2(s * b[2], s * a[2])
    for _ in range(2):
        cosine, sine = np.cos(peak), np.sin(peak)
        x = c * n[0] + s * (a[0] * cosine + b[0] * sine)
        y = c * n[1] + s * (a[1] * cosine + b[1] * sine)
        if x * x + y * y <= _CUT**2:
            roots[count], cuts[count] = peak - TAU * np.floor((peak + np.pi) / TAU), True
            count += 1
        peak += np.pi
    return count


@kernel
def feasible_arcs(
    geometry: FloatArray, rotation: FloatArray, position: FloatArray, lower: FloatArray, upper: FloatArray,
    branch: int, arcs: FloatArray,
) -> int:  # fmt: skip
    """List the arm angles at which a branch keeps its limits, as arcs (k, 2) = [start, stop]; return how many.

    Starts ascend from −π, and stop may pass π; [−π, π] is the whole circle. A joint fits if some whole number of turns
    brings it between its limits. Where q2 or q6 passes through zero the branch jumps, and arcs that touch meet there.
    An arc of length zero is a limit touched from outside, or a singular point that is feasible while its neighbours are
    not. Ends are the roots of a cos ψ + b sin ψ + c = 0. With more arcs than rows, only the count goes on. Where
    n is parallel to v there is no arm angle, and no arc.
    """
    q, side = np.empty(7), np.empty(7)
    basis, local = np.empty((3, 3)), np.empty((3, 3))
    roots, cuts = np.empty(_ROOTS), np.zeros(_ROOTS, np.bool_)
    if not posture(geometry, rotation, position, 0.0, q) or not joint_fits(
        -q[3] if branch & 4 else q[3], lower[3], upper[3], _ROUNDING
    ):
        return 0
    d = 0.0
    for i in range(3):
        basis[0, i] = position[i] - (geometry[0] if i == 2 else 0.0)
        d += basis[0, i] ** 2
    d = np.sqrt(d)
    basis[0] /= d
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        basis[2, i] = basis[0, j] * geometry[3 + k] - basis[0, k] * geometry[3 + j]
    basis[2] /= np.sqrt(basis[2, 0] ** 2 + basis[2, 1] ** 2 + basis[2, 2] ** 2)
    for v in (1, 2):  # a = b × n, b = n × a
        one, two = (basis[2], basis[0]) if v == 1 else (basis[0], basis[1])
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            side[i] = one[j] * two[k] - one[k] * two[j]
        basis[v] = side[:3]
    for v in range(3):
        for j in range(3):
            local[v, j] = basis[v, 0] * rotation[0, j] + basis[v, 1] * rotation[1, j] + basis[v, 2] * rotation[2, j]
    link, fore = geometry[1], geometry[2]
    outer, inner, skew = link + fore, abs(link - fore), (link - fore) * (link + fore)
    product = np.sqrt(max((outer - d) * (outer + d), 0.0)) * np.sqrt(max((d - inner) * (d + inner), 0.0))
    c, s = (d * d + skew) / (2.0 * link * d), product / (2.0 * link * d)
    count = limit_roots(basis, c, s, lower, upper, False, roots, cuts, 0)
    c, s = (d * d - skew) / (2.0 * fore * d), -product / (2.0 * fore * d)
    before = count
    count = limit_roots(local, c, s, lower, upper, True, roots, cuts, count)
    of_wrist = np.zeros(_ROOTS, np.bool_)
    of_wrist[before:count] = True

    order = np.argsort(roots[:count])
    many = 0  # roots nearer than _NEAREST to one another are one
    spot, free = np.empty(count + 1), np.zeros((count + 1, 2), np.bool_)
    for i in order:
        if many == 0 or roots[i] - spot[many - 1] > _NEAREST:
            spot[many] = roots[i]
            many += 1
        if cuts[i]:
            free[many - 1, 1 if of_wrist[i] else 0] = True
            spot[many - 1] = roots[i]
    if many > 1 and spot[0] + TAU - spot[many - 1] <= _NEAREST:
        many -= 1
        free[0, 0], free[0, 1] = free[0, 0] or free[many, 0], free[0, 1] or free[many, 1]
    if many == 0:
        solve_one(geometry, rotation, position, 0.0, branch, q)
        if not fits(q, lower, upper, _ROUNDING, False, False):
            return 0
        if len(arcs) > 0:
            arcs[0, 0], arcs[0, 1] = -np.pi, np.pi
        return 1
    inside, touched = np.empty(many, np.bool_), np.empty(many, np.bool_)
    for i in range(many):
        stop = spot[i + 1] if i + 1 < many else spot[0] + TAU
        solve_one(geometry, rotation, position, 0.5 * (spot[i] + stop), branch, q)
        inside[i] = fits(q, lower, upper, _ROUNDING, False, False)
        solve_one(geometry, rotation, position, spot[i], branch, q)
        touched[i] = fits(q, lower, upper, _ROOM, free[i, 0], free[i, 1])
    return join(spot[:many], free, inside, touched, arcs)


@kernel
def join(spot: FloatArray, free: BoolArray, inside: BoolArray, touched: BoolArray, arcs: FloatArray) -> int:
    """Join feasible pieces [spot[i], spot[i + 1]] of the circle to arcs, except across singular points."""
    many, count = len(spot), 0
    for i in range(many):
        before, cut = inside[i - 1], free[i, 0] or free[i, 1]
        if not inside[i]:
            if touched[i] and not before:
                if count < len(arcs):
                    arcs[count, 0], arcs[count, 1] = spot[i], spot[i]
                count += 1
            continue
        if before and not cut:
            continue  # begun earlier, maybe before −π
        j, length = i, 0
        while length < many and inside[j]:
            j, length = (j + 1) % many, length + 1
            if free[j, 0] or free[j, 1]:
                break
        if count < len(arcs):
            arcs[count, 0] = spot[i]
            arcs[count, 1] = spot[j] + TAU if j <= i else spot[j]
        count += 1
    if count == 0 and inside[0]:
        if len(arcs) > 0:
            arcs[0, 0], arcs[0, 1] = -np.pi, np.pi
        return 1
    return count
