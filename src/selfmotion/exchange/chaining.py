"""Strokes in any order and direction, chained where their ends meet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.exchange.pieces import Piece
from selfmotion.paths.base import distance


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
        first one that meets its end, turned round if need be, and is led back from its start in the same way.
    forks : list of array
        Where more than two ends meet.
    """
    if not strokes:
        return [], []
    from scipy.spatial import cKDTree

    ends = np.array([[stroke[0].start, stroke[-1].end] for stroke in strokes])
    closed = distance(ends[:, 1] - ends[:, 0]) <= within
    free = [k for k in range(len(strokes)) if not closed[k]]
    used = closed.copy()
    tree = cKDTree(ends[free].reshape(-1, 2)) if free else None
    forks: list[FloatArray] = []

    def following(point: FloatArray) -> tuple[int, bool] | None:
        """Return the first unused stroke with an end at `point`, and whether it must be turned round."""
        if tree is None:
            return None
        met = sorted(tree.query_ball_point(point, within))
        if len(met) > 2 and not any(distance(point - fork) <= within for fork in forks[-50:]):
            forks.append(point)
        for index in met:
            stroke = free[index // 2]
            if not used[stroke]:
                return stroke, index % 2 == 1
        return None

    chains = []
    for k, stroke in enumerate(strokes):
        if closed[k]:
            chains.append((k, list(stroke)))
            continue
        if used[k]:
            continue
        used[k] = True
        ahead, behind = list(stroke), []
        while (found := following(ahead[-1].end)) is not None:
            used[found[0]] = True
            ahead += _turned(strokes[found[0]]) if found[1] else strokes[found[0]]
        start = ahead[0].start
        while (found := following(start)) is not None:
            used[found[0]] = True
            before = strokes[found[0]] if found[1] else _turned(strokes[found[0]])
            behind.append(before)
            start = before[0].start
        chains.append((k, [piece for before in reversed(behind) for piece in before] + ahead))
    return [chain for _, chain in sorted(chains, key=lambda entry: entry[0])], forks


def _turned(stroke: list[Piece]) -> list[Piece]:
    return [piece.reversed() for piece in reversed(stroke)]
