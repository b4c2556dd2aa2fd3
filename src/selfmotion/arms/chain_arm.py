"""What is known of an arm in space from its chain alone: frames, Jacobians, tasks and limits; not how it is solved."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array
from selfmotion._types import BoolArray, FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import _chain_kernels, _curve_kernels
from selfmotion.arms.chain import Chain
from selfmotion.arms.limits import JointBox, JointLimits
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import conjugate, from_matrix, logarithm, matrix, product

_TASKS = 6
_ON_LIMIT = 1e-9  # [rad]


class ChainArm(ABC):
    """An arm of revolute joints whose tool keeps a pose, with one joint more than it has tasks.

    Parameters
    ----------
    chain : Chain
        Its joints, frames and limits; the tool frame is the chain's last. Lengths in metres.
    shift : array, shape (n,)
        What kernels count joint angles from: theirs are ``q + shift`` [rad].
    branches : tuple of str
    parameter : str
        What u is, such as ``q7``.
    """

    kind = "urdf"
    dimension = 7
    turning = 3
    """How many directions of the tool's rotation are tasks."""
    n_u = 1
    in_closed_form = True
    """Whether a closed form of ours solves it."""
    rigorous = True
    """Whether the cover leaves nothing out, so that bounds on every motion are proved."""

    def __init__(self, chain: Chain, shift: FloatArray, branches: tuple[str, ...], parameter: str) -> None:
        self.chain, self.shift = chain, shift
        self.n = chain.n
        self.limits: JointLimits = chain.limits
        self.branches = branches
        self.parameter = parameter

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.chain!r})"

    @property
    def has_structure(self) -> bool:
        """Whether the structure of the angle domain is known in closed form: it is not."""
        return False

    @cached_property
    def kernel(self) -> _curve_kernels.Chain:
        """The chain for kernels, in the closed form's joint angles ``q + shift``."""
        offsets = self.chain.offsets.copy()
        for j, angle in enumerate(self.shift):
            c, s = np.cos(-angle), np.sin(-angle)
            turn = np.eye(4)
            turn[:2, :2] = [[c, -s], [s, c]]
            offsets[j + 1] = turn @ offsets[j + 1]
        turns = np.ascontiguousarray(offsets[:, :3, :3])
        shifts = np.ascontiguousarray(offsets[:, :3, 3])
        lengths = np.linalg.norm(shifts[1:], axis=1)
        slides = self.limits.slides
        lengths[slides] += np.maximum(np.abs(self.limits.lower), np.abs(self.limits.upper))[slides]
        levers = np.cumsum(lengths[::-1])[::-1].copy()
        return _curve_kernels.Chain(turns, shifts, levers, int(slides.sum()))

    @property
    def _fixed(self) -> tuple[FloatArray, FloatArray, int]:
        """Turns and shifts between the joints, and the first joint that turns."""
        return self.kernel.turns, self.kernel.shifts, self.kernel.first

    @property
    def reach(self) -> float:
        """Sum of the lengths between the joints, from the first to the tool [m]."""
        return float(self.kernel.levers[0])

    def shortfall(self, x: ArrayLike) -> FloatArray:
        """Return how much farther away the tool should be than all links are long, shape (...) [m]."""
        offset = np.asarray(x, dtype=float)[..., :3] - self.chain.offsets[0][:3, 3]
        return np.asarray(np.linalg.norm(offset, axis=-1) - self.reach)

    def task(self, x: FloatArray) -> _curve_kernels.Task:
        """Return a pose (7,) as the kernels want it."""
        return _curve_kernels.Task(np.ascontiguousarray(matrix(x[3:])), np.ascontiguousarray(x[:3]), self.turning)

    def forward(self, q: ArrayLike) -> FloatArray:
        """Return the tool's poses, shape (..., 7)."""
        joints = self._joints(q)
        rotation, position = self._frames(joints.reshape(-1, self.n))
        pose = np.concatenate([position, from_matrix(rotation)], axis=1)
        return pose.reshape(*joints.shape[:-1], 7)

    def _frames(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        rotation, position = np.empty((len(q), 3, 3)), np.empty((len(q), 3))
        moved = np.ascontiguousarray(q + self.shift)
        _chain_kernels.forward_all(*self._fixed, moved, rotation, position)
        return rotation, position

    def joint_positions(self, q: ArrayLike) -> FloatArray:
        """Return the base, every joint and the tool as points, shape (..., n + 1, 3)."""
        joints = self._joints(q)
        flat = joints.reshape(-1, self.n) + self.shift
        found = np.empty((len(flat), self.n + 1, 3))
        axes, centers, rotation, position = np.empty((self.n, 3)), np.empty((self.n, 3)), np.empty((3, 3)), np.empty(3)
        for k, posture in enumerate(flat):
            _chain_kernels.frames(*self._fixed, posture, axes, centers, rotation, position)
            found[k, :-1], found[k, -1] = centers, position
        return found.reshape(*joints.shape[:-1], self.n + 1, 3)

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the tool's velocity and angular velocity by the joint rates, in the base frame, shape (..., 6, n)."""
        joints = self._joints(q)
        flat = np.ascontiguousarray(joints.reshape(-1, self.n) + self.shift)
        found = np.empty((len(flat), _TASKS, self.n))
        _chain_kernels.jacobian_all(*self._fixed, flat, found)
        return found.reshape(*joints.shape[:-1], _TASKS, self.n)

    def jacobian_rate(self, q: ArrayLike, dq: ArrayLike) -> FloatArray:
        """Return how :meth:`jacobian` changes along `dq`, shape (..., 6, n).

        Where ``J dq = 0`` this is the Hessian of the task times dq too, as Newton's method wants it.
        """
        joints, rates = np.broadcast_arrays(self._joints(q), self._joints(dq))
        flat = np.ascontiguousarray(joints.reshape(-1, self.n) + self.shift)
        found = np.empty((len(flat), _TASKS, self.n))
        moved = np.ascontiguousarray(rates.reshape(-1, self.n))
        _chain_kernels.jacobian_rate_all(*self._fixed, flat, moved, found)
        return found.reshape(*joints.shape[:-1], _TASKS, self.n)

    def task_rate(self, x: ArrayLike, dx: ArrayLike) -> FloatArray:
        """Return the velocity and angular velocity of poses `x` that change by `dx`, shape (..., 6)."""
        pose, rate = np.asarray(x, dtype=float), np.asarray(dx, dtype=float)
        spin = 2.0 * product(rate[..., 3:], conjugate(pose[..., 3:]))[..., 1:]
        return np.concatenate([rate[..., :3], spin], axis=-1)

    def task_residual(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return what postures lack to be at poses `x`: a displacement and a rotation vector, shape (..., 6)."""
        joints, target = self._joints(q), np.asarray(x, dtype=float)
        rotation, position = self._frames(joints.reshape(-1, self.n))
        now = from_matrix(rotation).reshape(*joints.shape[:-1], 4)
        lack = target[..., :3] - position.reshape(*joints.shape[:-1], 3)
        turn = product(target[..., 3:], conjugate(now))
        turn = logarithm(np.where(turn[..., :1] < 0, -turn, turn))
        return np.concatenate([lack, np.broadcast_to(turn, lack.shape)], axis=-1)

    def task_error(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return how far postures are from their poses: the larger of the distance and reach × angle [m], (...)."""
        lack = self.task_residual(q, x)
        return np.maximum(np.linalg.norm(lack[..., :3], axis=-1), self.reach * np.linalg.norm(lack[..., 3:], axis=-1))

    def margins(self, q: ArrayLike) -> FloatArray:
        """Return the signed distance to every joint limit, shape (..., n) [rad]."""
        return self.limits.margin(self._joints(q))

    def manipulability(self, q: ArrayLike) -> FloatArray:
        """Return Yoshikawa's √det(J Jᵀ), shape (...); zero at singular postures."""
        return np.asarray(np.linalg.svd(self.jacobian(q), compute_uv=False).prod(axis=-1))

    @abstractmethod
    def solve(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, BoolArray]:
        """Return the posture at poses (..., 7) and parameters (..., 1), and whether there is one."""

    @abstractmethod
    def _parameter_gradient(self, q: FloatArray) -> FloatArray:
        """Return ∂u/∂q, shape (..., n)."""

    @abstractmethod
    def boxes(self, elbow: str = "any", around: ArrayLike | None = None) -> list[JointBox]:
        """Return the joint limits, narrowed to one branch."""

    @cached_property
    def parameter_range(self) -> tuple[float, float]:
        """The values of u to look at: the limits of the joint that it is, or a full turn [rad]."""
        if self.parameter.startswith("q"):
            joint = int(self.parameter[1:]) - 1
            low, high = self.limits.lower[joint], self.limits.upper[joint]
            if np.isfinite(low) and np.isfinite(high) and high - low < TAU:
                return float(low) - _ON_LIMIT, float(high) + _ON_LIMIT
        return -np.pi, np.pi

    def solve_with_margin(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Like :meth:`solve`, with how far inside (0) or out of reach (−reach) instead of a verdict."""
        q, ok = self.solve(x, u, branch)
        return q, np.where(ok, 0.0, -self.reach)

    def rates(self, x: ArrayLike, dx: ArrayLike, u: ArrayLike, du: ArrayLike, branch: int | str = 0) -> FloatArray:
        """Return the joint rates that go with the rates of pose and redundancy parameter, shape (..., n)."""
        q, _ = self.solve(x, u, branch)
        by_q = self._parameter_gradient(q)
        square = np.concatenate([self.jacobian(q), by_q[..., None, :]], axis=-2)
        speed = np.broadcast_to(np.asarray(du, dtype=float), (*q.shape[:-1], 1))
        wanted = np.broadcast_to(self.task_rate(x, dx), (*q.shape[:-1], self.n - 1))
        right = np.concatenate([wanted, speed], axis=-1)
        with np.errstate(all="ignore"):
            return np.asarray(np.linalg.solve(square, right[..., None])[..., 0])

    def derivative(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Return ∂q/∂u (..., n, 1), and the joint rates by the tool's velocity and angular velocity (..., n, 6)."""
        q, _ = self.solve(x, u, branch)
        square = np.concatenate([self.jacobian(q), self._parameter_gradient(q)[..., None, :]], axis=-2)
        with np.errstate(all="ignore"):
            inverse = np.linalg.inv(square)
        return inverse[..., -1:], inverse[..., :-1]

    def relaxed(self, slack: ArrayLike, upper: ArrayLike | None = None) -> Self:
        """Return the same arm with joint limits that give by `slack`, upper ones by `upper` if it is given [rad]."""
        more = np.asarray(slack if upper is None else upper, dtype=float)
        ends = zip(self.limits.lower - np.asarray(slack, dtype=float), self.limits.upper + more, strict=True)
        return self._of(self.chain.with_limits(list(ends)))

    @abstractmethod
    def _of(self, chain: Chain) -> Self:
        """Return the same sort of arm of another chain."""

    def line(self, u0: ArrayLike, direction: ArrayLike) -> object:
        """Raise InvalidInputError: one redundant degree leaves nothing to choose a line in."""
        raise InvalidInputError("u0", "chooses a line, and the arm has one redundant degree", "use self_motion()", u0)

    def _joints(self, q: ArrayLike) -> FloatArray:
        joints = np.asarray(q, dtype=float)
        if joints.shape[-1:] != (self.n,):
            finite_array("q", q, joints.ndim, self.n)
        return joints
