"""Rows on the path: put there, filled in between until their steps are small, smoothed.

Everything here works in joint space with the Jacobian, which is regular at folds: no branch is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import RedundantArm
from selfmotion.constrained import constraints_of, keeps_constraints
from selfmotion.problem import Problem

SAME = 1e-5
"""Postures nearer to each other than this are one [rad]."""
HELD = 1e-9
"""Overrun of a limit allowed [rad]."""
# Largest joint step between two rows [rad].
_STEP = 0.06
_SMOOTHINGS = 100
_STILL = 1e-9  # what counts as a step in r where the tool stands still
_HALVINGS = 14
_SHRINKS = 0.8
_NEWTON = 30
_ON_PATH = 1e-12  # of the reach
_CLEAR = 1e-6  # part of its scale to which a constraint that was broken is kept


def on_path(problem: Problem, r: FloatArray, q: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Move postures to the nearest ones that do their task inside the limits, by Newton's method.

    A posture that breaks a constraint beyond joint limits is moved, by the shortest way to first order, to where its
    worst margin is kept.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)

    Returns
    -------
    q : array, shape (k, n)
    ok : array of bool, shape (k,)
        Whether task, limits, further constraints and elbow hold there.
    """
    arm, x = problem.arm, problem.path(r)
    q, free = q.copy(), np.ones(q.shape)
    for _ in range(2):  # the second time with joints that left their limits held on them
        for _ in range(_NEWTON):
            lack, jacobian = _rows_to_meet(arm, arm.task_residual(q, x), arm.jacobian(q), q)
            if not (np.abs(lack).max(axis=-1, initial=0.0) > _ON_PATH * arm.reach).any():
                break
            jacobian = jacobian * free[:, None, :]
            square = jacobian @ np.swapaxes(jacobian, -1, -2)
            square += 1e-14 * arm.reach**2 * np.eye(square.shape[-1])  # at singular postures
            step = np.swapaxes(jacobian, -1, -2) @ np.linalg.solve(square, lack[..., None])
            q += np.clip(step[..., 0], -0.5, 0.5)
        held = (arm.limits.margin(q) < 0) & (free > 0)
        if not held.any():
            break
        free[held] = 0.0
        q = np.clip(q, arm.limits.lower, arm.limits.upper)
    miss = np.abs(arm.task_residual(q, x)).max(axis=-1, initial=0.0)
    ok = (miss <= 10 * _ON_PATH * arm.reach) & (arm.limits.margin(q) >= -HELD).all(axis=-1)
    ok &= keeps_constraints(arm, q)
    return q, ok if problem.elbow == "any" else ok & arm.is_on_branch(q, problem.elbow, HELD)


def _rows_to_meet(
    arm: RedundantArm, lack: FloatArray, jacobian: FloatArray, q: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what postures (k, n) lack of their task, with a row for each constraint, and derivatives by the joints.

    A row says what the worst margin lacks, in the size of lengths; zero where the constraint is kept.
    """
    lacks, rows, each = [lack], [jacobian], np.arange(len(q))
    for constraint in constraints_of(arm):
        margins, gradients = constraint.gradients(q)
        worst = margins.argmin(axis=1)
        margin, unit = margins[each, worst], arm.reach / constraint.scale
        broken = margin < -constraint.tolerance
        lacks.append(np.where(broken, _CLEAR * arm.reach - unit * margin, 0.0)[:, None])
        rows.append(np.where(broken[:, None], unit * gradients[each, worst], 0.0)[:, None])
    return np.concatenate(lacks, axis=1), np.concatenate(rows, axis=1)


class Filled(NamedTuple):
    """A motion with small steps, and the steps of the one before that could not be made so, as indices."""

    r: FloatArray
    q: FloatArray
    broken: list[int]


def filled(problem: Problem, r: FloatArray, q: FloatArray) -> Filled:
    """Halve the steps of a motion on the path until they are small."""
    limits = problem.arm.limits
    return refined(problem, r, q, lambda _, q: np.abs(limits.steps(q[:-1], q[1:])).max(axis=1, initial=0.0) > _STEP)


def refined(
    problem: Problem, r: FloatArray, q: FloatArray, wanting: Callable[[FloatArray, FloatArray], BoolArray]
) -> Filled:
    """Halve steps of a motion on the path until none is wanting.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)
    wanting : callable
        Maps r and q to which of the steps are not good enough yet, shape (k − 1,).

    Returns
    -------
    Filled
        ``broken`` are the steps that do not get smaller by halving: jumps, and those with a forbidden posture half-way.
    """
    arm = problem.arm
    origin = np.arange(len(r))  # the row that each one comes after, or is
    broken: set[int] = set()
    for _ in range(_HALVINGS):
        large = np.flatnonzero(wanting(r, q) & ~np.isin(origin[:-1], list(broken)))
        if not len(large):
            return Filled(r, q, sorted(broken))
        step = arm.limits.steps(q[large], q[large + 1])
        middle_r = 0.5 * (r[large] + r[large + 1])
        middle, ok = on_path(problem, middle_r, q[large] + 0.5 * step)
        first, second = arm.limits.steps(q[large], middle), arm.limits.steps(middle, q[large + 1])
        half = np.maximum(np.abs(first).max(axis=1), np.abs(second).max(axis=1))
        good = ok & (half < _SHRINKS * np.abs(step).max(axis=1))
        broken |= set(origin[large[~good]].tolist())
        at = large[good] + 1
        r, q = np.insert(r, at, middle_r[good]), np.insert(q, at, middle[good], axis=0)
        origin = np.insert(origin, at, origin[large[good]])
    broken |= set(origin[:-1][wanting(r, q)].tolist())
    return Filled(r, q, sorted(broken))


def with_rows(problem: Problem, r: FloatArray, q: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the motion with a row at each of `rows`, where one can be put there."""
    new = np.setdiff1d(rows, r)
    after = np.searchsorted(r, new)
    inside = (after > 0) & (after < len(r))
    new, after = new[inside], after[inside]
    part = (new - r[after - 1]) / (r[after] - r[after - 1])
    step = problem.arm.limits.steps(q[after - 1], q[after])
    put, ok = on_path(problem, new, q[after - 1] + part[:, None] * step)
    return np.insert(r, after[ok], new[ok]), np.insert(q, after[ok], put[ok], axis=0)


def smoothed(problem: Problem, r: FloatArray, q: FloatArray, keep_first: bool, keep_last: bool) -> FloatArray:
    """Draw every posture to the straight line between its neighbours and back onto the path; given ends stay."""
    arm, gap = problem.arm, np.diff(r) + _STILL
    part = gap[:-1] / (gap[:-1] + gap[1:])
    q = q[:1] + np.concatenate([np.zeros((1, arm.n)), np.cumsum(arm.limits.steps(q[:-1], q[1:]), axis=0)])
    moving = slice(int(keep_first), -1 if keep_last else None)
    for _ in range(_SMOOTHINGS if len(q) > 2 else 0):
        line = np.concatenate([q[1:2], q[:-2] + part[:, None] * (q[2:] - q[:-2]), q[-2:-1]])
        put, ok = on_path(problem, r[moving], 0.5 * (q[moving] + line[moving]))
        ok &= np.abs(put - q[moving]).max(axis=1) < _STEP
        q[moving] = np.where(ok[:, None], put, q[moving])
    return q
