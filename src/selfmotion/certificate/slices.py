"""Slices: the cells at one r and what is proved on them, and which of two neighbouring slices motions may join."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import wrap
from selfmotion.arms.cells import Cells
from selfmotion.certificate._arrays import Values

SAME = 1e-9  # how near the ends of cells are that continue each other [rad]
_HOLE = 16  # cells of the holes in a tube that are filled, more between longer runs
Rows = IntArray | slice


@dataclass
class Slice:
    """The cells at one r, and what is proved on them."""

    r: float
    x: FloatArray
    """The task point there."""
    cells: Cells
    joined: BoolArray
    """Whether a cell begins where the one before it ends, shape (m,)."""
    severed: BoolArray
    """Whether what a cell's ends (m, 2) were joined to has been dropped."""
    fixed: bool = False
    forward: Values | None = None
    backward: Values | None = None
    least: FloatArray | None = None
    """The least cost of a motion through each cell, shape (m,)."""
    wraps: BoolArray | bool = True
    """Which joints are angles modulo 2π, shape (n,); others, such as a rail, are what they are."""
    after: IntArray | None = None
    """Groups of its cells (m,) in the slab that follows: no motion leads from one to another; None if not known."""
    before: IntArray | None = None
    """The same in the slab that ends here."""

    def below(self, threshold: float, least: FloatArray) -> Slice:
        """Return the slice with the cells whose `least` cost (m,) is no more than `threshold`.

        Cells in narrow holes between them stay too: values are sharper without holes.
        """
        rows = least <= threshold
        changes = np.flatnonzero(rows[1:] != rows[:-1]) + 1
        bounds = [0, *changes.tolist(), len(rows)]
        for k in range(1, len(bounds) - 2):
            first, last = bounds[k], bounds[k + 1]
            widest = max(_HOLE, first - bounds[k - 1], bounds[k + 2] - last)
            if not rows[first] and last - first <= widest and self.joined[first : last + 1].all():
                rows[first:last] = True
        return self.kept(rows)

    def kept(self, rows: BoolArray) -> Slice:
        """Return the slice with some of its cells only."""
        if rows.all():
            return replace(self)
        joined, severed = self.joined.copy(), self.severed.copy()
        joined[1:] &= rows[:-1]
        severed[1:, 0] |= self.joined[1:] & ~rows[:-1]
        severed[:-1, 1] |= self.joined[1:] & ~rows[1:]
        self._sever_at_seams(rows, severed)
        left = np.flatnonzero(rows)
        one_run = len(left) > 0 and left[-1] - left[0] == len(left) - 1
        chosen = slice(left[0], left[-1] + 1) if one_run else left  # a slice of an array need not be copied
        one, two, least = self.forward, self.backward, self.least
        return Slice(
            self.r, self.x, self.cells[chosen], joined[chosen], severed[chosen], self.fixed,
            None if one is None else one.of(chosen), None if two is None else two.of(chosen),
            None if least is None else least[chosen], self.wraps,
            None if self.after is None else self.after[chosen], None if self.before is None else self.before[chosen],
        )  # fmt: skip

    def _sever_at_seams(self, rows: BoolArray, severed: BoolArray) -> None:
        """Mark the kept ends of pieces that went on in cells of other pieces which are dropped."""
        ends = ~severed
        ends[:, 0] &= rows & ~self.joined
        ends[:, 1] &= rows & ~np.append(self.joined[1:], False)
        if not ends.any():
            return
        cell, end = np.nonzero(ends)
        q = np.where((end == 0)[:, None], self.cells.a[cell], self.cells.b[cell])
        a, b = self.cells.a, self.cells.b
        room = 0.5 * np.abs(b - a) + self.cells.dev + SAME
        away = q[:, None] - 0.5 * (a + b)
        inside = np.all(np.abs(np.where(self.wraps, wrap(away), away)) <= room, axis=2)
        inside[np.arange(len(cell)), cell] = False
        severed[cell, end] = np.any(inside, axis=1) & ~np.any(inside & rows, axis=1)


def led_parts(one: Slice, two: Slice) -> list[tuple[Rows, Rows]]:
    """Return the cells of two neighbouring slices, either the first, that motions may join: all, or group by group."""
    mine, theirs = joint_groups(one, two)
    if mine is None or theirs is None:
        return [(slice(None), slice(None))]
    return [(np.flatnonzero(mine == number), np.flatnonzero(theirs == number)) for number in np.unique(theirs)]


def joint_groups(one: Slice, two: Slice) -> tuple[IntArray | None, IntArray | None]:
    """Return the groups of the cells of two neighbouring slices in the slab between them."""
    return (one.after, two.before) if one.r < two.r else (one.before, two.after)


def leading_on(slices: list[Slice]) -> list[Slice]:
    """Return slices, from one end, without the cells to which no cell of the slice before leads."""
    found = slices[:1]
    for part in slices[1:]:
        groups_before, own = joint_groups(found[-1], part)
        led = groups_before is None or own is None or np.isin(own, groups_before)
        found.append(part if led is True else part.kept(np.asarray(led)))
    return found
