"""Spatial arms with seven joints that a closed form solves: one redundant degree at every pose."""

from __future__ import annotations

from functools import cached_property
from itertools import product as combinations
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import branch_index, finite_array
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import _chain_kernels, _curve_kernels, _family_kernels
from selfmotion.arms.cells import Cover
from selfmotion.arms.chain import Chain
from selfmotion.arms.closed_forms import FAMILIES, ClosedForm, closed_form_of, shortfall
from selfmotion.arms.curve_cover import CurveCover
from selfmotion.arms.curve_self_motion import CurveSelfMotion
from selfmotion.arms.curve_slabs import CurveSlabs
from selfmotion.arms.limits import JointBox, JointLimits
from selfmotion.arms.slabs import SlabCover
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import conjugate, from_matrix, logarithm, matrix, product

if TYPE_CHECKING:
    from selfmotion.paths import Path

_TASKS = 6

_UPRIGHT = 0.3  # sine of the angle of a wrist from above its shoulder


class SpatialArm:
    """An arm with seven revolute joints whose tool keeps a pose, six tasks, and has one redundant degree.

    Parameters
    ----------
    chain : Chain
        Its joints, frames and limits; the tool frame is the chain's last. Lengths in metres.

    Attributes
    ----------
    n : int
        Number of joints, 7.
    n_u : int
        Degree of redundancy, 1.
    branches : tuple of str
        The inverse kinematics' branches at a given u, named by the joints that tell them apart.
    closed_form : ClosedForm
        How it is solved, and what u is.

    Raises
    ------
    InvalidInputError
        If no closed form solves the chain.

    Notes
    -----
    A task point is a pose: a row ``x, y, z`` [m] and the unit quaternion ``w, x, y, z`` of the tool frame in the
    chain's base frame. Formulas: docs/mathematics.
    """

    kind = "urdf"
    dimension = 7
    turning = 3
    """How many directions of the tool's rotation are tasks."""
    families = FAMILIES
    recognised = staticmethod(closed_form_of)
    n_u = 1

    def __init__(self, chain: Chain) -> None:
        form = self.recognised(chain)
        if form is None:
            known = ", ".join(family.name for family in self.families)
            raise InvalidInputError(
                "arm", f"has {chain.n} joints that no closed form solves", f"give an arm of the families {known}"
            )
        self.chain, self.closed_form = chain, form
        self.n = chain.n
        self.limits: JointLimits = chain.limits
        self.branches = self.closed_form.family.branches

    def __repr__(self) -> str:
        return f"SpatialArm({self.chain!r})"

    @property
    def geometry(self) -> FloatArray:
        """The lengths that the closed form's kernels want."""
        return self.closed_form.geometry

    @property
    def closed(self) -> _family_kernels.Closed:
        """The closed form's kernels."""
        return _family_kernels.closed(self.closed_form.family.number)

    def geometry_at(self, origin: FloatArray) -> FloatArray:
        """Return the geometry for a cover at one pose, whose closed form's last frame is at `origin` (3,).

        Where a wrist is above or below its shoulder arm angles are not counted from the vertical; others do as well.
        """
        if self.closed_form.family.number != _family_kernels.SRS:
            return self.geometry
        across, length = np.hypot(origin[0], origin[1]), np.linalg.norm(origin)
        return self.geometry if across > _UPRIGHT * length else np.array([*self.geometry[:3], 1.0, 0.0, 0.0])

    @cached_property
    def kernel(self) -> _curve_kernels.Chain:
        """The chain for kernels, in the closed form's joint angles ``q + shift``."""
        offsets = self.chain.offsets.copy()
        for j, angle in enumerate(self.closed_form.shift):
            c, s = np.cos(-angle), np.sin(-angle)
            turn = np.eye(4)
            turn[:2, :2] = [[c, -s], [s, c]]
            offsets[j + 1] = turn @ offsets[j + 1]
        turns = np.ascontiguousarray(offsets[:, :3, :3])
        shifts = np.ascontiguousarray(offsets[:, :3, 3])
        lengths = np.linalg.norm(shifts[1:], axis=1)
        levers = np.cumsum(lengths[::-1])[::-1].copy()
        return _curve_kernels.Chain(turns, shifts, levers)

    @property
    def has_structure(self) -> bool:
        """Whether the structure of the angle domain is known in closed form: it is not."""
        return False

    @property
    def reach(self) -> float:
        """Sum of the lengths between the joints, from the first to the tool [m]."""
        return float(self.kernel.levers[0])

    @cached_property
    def parameter_range(self) -> tuple[float, float]:
        """The values of u to look at: the limits of the joint that it is, or a full turn [rad]."""
        if self.closed_form.family.parameter == "q7":
            low, high = self.limits.lower[6], self.limits.upper[6]
            if np.isfinite(low) and np.isfinite(high) and high - low < TAU:
                return float(low) - 1e-9, float(high) + 1e-9
        return -np.pi, np.pi

    def task(self, x: FloatArray) -> _curve_kernels.Task:
        """Return a pose (7,) as the kernels want it."""
        return _curve_kernels.Task(np.ascontiguousarray(matrix(x[3:])), np.ascontiguousarray(x[:3]), self.turning)

    def root(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return a pose (7,) as the closed form wants it: rotation (3, 3, 2) and position (3, 2), low and high ends."""
        rotation, position = self._root(x)
        return np.repeat(rotation[..., None], 2, -1), np.repeat(position[..., None], 2, -1)

    def _root(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the poses (..., 7) of the closed form's last frame, in its base."""
        base, tool = self.closed_form.base, self.closed_form.tool
        turned = matrix(x[..., 3:])
        back = np.linalg.inv(tool)
        rotation = base[:3, :3].T @ turned @ back[:3, :3]
        position = (turned @ back[:3, 3] + x[..., :3] - base[:3, 3]) @ base[:3, :3]
        return np.ascontiguousarray(rotation), np.ascontiguousarray(position)

    def shortfall(self, x: ArrayLike) -> FloatArray:
        """Return how far poses are out of the links' reach, whatever the joint limits, shape (...) [m].

        It is by how much shoulder and wrist would have to be nearer to each other, or farther apart.
        """
        pose = np.asarray(x, dtype=float)
        rotation, position = self._root(pose.reshape(-1, 7))
        return shortfall(self.closed_form, rotation, position).reshape(pose.shape[:-1])

    def forward(self, q: ArrayLike) -> FloatArray:
        """Return the tool's poses, shape (..., 7)."""
        joints = self._joints(q)
        rotation, position = self._frames(joints.reshape(-1, self.n))
        pose = np.concatenate([position, from_matrix(rotation)], axis=1)
        return pose.reshape(*joints.shape[:-1], 7)

    def _frames(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        rotation, position = np.empty((len(q), 3, 3)), np.empty((len(q), 3))
        moved = np.ascontiguousarray(q + self.closed_form.shift)
        _chain_kernels.forward_all(self.kernel.turns, self.kernel.shifts, moved, rotation, position)
        return rotation, position

    def joint_positions(self, q: ArrayLike) -> FloatArray:
        """Return the base, every joint and the tool as points, shape (..., n + 1, 3)."""
        joints = self._joints(q)
        flat = joints.reshape(-1, self.n) + self.closed_form.shift
        found = np.empty((len(flat), self.n + 1, 3))
        axes, centers, rotation, position = np.empty((self.n, 3)), np.empty((self.n, 3)), np.empty((3, 3)), np.empty(3)
        for k, posture in enumerate(flat):
            _chain_kernels.frames(self.kernel.turns, self.kernel.shifts, posture, axes, centers, rotation, position)
            found[k, :-1], found[k, -1] = centers, position
        return found.reshape(*joints.shape[:-1], self.n + 1, 3)

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the tool's velocity and angular velocity by the joint rates, in the base frame, shape (..., 6, n)."""
        joints = self._joints(q)
        flat = np.ascontiguousarray(joints.reshape(-1, self.n) + self.closed_form.shift)
        found = np.empty((len(flat), _TASKS, self.n))
        _chain_kernels.jacobian_all(self.kernel.turns, self.kernel.shifts, flat, found)
        return found.reshape(*joints.shape[:-1], _TASKS, self.n)

    def jacobian_rate(self, q: ArrayLike, dq: ArrayLike) -> FloatArray:
        """Return how :meth:`jacobian` changes along `dq`, shape (..., 6, n).

        Where ``J dq = 0`` this is the Hessian of the task times dq too, as Newton's method wants it.
        """
        joints, rates = np.broadcast_arrays(self._joints(q), self._joints(dq))
        flat = np.ascontiguousarray(joints.reshape(-1, self.n) + self.closed_form.shift)
        found = np.empty((len(flat), _TASKS, self.n))
        moved = np.ascontiguousarray(rates.reshape(-1, self.n))
        _chain_kernels.jacobian_rate_all(self.kernel.turns, self.kernel.shifts, flat, moved, found)
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

    def solve(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, BoolArray]:
        """Solve the inverse kinematics.

        Parameters
        ----------
        x : array_like, shape (..., 7)
            Poses.
        u : array_like, shape (..., 1)
            Redundancy parameters [rad]; leading dimensions broadcast against those of `x`.
        branch : int or str
            Index or name of the branch.

        Returns
        -------
        q : array, shape (..., n)
            Joint angles in [−π, π]; NaN out of reach.
        ok : array of bool, shape (...)
            Whether there is such a posture. Joint limits are not looked at.
        """
        index = branch_index(self.branches, branch)
        pose, parameter = np.asarray(x, dtype=float), np.asarray(u, dtype=float)[..., 0]
        shape = np.broadcast_shapes(pose.shape[:-1], parameter.shape)
        rotation, position = self._root(np.broadcast_to(pose, (*shape, 7)).reshape(-1, 7))
        q, ok = np.full((len(position), self.n), np.nan), np.zeros(len(position), bool)
        at = np.ascontiguousarray(np.broadcast_to(parameter, shape).reshape(-1))
        _family_kernels.solve_all(self.closed.solve, self.geometry, rotation, position, at, index, q, ok)
        return wrap(q - self.closed_form.shift).reshape(*shape, self.n), ok.reshape(shape)

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

    def _parameter_gradient(self, q: FloatArray) -> FloatArray:
        """Return ∂u/∂q, shape (..., n)."""
        gradient = np.zeros(q.shape)
        if self.closed_form.family.parameter == "q7":
            gradient[..., 6] = 1.0
            return gradient
        step = 1e-6
        for j in range(self.n):
            ahead, behind = q.copy(), q.copy()
            ahead[..., j] += step
            behind[..., j] -= step
            gradient[..., j] = wrap(self.u_of(ahead) - self.u_of(behind))[..., 0] / (2 * step)
        return gradient

    def u_of(self, q: ArrayLike) -> FloatArray:
        """Return the redundancy parameter of postures, in [−π, π], shape (..., 1) [rad]."""
        moved = self._joints(q) + self.closed_form.shift
        if self.closed_form.family.parameter == "q7":
            return np.asarray(wrap(moved[..., 6:7]))
        flat = np.ascontiguousarray(moved.reshape(-1, self.n))
        found = np.empty(len(flat))
        _family_kernels.parameter_all(self.closed.parameter_of, self.geometry, flat, found)
        return found.reshape(*moved.shape[:-1], 1)

    def branch_of(self, q: ArrayLike) -> IntArray:
        """Return the branch index of postures (..., n), shape (...)."""
        moved = self._joints(q) + self.closed_form.shift
        flat = np.ascontiguousarray(wrap(moved.reshape(-1, self.n)))
        found = np.empty(len(flat), np.int64)
        _family_kernels.branch_all(self.closed.branch_of, self.geometry, flat, found)
        return found.reshape(moved.shape[:-1])

    def is_on_branch(self, q: ArrayLike, branch: int | str, tolerance: float) -> BoolArray:
        """Return whether postures (..., n) are on a branch, or within `tolerance` of one of its folds."""
        joints = self._joints(q)
        inside = np.zeros(joints.shape[:-1], bool)
        for box in self.boxes(self.branches[branch_index(self.branches, branch)]):
            middle, half = 0.5 * (box.lower + box.upper), 0.5 * (box.upper - box.lower)
            with np.errstate(invalid="ignore"):
                off = np.where(
                    self._tells_apart, np.abs(wrap(joints - np.where(np.isfinite(middle), middle, 0.0))), 0.0
                )
                inside |= (off <= np.where(self._tells_apart, np.minimum(half, np.pi), 1.0) + tolerance).all(axis=-1)
        return inside

    @cached_property
    def _tells_apart(self) -> BoolArray:
        """Which joints' values tell branches apart."""
        return np.array([len(found) > 1 for found in self._halves])

    @cached_property
    def _halves(self) -> list[dict[str, list[tuple[float, float]]]]:
        """Per joint, the intervals modulo 2π of each part of the branches' names that concerns it."""
        shift, quarter, half = self.closed_form.shift, 0.5 * np.pi, np.pi
        found: list[dict[str, list[tuple[float, float]]]] = [{} for _ in range(self.n)]
        found[1] = {"q2+": [(0.0, half)], "q2-": [(-half, 0.0)]}
        if self.closed_form.family.parameter == "q7":
            _, d3, a4, d5, a5, _ = self.geometry
            stretched = float(wrap(np.arctan2(d3, a4) - np.arctan2(d5, a5)))
            found[3] = {"q4+": [(stretched, stretched + half)], "q4-": [(stretched - half, stretched)]}
            found[4] = {"q5in": [(-quarter, quarter)], "q5out": [(quarter, half + quarter)]}
        else:
            found[3] = {"q4+": [(0.0, half)], "q4-": [(-half, 0.0)]}
            found[5] = {"q6+": [(0.0, half)], "q6-": [(-half, 0.0)]}
        return [
            {name: [(low - shift[j], high - shift[j]) for low, high in parts] for name, parts in options.items()}
            for j, options in enumerate(found)
        ]

    def boxes(self, elbow: str = "any", around: ArrayLike | None = None) -> list[JointBox]:
        """Return the joint limits, narrowed to one branch.

        Parameters
        ----------
        elbow : str
            ``"any"`` or the name of a branch.
        around : array_like, shape (n,), optional
            Posture near which boxes come first.

        Returns
        -------
        list of JointBox
            Several where a branch's joints lie in several intervals inside the limits.
        """
        whole = JointBox(self.limits.lower, self.limits.upper)
        if elbow == "any":
            return [whole]
        named = self.branches[branch_index(self.branches, elbow)].split()
        options: list[list[tuple[float, float]]] = []
        for j, halves in enumerate(self._halves):
            low, high = whole.lower[j], whole.upper[j]
            parts = [part for name, given in halves.items() if name in named for part in given]
            if not parts:
                options.append([(low, high)])
                continue
            least, most = (low, high) if np.isfinite([low, high]).all() else (-np.pi, np.pi)
            turns = range(int(np.floor((least - np.pi) / TAU)) - 1, int(np.ceil((most + np.pi) / TAU)) + 2)
            inside = [(max(low, a + TAU * k), min(high, b + TAU * k)) for a, b in parts for k in turns]
            options.append([(a, b) for a, b in inside if a <= b])
        boxes = [JointBox(*(np.array(ends) for ends in zip(*choice, strict=True))) for choice in combinations(*options)]
        near = np.zeros(self.n) if around is None else self._joints(around)
        away = [float(np.maximum(np.maximum(b.lower - near, near - b.upper), 0.0).sum()) for b in boxes]
        return [boxes[k] for k in np.argsort(away, kind="stable")]

    def relaxed(self, slack: ArrayLike, upper: ArrayLike | None = None) -> SpatialArm:
        """Return the same arm with joint limits that give by `slack`, upper ones by `upper` if it is given [rad]."""
        more = np.asarray(slack if upper is None else upper, dtype=float)
        ends = zip(self.limits.lower - np.asarray(slack, dtype=float), self.limits.upper + more, strict=True)
        chain = self.chain
        return type(self)(
            Chain(chain.names, chain.offsets, list(ends), chain.prismatic, chain.velocity, chain.base, chain.tip)
        )

    def cover(self, elbow: str = "any") -> Cover:
        """Return the cells of the self-motion."""
        return CurveCover(self, elbow)

    def slabs(self, path: Path, elbow: str = "any") -> SlabCover:
        """Return boxes of the postures along parts of a path."""
        return CurveSlabs(self, path, elbow)

    def self_motion(self) -> CurveSelfMotion:
        """Return the self-motion."""
        return CurveSelfMotion(self)

    def line(self, u0: ArrayLike, direction: ArrayLike) -> object:
        """Raise InvalidInputError: one redundant degree leaves nothing to choose a line in."""
        raise InvalidInputError("u0", "chooses a line, and the arm has one redundant degree", "use self_motion()", u0)

    def _joints(self, q: ArrayLike) -> FloatArray:
        joints = np.asarray(q, dtype=float)
        if joints.shape[-1:] != (self.n,):
            finite_array("q", q, joints.ndim, self.n)
        return joints


__all__ = ["ClosedForm", "SpatialArm"]
