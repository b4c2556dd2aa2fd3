"""Slabs of a planar arm with one redundant degree: its postures along a part of the path in boxes.

While r is in a slab the tool stays in a disc about the point in the slab's middle, as far as the path's speed lets it
get. Pieces of the self-motion are enclosed for all points of that disc and dropped only where no posture reaches, where
another chart serves, or where a limit excludes all, as in :mod:`selfmotion.arms.planar_cover`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms._slab_kernels import slab_boxes
from selfmotion.arms.planar_cover import PlanarCover
from selfmotion.arms.slabs import Boxes

if TYPE_CHECKING:
    from selfmotion.arms.planar import PlanarArm
    from selfmotion.paths import Path

_NARROWEST = 1e-9  # of pieces [rad]
_MISPLACED = 1e-12  # parts of the reach by which rounding may misplace a task point


class PlanarSlabs:
    """Boxes of a planar arm along a path.

    Parameters
    ----------
    arm : PlanarArm
        With one redundant degree.
    path : Path
        One that bounds its speed, see :meth:`~selfmotion.paths.Path.fastest`.
    elbow : {"any", "positive", "negative"}
    """

    slabs = 16

    def __init__(self, arm: PlanarArm, path: Path, elbow: str = "any") -> None:
        self.path, self.n = path, arm.n
        self._cover = PlanarCover(arm, elbow)
        self.wraps = self._cover.wraps
        limits = arm.limits
        self.one_sided = limits.limited & ~(np.isfinite(limits.lower) & np.isfinite(limits.upper))
        self._room = _MISPLACED * arm.reach

    def boxes(self, low: float, high: float, size: float) -> Boxes:
        """Return boxes that hold every feasible posture at every r in [low, high]; see :class:`SlabCover`."""
        roots = self._cover.roots
        anywhere = np.full((len(roots), self.n), np.inf)
        return self._boxes(low, high, roots, -anywhere, anywhere, np.full(len(roots), size))

    def split(self, low: float, high: float, boxes: Boxes, size: FloatArray) -> Boxes:
        """Return boxes that hold every posture of `boxes` at every r in [low, high]; see :class:`SlabCover`."""
        return self._boxes(low, high, boxes.pieces, boxes.low, boxes.high, size)

    def _boxes(
        self, low: float, high: float, pieces: FloatArray, at_least: FloatArray, at_most: FloatArray, size: FloatArray
    ) -> Boxes:
        cover = self._cover
        x, y = self.path(0.5 * (low + high)) - cover.offset
        rho = 0.5 * (high - low) * self.path.fastest(low, high) * (1 + _MISPLACED) + self._room
        capacity = max(256, 4 * len(pieces))
        while True:
            starts, stops, found = (np.empty((capacity, k)) for k in (self.n, self.n, 4))
            clean, origin, places = np.empty(capacity, bool), np.empty(capacity, np.int64), np.empty((capacity, 4, 5))
            count = slab_boxes(
                cover.links, x, y, rho, cover.direction, self.wraps, cover.windows, cover.first,
                np.ascontiguousarray(pieces), at_least, at_most, size, _NARROWEST,
                starts, stops, clean, found, origin, places,
            )  # fmt: skip
            if count <= capacity:
                ends = self._with_tool(places[:count])
                return Boxes(starts[:count], stops[:count], clean[:count], found[:count], origin[:count], ends)
            capacity = count

    def _with_tool(self, places: FloatArray) -> FloatArray:
        """Return where links end (m, 4, 5) with the end of a fourth one, whose direction is given."""
        if self.n == len(self._cover.links):
            return places
        tool = places[:, -1:].copy()
        tool[..., :2] += self._cover.offset
        tool[..., 4] += self._room
        return np.concatenate([places, tool], axis=1)
