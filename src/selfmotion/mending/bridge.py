"""From one posture to another along the path: on straight joint lines, else by the shortest way, smoothed."""

from __future__ import annotations

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import RedundantArm
from selfmotion.errors import UnrepairableError
from selfmotion.mending.filling import SAME, filled, on_path, smoothed, with_rows
from selfmotion.mending.ladder import End, Ladder
from selfmotion.problem import Problem

_REFINEMENTS = 2
_ROUNDS = 3

PLAN_ANEW = "give more rows, or plan the motion anew"
"""What to do where a repair fails for no provable reason."""


def bridge(problem: Problem, start: End, end: End, between: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a continuous motion from one posture to another, its ends left out where they are given.

    Parameters
    ----------
    problem : Problem
    start, end : tuple
        Path parameter, and posture of shape (n,) or None for any.
    between : array, shape (k,)
        Path parameters that shall have a row.

    Returns
    -------
    r : array, shape (m,)
    q : array, shape (m, n)
        Steps are at most 0.06 rad.

    Raises
    ------
    UnrepairableError
        If no way was found.
    """
    arm = problem.arm
    inner = slice(start[1] is not None, -1 if end[1] is not None else None)
    if start[1] is not None and end[1] is not None:
        r = np.array([start[0], *between, end[0]])
        q, ok = on_path(problem, r, _straight(arm, start, end, between))
        direct = filled(problem, r, q)
        if ok.all() and not direct.broken:
            return direct.r[inner], direct.q[inner]
    for refinement in range(_REFINEMENTS):
        motion = Ladder(problem, start, end, between, refinement).shortest()
        if motion is None:
            continue
        better = filled(problem, *with_rows(problem, motion.r, motion.q, between))
        for _ in range(_ROUNDS):  # smoothed as long as it stays continuous
            if better.broken:
                break
            motion = better
            smooth = smoothed(problem, motion.r, motion.q, start[1] is not None, end[1] is not None)
            better = filled(problem, motion.r, smooth)
        r, q, _ = motion if better.broken else better
        size = np.abs(arm.limits.steps(q[:-1], q[1:])).max(axis=1)
        moved = np.concatenate([[True], (np.diff(r) > 0) | (size > SAME)])
        return r[moved][inner], q[moved][inner]
    raise UnrepairableError(
        f"no way from r = {start[0]:.6g} to {end[0]:.6g} was found, although the self-motions are connected",
        PLAN_ANEW,
        start[0],
        proved=False,
    )


def _straight(arm: RedundantArm, start: End, end: End, between: FloatArray) -> FloatArray:
    """Return postures on the straight joint line, shape (k + 2, n)."""
    assert start[1] is not None
    assert end[1] is not None
    step = arm.limits.steps(start[1], end[1])
    span = max(end[0] - start[0], 1e-300)
    part = np.concatenate([[0.0], (between - start[0]) / span, [1.0]])
    return start[1] + part[:, None] * step
