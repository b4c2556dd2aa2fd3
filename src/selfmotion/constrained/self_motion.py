"""The self-motion of a constrained arm: intervals of u end where a constraint does, too.

The arm gives its own breakpoints. Between each two of them the margins are looked at along u, at places that crowd
towards the breakpoints, as joints move fast at folds; where they dip towards zero one looks more closely, and where
they change sign the place is bisected. What is narrower than that is missed in pictures; proofs go by cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms.protocols import Breakpoints, Cause, FreeJoint, SelfMotion
from selfmotion.constrained.constraint import Constraint

_LOOKS = 32  # between two breakpoints
_ZOOMS = 6  # at dips
_NEAR = 9  # places of a zoom
_BISECTIONS = 46
_AT_ONCE = 100_000  # postures


class ConstrainedSelfMotion:
    """The self-motion of an arm under constraints; see :class:`~selfmotion.arms.SelfMotion`.

    Parameters
    ----------
    self_motion : SelfMotion
        Of the arm without them.
    constraints : sequence of Constraint
    """

    has_structure = False

    def __init__(self, self_motion: SelfMotion, constraints: Sequence[Constraint]) -> None:
        self._free, self._constraints = self_motion, tuple(constraints)
        self.n, self.branches = self_motion.n, self_motion.branches
        self.u_range, self.periodic, self.limits = self_motion.u_range, self_motion.periodic, self_motion.limits
        self.singular: BoolArray = np.zeros(0, bool)

    @property
    def wraps(self) -> BoolArray:
        """Which joints are full turns, shape (n,)."""
        return self._free.wraps

    def pose(self, x: ArrayLike) -> Any:
        """Return the constants of task points `x`, shape (k, dimension)."""
        return self._free.pose(x)

    def solve(self, pose: Any, u: ArrayLike, branch: int) -> tuple[FloatArray, BoolArray]:
        """Return postures (k, m, n) and whether they reach, for parameters `u` (k, m)."""
        return self._free.solve(pose, u, branch)

    def excess(self, q: ArrayLike) -> FloatArray:
        """Return by how much postures (..., n) miss limits, and constraints as parts of their scale, (..., n + c)."""
        postures = np.asarray(q, dtype=float)
        lack = [np.maximum(-least, 0.0) for least, _ in self._least(postures)]
        return np.concatenate([self.limits.excess(postures), np.stack(lack, axis=-1)], axis=-1)

    def separators(self, pose: Any) -> FloatArray:
        """Return no functions, shape (k, 0): none are known."""
        return np.empty((len(pose), 0))

    def free_joint(self, pose: Any) -> FreeJoint | None:
        """Return None: no separator vanishes."""
        return None

    def breakpoints(self, pose: Any, exact: bool = False) -> Breakpoints:
        """Return the arm's breakpoints, and where its constraints end what they allow.

        Parameters
        ----------
        pose : Any
            Of :meth:`pose`.
        exact : bool
            As the arm takes it.

        Returns
        -------
        Breakpoints
            Other poses have other columns.
        """
        own = self._free.breakpoints(pose, exact)
        found = [self._places(pose, own, branch) for branch in range(len(self.branches))]
        columns = [own]
        for branch, (row, u, q, which) in enumerate(found):
            columns += self._columns(len(own.u), branch, row, u, q, which)
        return Breakpoints(
            np.concatenate([part.u for part in columns], axis=1),
            np.concatenate([part.on_branch for part in columns], axis=1),
            np.concatenate([part.q for part in columns], axis=1),
            tuple(cause for part in columns for cause in part.causes),
        )

    def _columns(
        self, k: int, branch: int, row: IntArray, u: FloatArray, q: FloatArray, which: IntArray
    ) -> list[Breakpoints]:
        """Return places as columns: one per cause for each time that it occurs at a pose."""
        columns = []
        for number in np.unique(which):
            mine = np.flatnonzero(which == number)
            mine = mine[np.argsort(row[mine], kind="stable")]
            first = np.searchsorted(row[mine], row[mine])
            times = np.arange(len(mine)) - first
            m = int(times.max()) + 1
            at, on, posture = (
                np.full((k, m), np.nan),
                np.zeros((k, m, len(self.branches)), bool),
                np.full((k, m, self.n), np.nan),
            )
            at[row[mine], times], posture[row[mine], times] = wrap(u[mine]), q[mine]
            on[row[mine], times, branch] = True
            columns.append(Breakpoints(at, on, posture, (self._cause(int(number)),) * m))
        return columns

    def _cause(self, number: int) -> Cause:
        """Return the cause of a number that :meth:`_least` tells."""
        constraint = self._constraints[number % len(self._constraints)]
        return Cause(constraint.cause(number // len(self._constraints)), -1, np.nan)

    def _least(self, q: FloatArray) -> list[tuple[FloatArray, IntArray]]:
        """Return for each constraint its least margin (...), as a part of its scale, and which that is."""
        flat, found = q.reshape(-1, q.shape[-1]), []
        for constraint in self._constraints:
            margins = constraint.margins(flat) / constraint.scale
            which = margins.argmin(axis=1)
            found.append((margins[np.arange(len(flat)), which].reshape(q.shape[:-1]), which.reshape(q.shape[:-1])))
        return found

    def _judged(self, pose: Any, row: IntArray, u: FloatArray, branch: int) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return postures at poses `row` (m,) and u (m,), their least margin of all and the number of its cause.

        Out of reach the margin is NaN.
        """
        q, margin, number = np.empty((len(u), self.n)), np.empty(len(u)), np.empty(len(u), np.int64)
        for first in range(0, len(u), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            found, ok = self._free.solve(pose[row[part]], u[part, None], branch)
            found, ok = found[:, 0], ok[:, 0]
            each = self._least(found)
            least = np.stack([one for one, _ in each])
            worst = least.argmin(axis=0)
            which = np.stack([one for _, one in each])[worst, np.arange(len(worst))]
            q[part], margin[part] = found, np.where(ok, least.min(axis=0), np.nan)
            number[part] = which * len(self._constraints) + worst
        return q, margin, number

    def _places(self, pose: Any, own: Breakpoints, branch: int) -> tuple[IntArray, FloatArray, FloatArray, IntArray]:
        """Return where margins change sign on a branch: poses (m,), u (m,), postures (m, n) and numbers of causes."""
        u = np.sort(np.where(own.on_branch[..., branch], own.u, np.nan), axis=1)
        count = np.isfinite(u).sum(axis=1)
        after = np.roll(u, -1, axis=1)
        rows = np.arange(len(u))
        after[rows, count - 1] = u[:, 0] + TAU
        row, column = np.nonzero(np.isfinite(u) & (after > u))
        low, high = u[row, column], after[row, column]
        part = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, _LOOKS + 2)))[1:-1]
        at = low[:, None] + (high - low)[:, None] * part
        margin = self._judged(pose, np.repeat(row, _LOOKS), at.ravel(), branch)[1].reshape(at.shape)
        one, two, of, sign = self._changes(pose, row, at, margin, branch)
        for _ in range(_BISECTIONS):
            middle = 0.5 * (one + two)
            _, found, _ = self._judged(pose, of, middle, branch)
            same = (found >= 0.0) == sign
            one, two = np.where(same, middle, one), np.where(same, two, middle)
        inside, outside = np.where(sign, one, two), np.where(sign, two, one)
        q = self._judged(pose, of, inside, branch)[0]
        return of, inside, q, self._judged(pose, of, outside, branch)[2]

    def _changes(
        self, pose: Any, row: IntArray, at: FloatArray, margin: FloatArray, branch: int
    ) -> tuple[FloatArray, FloatArray, IntArray, BoolArray]:
        """Return pairs of u (m,) between which the sign changes, their poses, and whether it is kept at the first."""
        ones, twos, poses, signs = [], [], [], []

        def add(row: IntArray, at: FloatArray, margin: FloatArray) -> None:
            kept = margin >= 0.0
            i, k = np.nonzero((kept[:, 1:] != kept[:, :-1]) & np.isfinite(margin[:, 1:]) & np.isfinite(margin[:, :-1]))
            ones.append(at[i, k])
            twos.append(at[i, k + 1])
            poses.append(row[i])
            signs.append(kept[i, k])

        add(row, at, margin)
        # Dips that stay on one side of zero where one looked, but by less than they fell.
        before, here, after = margin[:, :-2], margin[:, 1:-1], margin[:, 2:]
        size = np.abs(here)
        dip = (
            (size <= np.abs(before))
            & (size <= np.abs(after))
            & (size < np.maximum(np.abs(before), np.abs(after)) - size)
        )
        same = ((before >= 0.0) == (here >= 0.0)) & ((after >= 0.0) == (here >= 0.0))
        i, k = np.nonzero(dip & same)
        if len(i):
            sign = np.where(here[i, k] >= 0.0, 1.0, -1.0)
            low, high, of = at[i, k], at[i, k + 2], row[i]
            for _ in range(_ZOOMS):
                near = np.linspace(low, high, _NEAR, axis=1)
                found = self._judged(pose, np.repeat(of, _NEAR), near.ravel(), branch)[1].reshape(near.shape)
                crossed = np.asarray((sign[:, None] * found < 0.0).any(axis=1))
                add(of[crossed], near[crossed], found[crossed])
                least = np.argmin(np.where(np.isfinite(found), sign[:, None] * found, np.inf), axis=1)
                lines = np.arange(len(near))
                low, high = near[lines, np.maximum(least - 1, 0)], near[lines, np.minimum(least + 1, _NEAR - 1)]
                low, high, of, sign = low[~crossed], high[~crossed], of[~crossed], sign[~crossed]
                if not len(of):
                    break
        return np.concatenate(ones), np.concatenate(twos), np.concatenate(poses), np.concatenate(signs)
