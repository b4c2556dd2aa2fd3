"""From one posture to another along the path: a short continuous motion through sampled self-motions, then smoothed.

At the path parameters given, and more between them, the self-motion is sampled at even steps in joint space. Postures
that follow each other on one self-motion are neighbours, and so are near ones at neighbouring parameters on the same or
a joining sheet; the shortest way through them (Dijkstra) fixes how the motion goes round obstacles. Then every posture
is drawn towards the straight line between its neighbours and put back on the path, again and again, which needs no
branch and passes folds.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray
from selfmotion.angles import TAU, unwrap, wrap
from selfmotion.arms import RedundantArm
from selfmotion.domain.sweep import sweep
from selfmotion.errors import UnrepairableError
from selfmotion.problem import Problem

# Largest joint step between two rows of a bridge [rad].
_STEP = 0.06
# Postures of one self-motion are sampled at most this far apart, and linked to the next parameter's up to _NEAR [rad].
_SPACING = 0.08
_NEAR = 0.3
_POSTURES, _FEWEST_POSTURES, _NODES = 200, 60, 60_000
_ASIDE = 0.02  # where beside the ends of a cell its self-motions are sampled, in parts of it
_FEWEST, _MOST = 6, 80  # parameters at which self-motions are sampled
_REFINEMENTS = 2
_SMOOTHINGS = 100
_ROUNDS = 3
_STILL = 1e-9  # what counts as a step in r where the tool stands still
_DETOURS = 40
_TRUSTING = 4  # detours before every link is looked at
_HALVINGS = 14
_SHRINKS = 0.8
_SAME = 1e-5  # postures nearer than this are one [rad]
_NEWTON = 30
_HELD = 1e-9  # limit overrun allowed [rad]
_ON_PATH = 1e-12  # of the reach

PLAN_ANEW = "give more rows, or plan the motion anew"
"""What to do where a repair fails for no provable reason."""
End = tuple[float, FloatArray | None]
"""Path parameter, and posture (n,) or None for any."""


def bridge(problem: Problem, start: End, end: End, between: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return a continuous motion from one posture to another, its ends left out where they are given.

    Parameters
    ----------
    problem : Problem
    start, end : tuple
        Path parameter, and posture of shape (n,) or None for any.
    between : array, shape (k,)
        Path parameters that shall have a row.

    Returns
    -------
    r : array, shape (m,)
    q : array, shape (m, n)
        Steps are at most 0.06 rad.

    Raises
    ------
    UnrepairableError
        If no way was found.
    """
    arm = problem.arm
    inner = slice(start[1] is not None, -1 if end[1] is not None else None)
    if start[1] is not None and end[1] is not None:
        r = np.array([start[0], *between, end[0]])
        q, ok = on_path(problem, r, _straight(arm, start, end, between))
        direct = _filled(problem, r, q)
        if ok.all() and not direct.broken:
            return direct.r[inner], direct.q[inner]
    for refinement in range(_REFINEMENTS):
        motion = _Ladder(problem, start, end, between, refinement).shortest()
        if motion is None:
            continue
        better = _filled(problem, *_with_rows(problem, motion.r, motion.q, between))
        for _ in range(_ROUNDS):  # smoothed as long as it stays continuous
            if better.broken:
                break
            motion = better
            smooth = _smoothed(problem, motion.r, motion.q, start[1] is not None, end[1] is not None)
            better = _filled(problem, motion.r, smooth)
        r, q, _ = motion if better.broken else better
        moved = np.concatenate([[True], (np.diff(r) > 0) | (np.abs(_steps(arm, q)).max(axis=1) > _SAME)])
        return r[moved][inner], q[moved][inner]
    raise UnrepairableError(
        f"no way from r = {start[0]:.6g} to {end[0]:.6g} was found, although the self-motions are connected",
        PLAN_ANEW,
        start[0],
        proved=False,
    )


def on_path(problem: Problem, r: FloatArray, q: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Move postures to the nearest ones that do their task inside the limits, by Newton's method.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)

    Returns
    -------
    q : array, shape (k, n)
    ok : array of bool, shape (k,)
        Whether task, limits and elbow hold there.
    """
    arm, x = problem.arm, problem.path(r)
    q, free = q.copy(), np.ones(q.shape)
    for _ in range(2):  # the second time with joints that left their limits held on them
        for _ in range(_NEWTON):
            lack = arm.task_residual(q, x)
            if not (np.abs(lack).max(axis=-1, initial=0.0) > _ON_PATH * arm.reach).any():
                break
            jacobian = arm.jacobian(q) * free[:, None, :]
            square = jacobian @ np.swapaxes(jacobian, -1, -2)
            square += 1e-14 * arm.reach**2 * np.eye(square.shape[-1])  # at singular postures
            step = np.swapaxes(jacobian, -1, -2) @ np.linalg.solve(square, lack[..., None])
            q += np.clip(step[..., 0], -0.5, 0.5)
        held = (arm.limits.margin(q) < 0) & (free > 0)
        if not held.any():
            break
        free[held] = 0.0
        q = np.clip(q, arm.limits.lower, arm.limits.upper)
    miss = np.abs(arm.task_residual(q, x)).max(axis=-1, initial=0.0)
    on_branch = [arm.is_on_branch(q, branch, _HELD) for branch in problem.elbow_branches]
    inside = (arm.limits.margin(q) >= -_HELD).all(axis=-1)
    return q, (miss <= 10 * _ON_PATH * arm.reach) & inside & np.any(on_branch, axis=0)


def _straight(arm: RedundantArm, start: End, end: End, between: FloatArray) -> FloatArray:
    """Return postures on the straight joint line, shape (k + 2, n)."""
    assert start[1] is not None
    assert end[1] is not None
    step = end[1] - start[1]
    step = np.where(arm.limits.limited, step, wrap(step))
    span = max(end[0] - start[0], 1e-300)
    part = np.concatenate([[0.0], (between - start[0]) / span, [1.0]])
    return start[1] + part[:, None] * step


class Filled(NamedTuple):
    """A motion with small steps, and the steps of the one before that could not be made so, as indices."""

    r: FloatArray
    q: FloatArray
    broken: list[int]


def _filled(problem: Problem, r: FloatArray, q: FloatArray) -> Filled:
    """Halve the steps of a motion on the path until they are small."""
    return refined(problem, r, q, lambda _, q: np.abs(_steps(problem.arm, q)).max(axis=1, initial=0.0) > _STEP)


def refined(
    problem: Problem, r: FloatArray, q: FloatArray, wanting: Callable[[FloatArray, FloatArray], BoolArray]
) -> Filled:
    """Halve steps of a motion on the path until none is wanting.

    Parameters
    ----------
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)
    wanting : callable
        Maps r and q to which of the steps are not good enough yet, shape (k − 1,).

    Returns
    -------
    Filled
        ``broken`` are the steps that do not get smaller by halving: jumps.
    """
    arm = problem.arm
    origin = np.arange(len(r))  # the row that each one comes after, or is
    broken: set[int] = set()
    for _ in range(_HALVINGS):
        large = np.flatnonzero(wanting(r, q) & ~np.isin(origin[:-1], list(broken)))
        if not len(large):
            return Filled(r, q, sorted(broken))
        step = _between(arm, q[large], q[large + 1])
        middle_r = 0.5 * (r[large] + r[large + 1])
        middle, ok = on_path(problem, middle_r, q[large] + 0.5 * step)
        first, second = _between(arm, q[large], middle), _between(arm, middle, q[large + 1])
        half = np.maximum(np.abs(first).max(axis=1), np.abs(second).max(axis=1))
        good = ok & (half < _SHRINKS * np.abs(step).max(axis=1))
        broken |= set(origin[large[~good]].tolist())
        at = large[good] + 1
        r, q = np.insert(r, at, middle_r[good]), np.insert(q, at, middle[good], axis=0)
        origin = np.insert(origin, at, origin[large[good]])
    broken |= set(origin[:-1][wanting(r, q)].tolist())
    return Filled(r, q, sorted(broken))


def _with_rows(problem: Problem, r: FloatArray, q: FloatArray, rows: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the motion with a row at each of `rows`, where one can be put there."""
    new = np.setdiff1d(rows, r)
    after = np.searchsorted(r, new)
    inside = (after > 0) & (after < len(r))
    new, after = new[inside], after[inside]
    part = (new - r[after - 1]) / (r[after] - r[after - 1])
    step = _between(problem.arm, q[after - 1], q[after])
    put, ok = on_path(problem, new, q[after - 1] + part[:, None] * step)
    return np.insert(r, after[ok], new[ok]), np.insert(q, after[ok], put[ok], axis=0)


def _smoothed(problem: Problem, r: FloatArray, q: FloatArray, keep_first: bool, keep_last: bool) -> FloatArray:
    """Draw every posture to the straight line between its neighbours and back onto the path; given ends stay."""
    arm, gap = problem.arm, np.diff(r) + _STILL
    part = gap[:-1] / (gap[:-1] + gap[1:])
    q = q[:1] + np.concatenate([np.zeros((1, arm.n)), np.cumsum(_steps(arm, q), axis=0)])
    moving = slice(int(keep_first), -1 if keep_last else None)
    for _ in range(_SMOOTHINGS if len(q) > 2 else 0):
        line = np.concatenate([q[1:2], q[:-2] + part[:, None] * (q[2:] - q[:-2]), q[-2:-1]])
        put, ok = on_path(problem, r[moving], 0.5 * (q[moving] + line[moving]))
        ok &= np.abs(put - q[moving]).max(axis=1) < _STEP
        q[moving] = np.where(ok[:, None], put, q[moving])
    return q


def _between(arm: RedundantArm, q: FloatArray, to: FloatArray) -> FloatArray:
    """Return joint steps, those of free joints modulo 2π."""
    return np.where(arm.limits.limited, to - q, wrap(to - q))


def _steps(arm: RedundantArm, q: FloatArray) -> FloatArray:
    return _between(arm, q[:-1], q[1:])


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


class _Ladder:
    """Self-motions sampled at some path parameters, and what links their postures."""

    def __init__(self, problem: Problem, start: End, end: End, rows: FloatArray, refinement: int) -> None:
        self.problem, self.arm, self.path = problem, problem.arm, problem.path
        self.given = [q for q in (start[1], end[1]) if q is not None]
        self.structure = problem.structure
        self.branches = problem.elbow_branches
        self.spacing = _SPACING / 2**refinement
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
                for lifted in _lifted(self.arm, part.q, self.given):
                    middle = lifted[len(lifted) // 2]
                    at = self.structure.sheet_at(r, float(self.arm.u_of(middle)[0]), branch, 1e-7, middle)
                    links.append(np.arange(len(lifted) - 1)[:, None] + [0, 1] + sum(map(len, q)))
                    q.append(lifted)
                    sheet.append(np.full(len(lifted), at[0] if at else -1))
        postures, pairs = np.concatenate(q), np.concatenate(links)
        size = np.abs(_between(self.arm, postures[pairs[:, 0]], postures[pairs[:, 1]])).max(axis=1, initial=0.0)
        same = self._near(postures, postures, _SAME)  # where branches fold and circles close
        return _Layer(
            postures, np.concatenate(sheet), np.concatenate([pairs[size < 1.0], same[same[:, 0] < same[:, 1]]])
        )

    def _placed(self, k: int, q: FloatArray | None) -> IntArray:
        """Return the nodes of a layer that the motion may begin or end with; a given posture becomes one."""
        layer = self.layers[k]
        if q is None:
            return np.arange(len(layer.q))
        new = len(layer.q)
        near = self._near(q[None], layer.q, 2 * self.spacing)[:, 1]
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
        apart = np.abs(_between(self.arm, one[pairs[:, 0]], two[pairs[:, 1]])).max(axis=1, initial=0.0)
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
        edges = np.unique(np.concatenate(pairs), axis=0)
        step = np.abs(_between(self.arm, self.q[edges[:, 0]], self.q[edges[:, 1]])).sum(axis=1)
        return edges, step + step**2 / _SPACING + 1e-9  # squares favour many small steps over a few large ones

    def _sound(self, edges: IntArray) -> BoolArray:
        """Return which links can be walked in quarters on the path: those that jump over a gap cannot."""
        step = _between(self.arm, self.q[edges[:, 0]], self.q[edges[:, 1]])
        along = self.r[edges[:, 1]] - self.r[edges[:, 0]]
        good, before = np.ones(len(edges), bool), self.q[edges[:, 0]]
        for quarter in (0.25, 0.5, 0.75, 1.0):
            here = self.q[edges[:, 0]] + quarter * step
            put, ok = on_path(self.problem, self.r[edges[:, 0]] + quarter * along, here)
            walked = np.abs(_between(self.arm, before, put)).max(axis=1)
            good &= ok & (walked <= 0.6 * np.abs(step).max(axis=1) + _SAME)
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
            found = _filled(self.problem, self.r[way], self.q[way])
            if not found.broken:
                return found
            # A step that cannot be filled jumps over something: go round it.
            closed = {frozenset((way[k], way[k + 1])) for k in found.broken}
            stays = np.array([frozenset(pair) not in closed for pair in edges.tolist()])
            edges, cost = edges[stays], cost[stays]
        return None


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
                inside = (angle >= limits.lower[j] - _HELD) & (angle <= limits.upper[j] + _HELD)
                edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
                for first, last in zip(edges[::2], edges[1::2], strict=True):
                    part = run[first:last].copy()
                    part[:, j] = np.clip(angle[first:last], limits.lower[j], limits.upper[j])
                    turned.append(part)
        runs = turned
    return runs
