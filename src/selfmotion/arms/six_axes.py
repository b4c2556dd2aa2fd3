"""What arms with six revolute joints have in common, whatever makes them redundant: a free roll, or a rail."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import branch_index
from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms.limits import JointBox
from selfmotion.arms.spatial import SpatialArm
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import matrix


class SixAxisArm(SpatialArm):
    """An arm whose closed form is one of six axes: its kernels put the tool on, and no one joint tells branches apart.

    Parameters
    ----------
    chain : Chain
    """

    what: ClassVar[str]
    """What such an arm is, for errors."""

    def _root(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the poses (..., 7) of the tool in the closed form's base."""
        base = self.closed_form.base
        rotation = base[:3, :3].T @ self._frame(x)
        return np.ascontiguousarray(rotation), np.ascontiguousarray((x[..., :3] - base[:3, 3]) @ base[:3, :3])

    def _frame(self, x: FloatArray) -> FloatArray:
        """Return the rotations (..., 3, 3) that the closed form starts from at poses (..., 7)."""
        return np.asarray(matrix(x[..., 3:]))

    def is_on_branch(self, q: ArrayLike, branch: int | str, tolerance: float) -> BoolArray:
        """Return whether postures (..., n) are on a branch, or within `tolerance` of its fold along the self-motion."""
        joints, index = self._joints(q), branch_index(self.branches, branch)
        along = tolerance * np.linalg.svd(self.jacobian(joints))[2][..., -1, :]
        return np.asarray(np.any([self.branch_of(joints + s * along) == index for s in (-1.0, 0.0, 1.0)], axis=0))

    def boxes(self, elbow: str = "any", around: ArrayLike | None = None) -> list[JointBox]:
        """Return the joint limits.

        Raises
        ------
        InvalidInputError
            If one branch is asked for: signs that are no joint's alone tell them apart, so no box holds just one.
        """
        if elbow != "any":
            raise InvalidInputError(
                "branch", f"cannot be asked of {self.what}", "leave it out, or give a start posture", elbow
            )
        return super().boxes("any", around)
