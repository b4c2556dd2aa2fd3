"""The self-motion of arms whose tool lies along the last joint's axis, in cells: straight lines along that joint."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import _straight_kernels as kernels
from selfmotion.arms._cell_kernels import Found
from selfmotion.arms.cells import Cells
from selfmotion.arms.curve_cover import CurveCells

if TYPE_CHECKING:
    from selfmotion.arms.roll import RollArm

_ALONG = 1e-14  # off the last joint's axis, and off its direction, that is rounding: parts of the reach, and of a turn


def is_straight(arm: RollArm) -> bool:
    """Return whether an arm's tool lies along its last joint's axis, so that only this joint moves in self-motions."""
    tool = arm.closed_form.tool
    return max(float(np.hypot(*tool[:2, 3])) / arm.reach, float(np.hypot(*tool[:2, 2]))) <= _ALONG


class StraightCover(CurveCells):
    """Cells of an arm whose rolling tool lies along the last joint's axis; see :class:`~selfmotion.arms.cells.Cover`.

    Parameters
    ----------
    arm : RollArm
    branch : str
        ``"any"`` or one of the arm's branches.
    rests : bool
        Whether the last joint never has a reason to move, so that cells need not say where it is.
    """

    def __init__(self, arm: RollArm, branch: str = "any", rests: bool = False) -> None:
        super().__init__(arm, branch)
        self.arm, self.rests = arm, rests

    def cells(self, x: FloatArray, spacing: float) -> Cells:
        """Return cells that hold every feasible posture at x."""
        arm, closed = self.arm, self.arm.closed
        root, origin = arm.root(x)
        start = np.concatenate([root[..., 0], origin[None, :, 0]])
        # What the tool is off the axis turns with the roll, and is taken as an error of the pose.
        off = 4 * _ALONG * np.array([-1.0, 1.0])

        def trace(found: Found) -> int:
            return kernels.trace_lines(
                closed.solve, closed.enclose, closed.turned, closed.free, arm.geometry, root + off,
                origin + arm.reach * off, start, self.windows, spacing, self.rests, found,
            )  # fmt: skip

        return self._in_order(self._filled(trace, 512))

    def _divided(self, x: FloatArray, given: Found, spacing: FloatArray, room: Found) -> int:
        return kernels.divide_lines(self.windows, given, spacing, room)
