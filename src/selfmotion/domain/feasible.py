"""The feasible set of a self-motion at task points, as exact unions of intervals.

Feasibility changes only at the breakpoints that the arm gives in closed form. So the parameter circle is cut
there, and one posture inside each arc decides for the whole arc.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause, SelfMotion
from selfmotion.intervals import IntervalSet

# A limit is a closed set: an angle on it up to rounding is inside.
_ON_LIMIT = 1e-12
# A posture that meets all constraints only at one breakpoint is computed from that breakpoint to about this.
_AT_POINT = 1e-10
# Breakpoints nearer to each other than this are one breakpoint with two causes.
_NO_ARC = 1e-14
# What ends an interval at places that differ by less does so together.
_ONE_END = 1e-10
# A joint angle known to its last digits.
_LAST_DIGITS = 4e-15
# Near a fold joints move like the square root of u: what is this near in u may be a millionth of a radian away.
_AT_FOLD = 1e-12
# Where beside a fold one looks for the side that is in reach.
_BESIDE_FOLD = 1e-7


class Run(NamedTuple):
    """Feasible parameters from `low` to `high` [rad], and the causes that end them there; at folds, limits may, too."""

    low: float
    high: float
    causes: tuple[tuple[Cause, ...], tuple[Cause, ...]]


class FeasibleArcs(NamedTuple):
    """Feasible parameters of one branch at k task points.

    Attributes
    ----------
    low, high : array, shape (k, m)
        The arcs between neighbouring breakpoints; ``high`` may exceed π.
    inside : array of bool, shape (k, m)
        Which of the arcs are feasible.
    points : array, shape (k, m)
        Breakpoints that are feasible even if no arc beside them is; NaN elsewhere.
    columns : array of int, shape (k, m)
        Which of the arm's breakpoints each ``low`` is, and ``causes`` says why it is one.
    causes : tuple of Cause
    """

    low: FloatArray
    high: FloatArray
    inside: BoolArray
    points: FloatArray
    columns: IntArray
    causes: tuple[Cause, ...]

    @property
    def empty(self) -> BoolArray:
        """At which task points nothing is feasible, shape (k,)."""
        return np.asarray(~(self.inside.any(axis=1) | np.isfinite(self.points).any(axis=1)))

    def at(self, k: int) -> ArcsAtPoint:
        """Return the arcs at task point `k`, without the columns that have no solution there."""
        count = int(np.isfinite(self.low[k]).sum())
        here = slice(count)
        return ArcsAtPoint(
            self.low[k, here], self.high[k, here], self.inside[k, here], self.points[k, here], self.columns[k, here],
            self.causes,
        )  # fmt: skip

    def interval_set(self, k: int) -> IntervalSet:
        """Return the feasible parameters at task point `k`, on the circle of circumference 2π."""
        if self._is_full(k):
            return IntervalSet.full()
        return IntervalSet([(run.low, run.high) for run in self.runs(k)], TAU)

    def runs(self, k: int) -> list[Run]:
        """Return the feasible intervals at task point `k`, each with what ends it; a full circle has no ends."""
        real = np.flatnonzero(self.high[k] - self.low[k] > _NO_ARC)  # False where NaN
        if self._is_full(k):
            start = float(self.low[k, real[0]])
            return [Run(start, start + TAU, ((), ()))]
        inside, low, high = self.inside[k, real], self.low[k, real], self.high[k, real]
        # Counted from an arc that is not feasible, the feasible ones form runs that do not cross the count's end.
        turn = int(np.argmin(inside)) if real.size else 0
        order = (turn + np.arange(len(real))) % len(real) if real.size else np.empty(0, int)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], inside[order].astype(int), [0]])))
        first, last = order[edges[::2]], order[edges[1::2] - 1]
        ends = np.column_stack([low[first], high[last] + TAU * (last < first)])
        after = np.searchsorted(real, np.arange(self.points.shape[1])) % max(len(real), 1)
        alone = np.isfinite(self.points[k]) & ~inside[after] & ~inside[after - 1]
        points = np.unique(self.points[k, alone])
        found = np.vstack([ends, np.column_stack([points, points])])
        return [Run(float(a), float(b), (self._causes_at(k, a), self._causes_at(k, b))) for a, b in found]

    def _is_full(self, k: int) -> bool:
        """Return whether every parameter is feasible at task point `k`."""
        real = self.high[k] - self.low[k] > _NO_ARC
        return bool(real.any() and self.inside[k, real].all())

    def _causes_at(self, k: int, u: float) -> tuple[Cause, ...]:
        """Return why there is a breakpoint at u; markers are no reason if there is another."""
        count = int(np.isfinite(self.low[k]).sum())
        here = np.flatnonzero(np.abs(wrap(self.low[k, :count] - u)) <= _ONE_END)
        causes = tuple(dict.fromkeys(self.causes[column] for column in self.columns[k, here]))
        return tuple(cause for cause in causes if cause.kind != "marker") or causes


class ArcsAtPoint(NamedTuple):
    """`FeasibleArcs` of one branch at one task point: shapes (m,) instead of (k, m)."""

    low: FloatArray
    high: FloatArray
    inside: BoolArray
    points: FloatArray
    columns: IntArray
    causes: tuple[Cause, ...]


def feasible_arcs(
    self_motion: SelfMotion, x: FloatArray, slack: float = 0.0, exact: bool = False
) -> tuple[FeasibleArcs, ...]:
    """Return the feasible self-motion at task points, per branch.

    Parameters
    ----------
    self_motion : SelfMotion
        Periodic in u with period 2π.
    x : array, shape (k, 2)
        Task points.
    slack : float
        Overrun of limits to be forgiven [rad]. With 1e-7 what is found holds every feasible posture, those included
        that rounding moves off a limit at a tangency: what is empty then is empty.
    exact : bool
        Whether signs decide instead of tolerances, as the order of breakpoints does that follow each other closely. The
        set is then not closed under rounding, but keeps its structure up to 1e-15 of an event.

    Returns
    -------
    tuple of FeasibleArcs
        One per branch: reach and all joint limits hold, whole turns being free.
    """
    pose = self_motion.pose(x)
    breaks = self_motion.breakpoints(pose, exact)
    at_point, on_limit = (_LAST_DIGITS, 0.0) if exact else (max(slack, _AT_POINT), max(slack, _ON_LIMIT))
    with np.errstate(invalid="ignore"):
        holds = (self_motion.excess(breaks.q) <= at_point).all(axis=-1)
    folds = np.array([cause.kind == "fold" for cause in breaks.causes])
    nudge = _towards_reach(self_motion, pose, breaks.u, folds) if exact else 0.0
    result = []
    for branch in range(len(self_motion.branches)):
        mine = breaks.on_branch[..., branch] & np.isfinite(breaks.u)
        u = np.where(mine, breaks.u, np.nan)
        order = np.argsort(u - nudge, axis=1, kind="stable")  # NaN last
        low = np.take_along_axis(u, order, axis=1)
        held = np.take_along_axis(mine & holds, order, axis=1)
        last = (np.arange(len(low)), np.isfinite(low).sum(axis=1) - 1)
        high, held_next = np.roll(low, -1, axis=1), np.roll(held, -1, axis=1)
        high[last], held_next[last] = low[:, 0] + TAU, held[:, 0]
        q, ok = self_motion.solve(pose, np.nan_to_num(0.5 * (low + high)), branch)
        within = (self_motion.excess(q) <= on_limit).all(axis=-1)
        with np.errstate(invalid="ignore"):
            inside = ok & within & (high - low > _NO_ARC)
            if exact:  # what is too near to a fold for u to tell is decided by the posture at the fold
                low_fold, high_fold = folds[order], np.roll(folds[order], -1, axis=1)
                high_fold[last] = low_fold[:, 0]
                at_fold = np.where(low_fold, held, held_next)
                inside = np.where((low_fold | high_fold) & (high - low <= _AT_FOLD), at_fold, inside)
            else:  # two causes may share one point up to rounding; what lies between them is no gap
                inside |= held & held_next & (high - low <= _AT_POINT)
        points = np.where(held, low, np.nan)
        result.append(FeasibleArcs(low, high, inside, points, order, breaks.causes))
    return tuple(result)


def _towards_reach(self_motion: SelfMotion, pose: Any, u: FloatArray, folds: BoolArray) -> FloatArray:
    """Return shifts, shape of `u`, that move each fold in the order of breakpoints to the side that is out of reach."""
    columns = np.flatnonzero(folds)
    at = np.nan_to_num(u[:, columns])
    (_, above), (_, below) = (self_motion.solve(pose, at + step, 0) for step in (_BESIDE_FOLD, -_BESIDE_FOLD))
    shift = np.zeros_like(u)
    shift[:, columns] = _AT_FOLD * (above.astype(float) - below)
    return shift
