"""Which cells of one slice a motion can come from that arrives at a cell of the next: chords jump gaps, motions do not.

Between two slices all feasible postures are in boxes, part by part of the slab. A motion goes on from box to box where
they overlap, and from part to part with r never descending; so cells that no such way joins are joined by no motion.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms.cells import Cells
from selfmotion.arms.slabs import SlabCover
from selfmotion.certificate._chain_kernels import components, meeting
from selfmotion.deadline import OutOfTimeError, in_time

_PARTS = 4  # of a slab
_SIZE = 0.1  # radius of boxes [rad]
_MOST = 20_000  # boxes of a part that are compared with each other
_ROUNDING = 1e-8  # of cells [rad]


def groups(
    slabs: SlabCover, low: float, high: float, one: Cells, two: Cells, deadline: float
) -> tuple[IntArray, IntArray]:
    """Return groups of cells at both ends of a slab, such that motions stay in their group.

    Parameters
    ----------
    slabs : SlabCover
    low, high : float
        Where the slab begins and ends.
    one, two : Cells
        At `low` and at `high`.
    deadline : float
        As :func:`time.perf_counter` tells it.

    Returns
    -------
    of_one, of_two : array of int, shape (m,) and (k,)
        Numbers of groups; −1 of cells that no motion through the slab passes.

    Raises
    ------
    OutOfTimeError
        Also if the slab takes more boxes than can be compared in any time.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges = np.linspace(low, high, _PARTS + 1)
    ways = np.eye(len(one), dtype=bool)  # from cells to what they lead to: themselves, connected parts, cells again
    before = _extent(one)
    for start, stop in pairwise(edges.tolist()):
        in_time(deadline)
        boxes = slabs.boxes(start, stop, _SIZE)
        if len(boxes) > _MOST:
            raise OutOfTimeError
        now = boxes.low, boxes.high, components(boxes.low, boxes.high, slabs.wraps)
        ways = ways @ _meeting(before, now, slabs.wraps)
        before = now
    ways = ways @ _meeting(before, _extent(two), slabs.wraps)
    m, k = ways.shape
    i, j = np.nonzero(ways)
    _, number = connected_components(coo_array((np.ones(len(i), bool), (i, m + j)), shape=(m + k, m + k)), False)
    return np.where(ways.any(axis=1), number[:m], -1), np.where(ways.any(axis=0), number[m:], -1)


Labelled = tuple[FloatArray, FloatArray, IntArray]
"""Ends of boxes (m, n), and the number of the part (m,) that each belongs to."""


def _extent(cells: Cells) -> Labelled:
    """Return the boxes of cells, each a part by itself."""
    room = cells.dev + _ROUNDING
    return np.minimum(cells.a, cells.b) - room, np.maximum(cells.a, cells.b) + room, np.arange(len(cells))


def _meeting(one: Labelled, two: Labelled, wraps: BoolArray) -> BoolArray:
    """Return which parts of one set of boxes meet which of another."""
    found = np.zeros([int(label.max(initial=-1)) + 1 for _, _, label in (one, two)], bool)
    meeting(*one, *two, wraps, found)
    return found
