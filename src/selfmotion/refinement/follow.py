"""Motions to start from: many postures led along the path at once by differential inverse kinematics."""

from __future__ import annotations

import time

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import JointBox, RedundantArm
from selfmotion.paths import Path

# Joints nearer to a limit than about this are moved less [rad]: steps are larger here than corrections of a spline are.
_SOFT = 0.1
_TO_LIMIT = 0.9  # part of the way to a limit that one step may go
_BOLDEST = 0.4  # largest change of a joint in one step [rad]
_ON_TASK = 1e-9  # tracking, as a part of the reach
_CORRECTIONS = 6  # Newton steps from one r to the next
_HALVINGS = 5  # of a step that is too large
_DAMPING = 1e-13  # part of the trace of J D Jᵀ, and of its least value that is told from zero
_LEAST_TRACE = 1e-6  # of the square of the reach: all joints on their limits, all but none moves
_CLEAR = 0.03  # margin, in its scale, that followers are pushed to keep of the arm's constraints
_PUSH = 0.1  # largest change of a joint by a push [rad]
_LEVER = 0.05  # change of a margin by the self-motion, in its scale by rad, below which pushing is of little use
_PUSHES = 40  # that may free a posture


def followed(
    arm: RedundantArm,
    path: Path,
    box: JointBox,
    q: FloatArray,
    drift: FloatArray,
    r: FloatArray,
    rng: np.random.Generator | None = None,
    deadline: float = np.inf,
) -> tuple[FloatArray, FloatArray]:
    """Lead postures along a path inside the limits.

    Parameters
    ----------
    arm : RedundantArm
    path : Path
    box : JointBox
    q : array, shape (p, n)
        Postures on the task at r[0], inside the limits.
    drift : array, shape (p, n)
        Joint rates dθ/dr that the self-motion follows as far as the task allows; zero for the least joint motion.
    r : array, shape (k,)
        Path parameters to pass, ascending.
    rng : Generator, optional
        What is caught by an arm's further constraints is replaced by; without one it is not.
    deadline : float
        As :func:`time.perf_counter` tells it; after that no posture goes any further.

    Returns
    -------
    motions : array, shape (p, k, n)
        A posture that can go no further stays as it is.
    reached : array, shape (p,)
        The last r at which the task was kept, and the arm's constraints on postures until then.

    Notes
    -----
    Of an arm's further constraints the motions are kept clear by pushes of their self-motion. One that is caught, or
    can go no further, goes on as a copy of one that is not, with another's drift, as long as there is one: go with the
    winners (Aldous, Vazirani 1994). Without one they go on through.
    """
    motions = np.empty((len(q), len(r), arm.n))
    motions[:, 0] = q
    reached, going = np.full(len(q), r[0]), np.arange(len(q))
    constrained, free, drift = is_constrained(arm), is_clear(arm, q), drift.copy()
    for k in range(1, len(r)):
        motions[:, k] = motions[:, k - 1]
        wish = drift[going]
        if constrained:
            wish = wish + push(arm, motions[going, k - 1]) / (r[k] - r[k - 1])
        moved, ok = _moved(arm, path, box, motions[going, k - 1], wish, r[k - 1], r[k], _HALVINGS)
        going = going[ok]
        motions[going, k] = moved[ok]
        if constrained:
            free[going] &= is_clear(arm, moved[ok])
            alive = going[free[going]]
            if rng is not None and 0 < len(alive) < len(q):
                caught = np.setdiff1d(np.arange(len(q)), alive)
                copied = rng.choice(alive, len(caught))
                motions[caught, : k + 1], drift[caught] = motions[copied, : k + 1], drift[rng.permutation(caught)]
                free[caught], going = True, np.arange(len(q))
        reached[going[free[going]]] = r[k]
        if not len(going) or time.perf_counter() > deadline:
            motions[:, k:] = motions[:, k : k + 1]
            break
    return motions, reached


def _moved(
    arm: RedundantArm,
    path: Path,
    box: JointBox,
    q: FloatArray,
    drift: FloatArray,
    start: float,
    stop: float,
    halvings: int,
) -> tuple[FloatArray, BoolArray]:
    """Lead postures from r = start to stop, in smaller steps where one is too large; return which arrived."""
    moved, ok = on_task(arm, path(stop), box, q, drift * (stop - start), _CORRECTIONS)
    if halvings and not ok.all():
        middle, left = 0.5 * (start + stop), np.flatnonzero(~ok)
        half, there = _moved(arm, path, box, q[left], drift[left], start, middle, halvings - 1)
        left, half = left[there], half[there]
        if len(left):
            moved[left], ok[left] = _moved(arm, path, box, half, drift[left], middle, stop, halvings - 1)
    return moved, ok


def on_task(
    arm: RedundantArm, x: FloatArray, box: JointBox, q: FloatArray, drift: FloatArray | float = 0.0, most: int = 60
) -> tuple[FloatArray, BoolArray]:
    """Move postures onto a task point inside the limits, by Newton steps weighted by each joint's room.

    Parameters
    ----------
    arm : RedundantArm
    x : array, shape (2,)
    box : JointBox
    q : array, shape (p, n)
        Inside the limits.
    drift : array, shape (p, n), optional
        Self-motion that the first step adds [rad].
    most : int
        Largest number of steps.

    Returns
    -------
    q : array, shape (p, n)
    ok : array of bool, shape (p,)
        Whether the task is kept.
    """
    wish = np.broadcast_to(drift, q.shape)
    for k in range(most):
        ok = arm.task_error(q, x) <= _ON_TASK * arm.reach
        if ok.all() and k > 0:
            break
        below, above = q - box.lower, box.upper - q
        room = np.maximum(np.minimum(below, above), 0.0)
        freedom = np.where(np.isfinite(room), room / (np.where(np.isfinite(room), room, 0.0) + _SOFT), 1.0)
        jacobian = arm.jacobian(q)
        weighted = jacobian * freedom[:, None, :]
        wish = freedom * wish
        lack = arm.task_residual(q, x) - (jacobian @ wish[:, :, None])[:, :, 0]
        square = weighted @ np.swapaxes(jacobian, 1, 2)
        size = np.trace(square, axis1=1, axis2=2)[:, None, None]
        damped = square + _DAMPING * np.maximum(size, _LEAST_TRACE * arm.reach**2) * np.eye(square.shape[1])
        step = wish + (np.swapaxes(weighted, 1, 2) @ np.linalg.solve(damped, lack[:, :, None]))[:, :, 0]
        speed = np.abs(step)
        way = np.where(step < 0, below, above)
        with np.errstate(divide="ignore", invalid="ignore"):
            limit = np.where(speed > 0, _TO_LIMIT * way / speed, np.inf).min(axis=1)
        limit = np.minimum(limit, _BOLDEST / np.maximum(speed.max(axis=1), 1e-300))
        q = q + np.clip(limit, 0.0, 1.0)[:, None] * step
        wish = np.zeros_like(q)
    return q, np.asarray(arm.task_error(q, x) <= _ON_TASK * arm.reach)


def is_constrained(arm: RedundantArm) -> bool:
    """Return whether an arm has further constraints on postures."""
    return bool(getattr(arm, "constraints", ()))


def is_clear(arm: RedundantArm, q: FloatArray) -> BoolArray:
    """Return which postures (p, n) keep the arm's further constraints, shape (p,)."""
    clear = np.ones(len(q), bool)
    for constraint in getattr(arm, "constraints", ()):
        clear &= constraint.least_margins(q)[0] >= 0.0
    return clear


def push(arm: RedundantArm, q: FloatArray) -> FloatArray:
    """Return the change (p, n) of postures, along their self-motion, that keeps them clear of the arm's constraints.

    For each margin below what is wanted this is Newton's step towards it along the self-motion, and their sum is kept
    small.
    """
    jacobian = arm.jacobian(q)
    whole = np.zeros_like(q)
    for constraint in getattr(arm, "constraints", ()):
        margins, gradients = constraint.gradients(q)
        lack, slopes = np.maximum(_CLEAR - margins / constraint.scale, 0.0), gradients / constraint.scale
        along = slopes - slopes @ np.linalg.pinv(jacobian) @ jacobian
        whole += ((lack / (np.square(along).sum(axis=2) + _LEVER**2))[:, :, None] * along).sum(axis=1)
    return np.asarray(whole * np.minimum(1.0, _PUSH / np.maximum(np.abs(whole).max(axis=1), 1e-300))[:, None])


def freed(
    arm: RedundantArm, x: FloatArray, box: JointBox, q: FloatArray, deadline: float = np.inf
) -> tuple[FloatArray, BoolArray]:
    """Return postures (p, n) on a task point pushed until they keep the arm's constraints, and whether they do.

    Parameters
    ----------
    arm : RedundantArm
    x : array, shape (dimension,)
    box : JointBox
    q : array, shape (p, n)
        On the task, inside the limits.
    deadline : float
        As :func:`time.perf_counter` tells it.

    Returns
    -------
    q : array, shape (p, n)
    ok : array of bool, shape (p,)
        Whether task and constraints are kept.
    """
    q, kept = q.copy(), np.ones(len(q), bool)
    for _ in range(_PUSHES):
        caught = np.flatnonzero(~is_clear(arm, q) & kept)
        if not len(caught) or time.perf_counter() > deadline:
            break
        q[caught], kept[caught] = on_task(arm, x, box, q[caught], push(arm, q[caught]), _CORRECTIONS)
    return q, kept & is_clear(arm, q)
