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
from selfmotion.angles import TAU, unit, wrap
from selfmotion.arms.event_circles import constraints, event_circles
from selfmotion.arms.protocols import Breakpoints, Cause, FreeJoint
from selfmotion.intervals import IntervalSet

if TYPE_CHECKING:
    from selfmotion.arms.planar import PlanarArm

# Circles that miss each other by rounding alone still touch: relative to the squares of their sizes.
_TOUCH = 1e-14
# A joint angle that differs from a fold in its last digits only [rad].
_ON_FOLD = 1e-15
# A posture may stand on a limit up to rounding [rad].
_ON_LIMIT = 1e-12
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
    has_structure = True

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

    def excess(self, q: ArrayLike) -> FloatArray:
        """Return by how much postures (..., n) miss what limits them, zero where they do not."""
        return self.limits.excess(q)

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

    Attributes
    ----------
    singular : array of bool, shape (m,)
        Per separator, whether a joint is free where it vanishes.
    """

    def __init__(self, arm: PlanarArm) -> None:
        super().__init__(arm, np.zeros(1), np.ones(1))
        self._offset = arm.annulus[0]
        circles = event_circles(arm)
        self._centers = np.array([circle.center for circle in circles])
        self._radii = np.array([circle.radius for circle in circles])
        self.singular = np.array([circle.singular for circle in circles])

    def breakpoints(self, pose: FloatArray, exact: bool = False) -> Breakpoints:
        """Return every parameter at which feasibility may change, in closed form.

        Parameters
        ----------
        pose : array, shape (k, 2)
        exact : bool
            Whether circles that miss each other by rounding do not meet.

        Returns
        -------
        Breakpoints
            Two columns per limit of a joint limited on both sides (one for the fourth joint); two per fold
            (θ2 = 0 where ``|x − l3 e(u)| = l1 + l2``, θ2 = π where it is ``|l1 − l2|``); and u = ψ, ψ + π as
            markers, ψ the direction of x: only there can w = 0, where θ1 is free.
        """
        target = pose - self._offset
        slack = 0.0 if exact else _TOUCH
        columns: list[_Column] = []
        for cause in constraints(self.arm):
            at = self._folds if cause.kind == "fold" else self._at_limit
            columns += at(target, cause, slack)
        psi = _direction(target)
        columns += [self._on_both(psi + turn, np.nan, np.nan, Cause("marker", -1, np.nan)) for turn in (0.0, np.pi)]
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

    def separators(self, pose: FloatArray) -> FloatArray:
        """Return functions of the task point whose zeros are where the structure of the self-motion may change.

        Parameters
        ----------
        pose : array, shape (k, 2)

        Returns
        -------
        array, shape (k, m)
            ``(|x − c|² − ρ²) / (ρ + reach)²`` for every :func:`~selfmotion.arms.event_circles.event_circles`:
            polynomials of x, of size 1 about where the arm can reach.
        """
        distance = np.hypot(*np.moveaxis(pose[:, None, :] - self._centers, -1, 0))
        return (distance - self._radii) * (distance + self._radii) / (self._radii + self.arm.reach) ** 2

    def free_joint(self, pose: FloatArray) -> FreeJoint | None:
        """Return the postures with w = 0, the first two links folded onto the base, where θ1 may turn freely.

        Parameters
        ----------
        pose : array, shape (1, 2)
            A task point at which a singular separator vanishes.

        Returns
        -------
        FreeJoint or None
            None where θ2 = π, or the direction of the last link, is outside its limits.
        """
        psi = float(_direction(pose - self._offset)[0])
        rest = {1: np.pi} | ({} if self.arm.direction is None else {3: self.arm.direction - psi})
        allowed = [self._allowed(joint) for joint in range(self.n)]
        if not all(allowed[joint].contains(angle, _ON_LIMIT) for joint, angle in rest.items()):
            return None
        # θ3 = ψ − π − θ1 must be inside its limits as well.
        mirrored = IntervalSet((psi - np.pi - allowed[2].intervals)[:, ::-1], TAU)
        return FreeJoint(0, psi, allowed[0] & mirrored)

    def _allowed(self, joint: int) -> IntervalSet:
        """Return the angles of a joint that its limits allow, modulo 2π."""
        low, high = self.limits.lower[joint], self.limits.upper[joint]
        return IntervalSet([(low, high)], TAU) if high - low < TAU else IntervalSet.full()

    def _folds(self, target: FloatArray, cause: Cause, slack: float) -> list[_Column]:
        """Return where the first two links are stretched, θ2 = 0, or folded, θ2 = π."""
        l1, l2, l3 = self.arm.links[:3]
        wrist = abs(l1 - l2) if cause.value else l1 + l2
        if wrist == 0.0:  # folded onto the base, where θ1 is free: a single point of a single R, at a marker
            return [self._on_both(np.full(len(target), np.nan), np.nan, cause.value, cause)] * 2
        columns = []
        for u in _meetings(target, l3, wrist, slack):
            theta1 = _direction(target - l3 * unit(u)) + (np.pi if cause.value and l1 < l2 else 0.0)
            columns.append(self._on_both(u, theta1, cause.value, cause))
        return columns

    def _at_limit(self, target: FloatArray, cause: Cause, slack: float) -> list[_Column]:
        """Return where a joint stands at one of its limits."""
        l1, l2, l3 = self.arm.links[:3]
        joint, value = cause.joint, cause.value
        if joint == 0:  # the elbow stands still: links 2 and 3 reach from there
            rest = target - l1 * unit(np.array([value]))
            return [
                self._column(u, value, _direction(rest - l3 * unit(u)) - value, cause)
                for u in _meetings(rest, l3, l2, slack)
            ]
        if joint == 1:  # |w| is known
            wrist = np.hypot(l1 + l2 * np.cos(value), l2 * np.sin(value))
            inner = np.arctan2(l2 * np.sin(value), l1 + l2 * np.cos(value))
            return [
                self._column(u, _direction(target - l3 * unit(u)) - inner, value, cause)
                for u in _meetings(target, l3, wrist, slack)
            ]
        if joint == 2:  # links 2 and 3 are one rigid link
            rigid = np.hypot(l3 + l2 * np.cos(value), l2 * np.sin(value))
            lag = np.arctan2(l2 * np.sin(value), l3 + l2 * np.cos(value))
            columns = []
            for along in _meetings(target, rigid, l1, slack):
                theta1 = _direction(target - rigid * unit(along))
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
        on_branch = np.stack([sine >= -_ON_FOLD, sine <= _ON_FOLD], axis=1)
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


def _direction(vector: FloatArray) -> FloatArray:
    return np.arctan2(vector[:, 1], vector[:, 0])


def _meetings(target: FloatArray, swing: float, distance: float, slack: float) -> tuple[FloatArray, FloatArray]:
    """Return both angles t with ``|target − swing·e(t)| = distance``, NaN where there are none.

    By half angles, ``tan²(τ/2) = (distance² − (R − swing)²)/((R + swing)² − distance²)`` with R = |target| and
    t = ψ ± τ: all digits survive where the circles touch.
    """
    radius, psi = np.hypot(target[:, 0], target[:, 1]), _direction(target)
    sine2 = (distance - radius + swing) * (distance + radius - swing)
    cosine2 = (radius + swing - distance) * (radius + swing + distance)
    most = slack * (radius + swing + distance) ** 2
    meet = (sine2 >= -most) & (cosine2 >= -most) & (radius > 0)
    tau = np.where(meet, 2 * np.arctan2(np.sqrt(sine2.clip(0)), np.sqrt(cosine2.clip(0))), np.nan)
    return psi + tau, psi - tau
