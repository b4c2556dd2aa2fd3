"""Six-axis arms whose tool may turn freely about its own z-axis: five tasks, one redundant degree, the roll."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.arms import _curve_kernels
from selfmotion.arms.cells import Cover
from selfmotion.arms.chain_arm import ChainArm
from selfmotion.arms.roll_forms import ROLL_FAMILIES, roll_form_of
from selfmotion.arms.six_axes import SixAxisArm
from selfmotion.arms.straight_cover import StraightCover, is_straight
from selfmotion.rotations import matrix

_DOWN = np.array([0.0, 0.0, -1.0])


class RollArm(SixAxisArm):
    """An arm with six revolute joints whose tool keeps a position and the direction of its z-axis.

    Parameters
    ----------
    chain : Chain
        Its joints, frames and limits; the tool frame is the chain's last. Lengths in metres.

    Attributes
    ----------
    n, n_u : int
        6 and 1.

    Raises
    ------
    InvalidInputError
        If no closed form solves the chain.

    Notes
    -----
    A task point is a pose, of which only the position and the z-axis d count. The redundancy parameter is the roll u
    about d, counted from a frame that is smooth in d: the one of the least turn from straight down, which is at a loss
    only for a tool that points straight up. Formulas: docs/mathematics.
    """

    turning = 2
    what = "an arm whose tool rolls"
    families = ROLL_FAMILIES
    recognised = staticmethod(roll_form_of)

    def task(self, x: FloatArray) -> _curve_kernels.Task:
        """Return a pose (7,) as the kernels want it."""
        return _curve_kernels.Task(_reference(_axis(x)), np.ascontiguousarray(x[:3]), self.turning)

    def _frame(self, x: FloatArray) -> FloatArray:
        """Return the frames from which rolls are counted at poses (..., 7)."""
        return _reference(_axis(x))

    def shortfall(self, x: ArrayLike) -> FloatArray:
        """Return how far tool positions are out of reach, whatever direction and joints, shape (...) [m]."""
        return ChainArm.shortfall(self, x)

    def jacobian(self, q: ArrayLike) -> FloatArray:
        """Return the tool's velocity, and the turn of its axis in the frame of rolls, (..., 5, n)."""
        whole = super().jacobian(q)
        frame = _reference(self._tool_axis(q))
        return np.concatenate(
            [whole[..., :3, :], (np.swapaxes(frame, -1, -2) @ whole[..., 3:, :])[..., :2, :]], axis=-2
        )

    def jacobian_rate(self, q: ArrayLike, dq: ArrayLike) -> FloatArray:
        """Return how :meth:`jacobian` changes along `dq`, shape (..., 5, n)."""
        whole, rate = super().jacobian(q), super().jacobian_rate(q, dq)
        axis = self._tool_axis(q)
        frame = np.swapaxes(_reference(axis), -1, -2)
        spin = (whole[..., 3:, :] @ np.asarray(dq, dtype=float)[..., :, None])[..., 0]
        turning = _frame_spin(axis, np.cross(spin, axis))
        carried = rate[..., 3:, :] - np.cross(turning[..., :, None], whole[..., 3:, :], axis=-2)
        return np.concatenate([rate[..., :3, :], (frame @ carried)[..., :2, :]], axis=-2)

    def task_rate(self, x: ArrayLike, dx: ArrayLike) -> FloatArray:
        """Return the velocity of poses `x` that change by `dx`, and the turn of their axes, shape (..., 5)."""
        pose = np.asarray(x, dtype=float)
        whole = super().task_rate(pose, dx)
        frame = np.swapaxes(_reference(_axis(pose)), -1, -2)
        return np.concatenate([whole[..., :3], (frame @ whole[..., 3:, None])[..., :2, 0]], axis=-1)

    def task_residual(self, q: ArrayLike, x: ArrayLike) -> FloatArray:
        """Return what postures lack to be at poses `x`: a displacement and the turn of their axes, shape (..., 5)."""
        joints, target = self._joints(q), np.asarray(x, dtype=float)
        rotation, position = self._frames(joints.reshape(-1, self.n))
        lack = target[..., :3] - position.reshape(*joints.shape[:-1], 3)
        now = rotation[:, :, 2].reshape(*joints.shape[:-1], 3)
        wanted = np.broadcast_to(_axis(target), now.shape)
        across = np.cross(now, wanted)
        sine = np.linalg.norm(across, axis=-1, keepdims=True)
        angle = np.arctan2(sine, (now * wanted).sum(axis=-1, keepdims=True))
        turn = across * np.where(sine > 1e-12, angle / np.maximum(sine, 1e-300), 1.0)
        frame = np.swapaxes(_reference(now), -1, -2)
        return np.concatenate([lack, (frame @ turn[..., None])[..., :2, 0]], axis=-1)

    def u_of(self, q: ArrayLike) -> FloatArray:
        """Return the roll of postures, in [−π, π], shape (..., 1) [rad]."""
        joints = self._joints(q)
        rotation, _ = self._frames(joints.reshape(-1, self.n))
        rolled = np.swapaxes(_reference(rotation[:, :, 2]), -1, -2) @ rotation
        return np.arctan2(rolled[:, 1, 0], rolled[:, 0, 0]).reshape(*joints.shape[:-1], 1)

    def derivative(self, x: ArrayLike, u: ArrayLike, branch: int | str = 0) -> tuple[FloatArray, FloatArray]:
        """Return ∂q/∂u (..., n, 1), and the joint rates by the five rates of the task (..., n, 5)."""
        return super().derivative(x, u, branch)

    def cover(self, elbow: str = "any") -> Cover:
        """Return the cells of the self-motion."""
        return StraightCover(self, elbow) if is_straight(self) else super().cover(elbow)

    def cover_with_an_end_open(self, elbow: str = "any") -> Cover:
        """Return cells for motions one end of which may have any posture.

        A tool along the last axis is rolled by that joint alone, which then has no reason to move.
        """
        return StraightCover(self, elbow, rests=True) if is_straight(self) else self.cover(elbow)

    def _tool_axis(self, q: ArrayLike) -> FloatArray:
        joints = self._joints(q)
        return self._frames(joints.reshape(-1, self.n))[0][:, :, 2].reshape(*joints.shape[:-1], 3)


def _axis(pose: FloatArray) -> FloatArray:
    """Return the z-axes of poses (..., 7), shape (..., 3)."""
    return np.asarray(matrix(pose[..., 3:])[..., :, 2])


def _reference(axis: FloatArray) -> FloatArray:
    """Return the frames (..., 3, 3) with z-axes (..., 3) from which rolls are counted."""
    # The least turn from straight down to d, after the half turn about x that turns z straight down. Written so that it
    # is a rotation to rounding right up to straight up, where it takes d as leaning along x.
    dx, dy, more = axis[..., 0], axis[..., 1], 1.0 + axis[..., 2]
    lean = np.hypot(dx, dy)
    ex, ey = np.where(lean > 0.0, dx / np.maximum(lean, 1e-300), 1.0), dy / np.maximum(lean, 1e-300)
    xx, xy, yy = 1.0 - ex * ex * more, -ex * ey * more, 1.0 - ey * ey * more
    columns = [np.stack([xx, xy, dx], -1), np.stack([-xy, -yy, -dy], -1), axis]
    return np.ascontiguousarray(np.stack(columns, axis=-1))


def _frame_spin(axis: FloatArray, change: FloatArray) -> FloatArray:
    """Return the angular velocity (..., 3) of :func:`_reference` where the axis changes by `change`."""
    dz, across = axis[..., 2], axis[..., 0] ** 2 + axis[..., 1] ** 2
    scale = np.where(dz > 0.0, (1.0 + dz) / np.maximum(across, 1e-300), 1.0 / np.maximum(1.0 - dz, 1.0))
    along = -(np.cross(axis, change) @ _DOWN) * scale
    return np.asarray(np.cross(axis, change) + along[..., None] * axis)
