"""The chain of postures along a path whose least margin is largest: where a motion that keeps far away may be."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.arms.cells import Cover
from selfmotion.constrained import keeps_constraints
from selfmotion.deadline import in_time
from selfmotion.problem import Posture, Problem, postures_of

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_ROOM = 0.45  # part of the way between rungs along which self-motion at one of them is told to be


class _Fineness(NamedTuple):
    """How many rungs, how far apart their postures are, and how far from rung to rung at most [rad].

    A step is a few postures long, so that chains can move along the self-motion.
    """

    rungs: int
    spacing: float
    step: float


COARSE, FINE = _Fineness(160, 0.05, 0.2), _Fineness(640, 0.02, 0.1)


class WidestChain(NamedTuple):
    """Postures q (k, n), turns included, and the least of their margins.

    Each is the posture of some rung; r (k,) ascends, and where the chain moves along the self-motion at one rung it
    goes a little ahead of it, since a motion has but one posture at each r.
    """

    r: FloatArray
    q: FloatArray
    margin: float


class _Rung(NamedTuple):
    """Postures q (m, n) at one r, and which of them a chain may start from or end in, shape (m,)."""

    q: FloatArray
    given: BoolArray


class _Ways(NamedTuple):
    """How each posture of a rung is reached, shape (m,): from where in the rung before, or from where in its own.

    −1 where it is not reached that way.
    """

    before: IntArray
    along: IntArray


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
    OutOfTimeError
        If the deadline passes before that is known: near singular postures and meshes postures take their time.

    Notes
    -----
    A chain steps to the next rung, and along the self-motion inside a rung. With margins m and postures q of rung i
    that are near q', ``W_{i+1}(q') = min(m(q'), max_q W_i(q))``, and of equally wide ones the nearest is taken; then
    ``W_{i+1}(q') ← max(W_{i+1}(q'), min(m(q'), W_{i+1}(q'')))`` over the postures q'' of the same rung near q', until
    nothing becomes wider.
    """
    from scipy.spatial import cKDTree

    cover, r = problem.arm.cover(problem.elbow), np.linspace(0.0, 1.0, fineness.rungs + 1)
    given = {0: problem.start, fineness.rungs: problem.end}
    rungs: list[_Rung] = []
    for k, value in enumerate(r):
        rungs.append(_rung(problem, cover, value, given.get(k), fineness.spacing))
        if not rungs[-1].given.any():
            return None
        in_time(deadline)
    before, width, ways = None, np.empty(0), []
    for rung in rungs:
        tree, margin = cKDTree(_embedded(rung.q, cover.wraps)), margins(rung.q)
        if before is None:
            best, width = np.full(len(margin), -1), np.where(rung.given, margin, -np.inf)
        else:
            best, width = _onward(before, tree, fineness.step, margin, width)
        along, width = _along(tree, fineness.step, margin, width)
        ways.append(_Ways(best, along))
        if not np.isfinite(width).any():
            return None
        before = tree
        in_time(deadline)
    width[~rungs[-1].given] = -np.inf
    if not np.isfinite(width).any():
        return None
    at, q = _traced(rungs, ways, int(np.argmax(width)), r)
    lifted = problem.arm.limits.lift(q[None], None if problem.start is None else problem.start.q)
    return WidestChain(at, lifted.q[0], float(width.max()))


def _onward(
    here: cKDTree, there: cKDTree, step: float, margin: FloatArray, width: FloatArray
) -> tuple[IntArray, FloatArray]:
    """Return from where in the rung before each posture is reached, −1 if it is not, and how widely."""
    near = here.sparse_distance_matrix(there, step, output_type="ndarray")
    near = near[np.lexsort((-near["v"], width[near["i"]]))]
    best = np.full(there.n, -1)
    best[near["j"]] = near["i"]  # the last one is the widest
    return best, np.where(best >= 0, np.minimum(margin, width[best]), -np.inf)


def _along(tree: cKDTree, step: float, margin: FloatArray, width: FloatArray) -> tuple[IntArray, FloatArray]:
    """Return from where in its own rung each posture is reached more widely, −1 if it is not, and how widely."""
    best, width = np.full(tree.n, -1), width.copy()
    if (width >= np.minimum(margin, width.max())).all():
        return best, width
    pairs = tree.query_pairs(step, output_type="ndarray")
    one, two = np.concatenate([pairs, pairs[:, ::-1]]).T
    while True:
        through = np.minimum(width[one], margin[two])
        wider = np.flatnonzero(through > width[two])
        if not len(wider):
            return best, width
        wider = wider[np.argsort(through[wider], kind="stable")]
        best[two[wider]], width[two[wider]] = one[wider], through[wider]  # the last one is the widest


def _traced(rungs: list[_Rung], ways: list[_Ways], at: int, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the chain that ends in posture `at` of the last rung: r (k,) and q (k, n)."""
    places, postures = [], []
    for k in range(len(rungs) - 1, -1, -1):
        way = [at]
        while ways[k].along[way[-1]] >= 0:
            way.append(int(ways[k].along[way[-1]]))
        way.reverse()
        last = k == len(rungs) - 1
        ahead = _ROOM * (r[1] - r[0]) * np.arange(len(way)) / len(way)
        places.append(r[k] - ahead[::-1] if last else r[k] + ahead)
        postures.append(rungs[k].q[way])
        at = int(ways[k].before[way[0]])
    return np.concatenate(places[::-1]), np.concatenate(postures[::-1])


def _rung(problem: Problem, cover: Cover, r: float, posture: Posture | None, spacing: float) -> _Rung:
    """Return the postures at r: both ends of all cells, and what a given posture may be."""
    cells = cover.cells(problem.path(r), spacing)
    q = np.concatenate([cells.a, cells.b])
    if posture is None:
        q = q[keeps_constraints(problem.arm, q)]
        return _Rung(q, np.full(len(q), True))
    own = postures_of(problem, posture, r)
    own = own[problem.arm.limits.admit(own)]
    given = np.arange(len(q) + len(own)) >= len(q)
    q = np.concatenate([q, own])
    kept = keeps_constraints(problem.arm, q)
    return _Rung(q[kept], given[kept])


def _embedded(q: FloatArray, wraps: BoolArray) -> FloatArray:
    """Return postures where angles that are the same modulo 2π are the same point."""
    return np.concatenate([np.cos(q[:, wraps]), np.sin(q[:, wraps]), q[:, ~wraps]], axis=1)
