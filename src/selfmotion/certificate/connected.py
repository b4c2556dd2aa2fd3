"""Which cells of one slice a motion can come from that arrives at a cell of the next: chords jump gaps, motions do not.

Between two slices all feasible postures are in boxes, part by part of the slab. A motion goes on from box to box where
they overlap, and from part to part with r never descending; so cells that no such way joins are joined by no motion.
"""

from __future__ import annotations

import time

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms.cells import Cells
from selfmotion.arms.slabs import Boxes, SlabCover
from selfmotion.certificate._chain_kernels import components, meeting

_PARTS = 4  # of a slab
_SIZE = 0.1  # radius of boxes [rad]
_ROUNDING = 1e-8  # of cells [rad]


class NotInTimeError(Exception):
    """The deadline passed before a slab was covered."""


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
    NotInTimeError
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    edges = np.linspace(low, high, _PARTS + 1)
    leads: BoolArray | None = None  # from the parts of the self-motion at the beginning to those that are reached
    begin: BoolArray | None = None
    boxes = label = None
    for start, stop in zip(edges[:-1], edges[1:], strict=True):
        if time.perf_counter() > deadline:
            raise NotInTimeError
        new = slabs.boxes(float(start), float(stop), _SIZE)
        to = components(new.low, new.high, slabs.wraps)
        count = int(to.max(initial=-1)) + 1
        if leads is None or boxes is None or label is None:
            begin, leads = _touched(one, new, to, count, slabs.wraps), np.eye(count, dtype=bool)
        else:
            step = np.zeros((leads.shape[1], count), bool)
            meeting(boxes.low, boxes.high, label, new.low, new.high, to, slabs.wraps, step)
            leads = leads @ step
        boxes, label = new, to
    assert leads is not None
    assert begin is not None
    assert boxes is not None
    end = _touched(two, boxes, label, leads.shape[1], slabs.wraps)
    ways = begin @ leads @ end.T  # which cell leads to which
    m, k = ways.shape
    i, j = np.nonzero(ways)
    _, number = connected_components(coo_array((np.ones(len(i), bool), (i, m + j)), shape=(m + k, m + k)), False)
    return np.where(ways.any(axis=1), number[:m], -1), np.where(ways.any(axis=0), number[m:], -1)


def _touched(cells: Cells, boxes: Boxes, label: IntArray, count: int, wraps: BoolArray) -> BoolArray:
    """Return which connected parts of the boxes each cell meets, shape (m, count)."""
    room: FloatArray = cells.dev + _ROUNDING
    low, high = np.minimum(cells.a, cells.b) - room, np.maximum(cells.a, cells.b) + room
    found = np.zeros((len(cells), count), bool)
    meeting(low, high, np.arange(len(cells)), boxes.low, boxes.high, label, wraps, found)
    return found
