"""The feasible set of a self-motion at task points, as exact unions of intervals.

Feasibility changes only at the breakpoints that the arm gives in closed form. So the parameter circle is cut
there, and one posture inside each arc decides for the whole arc.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import SelfMotion
from selfmotion.intervals import TAU, IntervalSet

# A limit is a closed set: an angle on it up to rounding is inside.
_ON_LIMIT = 1e-12
# A posture that meets all constraints only at one breakpoint is computed from that breakpoint to about this.
_AT_POINT = 1e-10
# Arcs shorter than this hold no representable posture of their own.
_SHORTEST_ARC = 1e-15


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
    """

    low: FloatArray
    high: FloatArray
    inside: BoolArray
    points: FloatArray

    @property
    def empty(self) -> BoolArray:
        """At which task points nothing is feasible, shape (k,)."""
        return ~(self.inside.any(axis=1) | np.isfinite(self.points).any(axis=1))

    def interval_set(self, k: int) -> IntervalSet:
        """Return the feasible parameters at task point `k`, on the circle of circumference 2π."""
        arcs = np.column_stack([self.low[k], self.high[k]])[self.inside[k]]
        points = self.points[k][np.isfinite(self.points[k])]
        return IntervalSet(np.vstack([arcs, np.column_stack([points, points])]), TAU)


def feasible_arcs(self_motion: SelfMotion, x: FloatArray) -> tuple[FeasibleArcs, ...]:
    """Return the feasible self-motion at task points, per branch.

    Parameters
    ----------
    self_motion : SelfMotion
        Periodic in u with period 2π.
    x : array, shape (k, 2)
        Task points.

    Returns
    -------
    tuple of FeasibleArcs
        One per branch: reach and all joint limits hold, whole turns being free.
    """
    pose = self_motion.pose(x)
    breaks = self_motion.breakpoints(pose)
    with np.errstate(invalid="ignore"):
        holds = (self_motion.limits.excess(breaks.q) <= _AT_POINT).all(axis=-1)
    result = []
    for branch in range(len(self_motion.branches)):
        mine = breaks.on_branch[..., branch] & np.isfinite(breaks.u)
        points = np.where(mine & holds, breaks.u, np.nan)
        low = np.sort(np.where(mine, breaks.u, np.nan), axis=1)  # NaN last
        count = np.isfinite(low).sum(axis=1)
        high = np.roll(low, -1, axis=1)
        high[np.arange(len(low)), count - 1] = low[:, 0] + TAU
        middle = 0.5 * (low + high)
        q, ok = self_motion.solve(pose, np.nan_to_num(middle), branch)
        within = (self_motion.limits.excess(q) <= _ON_LIMIT).all(axis=-1)
        with np.errstate(invalid="ignore"):
            inside = ok & within & (high - low > _SHORTEST_ARC)
        result.append(FeasibleArcs(low, high, inside, points))
    return tuple(result)
