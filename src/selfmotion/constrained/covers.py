"""Covers of a constrained arm: its cells and boxes without those that are surely blocked.

What is undecided is looked at in shorter cells, a few times, and kept: a bound loses nothing by it but sharpness.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms.cells import Cells, Cover
from selfmotion.arms.slabs import Boxes, SlabCover
from selfmotion.constrained.constraint import BLOCKED, FREE, UNDECIDED, Constraint

_TIMES = 3  # that undecided cells are split again …
_SHORTER = 4.0  # … into cells so many times as short
_MOST = 200  # undecided cells that are split again at once: more are no borders but narrows
_HALVINGS = 4  # of boxes that are undecided …
_MOST_BOXES = 20_000  # … and not more than these …
_SMALLEST = 1e-3  # … and have a radius above this [rad]; at the ends of the path, in slabs of no width, all are large
_SHRUNK = 0.75  # part of its radius that half a box has where its slab is not too thick for smaller ones
_SHORTEST = 1e-7  # cells that are not split again [rad]


class ConstrainedCover:
    """The cells of an arm that its constraints do not surely forbid; see :class:`~selfmotion.arms.cells.Cover`.

    Parameters
    ----------
    cover : Cover
        Of the arm without constraints.
    constraints : sequence of Constraint
    """

    def __init__(self, cover: Cover, constraints: Sequence[Constraint]) -> None:
        self._cover, self._constraints = cover, tuple(constraints)
        self.n, self.wraps = cover.n, cover.wraps

    def cells(self, x: FloatArray, spacing: float) -> Cells:
        """Return cells that hold every feasible posture at x."""
        return self._sifted(x, self._cover.cells(x, spacing))

    def split(self, x: FloatArray, cells: Cells, spacing: FloatArray) -> Cells:
        """Return cells of about `spacing` that hold every feasible posture of the given ones at x."""
        return self._sifted(x, self._cover.split(x, cells, spacing))

    def points(self, q: FloatArray, turned: bool) -> Cells:
        """Return cells that are postures q (m, n) alone; if `turned`, in every turn that the limits allow."""
        cells = self._cover.points(q, turned)
        return cells[states(self._constraints, cells) != BLOCKED]

    def causes(self, x: FloatArray, spacing: float) -> list[str]:
        """Return what surely blocks cells at x, in words, the most frequent cause first."""
        cells, found = self._cover.cells(x, spacing), Counter[str]()
        for _ in range(_TIMES + 1):
            if not len(cells):
                break
            open_ = np.ones(len(cells), bool)
            for constraint in self._constraints:
                state, by = constraint.of_cells(cells)
                found.update(constraint.cause(int(k)) for k in by[open_ & (state == BLOCKED)])
                open_ &= state != BLOCKED
            longest = np.abs(cells.b - cells.a).max(axis=1, initial=0.0)
            left = np.flatnonzero(open_ & (longest > _SHORTEST))
            cells = self._cover.split(x, cells[left], longest[left] / _SHORTER) if len(left) else cells[left]
        return [cause for cause, _ in found.most_common()]

    def _sifted(self, x: FloatArray, cells: Cells) -> Cells:
        """Return the cells that are not surely blocked, those that are undecided in shorter ones."""
        state = states(self._constraints, cells)
        undecided = (state != BLOCKED) & (state != FREE)
        for _ in range(_TIMES):
            longest = np.abs(cells.b - cells.a).max(axis=1, initial=0.0)
            again = np.flatnonzero(undecided & (longest > _SHORTEST))
            if not 0 < len(again) <= _MOST:
                break
            shorter = self._cover.split(x, cells[again], longest[again] / _SHORTER)
            state_of = states(self._constraints, shorter)
            left = np.flatnonzero((state != BLOCKED) & ~np.isin(np.arange(len(cells)), again))
            cells, order = _inserted(cells, left, shorter, again)
            state = np.concatenate([state[left], state_of])[order]
            undecided = np.concatenate([np.zeros(len(left), bool), state_of != FREE])[order] & (state != BLOCKED)
        kept = state != BLOCKED
        return cells if kept.all() else cells[kept]


def why_empty(cover: Cover, x: FloatArray, spacing: float) -> list[str]:
    """Return what forbids the postures that joint limits allow at x, the most frequent first; none without any.

    Parameters
    ----------
    cover : Cover
        Without cells at x.
    x : array, shape (dimension,)
    spacing : float
        Length of the cells that are looked at [rad].
    """
    return cover.causes(x, spacing) if isinstance(cover, ConstrainedCover) else []


def _inserted(cells: Cells, left: IntArray, shorter: Cells, of: IntArray) -> tuple[Cells, IntArray]:
    """Return cells `left` with those that cells `of` were split into, in order; and their order, left before split."""
    order = np.argsort(np.concatenate([left, of[shorter.origin]]), kind="stable")

    def both(one: FloatArray, two: FloatArray) -> FloatArray:
        return np.concatenate([one[left], two])[order]

    origin = np.concatenate([cells.origin[left], cells.origin[of[shorter.origin]]])[order]
    return Cells(
        both(cells.a, shorter.a), both(cells.b, shorter.b), both(cells.dev, shorter.dev),
        both(cells.pieces, shorter.pieces), origin, both(cells.bow, shorter.bow), both(cells.rest, shorter.rest),
    ), order  # fmt: skip


def states(constraints: Sequence[Constraint], cells: Cells) -> IntArray:
    """Return what is sure of cells: blocked if one constraint says so, free if all do, shape (m,)."""
    if not len(cells):
        return np.zeros(0, np.int64)
    return np.min([constraint.of_cells(cells).state for constraint in constraints], axis=0)


def _together(parts: Sequence[Boxes]) -> Boxes:
    return Boxes(*(np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(Boxes)))


class ConstrainedSlabs:
    """The boxes of an arm that its constraints do not surely forbid; see :class:`~selfmotion.arms.slabs.SlabCover`.

    Parameters
    ----------
    slabs : SlabCover
        Of the arm without constraints.
    constraints : sequence of Constraint
    """

    def __init__(self, slabs: SlabCover, constraints: Sequence[Constraint]) -> None:
        self._slabs, self._constraints = slabs, tuple(constraints)
        self.n, self.wraps, self.one_sided, self.slabs = slabs.n, slabs.wraps, slabs.one_sided, slabs.slabs

    def boxes(self, low: float, high: float, size: float) -> Boxes:
        """Return boxes that hold every feasible posture at every r in [low, high]; see :class:`SlabCover`."""
        return self._sifted(low, high, self._slabs.boxes(low, high, size))

    def split(self, low: float, high: float, boxes: Boxes, size: FloatArray) -> Boxes:
        """Return boxes that hold every posture of `boxes` at every r in [low, high]; see :class:`SlabCover`."""
        return self._sifted(low, high, self._slabs.split(low, high, boxes, size))

    def _sifted(self, low: float, high: float, boxes: Boxes) -> Boxes:
        """Return the boxes that are not surely blocked, those that are undecided in smaller ones if that tells more."""
        levels: list[_Level] = []
        parent, most = np.arange(len(boxes)), np.full(len(boxes), np.inf)
        while len(boxes):
            found = [constraint.of_boxes(boxes.low, boxes.high, boxes.places).state for constraint in self._constraints]
            state = np.min(found, axis=0)
            radius = 0.5 * (boxes.high - boxes.low).max(axis=1)
            again = (state != BLOCKED) & (state != FREE) & (radius > _SMALLEST) & (radius <= _SHRUNK * most)
            again &= len(levels) < _HALVINGS and high > low and len(boxes) <= _MOST_BOXES
            levels.append(_Level(replace(boxes, clean=boxes.clean & (state == FREE)), state, again, parent))
            if not again.any():
                break
            smaller = self._slabs.split(low, high, boxes[again], 0.5 * radius[again])
            parent = np.flatnonzero(again)[smaller.origin]
            boxes, most = replace(smaller, origin=boxes.origin[parent]), radius[parent]
        return _leaves(levels) if levels else boxes


class _Level(NamedTuple):
    """Boxes that were split equally often: what is sure of each (m,), whether it was split again, and its parent."""

    boxes: Boxes
    state: IntArray
    again: BoolArray
    parent: IntArray


def _leaves(levels: Sequence[_Level]) -> Boxes:
    """Return the boxes that are not surely blocked, whole where nothing is sure of any of the parts of one."""
    whole = [(level.state == UNDECIDED) & ~level.again for level in levels]
    for k in range(len(levels) - 1, 0, -1):
        above, parent = levels[k - 1].again, levels[k].parent
        parts, vague = (np.bincount(rows, minlength=len(above)) for rows in (parent, parent[whole[k]]))
        whole[k - 1] |= above & (parts > 1) & (vague == parts)
    kept, hidden = [], np.zeros(len(levels[0].boxes), bool)
    for level, mine in zip(levels, whole, strict=True):
        hidden = hidden[level.parent]
        kept.append(level.boxes[~hidden & (level.state != BLOCKED) & (mine | ~level.again)])
        hidden = hidden | mine
    return _together(kept)
