"""A short way from posture to posture through self-motions sampled along the path.

At the path parameters given, and more between them, the self-motion is sampled at even steps in joint space. Postures
that follow each other on one self-motion are neighbours, and so are near ones at neighbouring parameters on the same or
a joining sheet; the shortest way through them (Dijkstra) fixes how the motion goes round obstacles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, unwrap
from selfmotion.arms import RedundantArm
from selfmotion.constrained import keeps_constraints
from selfmotion.domain.sweep import sweep
from selfmotion.mending.filling import HELD, SAME, Filled, filled, on_path
from selfmotion.problem import Problem

# Steps of about this size [rad] are wanted; postures are linked to those at the next parameter up to _NEAR.
_SPACING = 0.08
_NEAR = 0.3
_POSTURES, _FEWEST_POSTURES, _NODES = 200, 60, 60_000
_FEWEST, _MOST = 6, 80  # parameters at which self-motions are sampled
_ASIDE = 0.02  # where beside the ends of a cell its self-motions are sampled, in parts of it
_DETOURS = 40
_TRUSTING = 4  # detours before every link is looked at

End = tuple[float, FloatArray | None]
"""Path parameter, and posture (n,) or None for any."""


class _Layer(NamedTuple):
    """Postures at one path parameter.

    Attributes
    ----------
    q : array, shape (k, n)
    sheet : array of int, shape (k,)
    links : array of int, shape (m, 2)
        Pairs that follow each other on the self-motion.
    """

    q: FloatArray
    sheet: IntArray
    links: IntArray


class Ladder:
    """Self-motions sampled at some path parameters, and what links their postures."""

    def __init__(self, problem: Problem, start: End, end: End, rows: FloatArray, refinement: int) -> None:
        self.problem, self.arm, self.path = problem, problem.arm, problem.path
        self.given = [q for q in (start[1], end[1]) if q is not None]
        self.structure = problem.structure
        self.branches = problem.elbow_branches
        self.parameters = self._chosen(start[0], end[0], rows, refinement)
        self.count = self._postures(refinement)
        self.layers = [self._layer(float(r)) for r in self.parameters]
        self.first, self.last = self._placed(0, start[1]), self._placed(-1, end[1])
        sizes = [len(layer.q) for layer in self.layers]
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        self.q = np.concatenate([layer.q for layer in self.layers])
        self.r = np.repeat(self.parameters, sizes)

    def _chosen(self, low: float, high: float, rows: FloatArray, refinement: int) -> FloatArray:
        """Return the parameters to sample at: rows if they are neither too few nor too many, and both ends of cells."""
        fewest, most = _FEWEST * 3**refinement, _MOST * (1 + refinement)
        inner = rows[(rows > low) & (rows < high)]
        if len(inner) > most:
            inner = inner[np.linspace(0, len(inner) - 1, most).astype(int)]
        if len(inner) < fewest:
            inner = np.concatenate([inner, np.linspace(low, high, fewest + 2)[1:-1]])
        for first, last in (cell.r for cell in self.structure.cells):
            inside = first + np.array([_ASIDE, 0.5, 1 - _ASIDE]) * (last - first)
            inner = np.concatenate([inner, inside[(inside > low) & (inside < high)]])
        return np.unique(np.concatenate([[low, high], inner]))

    def _postures(self, refinement: int) -> int:
        """Return how many postures to sample per interval: fewer where layers and turns are many."""
        span = self.arm.limits.upper - self.arm.limits.lower
        turns = np.prod(np.where(np.isfinite(span), np.floor(span / TAU) + 1, 1))
        affordable = _NODES * 2**refinement / (len(self.parameters) * turns * len(self.branches))
        return int(np.clip(affordable, _FEWEST_POSTURES, _POSTURES * 2**refinement))

    def _layer(self, r: float) -> _Layer:
        """Sample the self-motion at r, with every number of turns that limited joints may have."""
        q, sheet, links = [np.empty((0, self.arm.n))], [np.empty(0, int)], [np.empty((0, 2), int)]
        for branch in self.branches:
            for part in sweep(self.structure.self_motion, self.path(r), branch, self.count).parts():
                for lifted in (some for run in _kept(self.arm, part.q) for some in _lifted(self.arm, run, self.given)):
                    middle = lifted[len(lifted) // 2]
                    at = self.structure.sheet_at(r, float(self.arm.u_of(middle)[0]), branch, 1e-7, middle)
                    links.append(np.arange(len(lifted) - 1)[:, None] + [0, 1] + sum(map(len, q)))
                    q.append(lifted)
                    sheet.append(np.full(len(lifted), at[0] if at else -1))
        postures, pairs = np.concatenate(q), np.concatenate(links)
        size = np.abs(self.arm.limits.steps(postures[pairs[:, 0]], postures[pairs[:, 1]])).max(axis=1, initial=0.0)
        same = self._near(postures, postures, SAME)  # where branches fold and circles close
        return _Layer(
            postures, np.concatenate(sheet), np.concatenate([pairs[size < 1.0], same[same[:, 0] < same[:, 1]]])
        )

    def _placed(self, k: int, q: FloatArray | None) -> IntArray:
        """Return the nodes of a layer that the motion may begin or end with; a given posture becomes one."""
        layer = self.layers[k]
        if q is None:
            return np.arange(len(layer.q))
        new = len(layer.q)
        one, two = layer.q[layer.links].swapaxes(0, 1)
        apart = np.abs(self.arm.limits.steps(one, two)).max(initial=_SPACING)
        near = self._near(q[None], layer.q, apart)[:, 1]
        sheet = np.append(layer.sheet, layer.sheet[near[:1]] if len(near) else -1)
        links = np.column_stack([np.full(len(near), new), near])
        self.layers[k] = _Layer(np.vstack([layer.q, q]), sheet, np.concatenate([layer.links, links]))
        return np.array([new])

    def _near(self, one: FloatArray, two: FloatArray, distance: float) -> IntArray:
        """Return the pairs (i, j) of postures within `distance` in every joint, shape (m, 2)."""
        from scipy.spatial import cKDTree

        limited = self.arm.limits.limited

        def embedded(q: FloatArray) -> FloatArray:
            return np.hstack([q[:, limited], np.cos(q[:, ~limited]), np.sin(q[:, ~limited])])

        if not len(one) or not len(two):
            return np.empty((0, 2), int)
        trees = cKDTree(embedded(one)), cKDTree(embedded(two))
        found = trees[0].sparse_distance_matrix(trees[1], distance, p=np.inf, output_type="ndarray")
        pairs = np.column_stack([found["i"], found["j"]])
        apart = np.abs(self.arm.limits.steps(one[pairs[:, 0]], two[pairs[:, 1]])).max(axis=1, initial=0.0)
        return pairs[apart <= distance]

    def _edges(self) -> tuple[IntArray, FloatArray]:
        """Return directed links and their costs: along one self-motion either way, along the path only onward."""
        onward = [{k, *sheet.after} for k, sheet in enumerate(self.structure.sheets)]
        count = len(onward)
        # Index −1, the last one: where the path only touches something, the sheet of a posture is not known.
        may = np.ones((count + 1, count + 1), bool)
        may[:count, :count] = [[b in onward[a] for b in range(count)] for a in range(count)]
        pairs = []
        for k, layer in enumerate(self.layers):
            still = layer.links + self.offsets[k]
            pairs += [still, still[:, ::-1]]
            if k + 1 < len(self.layers):
                near = self._near(layer.q, self.layers[k + 1].q, _NEAR)
                near = near[may[layer.sheet[near[:, 0]], self.layers[k + 1].sheet[near[:, 1]]]]
                pairs.append(near + self.offsets[k : k + 2])
        one, two = np.concatenate(pairs).T
        edges = np.stack(np.divmod(np.unique(one * len(self.q) + two), len(self.q)), axis=-1)
        step = np.abs(self.arm.limits.steps(self.q[edges[:, 0]], self.q[edges[:, 1]])).sum(axis=1)
        return edges, step + step**2 / _SPACING + 1e-9  # squares favour many small steps over a few large ones

    def _sound(self, edges: IntArray) -> BoolArray:
        """Return which links can be walked in quarters on the path: those that jump over a gap cannot."""
        step = self.arm.limits.steps(self.q[edges[:, 0]], self.q[edges[:, 1]])
        along = self.r[edges[:, 1]] - self.r[edges[:, 0]]
        good, before = np.ones(len(edges), bool), self.q[edges[:, 0]]
        for quarter in (0.25, 0.5, 0.75, 1.0):
            here = self.q[edges[:, 0]] + quarter * step
            put, ok = on_path(self.problem, self.r[edges[:, 0]] + quarter * along, here)
            walked = np.abs(self.arm.limits.steps(before, put)).max(axis=1)
            good &= ok & (walked <= 0.6 * np.abs(step).max(axis=1) + SAME)
            before = put
        return good

    def shortest(self) -> Filled | None:
        """Return the shortest continuous motion, ends included; None if this ladder has none."""
        from scipy.sparse import csr_matrix
        from scipy.sparse.csgraph import dijkstra

        edges, cost = self._edges()
        goals = self.last + self.offsets[-2]
        for detour in range(_DETOURS):
            if detour == _TRUSTING:
                sound = self._sound(edges)
                edges, cost = edges[sound], cost[sound]
            graph = csr_matrix((cost, edges.T), shape=(len(self.q), len(self.q)))
            distance, before, _ = dijkstra(graph, indices=self.first, return_predecessors=True, min_only=True)
            goal = int(goals[np.argmin(distance[goals])])
            if not np.isfinite(distance[goal]):
                return None
            way = [goal]
            while before[way[-1]] >= 0:
                way.append(int(before[way[-1]]))
            way.reverse()
            found = filled(self.problem, self.r[way], self.q[way])
            if not found.broken:
                return found
            # A step that cannot be filled jumps over something: go round it.
            closed = {frozenset((way[k], way[k + 1])) for k in found.broken}
            stays = np.array([frozenset(pair) not in closed for pair in edges.tolist()])
            edges, cost = edges[stays], cost[stays]
        return None


def _kept(arm: RedundantArm, q: FloatArray) -> list[FloatArray]:
    """Return the runs of postures (k, n) along a self-motion that keep the arm's constraints beyond joint limits."""
    kept = keeps_constraints(arm, q)
    cuts = np.flatnonzero(np.diff(kept)) + 1
    return [run for run, first in zip(np.split(q, cuts), [0, *cuts], strict=True) if kept[first : first + 1].any()]


def _lifted(arm: RedundantArm, q: FloatArray, given: list[FloatArray]) -> list[FloatArray]:
    """Return the runs of postures (k, n) with all numbers of turns that their limits allow throughout.

    Joints limited on one side only may have any number: they get those of the given postures, or the first inside.
    """
    limits = arm.limits
    q = q.copy()
    unwrap(q)
    runs = [q]
    for j in np.flatnonzero(limits.limited):
        low, high = q[:, j].min(), q[:, j].max()
        least, most = np.ceil((limits.lower[j] - high) / TAU), np.floor((limits.upper[j] - low) / TAU)
        if np.isinf(least) or np.isinf(most):
            wanted = [np.rint((posture[j] - 0.5 * (low + high)) / TAU) for posture in given]
            wanted = wanted or [least if np.isfinite(least) else most]
            least, most = max(least, min(wanted) - 1), min(most, max(wanted) + 1)
        turned = []
        for run in runs:
            for k in range(int(least), int(most) + 1):
                angle = run[:, j] + TAU * k
                inside = (angle >= limits.lower[j] - HELD) & (angle <= limits.upper[j] + HELD)
                edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
                for first, last in zip(edges[::2], edges[1::2], strict=True):
                    part = run[first:last].copy()
                    part[:, j] = np.clip(angle[first:last], limits.lower[j], limits.upper[j])
                    turned.append(part)
        runs = turned
    return runs
