"""The chain of postures along a path whose least margin is largest: where a motion that keeps far away may be."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms.cells import Cover
from selfmotion.constrained import keeps_constraints
from selfmotion.problem import Posture, Problem

_ON_LIMIT = 1e-9  # overrun of a limit allowed [rad]


class _Fineness(NamedTuple):
    """How many rungs, how far apart their postures are, and how far from rung to rung at most [rad].

    A step is a few postures long, so that chains can move along the self-motion.
    """

    rungs: int
    spacing: float
    step: float


COARSE, FINE = _Fineness(160, 0.05, 0.2), _Fineness(640, 0.02, 0.1)


class WidestChain(NamedTuple):
    """Postures q (k, n) at r (k,), and the least of their margins."""

    r: FloatArray
    q: FloatArray
    margin: float


def widest_chain(
    problem: Problem,
    margins: Callable[[FloatArray], FloatArray],
    fineness: _Fineness = COARSE,
    deadline: float = np.inf,
) -> WidestChain | None:
    """Return the chain of postures from start to end whose least margin is largest.

    Parameters
    ----------
    problem : Problem
        Of an arm with one redundant degree.
    margins : callable
        Maps postures (k, n) to what is to be large, shape (k,).
    fineness : tuple
        `COARSE` or `FINE`.
    deadline : float
        As :func:`time.perf_counter` tells it.

    Returns
    -------
    WidestChain or None
        None if no chain of short steps leads from start to end.

    Raises
    ------
    TimeoutError
        If the deadline passes before that is known: near singular postures and meshes postures take their time.

    Notes
    -----
    ``W_{i+1}(q') = min(m(q'), max_q W_i(q))`` over the postures q of the rung before that are near q'; of equally wide
    ones the nearest is taken.
    """
    from scipy.spatial import cKDTree

    cover, r = problem.arm.cover(problem.elbow), np.linspace(0.0, 1.0, fineness.rungs + 1)
    given = {0: problem.start, fineness.rungs: problem.end}
    rungs: list[FloatArray] = []
    for k, value in enumerate(r):
        rungs.append(_rung(problem, cover, value, given.get(k), fineness.spacing))
        if not len(rungs[-1]):
            return None
        if time.perf_counter() > deadline:
            raise TimeoutError
    widths, trees = [margins(q) for q in rungs], [cKDTree(_embedded(q, cover.wraps)) for q in rungs]
    width, before = widths[0], []
    for k in range(fineness.rungs):
        near = trees[k].sparse_distance_matrix(trees[k + 1], fineness.step, output_type="ndarray")
        near = near[np.lexsort((-near["v"], width[near["i"]]))]
        best = np.full(len(rungs[k + 1]), -1)
        best[near["j"]] = near["i"]  # the last one is the widest
        before.append(best)
        width = np.where(best >= 0, np.minimum(widths[k + 1], width[best]), -np.inf)
    at = int(np.argmax(width))
    if not np.isfinite(width[at]):
        return None
    way = [at]
    for best in reversed(before):
        way.append(int(best[way[-1]]))
    return WidestChain(r, np.array([q[k] for q, k in zip(rungs, reversed(way), strict=True)]), float(width[at]))


def _rung(problem: Problem, cover: Cover, r: float, posture: Posture | None, spacing: float) -> FloatArray:
    """Return the postures (m, n) at r: both ends of all cells, or what a given posture may be."""
    if posture is None:
        cells = cover.cells(problem.path(r), spacing)
        q = np.concatenate([cells.a, cells.b])
    elif posture.q is not None:
        q = posture.q[None]
    else:
        solved = [problem.arm.solve(problem.path(r), posture.u, branch) for branch in problem.elbow_branches]
        q = np.array([q for q, ok in solved if ok]).reshape(-1, problem.arm.n)
        q = q[(problem.arm.limits.excess(q) <= _ON_LIMIT).all(axis=1)]
    return q[keeps_constraints(problem.arm, q)]


def _embedded(q: FloatArray, wraps: BoolArray) -> FloatArray:
    """Return postures where angles that are the same modulo 2π are the same point."""
    return np.concatenate([np.cos(q[:, wraps]), np.sin(q[:, wraps]), q[:, ~wraps]], axis=1)
