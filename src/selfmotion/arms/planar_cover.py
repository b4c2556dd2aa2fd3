"""The self-motion of a planar arm with one redundant degree in cells that leave nothing out.

Any of the three directions φ1, φ2, φ3 may serve as parameter where it is the one that moves fastest: there the other
two are smooth functions of it, through folds as well. A piece, a chart with an interval of its parameter, is dropped
only when it is proved that no posture of it reaches, that another direction moves faster on all of it, or that a limit
excludes it; so every feasible posture is in a cell of the chart in which it moves fastest.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms._cover_kernels import cover
from selfmotion.arms.cells import Cells
from selfmotion.arms.windows import turned_postures

if TYPE_CHECKING:
    from selfmotion.arms.planar import PlanarArm

_ROOTS = 16  # pieces that each chart's circle is looked at in first
_NARROWEST = 1e-7  # a piece this narrow that is still not understood becomes a cell as it is [rad]
_OVERRUN = 1e-9  # of limits, which verification allows [rad]


class PlanarCover:
    """Cells of a planar arm with one redundant degree; see :class:`~selfmotion.arms.cells.Cover`.

    Parameters
    ----------
    arm : PlanarArm
    elbow : {"any", "positive", "negative"}
    """

    def __init__(self, arm: PlanarArm, elbow: str = "any") -> None:
        self.n = arm.n
        self.offset, self.direction = arm.annulus[0], 0.0 if arm.direction is None else arm.direction
        self.links = np.ascontiguousarray(arm.links[:3])
        windows = [_windows(arm, elbow, j) for j in range(arm.n)]
        self.wraps = np.array([not mine for mine in windows])
        self.first = np.cumsum([0, *(len(w) for w in windows)])
        self._period = arm.limits.period
        flat = [pair for w in windows for pair in w]
        self.windows = np.array(flat, float).reshape(-1, 2) + np.array([-_OVERRUN, _OVERRUN])
        edges = np.linspace(-np.pi, np.pi, _ROOTS + 1)
        roots = [(c, s, lo, hi) for c in range(3) for s in (1.0, -1.0) for lo, hi in pairwise(edges)]
        self.roots = np.array(roots)

    def cells(self, x: FloatArray, spacing: float) -> Cells:
        """Return cells that hold every feasible posture at x."""
        return self._cover(x, self.roots, np.zeros((len(self.roots), self.n)), False, np.full(len(self.roots), spacing))

    def split(self, x: FloatArray, cells: Cells, spacing: FloatArray) -> Cells:
        """Return cells of about `spacing` that hold every feasible posture of the given ones at x."""
        return self._cover(x, cells.pieces, 0.5 * (cells.a + cells.b), True, spacing)

    def points(self, q: FloatArray, turned: bool) -> Cells:
        """Return cells that are postures q (m, n) alone; if `turned`, in every turn that the limits allow."""
        found = [tuple(posture) for posture in q]
        if turned:
            found = [turn for p in q for turn in turned_postures(p, self.wraps, self.windows, self.first, self._period)]
        a = np.array(found, float).reshape(-1, self.n)
        pieces = np.full((len(a), 4), -1.0)
        return Cells(a, a.copy(), np.full(a.shape, _OVERRUN), pieces, np.zeros(len(a), np.int64))

    def _cover(
        self, point: FloatArray, pieces: FloatArray, near: FloatArray, only_near: bool, spacing: FloatArray
    ) -> Cells:
        x, y = point - self.offset
        capacity = max(64, 3 * len(pieces))
        while True:
            a, b, bow, dev, rest = (np.empty((capacity, self.n)) for _ in range(5))
            found, origin = np.empty((capacity, 4)), np.empty(capacity, np.int64)
            count = cover(
                self.links, x, y, self.direction, self.wraps, self.windows, self.first,
                pieces[:, 0].astype(np.int64), pieces[:, 1].copy(), pieces[:, 2].copy(), pieces[:, 3].copy(),
                near, only_near, spacing, _NARROWEST, a, b, bow, dev, rest,
                found, origin,
            )  # fmt: skip
            if count <= capacity:
                return Cells(a, b, dev, found, origin, bow, rest)[:count]
            capacity = count


def _windows(arm: PlanarArm, elbow: str, joint: int) -> list[tuple[float, float]]:
    """Return the intervals that a joint may lie in, none if it is an angle modulo 2π.

    A joint with a limit on one side is one: by whole turns any motion gets away from it.
    """
    low, high = float(arm.limits.lower[joint]), float(arm.limits.upper[joint])
    if not (np.isfinite(low) and np.isfinite(high)):
        if joint != 1 or elbow == "any":
            return []
        # All half turns are alike; one may be cut by the limit.
        boxes = [(float(box.lower[joint]), float(box.upper[joint])) for box in arm.boxes(elbow)]
        return [max(boxes, key=lambda box: box[1] - box[0])]
    if joint != 1 or elbow == "any":
        return [(low, high)]
    first = 0.0 if elbow == "positive" else -np.pi
    turns = range(int(np.floor((low - first - np.pi) / TAU)), int(np.ceil((high - first) / TAU)) + 1)
    halves = [(max(low, first + TAU * k), min(high, first + np.pi + TAU * k)) for k in turns]
    return [(one, two) for one, two in halves if one <= two]
