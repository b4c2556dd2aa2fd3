"""The closed forms of spatial arms, chosen by number: compiled code cannot be handed functions and be kept on disk."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms import _panda_kernels as panda
from selfmotion.arms import _srs_kernels as srs
from selfmotion.arms import _ur_kernels as ur
from selfmotion.arms import _wrist_kernels as wrist

PANDA, SRS, WRIST, UR = 0, 1, 2, 3
BRANCHES = 8
_FULL = 6.28  # a joint's box at least this wide is a whole turn


@kernel
def solve_branches(
    family: int, geometry: FloatArray, rotation: FloatArray, position: FloatArray, u: float, q: FloatArray,
    ok: BoolArray,
) -> None:  # fmt: skip
    """Fill in the posture on every branch (8, n), and which there are."""
    if family == PANDA:
        panda.solve(geometry, rotation, position, u, q, ok)
    elif family == SRS:
        srs.solve(geometry, rotation, position, u, q, ok)
    elif family == WRIST:
        wrist.solve(geometry, rotation, position, u, q, ok)
    else:
        ur.solve(geometry, rotation, position, u, q, ok)


@kernel
def solve_all(
    family: int, geometry: FloatArray, rotations: FloatArray, positions: FloatArray, u: FloatArray, branch: int,
    q: FloatArray, ok: BoolArray,
) -> None:  # fmt: skip
    """Fill in the postures (k, n) on one branch at k poses, and which there are."""
    every, there = np.empty((BRANCHES, q.shape[1])), np.empty(BRANCHES, np.bool_)
    for k in range(len(u)):
        solve_branches(family, geometry, rotations[k], positions[k], u[k], every, there)
        ok[k] = there[branch]
        if ok[k]:
            q[k] = every[branch]


@kernel
def parameter_all(family: int, geometry: FloatArray, q: FloatArray, u: FloatArray) -> None:
    """Fill in the redundancy parameters of postures (k, n), of arms where these are a matter of the joints alone."""
    for k in range(len(q)):
        u[k] = q[k, 6] if family == PANDA else srs.arm_angle(geometry, q[k])


@kernel
def branch_all(family: int, geometry: FloatArray, q: FloatArray, branch: IntArray) -> None:
    """Fill in the branches of postures (k, n)."""
    for k in range(len(q)):
        if family == PANDA:
            branch[k] = panda.branch_of(geometry, q[k])
        elif family == SRS:
            branch[k] = srs.branch_of(q[k])
        elif family == WRIST:
            branch[k] = wrist.branch_of(geometry, q[k])
        else:
            branch[k] = ur.branch_of(geometry, q[k])


@kernel
def enclose_branches(
    family: int, geometry: FloatArray, rotation: FloatArray, position: FloatArray, low: float, high: float,
    box: FloatArray, rate: FloatArray, state: IntArray,
) -> None:  # fmt: skip
    """Enclose the postures of every branch, box and rate (8, n, 2), and say what they are."""
    if family == PANDA:
        panda.enclose(geometry, rotation, position, low, high, box, rate, state)
    elif family == SRS:
        srs.enclose(geometry, rotation, position, low, high, box, rate, state)
    elif family == WRIST:
        wrist.enclose(geometry, rotation, position, low, high, box, rate, state)
    else:
        ur.enclose(geometry, rotation, position, low, high, box, rate, state)


@kernel
def free_joint(family: int, which: int) -> int:
    """Return the joint that tells the others where the shoulder (which = 0) or wrist (1) is singular, −1 if none is."""
    if which == 0:
        return -1 if family == UR else 0
    if family == SRS:
        return 4
    return -1 if family == PANDA else 3 if family == WRIST else 5


@kernel
def is_free(family: int, box: FloatArray, which: int) -> bool:
    """Return whether the joint that tells where shoulder or wrist are may be anywhere."""
    joint = free_joint(family, which)
    return joint >= 0 and bool(box[joint, 1] - box[joint, 0] > _FULL)


@kernel
def enclose_sector(
    family: int, geometry: FloatArray, rotation: FloatArray, position: FloatArray, low: float, high: float,
    branch: int, which: int, sector: int, sectors: int, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow a box to one of the `sectors` of a shoulder or wrist that is free; return whether any may be in it."""
    width = 2 * np.pi / sectors
    start = -np.pi + sector * width
    return enclose_interval(family, geometry, rotation, position, low, high, branch, which, start, start + width, box)


@kernel
def enclose_interval(
    family: int, geometry: FloatArray, rotation: FloatArray, position: FloatArray, low: float, high: float,
    branch: int, which: int, start: float, stop: float, box: FloatArray,
) -> bool:  # fmt: skip
    """Narrow a box to where a shoulder or wrist that is free is in [start, stop]; return whether there may be any."""
    if family == PANDA:
        return panda.shoulder(geometry, rotation, position, low, high, branch, start, stop, box)
    joint = free_joint(family, which)
    if family == SRS:
        return srs.turned(geometry, rotation, position, low, high, branch, joint, start, stop, box)
    if family == WRIST:
        return wrist.turned(geometry, rotation, position, low, high, branch, joint, start, stop, box)
    return ur.turned(geometry, rotation, position, low, high, branch, joint, start, stop, box)
