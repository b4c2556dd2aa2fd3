"""The self-motion of planar arms: along any line of the redundancy vector, and in closed form for one degree.

With one redundant degree the arm is a 3R arm (a 4R arm with a fixed direction of its last link is one as
well, with its fourth joint ``θ4 = direction − u``). Every event on its self-motion is then the meeting of
two circles: a fold, or a joint at one of its limits.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms.protocols import Breakpoints, Cause

if TYPE_CHECKING:
    from selfmotion.arms.planar import PlanarArm

# Circles that miss each other by rounding alone still touch: relative to the squares of their sizes.
_TOUCH = 1e-14
# A posture computed at a breakpoint misses its task by less than this part of the reach, or is none.
_MISSED = 1e-10


class PlanarLine:
    """The self-motion of a planar arm along ``u(s) = u0 + s·direction``: poses and postures.

    Parameters
    ----------
    arm : PlanarArm
    u0, direction : array, shape (n_u,)
    """

    u_range = (-np.pi, np.pi)

    def __init__(self, arm: PlanarArm, u0: FloatArray, direction: FloatArray) -> None:
        self.arm = arm
        self.u0 = u0
        self.direction = direction
        self.n = arm.n
        self.branches: tuple[str, ...] = arm.branches
        self.limits = arm.limits
        self.periodic = bool((direction == np.rint(direction)).all())

    @property
    def wraps(self) -> BoolArray:
        """Which joints are full turns, shape (n,); those without limits are."""
        return ~self.limits.limited

    def pose(self, x: ArrayLike) -> FloatArray:
        """Return the constants of task points `x`: the points, shape (k, 2)."""
        return np.asarray(x, dtype=float).reshape(-1, 2)

    def solve(self, pose: FloatArray, u: ArrayLike, branch: int) -> tuple[FloatArray, BoolArray]:
        """Return postures (k, m, n) and whether they reach, for parameters `u` of shape (k, m)."""
        along = self.u0 + np.asarray(u, dtype=float)[..., None] * self.direction
        return self.arm.solve(pose[:, None, :], along, branch)


class PlanarSelfMotion(PlanarLine):
    """The self-motion of a planar arm with one redundant degree, u being the direction of the third link.

    Parameters
    ----------
    arm : PlanarArm
        With ``n_u == 1``.
    """

    def __init__(self, arm: PlanarArm) -> None:
        super().__init__(arm, np.zeros(1), np.ones(1))
        self._offset = arm.annulus[0]

    def breakpoints(self, pose: FloatArray) -> Breakpoints:
        """Return every parameter at which feasibility may change, in closed form.

        Parameters
        ----------
        pose : array, shape (k, 2)

        Returns
        -------
        Breakpoints
            Per fold (θ2 = 0 where ``|x − l3 e(u)| = l1 + l2``, θ2 = π where it is ``|l1 − l2|``) two columns; per
            finite joint limit two, or one for the fourth joint; and u = ψ, ψ + π as markers, ψ the direction
            of x: only there can w = 0, where θ1 is free.
        """
        target = pose - self._offset
        columns: list[_Column] = []
        for joint, bound, value in self._finite_limits():
            columns += self._at_limit(target, joint, Cause(f"{bound} limit", joint), value)
        columns += self._folds(target)
        psi = _direction(target)
        columns += [self._on_both(psi + turn, np.nan, np.nan, Cause("marker", -1)) for turn in (0.0, np.pi)]
        u = np.stack([column.u for column in columns], axis=1)
        q = np.stack([column.q for column in columns], axis=1)
        # Circles that only nearly touch give a direction worth looking at, but no posture.
        q[~(self.arm.task_error(q, pose[:, None, :]) <= _MISSED * self.arm.reach)] = np.nan
        return Breakpoints(
            wrap(u),
            np.stack([column.on_branch for column in columns], axis=1),
            q,
            tuple(column.cause for column in columns),
        )

    def _finite_limits(self) -> list[tuple[int, str, float]]:
        """Return (joint, "lower" or "upper", angle) of every limit that can bind modulo 2π."""
        lower, upper = self.limits.lower, self.limits.upper
        binding = [j for j in range(self.n) if upper[j] - lower[j] < TAU]
        return [(j, bound, float(values[j])) for j in binding for bound, values in (("lower", lower), ("upper", upper))]

    def _folds(self, target: FloatArray) -> list[_Column]:
        l1, l2, l3 = self.arm.links[:3]
        columns = []
        for theta2, wrist in ((0.0, l1 + l2), (np.pi, abs(l1 - l2))):
            for u in _meetings(target, l3, wrist):
                w = target - l3 * _unit(u)
                theta1 = _direction(w) + (np.pi if theta2 and l1 < l2 else 0.0)
                if wrist == 0.0:
                    theta1 = np.full_like(theta1, np.nan)  # folded onto the base: θ1 is free
                columns.append(self._on_both(u, theta1, theta2, Cause("fold", 1)))
        return columns

    def _at_limit(self, target: FloatArray, joint: int, cause: Cause, value: float) -> list[_Column]:
        """Return where joint `joint` has the angle `value`."""
        l1, l2, l3 = self.arm.links[:3]
        if joint == 0:  # the elbow stands still: links 2 and 3 reach from there
            rest = target - l1 * _unit(np.array([value]))
            return [
                self._column(u, value, _direction(rest - l3 * _unit(u)) - value, cause) for u in _meetings(rest, l3, l2)
            ]
        if joint == 1:  # |w| is known
            wrist = np.hypot(l1 + l2 * np.cos(value), l2 * np.sin(value))
            inner = np.arctan2(l2 * np.sin(value), l1 + l2 * np.cos(value))
            return [
                self._column(u, _direction(target - l3 * _unit(u)) - inner, value, cause)
                for u in _meetings(target, l3, wrist)
            ]
        if joint == 2:  # links 2 and 3 are one rigid link
            rigid = np.hypot(l3 + l2 * np.cos(value), l2 * np.sin(value))
            lag = np.arctan2(l2 * np.sin(value), l3 + l2 * np.cos(value))
            columns = []
            for along in _meetings(target, rigid, l1):
                theta1 = _direction(target - rigid * _unit(along))
                u = along + lag
                columns.append(self._column(u, theta1, u - value - theta1, cause))
            return columns
        assert self.arm.direction is not None
        u = np.full(len(target), self.arm.direction - value)
        both = []
        for branch in range(len(self.branches)):
            q, ok = self.arm.solve(target + self._offset, u[:, None], branch)
            column = self._column(np.where(ok, u, np.nan), q[:, 0], q[:, 1], cause)
            mask = np.zeros_like(column.on_branch)
            mask[:, branch] = True
            both.append(column._replace(on_branch=mask))
        return both

    def _column(self, u: FloatArray, theta1: ArrayLike, theta2: ArrayLike, cause: Cause) -> _Column:
        q = np.empty((len(u), self.n))
        q[:, 0], q[:, 1] = theta1, theta2
        q[:, 2] = u - q[:, 0] - q[:, 1]
        if self.arm.direction is not None:
            q[:, 3] = self.arm.direction - u
        q = wrap(q)
        sine = np.sin(q[:, 1])
        on_branch = np.stack([sine >= -_TOUCH * 100, sine <= _TOUCH * 100], axis=1)
        return _Column(u, on_branch, q, cause)

    def _on_both(self, u: FloatArray, theta1: ArrayLike, theta2: ArrayLike, cause: Cause) -> _Column:
        column = self._column(u, theta1, theta2, cause)
        return column._replace(on_branch=np.ones_like(column.on_branch))


class _Column(NamedTuple):
    """One column of `Breakpoints`."""

    u: FloatArray
    on_branch: BoolArray
    q: FloatArray
    cause: Cause


def _unit(angle: FloatArray) -> FloatArray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _direction(vector: FloatArray) -> FloatArray:
    return np.arctan2(vector[:, 1], vector[:, 0])


def _meetings(target: FloatArray, swing: float, distance: float) -> tuple[FloatArray, FloatArray]:
    """Return both angles t with ``|target − swing·e(t)| = distance``, NaN where there are none.

    By half angles, ``tan²(τ/2) = (distance² − (R − swing)²)/((R + swing)² − distance²)`` with R = |target| and
    t = ψ ± τ: all digits survive where the circles touch.
    """
    radius, psi = np.hypot(target[:, 0], target[:, 1]), _direction(target)
    sine2 = (distance - radius + swing) * (distance + radius - swing)
    cosine2 = (radius + swing - distance) * (radius + swing + distance)
    slack = _TOUCH * (radius + swing + distance) ** 2
    meet = (sine2 >= -slack) & (cosine2 >= -slack) & (radius > 0)
    tau = np.where(meet, 2 * np.arctan2(np.sqrt(sine2.clip(0)), np.sqrt(cosine2.clip(0))), np.nan)
    return psi + tau, psi - tau
