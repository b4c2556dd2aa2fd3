"""The self-motion of an arm that is solved but not enclosed, in proved pieces of its curves: not proved to be all."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import _walk_kernels as kernels
from selfmotion.arms._cell_kernels import Found
from selfmotion.arms.cells import Cells
from selfmotion.arms.curve_cover import CurveCells, found_for

if TYPE_CHECKING:
    from selfmotion.arms.locked import LockedArm

VALUES = 256
"""Values of u, evenly spaced, at which curves are looked for."""
_SHORTEST = 1e-5  # step below which a curve is not followed any farther [rad]
_CELLS = 2048  # for which there is room to begin with


class TracedCover(CurveCells):
    """Cells of an arm solved at single values of u; see :class:`~selfmotion.arms.cells.Cover`.

    Parameters
    ----------
    arm : LockedArm
    branch : str
        ``"any"``; the arm refuses others.

    Notes
    -----
    The arm is solved at 256 values of u, evenly spaced over the limits of the joint that it is. From every posture that
    is not on a known curve yet, inside the other joints' limits or not, its curve is followed both ways by proved
    pieces, until it closes or steps of 1e-5 rad are not proved, as where the posture is singular: a box of 2e-3 rad
    then stands for what is there. Of this, what is inside the limits becomes cells. Every piece is proved to hold one
    curve, and all of it. Left out is a curve that no posture of these lies on: one whose u stays between two of the
    values; and, next to singularities that take ever shorter pieces, what is left after 50000 of them.
    """

    def __init__(self, arm: LockedArm, branch: str = "any") -> None:
        super().__init__(arm, branch)
        self._arm = arm
        low, high = arm.parameter_range
        self._values = low + (np.arange(VALUES) + 0.5) * (high - low) / VALUES

    def cells(self, x: FloatArray, spacing: float) -> Cells:
        """Return the cells that are found at x."""
        arm = self._arm
        seeds, _ = arm.postures(np.tile(x, (VALUES, 1)), self._values)

        def trace(room: Found) -> int:
            seen = found_for(len(room.a), self.n)
            return kernels.trace_from(arm.kernel, arm.task(x), self.windows, seeds, spacing, _SHORTEST, room, seen)

        return self._in_order(self._filled(trace, _CELLS))
