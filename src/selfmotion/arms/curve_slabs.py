"""Slabs of a spatial arm: its postures along a part of the path in boxes.

While r is in a slab the tool's pose stays near the one in the slab's middle, as far as the path's speeds let it get:
the closed form, evaluated for all those poses at once, encloses the postures of each interval of u and each branch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import _curve_slab_kernels as kernels
from selfmotion.arms._family_kernels import BRANCHES
from selfmotion.arms.curve_cover import CurveCover
from selfmotion.arms.slabs import Boxes

if TYPE_CHECKING:
    from selfmotion.arms.spatial import SpatialArm
    from selfmotion.paths import Path

_PIECES = 16  # of the parameter's range, to begin with …
_LONGEST = 0.5  # … more of it where they would be longer [rad, m]
_THICK = 0.01  # turn of the tool, and way by the reach, in a slab
_SLABS = (16, 512)  # at least and at most
_NARROWEST = 1e-7  # of pieces [rad]
_MISPLACED = 1e-12  # by which rounding may misplace a pose: parts of the reach, and of a turn


class CurveSlabs:
    """Boxes of a spatial arm along a path.

    Parameters
    ----------
    arm : SpatialArm
    path : Path
        One of poses that bounds its speeds, see :meth:`~selfmotion.paths.Path.fastest` and ``turning``.
    branch : str
        ``"any"`` or one of the arm's branches.
    """

    def __init__(self, arm: SpatialArm, path: Path, branch: str = "any") -> None:
        self.arm, self.path, self.n = arm, path, arm.n
        self._cover = CurveCover(arm, branch)
        self.wraps = self._cover.wraps
        limits = arm.limits
        moved = path.turning(0.0, 1.0) + path.fastest(0.0, 1.0) / arm.reach
        self.slabs = int(np.clip(np.ceil(moved / _THICK), *_SLABS))
        self.one_sided = limits.limited & ~(np.isfinite(limits.lower) & np.isfinite(limits.upper))

    def boxes(self, low: float, high: float, size: float) -> Boxes:
        """Return boxes that hold every feasible posture at every r in [low, high]; see :class:`SlabCover`."""
        first, last = self.arm.parameter_range
        count = max(_PIECES, int(np.ceil((last - first) / _LONGEST)))
        edges = np.linspace(first, last, count + 1)
        whole = np.array([float((1 << BRANCHES) - 1), -np.pi, np.pi, -np.pi, np.pi])
        pieces = np.column_stack([edges[:-1], edges[1:], np.tile(whole, (count, 1))])
        anywhere = np.full((count, self.n), np.inf)
        return self._boxes(low, high, pieces, -anywhere, anywhere, np.full(count, size))

    def split(self, low: float, high: float, boxes: Boxes, size: FloatArray) -> Boxes:
        """Return boxes that hold every posture of `boxes` at every r in [low, high]; see :class:`SlabCover`."""
        shift = self.arm.closed_form.shift
        return self._boxes(low, high, boxes.pieces, boxes.low + shift, boxes.high + shift, size)

    def _boxes(
        self, low: float, high: float, pieces: FloatArray, at_least: FloatArray, at_most: FloatArray, size: FloatArray
    ) -> Boxes:
        arm, half = self.arm, 0.5 * (high - low)
        angle = half * self.path.turning(low, high) * (1 + _MISPLACED) + _MISPLACED
        moved = half * self.path.fastest(low, high) * (1 + _MISPLACED) + _MISPLACED * arm.reach
        lever = float(np.linalg.norm(np.linalg.inv(arm.closed_form.tool)[:3, 3]))
        root, origin = arm.root(self.path(0.5 * (low + high)))
        ends = np.array([-1.0, 1.0])
        root, origin = root + angle * ends, origin + (moved + angle * lever) * ends
        capacity, shift = max(256, 4 * len(pieces)), arm.closed_form.shift
        while True:
            starts, stops, found = (np.empty((capacity, k)) for k in (self.n, self.n, kernels.COLUMNS))
            clean, parent = np.empty(capacity, bool), np.empty(capacity, np.int64)
            count = kernels.boxes_of_slab(
                arm.closed.enclose, arm.closed.turned, arm.closed.free, arm.geometry, root, origin, self._cover.windows,
                np.ascontiguousarray(pieces), at_least, at_most, size, _NARROWEST, starts, stops, clean, found, parent,
            )  # fmt: skip
            if count <= capacity:
                return Boxes(
                    starts[:count] - shift, stops[:count] - shift, clean[:count], found[:count], parent[:count],
                    np.empty((count, 0, 5)),
                )  # fmt: skip
            capacity = count
