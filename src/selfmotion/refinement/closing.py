"""From a spline that nearly keeps the task to a motion that keeps it exactly, between the collocation points too."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.angles import nearest_turn
from selfmotion.arms import JointBox, RedundantArm
from selfmotion.arms.protocols import u_period
from selfmotion.paths import Path
from selfmotion.paths.base import path_parameter
from selfmotion.refinement.spline import SplineSpace

# Joints nearer to a limit than about this are moved less [rad]: far more than corrections are, which so change little.
_SOFT = 0.05
_EXACT = 1e-15  # tracking at which nothing is left to gain, as a part of the reach
_LOST = 1e-9  # tracking error, as a part of the reach, of what could not be brought onto the path
_MOST_STEPS = 30  # of Newton's method; four are usual
_NODES_PER_SPAN = 8  # at which the turns of u are counted


class _Closed(NamedTuple):
    """Postures on the task and what made them, k of each."""

    q: FloatArray
    s: FloatArray
    jacobian: FloatArray
    multipliers: FloatArray


class ClosedSpline:
    """The motion ``θ = s + g(J(s)ᵀ λ; s)``, where λ(r) makes the tool be at x(r).

    Parameters
    ----------
    arm : RedundantArm
    path : Path
    space : SplineSpace
    coefficients : array, shape (n, m)
        Of s, inside the limits.
    box : JointBox
        Joint limits, narrowed to one elbow if the problem asks for it.

    Notes
    -----
    Joint by joint ``g(v; a) = a v/√((a + ρ)² + v²)`` with ``a = (s − lower)(upper − s)/(upper − lower)``, the room that
    the joint has, and ρ = 0.05 rad; a free joint has g = v. Since ``|g| < a`` no correction, however large, breaks a
    limit, and a joint on its limit stays there: limits hold by construction, not by a check. With one limit only, a is
    the distance to it. The motion is as smooth as s and x are, wherever the arm is not singular.
    """

    def __init__(
        self, arm: RedundantArm, path: Path, space: SplineSpace, coefficients: FloatArray, box: JointBox
    ) -> None:
        self.arm, self.path, self.space, self.box = arm, path, space, box
        self.coefficients = coefficients
        self._spline = space.spline(coefficients)
        both = np.isfinite(box.lower) & np.isfinite(box.upper)
        self._width = np.where(both, box.upper - np.where(both, box.lower, 0.0), np.inf)
        self._nodes = path.grid(_NODES_PER_SPAN * space.m)
        self._directions = np.unwrap(arm.u_of(self(self._nodes)), axis=0, period=u_period(arm))

    def __call__(self, r: ArrayLike) -> FloatArray:
        """Return the joint angles, shape (..., n), turns included [rad]."""
        values = path_parameter(r)
        return self._closed(values.reshape(-1)).q.reshape(*values.shape, self.arm.n)

    @property
    def breaks(self) -> FloatArray:
        """Path parameters inside (0, 1) where the first or the second derivative may jump."""
        knots, times = np.unique(self.space.knots, return_counts=True)
        inner = (knots > 0.0) & (knots < 1.0) & (times > 1)
        return np.union1d(self.path.breaks, knots[inner])

    def u(self, r: ArrayLike) -> FloatArray:
        """Return the redundancy vector, shape (..., n_u), continuous along the path [rad]."""
        values = path_parameter(r)
        near = np.stack([np.interp(values, self._nodes, column) for column in self._directions.T], axis=-1)
        return nearest_turn(self.arm.u_of(self(values)), near, u_period(self.arm))

    def rates(self, r: ArrayLike) -> FloatArray:
        """Return dθ/dr, shape (..., n)."""
        values = path_parameter(r)
        flat = values.reshape(-1)
        at = self._closed(flat)
        ds = self._spline(flat, 1)
        pull, room = _pull(at.jacobian, at.multipliers), self._room(at.s)
        by_pull, by_room = _slopes(pull, room)
        given = (
            ds + by_room * self._room_rate(at.s, ds) + by_pull * _pull(self.arm.jacobian_rate(at.s, ds), at.multipliers)
        )
        now = self.arm.jacobian(at.q)
        lack = self.arm.task_rate(self.path(flat), self.path(flat, 1)) - (now @ given[:, :, None])[:, :, 0]
        speed = _solved((now * by_pull[:, None, :]) @ np.swapaxes(at.jacobian, 1, 2), lack)
        rates = given + by_pull * _pull(at.jacobian, speed)
        return rates.reshape(*values.shape, self.arm.n)

    def correction(self, r: FloatArray) -> FloatArray:
        """Return the largest change of a joint from s to the motion at r (k,), shape (k,) [rad]; infinite off path."""
        at = self._closed(r)
        lost = self.arm.task_error(at.q, self.path(r)) > _LOST * self.arm.reach
        return np.where(lost, np.inf, np.abs(at.q - at.s).max(axis=1))

    def _room(self, s: FloatArray) -> FloatArray:
        """Return the room a of each joint: below the distance to either limit, infinite for a free joint."""
        below, above = s - self.box.lower, self.box.upper - s
        two_sided = np.isfinite(self._width)
        product = np.where(two_sided, below, 1.0) * np.where(two_sided, above, 1.0) / self._width
        return np.maximum(np.where(two_sided, product, np.minimum(below, above)), 0.0)

    def _room_rate(self, s: FloatArray, ds: FloatArray) -> FloatArray:
        """Return how the room changes along ds; zero for free joints."""
        two_sided = np.isfinite(self._width)
        middle = np.where(two_sided, self.box.lower, 0.0) + np.where(two_sided, self.box.upper, 0.0)
        one_sided = np.where(np.isfinite(self.box.lower), 1.0, np.where(np.isfinite(self.box.upper), -1.0, 0.0))
        return np.where(two_sided, (middle - 2 * s) / self._width, one_sided) * ds

    def _closed(self, r: FloatArray) -> _Closed:
        """Solve for λ by Newton's method, all r at once; where it fails the tracking error says so."""
        arm, x, s = self.arm, self.path(r), self._spline(r)
        room, jacobian = self._room(s), arm.jacobian(s)
        found = np.zeros(jacobian.shape[:2])
        best, least = s, arm.task_error(s, x)
        for _ in range(_MOST_STEPS):
            if not least.max(initial=0.0) > _EXACT * arm.reach:
                break
            by_pull = _slopes(_pull(jacobian, found), room)[0]
            square = (arm.jacobian(best) * by_pull[:, None, :]) @ np.swapaxes(jacobian, 1, 2)
            multipliers = found + _solved(square, arm.task_residual(best, x))
            q = s + _corrections(_pull(jacobian, multipliers), room)
            miss = arm.task_error(q, x)
            better = miss < least
            if not better.any():
                break
            found = np.where(better[:, None], multipliers, found)
            best, least = np.where(better[:, None], q, best), np.where(better, miss, least)
        return _Closed(best, s, jacobian, found)


def _pull(jacobian: FloatArray, multipliers: FloatArray) -> FloatArray:
    """Return Jᵀλ, shape (k, n)."""
    return np.asarray((jacobian * multipliers[:, :, None]).sum(axis=1))


def _corrections(v: FloatArray, a: FloatArray) -> FloatArray:
    """Return g(v; a) = a v/√((a + ρ)² + v²), v where a is infinite."""
    with np.errstate(invalid="ignore"):
        return np.where(np.isfinite(a), a * v / np.hypot(a + _SOFT, v), v)


def _slopes(v: FloatArray, a: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the derivatives of g by v and by a."""
    with np.errstate(invalid="ignore"):
        h = np.hypot(a + _SOFT, v)
        by_v = np.where(np.isfinite(a), a * ((a + _SOFT) / h) ** 2 / h, 1.0)
        by_a = np.where(np.isfinite(a), v / h * (1.0 - a * (a + _SOFT) / h**2), 0.0)
    return by_v, by_a


def _solved(matrices: FloatArray, right: FloatArray) -> FloatArray:
    """Solve small systems (k, t, t) for (k, t); if one is singular to the last bit, all by least squares."""
    try:
        return np.asarray(np.linalg.solve(matrices, right[:, :, None])[:, :, 0])
    except np.linalg.LinAlgError:
        return np.asarray((np.linalg.pinv(matrices) @ right[:, :, None])[:, :, 0])
