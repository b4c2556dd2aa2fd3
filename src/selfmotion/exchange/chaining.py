"""Strokes in any order and direction, chained where their ends meet."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.exchange.pieces import Piece
from selfmotion.paths.base import distance

# Ends whose distances from a third differ by less than this part of the tolerance are equally near.
_EVEN = 1e-6


def chained(strokes: Sequence[list[Piece]], within: float) -> tuple[list[list[Piece]], list[FloatArray]]:
    """Return the chains that strokes make, and the points where it was not plain which one goes on.

    Parameters
    ----------
    strokes : sequence of list of Piece
    within : float
        How far apart two ends may be that meet.

    Returns
    -------
    chains : list of list of Piece
        Each starts with the first stroke of the file that no chain before it has, runs as that does, goes on with the
        stroke whose end is nearest to its own, of several the first one of the file, turned round if need be, and is
        led back from its start in the same way.
    forks : list of array
        Where more than two ends meet.
    """
    if not strokes:
        return [], []
    ends = _Ends(strokes, within)
    chains = []
    for k, stroke in enumerate(strokes):
        if not ends.take(k):
            continue
        ahead, behind = list(stroke), []
        if not ends.closed[k]:
            while (found := ends.following(ahead[-1].end)) is not None:
                ahead += _turned(strokes[found[0]]) if found[1] else strokes[found[0]]
            start = ahead[0].start
            while (found := ends.following(start)) is not None:
                before = strokes[found[0]] if found[1] else _turned(strokes[found[0]])
                behind.append(before)
                start = before[0].start
        chains.append([piece for before in reversed(behind) for piece in before] + ahead)
    return chains, ends.forks


class _Ends:
    """The free ends of strokes, by where they are.

    Attributes
    ----------
    closed : array of bool
        Which strokes end where they start, so that they have no free ends.
    forks : list of array
    """

    def __init__(self, strokes: Sequence[list[Piece]], within: float) -> None:
        from scipy.spatial import cKDTree

        ends = np.array([[stroke[0].start, stroke[-1].end] for stroke in strokes])
        open_by = distance(ends[:, 1] - ends[:, 0])
        # What is short all along its way is not closed: fine curves are drawn as many short lines.
        lengths = np.array([sum(piece.length for piece in stroke) for stroke in strokes])
        self.closed = (open_by <= within) & (lengths > 4 * open_by)
        self.forks: list[FloatArray] = []
        self._within = within
        self._free = [True] * len(strokes)
        # Many strokes may start at one point: ends that coincide are kept together, in the order of the file.
        self._points, where = np.unique(ends[~self.closed].reshape(-1, 2), axis=0, return_inverse=True)
        self._there: list[deque[tuple[int, bool]]] = [deque() for _ in self._points]
        self._left = np.bincount(where.ravel(), minlength=len(self._points))
        self._at: dict[int, tuple[int, ...]] = {}
        for pair, k in zip(where.reshape(-1, 2).tolist(), np.flatnonzero(~self.closed).tolist(), strict=True):
            self._at[k] = tuple(pair)
            for end, point in enumerate(pair):
                self._there[point].append((k, end == 1))
        self._tree = cKDTree(self._points) if len(self._points) else None

    def take(self, stroke: int) -> bool:
        """Use a stroke; return whether it was free."""
        was, self._free[stroke] = self._free[stroke], False
        if was:
            for point in self._at.get(stroke, ()):
                self._left[point] -= 1
        return was

    def following(self, point: FloatArray) -> tuple[int, bool] | None:
        """Use the free stroke with the end nearest to `point`; return it and whether it must be turned round."""
        if self._tree is None:
            return None
        met = np.array(self._tree.query_ball_point(point, self._within), dtype=int)
        met = met[self._left[met] > 0]
        if not len(met):
            return None
        far = distance(self._points[met] - point)
        near = met[far <= far.min() + _EVEN * self._within]
        firsts = [self._first(where) for where in near.tolist()]
        ambiguous = self._left[near].sum() > 1
        if ambiguous and not any(distance(point - fork) <= self._within for fork in self.forks[-50:]):
            self.forks.append(point)
        stroke, turned = min(firsts)
        self.take(stroke)
        return stroke, turned

    def _first(self, point: int) -> tuple[int, bool]:
        """Return the first free end at a point that has one."""
        there = self._there[point]
        while not self._free[there[0][0]]:
            there.popleft()
        return there[0]


def _turned(stroke: list[Piece]) -> list[Piece]:
    return [piece.reversed() for piece in reversed(stroke)]
