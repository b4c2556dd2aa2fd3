"""All postures at one task point, from one end of each feasible interval to the other."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import branch_index, integer
from selfmotion._types import FloatArray, IntArray
from selfmotion.angles import wrap
from selfmotion.arms import SelfMotion
from selfmotion.domain.feasible import feasible_arcs

MAX_POSTURES = 100_000
# Postures looked at to space those that are given; and how much one step of them may count [rad].
_DENSE = 801
_LONGEST_STEP = 0.5
# An end of an interval is the breakpoint that it was computed from, up to rounding.
_SAME = 1e-12


class Sweep(NamedTuple):
    """Postures across the feasible intervals of one branch at one task point.

    Attributes
    ----------
    u : array, shape (k,)
        Redundancy parameters [rad], ascending inside each interval, whose first and last are its ends; above π where
        the interval crosses the seam.
    q : array, shape (k, n)
        Postures [rad]: limited joints inside their limits, free joints in [−π, π].
    interval : array of int, shape (k,)
        Which interval each posture belongs to, in the order of ``IntervalSet.intervals``.
    """

    u: FloatArray
    q: FloatArray
    interval: IntArray

    def parts(self) -> list[Sweep]:
        """Return one sweep per interval."""
        return [Sweep(*(column[self.interval == k] for column in self)) for k in np.unique(self.interval)]


def sweep(self_motion: SelfMotion, x: ArrayLike, branch: int | str = 0, count: int = 25) -> Sweep:
    """Return postures from the minimum to the maximum of every feasible interval at one task point.

    Parameters
    ----------
    self_motion : SelfMotion
    x : array_like, shape (2,)
        Task point.
    branch : int or str
        Index or name of the IK branch.
    count : int
        Number of postures per interval, 2 or more; an interval that is a single point has one.

    Returns
    -------
    Sweep
        The first and last posture of each interval are its minimum and maximum configuration, (11)–(15) with the
        misprints of (13) mended, exact on the fold or limit that ends it. Between them the postures have equal
        distances in joint space (Euclidean, [rad]), so they crowd in u towards folds, where joints move fast. A full
        circle is swept from −π to π: the last posture is the first.

    Raises
    ------
    InvalidInputError
        If `count` is below 2 or the branch is not known.
    """
    number = integer("count", count, 2, MAX_POSTURES)
    index = branch_index(self_motion.branches, branch)
    point = np.asarray(x, dtype=float).reshape(1, 2)
    intervals = feasible_arcs(self_motion, point)[index].interval_set(0)
    pose = self_motion.pose(point)
    u, q, members = [], [], []
    for k, (low, high) in enumerate(intervals):
        mine = np.array([low]) if high == low else _even(self_motion, pose, index, low, high, number)
        postures = self_motion.solve(pose, mine[None], index)[0][0]
        if not intervals.is_full:
            for end in (0, -1):
                postures[end] = _at_end(self_motion, pose, index, mine[end], postures[end])
        u.append(mine)
        q.append(self_motion.limits.lift(postures[:, None]).q[:, 0])
        members.append(np.full(len(mine), k))
    if not u:
        return Sweep(np.empty(0), np.empty((0, self_motion.n)), np.empty(0, dtype=int))
    return Sweep(np.concatenate(u), np.concatenate(q), np.concatenate(members))


def _even(self_motion: SelfMotion, pose: Any, branch: int, low: float, high: float, count: int) -> FloatArray:
    """Return `count` parameters from `low` to `high` whose postures are equally far apart in joint space."""
    # u = middle + half·sin s takes the square roots out of the joint angles at folds.
    s = np.linspace(-np.pi / 2, np.pi / 2, max(_DENSE, 4 * count))
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    q = self_motion.solve(pose, (middle + half * np.sin(s))[None], branch)[0][0]
    # Where θ1 is free it jumps: no reason to put all postures there.
    steps = np.minimum(np.linalg.norm(wrap(np.diff(q, axis=0)), axis=1), _LONGEST_STEP)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    u = middle + half * np.sin(np.interp(np.linspace(0.0, length[-1], count), length, s))
    u[0], u[-1] = low, high
    return np.clip(u, low, high)


def _at_end(self_motion: SelfMotion, pose: Any, branch: int, u: float, solved: FloatArray) -> FloatArray:
    """Return the posture at the end of an interval, exact on what ends it, where that determines it."""
    breaks = self_motion.breakpoints(pose)
    gap = np.abs(wrap(breaks.u[0] - u))
    fits = (gap <= _SAME) & breaks.on_branch[0, :, branch] & np.isfinite(breaks.q[0]).all(axis=-1)
    if not fits.any():
        return solved
    column = int(np.argmin(np.where(fits, gap, np.inf)))
    return np.asarray(breaks.q[0, column])
