"""The angle domain as curves: each interval followed through its cell, ready to draw."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import Cause
from selfmotion.domain.fibre import End, Interval
from selfmotion.domain.structure import Cell, DomainStructure

# Places per cell, and how often neighbours between which an end moves by more than this [rad] get one between them.
_PLACES = 201
_MOVED = 0.05
_ROUNDS = 12
_SINE = np.sin(0.5 * np.pi * np.sin(0.5 * np.pi * np.linspace(-1.0, 1.0, _PLACES)))
"""Of a cell from −1 to 1: so dense at its ends that what moves there like a square root moves evenly."""


class Strip(NamedTuple):
    """An interval over the part of the path on which it keeps its ends.

    Attributes
    ----------
    r : array, shape (k,)
        Ascending, from one end of the cell to the other.
    low, high : array, shape (k,)
        Ends of the interval [rad], continuous in r. Equal where joints are locked: the strip is a curve.
    ends : tuple
        What stands at `low` and at `high`: indices of the arm's breakpoints. Empty for a full circle.
    causes : tuple
        The same as `Cause`.
    sheet : int
        Index into the structure's sheets.
    """

    r: FloatArray
    low: FloatArray
    high: FloatArray
    ends: tuple[End, End]
    causes: tuple[tuple[Cause, ...], tuple[Cause, ...]]
    sheet: int

    @property
    def is_circle(self) -> bool:
        """Whether every u is inside."""
        return not self.ends[0]


def strips(structure: DomainStructure, branch: int) -> list[Strip]:
    """Return the angle domain of one branch as strips, in the order of the path.

    Parameters
    ----------
    structure : DomainStructure
    branch : int

    Returns
    -------
    list of Strip
        Together they are the domain. Where joints' turns are counted strips may overlap, and one strip stands
        for all intervals that differ in their turns only.
    """
    return [strip for cell in structure.cells for strip in _of_cell(structure, cell, branch)]


def _of_cell(structure: DomainStructure, cell: Cell, branch: int) -> list[Strip]:
    mine: dict[tuple[End, End], tuple[Interval, int]] = {}
    for interval, part in zip(cell.fibre.intervals, cell.fibre.component, strict=True):
        if interval.branch == branch:
            mine.setdefault(interval.ends, (interval, cell.sheets[part]))
    if not mine:
        return []
    columns = sorted({end[0] for ends in mine for end in ends if end})
    r, u = _followed(structure, cell, columns)
    looked = int(np.searchsorted(r, cell.look))

    def curve(end: End, at: float) -> FloatArray:
        if not end:
            return np.full(len(r), at)
        values = u[:, columns.index(end[0])]
        return values + TAU * np.rint((at - values[looked]) / TAU)

    found = []
    for ends, (interval, sheet) in mine.items():
        low, high = curve(ends[0], interval.low), curve(ends[1], interval.high)
        causes = _causes(cell, ends[0]), _causes(cell, ends[1])
        # Where the two meet, rounding would let them cross.
        found.append(Strip(r, low, np.maximum(low, high), ends, causes, sheet))
    return found


def _causes(cell: Cell, end: End) -> tuple[Cause, ...]:
    return tuple(dict.fromkeys(cell.fibre.causes[column] for column in end))


def _followed(structure: DomainStructure, cell: Cell, columns: list[int]) -> tuple[FloatArray, FloatArray]:
    """Return places through a cell, that of its look among them, and the breakpoints there, continuous."""

    def at(r: FloatArray) -> FloatArray:
        motion = structure.self_motion
        return motion.breakpoints(motion.pose(structure.path(r))).u[:, columns]

    low, high = cell.r
    r = np.unique(np.concatenate([[low, cell.look, high], 0.5 * (low + high) + 0.5 * (high - low) * _SINE[1:-1]]))
    u = _without_gaps(at(r))
    for _ in range(_ROUNDS):
        apart = np.abs(np.angle(np.exp(1j * np.diff(u, axis=0)))).max(axis=1, initial=0.0) > _MOVED
        between = 0.5 * (r[:-1] + r[1:])[apart]
        if not len(between):
            break
        place = np.flatnonzero(apart) + 1
        r, u = np.insert(r, place, between), _without_gaps(np.insert(u, place, at(between), axis=0))
    return r, np.unwrap(u, axis=0)


def _without_gaps(u: FloatArray) -> FloatArray:
    """Return `u`, at an end of the cell where rounding leaves no solution the value beside it."""
    for column in u.T:
        known = np.flatnonzero(np.isfinite(column))
        if 0 < len(known) < len(column):
            column[:] = column[known[np.abs(np.arange(len(column))[:, None] - known).argmin(axis=1)]]
    return u
