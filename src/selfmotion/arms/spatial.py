"""Spatial arms with seven joints that a closed form solves: one redundant degree at every pose."""

from __future__ import annotations

from functools import cached_property
from itertools import product as combinations
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import branch_index
from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import _family_kernels
from selfmotion.arms.cells import Cover
from selfmotion.arms.chain import Chain
from selfmotion.arms.chain_arm import ChainArm
from selfmotion.arms.closed_forms import FAMILIES, ClosedForm, Family, closed_form_of, shortfall
from selfmotion.arms.curve_cover import CurveCover
from selfmotion.arms.curve_self_motion import CurveSelfMotion
from selfmotion.arms.curve_slabs import CurveSlabs
from selfmotion.arms.limits import JointBox
from selfmotion.arms.slabs import SlabCover
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import matrix

if TYPE_CHECKING:
    from selfmotion.paths import Path

_UPRIGHT = 0.3  # sine of the angle of a wrist from above its shoulder


class SpatialArm(ChainArm):
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

    families: tuple[Family, ...] = FAMILIES
    recognised = staticmethod(closed_form_of)

    def __init__(self, chain: Chain) -> None:
        form = self.recognised(chain)
        if form is None:
            known = ", ".join(family.name for family in self.families)
            raise InvalidInputError(
                "arm", f"has {chain.n} joints that no closed form solves", f"give an arm of the families {known}"
            )
        self.closed_form = form
        super().__init__(chain, form.shift, form.family.branches, form.family.parameter)

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
        return wrap(q - self.shift, self.limits.period).reshape(*shape, self.n), ok.reshape(shape)

    def _parameter_gradient(self, q: FloatArray) -> FloatArray:
        """Return ∂u/∂q, shape (..., n)."""
        gradient = np.zeros(q.shape)
        if self.parameter == "q7":
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
        moved = self._joints(q) + self.shift
        if self.parameter == "q7":
            return np.asarray(wrap(moved[..., 6:7]))
        flat = np.ascontiguousarray(moved.reshape(-1, self.n))
        found = np.empty(len(flat))
        _family_kernels.parameter_all(self.closed.parameter_of, self.geometry, flat, found)
        return found.reshape(*moved.shape[:-1], 1)

    def branch_of(self, q: ArrayLike) -> IntArray:
        """Return the branch index of postures (..., n), shape (...)."""
        moved = self._joints(q) + self.shift
        flat = np.ascontiguousarray(wrap(moved.reshape(-1, self.n), self.limits.period))
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
        shift, quarter, half = self.shift, 0.5 * np.pi, np.pi
        found: list[dict[str, list[tuple[float, float]]]] = [{} for _ in range(self.n)]
        found[1] = {"q2+": [(0.0, half)], "q2-": [(-half, 0.0)]}
        if self.parameter == "q7":
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

    def _of(self, chain: Chain) -> Self:
        return type(self)(chain)

    def cover(self, elbow: str = "any") -> Cover:
        """Return the cells of the self-motion."""
        return CurveCover(self, elbow)

    def slabs(self, path: Path, elbow: str = "any") -> SlabCover:
        """Return boxes of the postures along parts of a path."""
        return CurveSlabs(self, path, elbow)

    def self_motion(self) -> CurveSelfMotion:
        """Return the self-motion."""
        return CurveSelfMotion(self)


__all__ = ["ClosedForm", "SpatialArm"]
