"""The self-motion of a spatial arm in cells that leave nothing out: proved pieces of its curves in joint space."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import _trace_kernels as kernels
from selfmotion.arms._cell_kernels import Found, Windows
from selfmotion.arms.cells import Cells
from selfmotion.arms.windows import turned_postures

if TYPE_CHECKING:
    from selfmotion.arms.chain_arm import ChainArm
    from selfmotion.arms.spatial import SpatialArm

_OVERRUN = 1e-9  # of limits, which verification allows [rad]
_PIECES = 8  # of the parameter's range, to begin with …
_LONGEST = 1.0  # … more of it where they would be longer [rad, m]
_NARROWEST = 1e-6  # a box this narrow that is still not understood becomes a cell as it is [rad]
_KEY = np.array([0.7548776662466927, 0.5698402909980532, 0.4301597090019468, 0.3247179572447460])


class CurveCells:
    """What covers by pieces of curves have in common: windows, turns, splitting and order. They differ in their cells.

    Parameters
    ----------
    arm : ChainArm
    branch : str
        ``"any"`` or one of the arm's branches.
    """

    def __init__(self, arm: ChainArm, branch: str = "any") -> None:
        self._chain, self._task, self.n = arm.kernel, arm.task, arm.n
        windows = [_windows(arm, branch, j) for j in range(arm.n)]
        self.wraps = np.array([not mine for mine in windows])
        first = np.cumsum([0, *(len(w) for w in windows)])
        ends = np.array([pair for w in windows for pair in w], float).reshape(-1, 2)
        ends += np.array([-_OVERRUN, _OVERRUN])
        self._shift = arm.shift
        for j, mine in enumerate(windows):  # kernels count joints as the closed form does
            ends[first[j] : first[j] + len(mine)] += self._shift[j]
        # A copy: arrays that may not be written to are of another type, for which kernels would be compiled again.
        self.windows = Windows(self.wraps, ends, first, arm.limits.period.copy())
        self._key = np.resize(_KEY, arm.n) * (1.0 + 0.1 * np.arange(arm.n))

    def split(self, x: FloatArray, cells: Cells, spacing: FloatArray) -> Cells:
        """Return cells of about `spacing` that hold every feasible posture of the given ones at x."""
        given = Found(
            cells.a + self._shift, cells.b + self._shift, cells.bow, cells.dev, cells.rest, cells.pieces, cells.origin
        )
        found = self._filled(lambda room: self._divided(x, given, spacing, room), 3 * len(cells) + 64)
        return Cells(
            found.a - self._shift, found.b - self._shift, found.dev, found.pieces, found.origin, found.bow, found.rest
        )

    def _divided(self, x: FloatArray, given: Found, spacing: FloatArray, room: Found) -> int:
        """Fill in shorter cells than the given ones; return how many there are."""
        return kernels.divide(self._chain, self._task(x), self.windows, given, spacing, _NARROWEST, room)

    def points(self, q: FloatArray, turned: bool) -> Cells:
        """Return cells that are postures q (m, n) alone; if `turned`, in every turn that the limits allow."""
        found = [tuple(posture) for posture in q]
        if turned:
            moved = [turned_postures(p + self._shift, *self.windows) for p in q]
            found = [tuple(np.array(turn) - self._shift) for turns in moved for turn in turns]
        a = np.array(found, float).reshape(-1, self.n)
        pieces = np.column_stack([-np.ones(len(a)), np.ones(len(a)), np.zeros((len(a), 2))])
        return Cells(a, a.copy(), np.full(a.shape, _OVERRUN), pieces, np.zeros(len(a), np.int64))

    def _filled(self, fill: Callable[[Found], int], capacity: int) -> Found:
        while True:
            found = found_for(capacity, self.n)
            count = fill(found)
            if count <= capacity:
                return Found(
                    found.a[:count], found.b[:count], found.bow[:count], found.dev[:count], found.rest[:count],
                    found.pieces[:count], found.origin[:count],
                )  # fmt: skip
            capacity = count

    def _in_order(self, found: Found) -> Cells:
        """Return cells one after the other along their curves, which are told apart by the pieces' first column."""
        m = len(found.a)
        both = np.concatenate([found.a, found.b])
        keys = np.where(self.wraps, np.sin(both + self._key), both) @ self._key
        order, turned, strand = np.empty(m, np.int64), np.empty(m, bool), np.empty(m, np.int64)
        kernels.order_along(found.a, found.b, self.wraps, keys, order, turned, strand)
        a, b = found.a[order], found.b[order]
        a[turned], b[turned] = b[turned], a[turned]
        pieces = found.pieces[order]
        pieces[:, 0] = strand
        k = np.arange(m, dtype=float)
        pieces[:, 2], pieces[:, 3] = k, k + 1.0
        return Cells(
            a - self._shift,
            b - self._shift,
            found.dev[order],
            pieces,
            np.zeros(m, np.int64),
            found.bow[order],
            found.rest[order],
        )


class CurveCover(CurveCells):
    """Cells of a spatial arm with one redundant degree; see :class:`~selfmotion.arms.cells.Cover`.

    Parameters
    ----------
    arm : SpatialArm
    branch : str
        ``"any"`` or one of the arm's branches.
    """

    def __init__(self, arm: SpatialArm, branch: str = "any") -> None:
        super().__init__(arm, branch)
        self.arm = arm
        low, high = arm.parameter_range
        self._edges = np.linspace(low, high, max(_PIECES, int(np.ceil((high - low) / _LONGEST))) + 1)

    def cells(self, x: FloatArray, spacing: float) -> Cells:
        """Return cells that hold every feasible posture at x."""
        arm = self.arm
        root, origin = arm.root(x)
        geometry, closed = arm.geometry_at(origin[:, 0]), arm.closed

        def trace(found: Found) -> int:
            return kernels.trace(
                closed.solve, closed.enclose, closed.turned, closed.free, geometry, root, origin, self._edges,
                arm.kernel, arm.task(x), self.windows, spacing, _NARROWEST, found,
            )  # fmt: skip

        return self._in_order(self._filled(trace, 512))


def found_for(capacity: int, n: int) -> Found:
    """Return room for cells of n joints."""
    a, b, bow, dev, rest = (np.empty((capacity, n)) for _ in range(5))
    return Found(a, b, bow, dev, rest, np.empty((capacity, 4)), np.empty(capacity, np.int64))


def _windows(arm: ChainArm, branch: str, joint: int) -> list[tuple[float, float]]:
    """Return the intervals that a joint may lie in, none if it is an angle modulo 2π.

    One with two whole turns or more counts as that too: whatever motion is shorter than a turn fits somewhere.
    """
    low, high = float(arm.limits.lower[joint]), float(arm.limits.upper[joint])
    if not (np.isfinite(low) and np.isfinite(high)) or high - low >= 2 * arm.limits.period[joint] - _OVERRUN:
        return []
    found = sorted({(float(box.lower[joint]), float(box.upper[joint])) for box in arm.boxes(branch)})
    merged: list[tuple[float, float]] = []
    for one, two in found:
        if merged and one <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(merged[-1][1], two))
        else:
            merged.append((one, two))
    return merged
