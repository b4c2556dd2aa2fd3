"""The self-motion of spatial arms with one redundant degree, seen from the redundancy parameter.

Feasibility changes only where a joint is at a limit, where two branches meet in a fold, and where a joint is free. The
arm's cover holds every feasible posture in short pieces of its self-motion, so a search along these finds all such
places, and Newton's method on the chain makes them exact.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import wrap
from selfmotion.arms import _curve_event_kernels as kernels
from selfmotion.arms.cells import Cells
from selfmotion.arms.protocols import Breakpoints, Cause, FreeJoint
from selfmotion.errors import InvalidInputError

if TYPE_CHECKING:
    from selfmotion.arms.spatial import SpatialArm

_SPACING = 0.3  # of the cells; proofs make most of them much shorter [rad]
_ROUGH = 1.0  # what the cover marks cells with of which nothing is known
_STILL = 1e-10  # by how much u may move where it stands still and a joint is free [rad]
_MOVING = 1e-3  # by how much some joint moves there [rad]
_ONE = 1e-7  # free joints at places that differ by less are one [rad]
_ON_BRANCH = 1e-9  # [rad]
_PARAMETERS = ("q7", "arm angle", "roll")
_MARKER = Cause("marker", -1, np.nan)
_TURN = Cause("fold", -1, np.nan)  # where the roll turns about: no single joint need be at a value that is known


class _Row(NamedTuple):
    """Breakpoints at one pose: parameters (m,), branches (m, b), postures (m, n), numbers of their causes (m,)."""

    u: FloatArray
    on_branch: BoolArray
    q: FloatArray
    cause: IntArray


class CurveSelfMotion:
    """The self-motion of a spatial arm, u being what its closed form is solved at: θ7, the arm angle, or the roll.

    Parameters
    ----------
    arm : SpatialArm

    Attributes
    ----------
    causes : tuple of Cause
        Everything that can end an interval of feasible parameters.

    Raises
    ------
    InvalidInputError
        If u is something else.

    Notes
    -----
    u is an angle modulo 2π, θ7 too: a joint fits if some whole number of turns brings it between its limits. Where the
    arm angle does not exist, the wrist being right above or below the shoulder, nothing counts as feasible.
    """

    u_range = (-np.pi, np.pi)
    periodic = True
    has_structure = False

    def __init__(self, arm: SpatialArm) -> None:
        if arm.closed_form.family.parameter not in _PARAMETERS:
            what = f"has the {arm.closed_form.family.parameter} as its redundancy parameter, whose range is not told"
            raise InvalidInputError("arm", what, "use plan, verify or compare")
        self.arm = arm
        self.n = arm.n
        self.branches = arm.branches
        self.limits = arm.limits
        self.singular: BoolArray = np.zeros(0, bool)
        self._cover = arm.cover()
        limits = [
            (Cause(kind, int(j), float(ends[j])), False)
            for j in np.flatnonzero(~self.wraps)
            for kind, ends in (("lower limit", arm.limits.lower), ("upper limit", arm.limits.upper))
        ]
        sought = limits + [(fold, True) for fold in _folds(arm)]
        self._rolls = arm.closed_form.family.parameter == "roll"
        turns = (_TURN,) if self._rolls else ()
        free = (Cause("free", j, np.nan) for j in range(arm.n))
        self.causes = (*(cause for cause, _ in sought), *turns, *free, _MARKER)
        joints = np.array([cause.joint for cause, _ in sought], np.int64)
        values = np.array([cause.value for cause, _ in sought], float) + arm.closed_form.shift[joints]
        self._sought = kernels.Values(joints, values, np.array([turning for _, turning in sought], bool))

    @property
    def wraps(self) -> BoolArray:
        """Which joints are full turns, shape (n,); those without limits on both sides are."""
        return ~(np.isfinite(self.limits.lower) & np.isfinite(self.limits.upper))

    def excess(self, q: ArrayLike) -> FloatArray:
        """Return by how much postures (..., n) miss what limits them, zero where they do not."""
        return self.limits.excess(q)

    def pose(self, x: ArrayLike) -> FloatArray:
        """Return the constants of task points `x`: the poses, shape (k, 7)."""
        return np.asarray(x, dtype=float).reshape(-1, 7)

    def solve(self, pose: FloatArray, u: ArrayLike, branch: int) -> tuple[FloatArray, BoolArray]:
        """Return postures (k, m, n) and whether they reach, for parameters `u` of shape (k, m)."""
        return self.arm.solve(pose[:, None, :], np.asarray(u, dtype=float)[..., None], branch)

    def breakpoints(self, pose: FloatArray, exact: bool = False) -> Breakpoints:
        """Return the ends of every feasible interval, and maybe more.

        Parameters
        ----------
        pose : array, shape (k, 7)
        exact : bool
            Makes no difference: what is found holds to rounding.

        Returns
        -------
        Breakpoints
            One column per cause for each time that it occurs, as often as it does at any of these poses, and u = −π as
            a marker: other poses have other columns. Places that no feasible posture comes near are left out.
        """
        rows = self._rows(pose)
        number = len(self.causes)
        counts = np.array([np.bincount(row.cause, minlength=number) for row in rows]).reshape(-1, number)
        most = counts.max(axis=0, initial=0)
        first = np.cumsum(most) - most
        k, m = len(rows), int(most.sum())
        u, q = np.full((k, m), np.nan), np.full((k, m, self.n), np.nan)
        on_branch = np.zeros((k, m, len(self.branches)), bool)
        for i, row in enumerate(rows):
            order = np.lexsort((row.u, row.cause))
            before = np.cumsum(counts[i]) - counts[i]
            column = first[row.cause[order]] + np.arange(len(order)) - before[row.cause[order]]
            u[i, column], q[i, column], on_branch[i, column] = row.u[order], row.q[order], row.on_branch[order]
        causes = tuple(cause for cause, times in zip(self.causes, most, strict=True) for _ in range(times))
        return Breakpoints(u, on_branch, q, causes)

    def separators(self, pose: FloatArray) -> FloatArray:
        """Return no functions, shape (k, 0): none are known."""
        return np.empty((len(pose), 0))

    def free_joint(self, pose: FloatArray) -> FreeJoint | None:
        """Return None: no separator vanishes."""
        return None

    def _rows(self, pose: FloatArray) -> list[_Row]:
        covers = [self._cover.cells(x, _SPACING) for x in pose]
        found = [self._places(x, cells) for x, cells in zip(pose, covers, strict=True)]
        every = np.concatenate([np.empty((0, self.n)), *(q for q, _ in found)])
        u, on_branch = self.arm.u_of(every)[:, 0], self._branches_of(every)
        seam = self._markers(np.array([-np.pi]))
        rows, first = [], 0
        for cells, (q, which) in zip(covers, found, strict=True):
            mine = slice(first, first + len(q))
            first += len(q)
            parts = [_Row(u[mine], on_branch[mine], q, which), *self._free(cells), self._rough(cells, u[mine]), seam]
            rows.append(_Row(*(np.concatenate(columns) for columns in zip(*parts, strict=True))))
        return rows

    def _places(self, x: FloatArray, cells: Cells) -> tuple[FloatArray, IntArray]:
        """Return the postures at which limits and folds are met, and which."""
        shift, capacity = self.arm.closed_form.shift, 64
        curves = cells.pieces[:, 1] != _ROUGH
        a, b = cells.a[curves] + shift, cells.b[curves] + shift
        task = self.arm.task(x)
        while True:
            found = kernels.Places(np.empty((capacity, self.n)), np.empty(capacity, np.int64))
            count = kernels.find_places(self.arm.kernel, task, a, b, self._sought, found)
            if count <= capacity:
                break
            capacity = count
        q, which = found.q[:count] - shift, found.which[:count]
        if not self._rolls:
            return q, which
        turns = kernels.Places(np.empty((kernels.LOOKS * len(a), self.n)), np.empty(kernels.LOOKS * len(a), np.int64))
        count = kernels.find_turns(self.arm.kernel, task, a, b, turns)
        mine = np.full(count, len(self._sought.joints))
        return np.concatenate([q, turns.q[:count] - shift]), np.concatenate([which, mine])

    def _free(self, cells: Cells) -> list[_Row]:
        """Return where u stands still while a joint turns: one breakpoint each, with a posture that fits if any."""
        start, stop = self.arm.u_of(cells.a)[:, 0], self.arm.u_of(cells.b)[:, 0]
        moved = np.abs(cells.b - cells.a)
        standing = (np.abs(wrap(stop - start)) <= _STILL) & (moved.max(axis=1, initial=0.0) > _MOVING)
        if self.arm.closed_form.family.parameter == "q7":  # at a fold it comes back
            standing &= np.abs(cells.bow[:, 6]) <= _STILL
        left, rows = np.flatnonzero(standing), []
        while len(left):
            u = start[left[0]]
            here = np.asarray(np.abs(wrap(start[left] - u)) <= _ONE)
            mine, left = left[here], left[~here]
            postures = np.concatenate([cells.a[mine], cells.b[mine]])
            best = postures[int(np.argmin(self.limits.excess(postures).max(axis=1)))]
            on = np.asarray(self._branches_of(postures).any(axis=0))
            number = len(self.causes) - 1 - self.n + int(np.argmax(moved[mine].max(axis=0).round(6)))
            rows.append(_Row(np.array([u]), on[None], best[None], np.array([number])))
        return rows

    def _rough(self, cells: Cells, known: FloatArray) -> _Row:
        """Return the parameters of boxes of which nothing is known, as markers, but for those that are known better."""
        u = self.arm.u_of(cells.a[cells.pieces[:, 1] == _ROUGH])[:, 0]
        return self._markers(u[(np.abs(wrap(u[:, None] - known)) > _ONE).all(axis=1)])

    def _markers(self, u: FloatArray) -> _Row:
        """Return breakpoints on every branch at which nothing need happen."""
        k = len(u)
        on_branch, q = np.ones((k, len(self.branches)), bool), np.full((k, self.n), np.nan)
        return _Row(u, on_branch, q, np.full(k, len(self.causes) - 1))

    def _branches_of(self, q: FloatArray) -> BoolArray:
        """Return the branches that postures (m, n) are on, several at their folds, shape (m, b)."""
        if not len(q):
            return np.zeros((0, len(self.branches)), bool)
        return np.stack([self.arm.is_on_branch(q, k, _ON_BRANCH) for k in range(len(self.branches))], axis=1)


def _folds(arm: SpatialArm) -> list[Cause]:
    """Return the joint values at which two branches meet while u turns about."""
    if arm.closed_form.family.parameter != "q7":
        return []  # the arm angle turns about nowhere, and where the roll does no joint's value tells
    _, d3, a4, d5, a5, _ = arm.geometry
    stretched = np.arctan2(d3, a4) - np.arctan2(d5, a5)
    values = ((3, stretched), (3, stretched + np.pi), (4, -0.5 * np.pi), (4, 0.5 * np.pi))
    return [Cause("fold", joint, float(wrap(value - arm.closed_form.shift[joint]))) for joint, value in values]
