"""The self-motion of a constrained arm: intervals of u end where a constraint does, too.

The arm gives its own breakpoints. Between each two of them the margins are looked at along u, at places that crowd
towards the breakpoints, as joints move fast at folds; where they may dip through zero between two
looks one looks more closely, and where they change sign the place is closed in upon. What is narrower than that is
missed in pictures; proofs go by cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms.protocols import Breakpoints, Cause, FreeJoint, SelfMotion
from selfmotion.constrained.constraint import Constraint

_LOOKS = ((TAU / 16, 8), (TAU / 4, 14), (np.inf, 28))  # between two breakpoints, up to how far apart they are
_BESIDE = 1e-8  # how near to both one looks, as a part of what lies between
_ZOOMS = 3  # at dips
_NEAR = 6  # places of a zoom
_GIVEN = 1e-6  # what limits may give, at most, where they are asked to [rad]
_STEPS = 60  # of a search for a zero; most take eight
_EXACT = 1e-14  # where a zero is [rad]
_AT_ONCE = 100_000  # postures


class ConstrainedSelfMotion:
    """The self-motion of an arm under constraints; see :class:`~selfmotion.arms.SelfMotion`.

    Parameters
    ----------
    self_motion : SelfMotion
        Of the arm without them.
    constraints : sequence of Constraint

    Attributes
    ----------
    free : SelfMotion
        Of the arm without constraints.
    """

    has_structure = False

    def __init__(self, self_motion: SelfMotion, constraints: Sequence[Constraint]) -> None:
        self.free, self._constraints = self_motion, tuple(constraints)
        self.n, self.branches = self_motion.n, self_motion.branches
        self.u_range, self.periodic, self.limits = self_motion.u_range, self_motion.periodic, self_motion.limits
        self.singular: BoolArray = np.zeros(0, bool)

    @property
    def wraps(self) -> BoolArray:
        """Which joints are full turns, shape (n,)."""
        return self.free.wraps

    def pose(self, x: ArrayLike) -> Any:
        """Return the constants of task points `x`, shape (k, dimension)."""
        return self.free.pose(x)

    def solve(self, pose: Any, u: ArrayLike, branch: int) -> tuple[FloatArray, BoolArray]:
        """Return postures (k, m, n) and whether they reach, for parameters `u` (k, m)."""
        return self.free.solve(pose, u, branch)

    def excess(self, q: ArrayLike) -> FloatArray:
        """Return by how much postures (..., n) miss limits, and constraints as parts of their scale, (..., n + c)."""
        postures = np.asarray(q, dtype=float)
        lack = [np.maximum(-least, 0.0) for least, _ in self._least(postures)]
        return np.concatenate([self.limits.excess(postures), np.stack(lack, axis=-1)], axis=-1)

    @property
    def arm(self) -> Any:
        """The arm without constraints, None if its self-motion does not tell it."""
        return getattr(self.free, "arm", None)

    def least_kept(self, pose: Any, u: FloatArray, branch: int) -> IntArray:
        """Return which constraint is kept least, of postures that joint limits allow and constraints do not.

        Parameters
        ----------
        pose : Any
            Of :meth:`pose`.
        u : array, shape (k, m)
        branch : int

        Returns
        -------
        array of int, shape (k, m)
            For :meth:`cause`; −1 of postures that are allowed, out of reach, or outside of their limits.
        """
        row = np.repeat(np.arange(u.shape[0]), u.shape[1])
        q, margin, number = self._judged(pose, row, u.ravel(), branch)
        with np.errstate(invalid="ignore"):
            least = (margin < 0.0) & (self.free.excess(q) <= _GIVEN).all(axis=-1)
        return np.where(least, number, -1).reshape(u.shape)

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
        own = self.free.breakpoints(pose, exact)
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
            columns.append(Breakpoints(at, on, posture, (self.cause(int(number)),) * m))
        return columns

    def cause(self, number: int) -> Cause:
        """Return the cause of a number that :meth:`least_kept` tells."""
        constraint = self._constraints[number % len(self._constraints)]
        return Cause(constraint.cause(number // len(self._constraints)), -1, np.nan)

    def _least(self, q: FloatArray) -> list[tuple[FloatArray, IntArray]]:
        """Return for each constraint its least margin (...), as a part of its scale, and which that is."""
        flat, found = q.reshape(-1, q.shape[-1]), []
        for constraint in self._constraints:
            margin, which = constraint.least_margins(flat)
            found.append((margin.reshape(q.shape[:-1]) / constraint.scale, which.reshape(q.shape[:-1])))
        return found

    def _judged(self, pose: Any, row: IntArray, u: FloatArray, branch: int) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return postures at poses `row` (m,) and u (m,), their least margin of all and the number of its cause.

        Out of reach the margin is NaN.
        """
        q, margin, number = np.empty((len(u), self.n)), np.empty(len(u)), np.empty(len(u), np.int64)
        for first in range(0, len(u), _AT_ONCE):
            part = slice(first, first + _AT_ONCE)
            found, ok = self.free.solve(pose[row[part]], u[part, None], branch)
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
        q, reached = self.free.solve(pose, np.nan_to_num(0.5 * (u + after)), branch)
        allowed = reached & (self.free.excess(q) <= _GIVEN).all(axis=-1)  # so it is between the same two throughout
        row, column = np.nonzero(allowed & (after > u))
        low, high = u[row, column], after[row, column]
        size = np.searchsorted([wide for wide, _ in _LOOKS], high - low)
        found = []
        for k, (_, looks) in enumerate(_LOOKS):
            mine = size == k
            found.append(self._changes(pose, row[mine], _crowded(low[mine], high[mine], looks), branch))
        ends = _Ends(*(np.concatenate(column) for column in zip(*found, strict=True)))
        inside, outside = self._zeros(pose, ends, branch)
        q = self._judged(pose, ends.row, inside, branch)[0]
        return ends.row, inside, q, self._judged(pose, ends.row, outside, branch)[2]

    def _zeros(self, pose: Any, ends: _Ends, branch: int) -> tuple[FloatArray, FloatArray]:
        """Return where margins change sign, (m,): the last u that keeps the constraints, and the first that does not.

        Chandrupatla's method: an inverse quadratic through three places where that is safe, else the middle.
        """
        a, b, at_a, at_b = (column.copy() for column in ends[1:])
        c, at_c = b.copy(), at_b.copy()
        part, going = np.full(len(a), 0.5), np.arange(len(a))
        for _ in range(_STEPS):
            one, two = a[going], b[going]
            new = one + part[going] * (two - one)
            value = self._judged(pose, ends.row[going], new, branch)[1]
            value = np.where(np.isnan(value), at_a[going], value)  # out of reach by rounding, at a fold
            same = (value >= 0.0) == (at_a[going] >= 0.0)
            c[going], at_c[going] = np.where(same, one, two), np.where(same, at_a[going], at_b[going])
            b[going], at_b[going] = np.where(same, two, one), np.where(same, at_b[going], at_a[going])
            a[going], at_a[going] = new, value
            size = np.abs(b - a)
            going = going[(size[going] > _EXACT) & (at_a[going] != 0.0)]
            if not len(going):
                break
            part[going] = _next_part(*(column[going] for column in (a, b, c, at_a, at_b, at_c)))
        kept = at_a >= 0.0
        return np.where(kept, a, b), np.where(kept, b, a)

    def _changes(self, pose: Any, row: IntArray, at: FloatArray, branch: int) -> _Ends:
        """Return between which of the places `at` (m, looks) of poses `row` (m,) margins change sign."""
        found = []
        for _ in range(1 + _ZOOMS):
            margin = self._judged(pose, np.repeat(row, at.shape[1]), at.ravel(), branch)[1].reshape(at.shape)
            found.append(_crossed(row, at, margin))
            i, k = _dips(margin)
            if not len(i):
                break
            row, at = row[i], np.linspace(at[i, k], at[i, k + 1], _NEAR, axis=1)
        return _Ends(*(np.concatenate(column) for column in zip(*found, strict=True)))


class _Ends(NamedTuple):
    """Places `a` and `b` (m,) of poses `row` (m,), with margins of different signs, and nothing known between."""

    row: IntArray
    a: FloatArray
    b: FloatArray
    at_a: FloatArray
    at_b: FloatArray


def _crowded(low: FloatArray, high: FloatArray, looks: int) -> FloatArray:
    """Return places between `low` and `high` (m,) that crowd towards both, shape (m, looks)."""
    part = np.clip(0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, looks))), _BESIDE, 1.0 - _BESIDE)
    return np.asarray(low[:, None] + (high - low)[:, None] * part)


def _crossed(row: IntArray, at: FloatArray, margin: FloatArray) -> _Ends:
    """Return the neighbours among places (m, looks) whose margins have different signs."""
    kept, known = margin >= 0.0, np.isfinite(margin)
    i, k = np.nonzero((kept[:, 1:] != kept[:, :-1]) & known[:, 1:] & known[:, :-1])
    return _Ends(row[i], at[i, k], at[i, k + 1], margin[i, k], margin[i, k + 1])


def _dips(margin: FloatArray) -> tuple[IntArray, IntArray]:
    """Return rows i and columns k where margins may cross zero and come back between places k and k + 1.

    They may if they can get to zero as fast as they change just before, between or behind the two; `margin` is
    (m, looks), at places that are about as far from each other as the next ones are.
    """
    step = np.abs(np.diff(margin, axis=1))
    step = np.where(np.isfinite(step), step, 0.0)
    beside = np.concatenate([np.zeros_like(step[:, :1]), step, np.zeros_like(step[:, :1])], axis=1)
    fastest = np.maximum(np.maximum(beside[:, :-2], beside[:, 2:]), step)
    with np.errstate(invalid="ignore"):
        same = (margin[:, :-1] >= 0.0) == (margin[:, 1:] >= 0.0)
        i, k = np.nonzero(same & (np.abs(margin[:, :-1]) + np.abs(margin[:, 1:]) < fastest))
    return i, k


def _next_part(
    a: FloatArray, b: FloatArray, c: FloatArray, at_a: FloatArray, at_b: FloatArray, at_c: FloatArray
) -> FloatArray:
    """Return where between a and b to look next, as a part of the way; c is the place before."""
    with np.errstate(all="ignore"):
        place, value = (a - b) / (c - b), (at_a - at_b) / (at_c - at_b)
        safe = (value * value < place) & ((1.0 - value) ** 2 < 1.0 - place)
        inverse = at_a / (at_b - at_a) * at_c / (at_b - at_c) + (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (
            at_c - at_b
        )
        least = 0.5 * _EXACT / np.abs(b - a)
    return np.clip(np.where(safe & np.isfinite(inverse), inverse, 0.5), least, 1.0 - least)
