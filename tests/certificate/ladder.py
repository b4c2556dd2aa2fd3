"""Ways through everything feasible: a ladder of postures along the path, and the best sequences of its rungs' postures.

Rungs are the feasible self-motion in places along the path, sampled evenly in the joints on both elbows, with every
number of turns that the limits leave. Steps lead to near postures of the next rung, or along the self-motion on one
rung. The ways found are the best one and the best of some that go elsewhere.
"""

from typing import NamedTuple

import numpy as np
from curves import TAU, Curve
from scipy.spatial import cKDTree

_SAMPLES = 384  # of each loop of self-motion before it is thinned out
_BISECTIONS = 24
_FAR = 1e4  # more than anything costs
_MOST_TURNS = 32
_OTHERS = 8
_ELSEWHERE = 0.2  # a way is another one if some joint is this far off [rad]
_STARTS = 24  # postures that closed motions are tried from


class Rung(NamedTuple):
    """Postures q (m, n) in one place, their number of run, and the length of the run up to them."""

    r: float
    q: np.ndarray
    run: np.ndarray
    along: np.ndarray


class Step(NamedTuple):
    """Steps between two rungs: postures from and to, sorted by to, with costs; where each group of to begins."""

    source: np.ndarray
    target: np.ndarray
    cost: np.ndarray
    first: np.ndarray
    groups: np.ndarray


def _loops(task, r):
    """The loops of self-motion at places r: place, elbow (0 both), and middle and half width of v = u − ψ."""
    x = task.target(r)
    (l1, l2, l3), radius = task.l, np.abs(x)
    with np.errstate(divide="ignore", invalid="ignore"):
        outer = (radius**2 + l3**2 - (l1 + l2) ** 2) / (2 * radius * l3)
        inner = (radius**2 + l3**2 - (l1 - l2) ** 2) / (2 * radius * l3)
    found = []
    for k in range(len(r)):
        if radius[k] < 1e-9 or outer[k] > 1 or inner[k] < -1:
            continue
        low = np.arccos(inner[k]) if inner[k] < 1 else 0.0
        high = np.arccos(outer[k]) if outer[k] > -1 else np.pi
        if low == 0 and high == np.pi:
            found += [(k, sign, 0.0, np.pi) for sign in (1, -1)]
        elif low == 0:
            found.append((k, 0, 0.0, high))
        elif high == np.pi:
            found.append((k, 0, np.pi, np.pi - low))
        else:
            found += [(k, 0, sign * 0.5 * (low + high), 0.5 * (high - low)) for sign in (1, -1)]
    return [np.array(column) for column in zip(*found, strict=True)] if found else None


class _Fibres:
    """All loops at once; s in [0, 1] runs through each."""

    def __init__(self, task, r):
        self.task = task
        loops = _loops(task, r)
        self.count = 0 if loops is None else len(loops[0])
        if self.count:
            self.place, self.elbow, self.middle, self.half = loops
            self.x = task.target(r)[self.place]

    def __call__(self, loop, s):
        """Principal joint angles at s (...) of loops (...), and their elbow."""
        angle = TAU * s - 0.5 * np.pi
        elbow, half, x = self.elbow[loop], self.half[loop], self.x[loop]
        v = self.middle[loop] + np.where(elbow == 0, half * np.sin(angle), TAU * s - np.pi)
        sign = np.where(elbow == 0, np.where(np.cos(angle) >= 0, 1, -1), elbow)
        p, _ = self.task.solved(x, np.angle(x) + v, sign)
        q = self.task.joints(p, 0.0)
        if self.task.n == 4:
            q[..., 3] += self.task.direction
        return np.mod(q + np.pi, TAU) - np.pi, sign


def rungs_of(task, r, spacing):
    """The rungs at places r, self-motion on each thinned out to `spacing` in the fastest joint."""
    fibres = _Fibres(task, r)
    parts = [[] for _ in r]
    if fibres.count:
        s = (np.arange(_SAMPLES) + 0.5) / _SAMPLES
        q, sign = fibres(np.arange(fibres.count)[:, None], s[None])
        q = np.unwrap(q, axis=1)
        runs = [run for loop in range(fibres.count) for run in _runs(task, loop, q[loop], sign[loop])]
        first, last = _ends(task, fibres, s, q, runs)
        for k, (loop, turns, a, b) in enumerate(runs):
            whole = q[loop, a : b + 1] + TAU * turns
            whole = np.concatenate([first[k], whole, last[k]])
            steps = np.abs(np.diff(whole, axis=0)).max(axis=1)
            length = np.concatenate([[0.0], np.cumsum(steps)])
            keep = np.unique(
                np.searchsorted(length, np.arange(0.0, length[-1] + spacing, spacing)).clip(0, len(whole) - 1)
            )
            parts[fibres.place[loop]].append(whole[np.union1d(keep, [0, len(whole) - 1])])
    return [_rung(task, float(at), mine) for at, mine in zip(r, parts, strict=True)]


def _rung(task, r, runs):
    if not runs:
        return Rung(r, np.empty((0, task.n)), np.empty(0, int), np.empty(0))
    along = [np.concatenate([[0.0], np.cumsum(task.cost_of(np.diff(q, axis=0), np.zeros(len(q) - 1)))]) for q in runs]
    run = np.repeat(np.arange(len(runs)), [len(q) for q in runs])
    return Rung(r, np.concatenate(runs), run, np.concatenate(along))


def _runs(task, loop, q, sign):
    """Feasible runs of a loop: (loop, turns, first, last)."""
    allowed = np.ones(len(q), bool) if task.sign == 0 else sign == task.sign
    ranges = []
    for j in range(task.n):
        turns = np.zeros(1)
        if task.limited[j]:
            low = np.floor((task.lower[j] - q[:, j].max()) / TAU) if np.isfinite(task.lower[j]) else None
            high = np.ceil((task.upper[j] - q[:, j].min()) / TAU) if np.isfinite(task.upper[j]) else None
            low, high = (high - 2 if low is None else low), (low + 2 if high is None else high)
            turns = np.arange(low, high + 1)
        ranges.append(turns)
    found = []
    for turns in np.stack(np.meshgrid(*ranges, indexing="ij"), axis=-1).reshape(-1, task.n):
        here = q + TAU * turns
        ok = allowed & (here >= task.lower).all(axis=1) & (here <= task.upper).all(axis=1)
        edges = np.flatnonzero(np.diff(np.concatenate([[False], ok, [False]]).astype(int)))
        found += [(loop, turns, a, b - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return found[:_MOST_TURNS]


def _ends(task, fibres, s, q, runs):
    """The last feasible postures at both ends of each run, found by bisection; none at a loop's seam."""
    found = {1: [np.empty((0, task.n))] * len(runs), -1: [np.empty((0, task.n))] * len(runs)}
    for way in (1, -1):
        at = [(k, loop, turns, b if way == 1 else a) for k, (loop, turns, a, b) in enumerate(runs)]
        at = [row for row in at if 0 <= row[3] + way < len(s)]
        if not at:
            continue
        number, loop, turns, index = (np.array(column) for column in zip(*at, strict=True))
        inside, outside = s[index], s[index + way]
        q_inside = q[loop, index] + TAU * turns
        for _ in range(_BISECTIONS):
            middle = 0.5 * (inside + outside)
            here, sign = fibres(loop, middle)
            here = here + TAU * np.rint((q_inside - here) / TAU)
            ok = (here >= task.lower).all(axis=1) & (here <= task.upper).all(axis=1)
            if task.sign:
                ok &= sign == task.sign
            inside, outside = np.where(ok, middle, inside), np.where(ok, outside, middle)
            q_inside = np.where(ok[:, None], here, q_inside)
        for k, posture in zip(number, q_inside, strict=True):
            found[way][k] = posture[None]
    return found[-1], found[1]


def _given(task, r, u):
    """The rung of the postures with redundancy parameter u."""
    signs = np.array([s for s in (1, -1) if task.sign in (0, s)])
    p, margin = task.solved(np.broadcast_to(task.target(np.array(r)), signs.shape), u, signs)
    q = task.joints(p, 0.0)
    if task.n == 4:
        q[:, 3] += task.direction
    q = np.mod(q + np.pi, TAU) - np.pi
    found = [task.lifts(row)[:_MOST_TURNS] for row, m in zip(q, margin, strict=True) if m > -1e-13]
    found = np.concatenate(found) if found else np.empty((0, task.n))
    over = np.maximum(task.lower - found, found - task.upper).max(axis=1) if len(found) else np.empty(0)
    return _rung(task, r, [row[None] for row in found[over <= 1e-12]])


class Ladder:
    """Rungs, steps between them, and the best ways through."""

    def __init__(self, task, slabs, spacing, radius):
        self.task = task
        r = np.unique(np.concatenate([np.linspace(0.0, 1.0, slabs + 1), task.breaks]))
        self.rungs = rungs_of(task, r, spacing)
        if task.start_u is not None:
            self.rungs.insert(0, _given(task, 0.0, task.start_u))
        if task.cyclic:
            self.rungs[-1] = self.rungs[0]._replace(r=1.0)
        elif task.end_u is not None:
            self.rungs.append(_given(task, 1.0, task.end_u))
        self.reach = np.full(len(self.rungs) - 1, radius)
        self.is_whole = all(len(rung.q) for rung in self.rungs)
        self.steps = [self._step(k) for k in range(len(self.reach))] if self.is_whole else []

    def _step(self, k):
        """Steps from rung k to the next, between postures that no joint is farther apart in than allowed."""
        task, one, two = self.task, self.rungs[k], self.rungs[k + 1]
        box = np.where(task.limited, 0.0, TAU)
        a, b = (
            np.where(task.limited, rung.q - np.minimum(one.q.min(0), two.q.min(0)), np.mod(rung.q, TAU))
            for rung in (one, two)
        )
        a, b = (np.where(task.limited, value, np.minimum(value, np.nextafter(TAU, 0))) for value in (a, b))
        near = cKDTree(a, boxsize=box).sparse_distance_matrix(
            cKDTree(b, boxsize=box), float(self.reach[k]), p=np.inf, output_type="ndarray"
        )
        order = np.argsort(near["j"], kind="stable")
        source, target = near["i"][order], near["j"][order]
        cost = task.cost_of(task.steps(two.q[target] - one.q[source]), np.full(len(source), two.r - one.r))
        groups, first = np.unique(target, return_index=True)
        return Step(source, target, cost, first, groups)

    def narrow(self, k, most):
        """Allow only smaller steps after rung k from now on."""
        self.reach[k] = min(most, 0.7 * self.reach[k])
        self.steps[k] = self._step(k)

    def forward(self, value):
        """Least costs (starts, postures) to get to each posture, rung by rung, from costs on the first rung."""
        values = [self._slid(self.rungs[0], value)]
        for step, rung in zip(self.steps, self.rungs[1:], strict=True):
            value = np.full((len(value), len(rung.q)), np.inf)
            if len(step.source):
                value[:, step.groups] = np.minimum.reduceat(values[-1][:, step.source] + step.cost, step.first, axis=1)
            values.append(self._slid(rung, value))
        return values

    def backward(self):
        """Least costs to get from each posture to the end."""
        values = [self._slid(self.rungs[-1], np.zeros((1, len(self.rungs[-1].q))))]
        for step, rung in zip(self.steps[::-1], self.rungs[-2::-1], strict=True):
            value = np.full(len(rung.q), np.inf)
            np.minimum.at(value, step.source, values[-1][0, step.target] + step.cost)
            values.append(self._slid(rung, value[None]))
        return values[::-1]

    @staticmethod
    def _slid(rung, value):
        """Costs lowered where sliding along the self-motion of the rung is cheaper."""
        capped = np.minimum(value, 0.5 * _FAR)
        up = np.minimum.accumulate(capped - rung.along - _FAR * rung.run, axis=1) + rung.along + _FAR * rung.run
        down = np.minimum.accumulate((capped + rung.along + _FAR * rung.run)[:, ::-1], axis=1)[:, ::-1]
        slid = np.minimum(up, down - rung.along - _FAR * rung.run)
        return np.where((slid < value - 1e-9) & (slid < 0.4 * _FAR), slid, value)

    def back(self, values, start, node, rung=None):
        """Indices (rung, posture) of the best way to a posture, slides included, in order."""
        k = len(self.rungs) - 1 if rung is None else rung
        way = [(k, node)]
        while True:
            here, costs = self.rungs[k], values[k][start]
            if k > 0:
                step = self.steps[k - 1]
                rows = slice(*np.searchsorted(step.target, [node, node + 1]))
                sums = values[k - 1][start, step.source[rows]] + step.cost[rows]
                if len(sums) and sums.min() <= costs[node] + 1e-9:
                    node, k = int(step.source[rows][np.argmin(sums)]), k - 1
                    way.append((k, node))
                    continue
            near = [j for j in (node - 1, node + 1) if 0 <= j < len(here.q) and here.run[j] == here.run[node]]
            near = [j for j in near if abs(costs[j] + abs(here.along[j] - here.along[node]) - costs[node]) <= 1e-8]
            near = [j for j in near if (k, j) not in way]
            if not near:
                return way[::-1]
            node = near[0]
            way.append((k, node))

    def best_ways(self):
        """The best way through the ladder first, then the best that pass elsewhere, as lists of (rung, posture)."""
        if self.task.cyclic:
            return self._closed_ways()
        values, rest = self.forward(np.zeros((1, len(self.rungs[0].q)))), self.backward()
        if not np.isfinite(values[-1]).any():
            return []
        ways = [self.back(values, 0, int(np.argmin(values[-1][0])))]
        through = []
        for k in np.unique(np.linspace(0, len(self.rungs) - 1, 9).round().astype(int)):
            total = values[k][0] + rest[k][0]
            padded = np.concatenate([[np.inf], total, [np.inf]])
            for node in np.flatnonzero((total <= padded[:-2]) & (total <= padded[2:]) & np.isfinite(total)):
                through.append((float(total[node]), int(k), int(node)))
        for _, k, node in sorted(through):
            q = self.rungs[k].q[node]
            if len(ways) <= _OTHERS and all(self._is_elsewhere(way, k, q) for way in ways):
                ways.append(self.back(values, 0, node, k) + self._onward(rest, k, node))
        return ways

    def _is_elsewhere(self, way, k, q):
        return min(np.abs(self.task.steps(q - self.rungs[k].q[j])).max() for rung, j in way if rung == k) > _ELSEWHERE

    def _onward(self, rest, k, node):
        """The best way from a posture to the end, without the posture itself."""
        way = []
        while k < len(self.steps):
            step, costs = self.steps[k], rest[k][0]
            rows = np.flatnonzero(step.source == node)
            sums = rest[k + 1][0, step.target[rows]] + step.cost[rows]
            if len(sums) and sums.min() <= costs[node] + 1e-9:
                node, k = int(step.target[rows][np.argmin(sums)]), k + 1
                way.append((k, node))
                continue
            here = self.rungs[k]
            near = [j for j in (node - 1, node + 1) if 0 <= j < len(here.q) and here.run[j] == here.run[node]]
            near = [j for j in near if abs(costs[j] + abs(here.along[j] - here.along[node]) - costs[node]) <= 1e-8]
            near = [j for j in near if (k, j) not in way]
            if not near:
                break
            node = near[0]
            way.append((k, node))
        return way

    def _closed_ways(self):
        """The best ways that end in the posture that they start from."""
        first, last = self.rungs[0], self.rungs[-1]
        starts = np.unique(np.linspace(0, len(first.q) - 1, _STARTS).round().astype(int))
        value = np.full((len(starts), len(first.q)), np.inf)
        value[np.arange(len(starts)), starts] = 0.0
        values = self.forward(value)
        ends = [np.abs(self.task.steps(last.q - first.q[j])).max(axis=1) for j in starts]
        found = [
            (float(values[-1][k, np.argmin(off)]), k, int(np.argmin(off)))
            for k, off in enumerate(ends)
            if off.min() < 1e-6
        ]
        found = [row for row in sorted(found) if np.isfinite(row[0])]
        return [self.back(values, k, node) for _, k, node in found[: 1 + _OTHERS]]

    def postures(self, way):
        """r and q of a way, free joints continuous."""
        r = np.array([self.rungs[k].r for k, _ in way])
        return r, self.task.continuous(np.array([self.rungs[k].q[j] for k, j in way]))


def ways_through(task, ladder):
    """Ways through the ladder that are continuous, steps that are not having been taken out of it."""
    good = []
    for _ in range(10):
        bad = []
        for way in ladder.best_ways():
            r, q = ladder.postures(way)
            broken = _broken(task, r, q)
            if not len(broken):
                good.append((r, q))
            for k in broken:
                if way[k + 1][0] != way[k][0]:
                    bad.append((way[k][0], 0.99 * np.abs(q[k + 1] - q[k]).max()))
        if good or not bad:
            break
        for k, most in set(bad):
            ladder.narrow(k, most)
    return good


def _broken(task, r, q):
    """Numbers of the steps on which the motion through the postures is not continuous inside the limits."""
    if task.cyclic == "exact" and np.abs(q[-1] - q[0]).max() > 1e-6:
        return []
    curve = Curve(task, r, q)
    parts = np.linspace(0.0, 1.0, 9)
    tau = curve.tau[:-1, None] + curve.h[:, None] * parts
    _, looks = curve(tau.ravel())
    looks = looks.reshape(len(curve.h), len(parts), -1)
    over = np.maximum(curve.lower - looks, looks - curve.upper).max(axis=(1, 2))
    jump = np.abs(np.diff(looks, axis=1)).max(axis=(1, 2))
    size = np.abs(np.diff(q, axis=0)).max(axis=1)
    return np.flatnonzero(~((over <= 1e-12) & (jump <= np.maximum(0.6 * size, 0.05))))
