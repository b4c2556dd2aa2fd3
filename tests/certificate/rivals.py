"""Rivals that look for short motions in their own ways, to try to refute lower bounds: each with a different blindness.

A rival is called with a problem and a seed; it returns a motion that has been checked by forward kinematics, with its
cost and the cost's error, or None if it found none.
"""

import numpy as np
from curves import TAU, Curve, Task, checked, dense, motion_through
from ladder import Ladder, ways_through
from scipy.interpolate import BSpline
from scipy.optimize import differential_evolution, minimize
from shortening import LEVELS, Shortener, shortened

import selfmotion as sm
from selfmotion.errors import SelfMotionError

# Slabs, spacing of postures and largest step [rad].
_LADDERS = ((32, 0.035, 0.6), (100, 0.03, 0.5))
_FINER = 3  # ways through the ladder that are shortened further
_SAME_COST = 1e-4

_PLACES = 160  # along the path where a spline's posture is looked at
_CLEAR = 1e-7  # that splines keep from limits and folds
_PENALTIES = (10.0, 1000.0)
_DIFFERENCE = 1e-6
_GUESSES = 240  # values of u that followers choose from


def cheap(problem, seed):
    """The ladder's ways, shortened; a longer ladder where the first one has none."""
    return next(filter(None, (_climbed(Task(problem), *ladder) for ladder in _LADDERS)), None)


def _climbed(task, slabs, spacing, radius):
    ladder = Ladder(task, slabs, spacing, radius)
    if not ladder.is_whole:
        return None
    short = []
    for r, q in ways_through(task, ladder):
        shortener = Shortener(task, r, q, radius)
        shortener.run(2 * spacing, 1e-3, 12)
        short.append((shortener.cost(), r, shortener.q))
    # Straight steps cost less than the motion, so that coarse ways are compared with coarse ones only.
    finer = []
    for _, r, q in _different(short)[:_FINER]:
        levels = shortened(task, r, q, LEVELS[:-1])
        if levels:
            finer.append((Curve(task, *levels[-1]).cost(1e-5)[0], levels))
    for _, levels in sorted(finer, key=lambda row: row[0]):
        for r, q in shortened(task, *levels[-1], LEVELS[-1:]) + levels[::-1]:
            found = motion_through(task, r, q)
            if found is not None:
                return found
    return None


def _different(ways):
    """Ways (cost, r, q), the shortest first, without those of the same cost."""
    kept = []
    for way in sorted(ways, key=lambda way: way[0]):
        if not kept or way[0] > kept[-1][0] * (1 + _SAME_COST):
            kept.append(way)
    return kept


def splines(problem, seed, starts=4, coefficients=14):
    """B-splines in u on one elbow, from several starts led through what is feasible."""
    task, rng = Task(problem), np.random.default_rng([seed, 1])
    found = []
    for sign in _signs(task):
        space = _Splines(task, sign, coefficients)
        found += [space.motion(space.minimised(c)) for c in space.followers(rng, starts)]
    return _best(found)


def evolution(problem, seed, coefficients=7, population=40, generations=100):
    """Differential evolution of B-splines in u on one elbow; the best is refined on more coefficients."""
    task, rng = Task(problem), np.random.default_rng([seed, 2])
    found = []
    for sign in _signs(task):
        coarse, fine = _Splines(task, sign, coefficients), _Splines(task, sign, 2 * coefficients)
        first = coarse.followers(rng, population)
        first += rng.normal(0.0, 0.1, first.shape)
        middle = first.mean(axis=0)
        best = differential_evolution(
            lambda c: coarse.objective(c.T, _PENALTIES[0]),  # noqa: B023
            np.stack([middle - 1.5 * np.pi, middle + 1.5 * np.pi], axis=1),
            init=np.clip(first, middle - 1.49 * np.pi, middle + 1.49 * np.pi),
            maxiter=generations,
            vectorized=True,
            updating="deferred",
            polish=False,
            rng=rng,
        ).x
        found.append(fine.motion(fine.minimised(fine.fitted(coarse.u(best[None])[0]))))
    return _best(found)


def refined(problem, seed, starts=8):
    """The package's own local planner, which shares nothing with bounds."""
    try:
        plan = sm.plan(problem, sm.Refine(starts=starts, seed=seed, time_limit=20))
    except SelfMotionError:
        return None
    tau = problem.path.grid(4000)
    r, q = dense(lambda tau: (tau, plan(tau)), tau)
    return checked(Task(problem), plan.cost, plan.cost_error, r, q)


RIVALS = {"cheap": cheap, "splines": splines, "evolution": evolution, "refined": refined}


def _best(found):
    return min((motion for motion in found if motion is not None), key=lambda motion: motion.cost, default=None)


def _signs(task):
    return (1, -1) if task.sign == 0 else (task.sign,)


class _Splines:
    """B-splines u(r) on one elbow: what they cost, with penalties for leaving reach, limits and ends."""

    def __init__(self, task, sign, count):
        self.task, self.sign = task, sign
        self.r = np.unique(np.concatenate([np.linspace(0.0, 1.0, _PLACES + 1), task.breaks]))
        inner = np.linspace(0.0, 1.0, count - 2)
        knots = np.concatenate([[0.0] * 3, inner, [1.0] * 3])
        self.basis = BSpline.design_matrix(self.r, knots, 3).toarray()
        self.x = task.target(self.r)
        start, end = task.start_u, task.end_u
        self.fixed = {0: start} if start is not None else {}
        if end is not None:
            self.fixed[count - 1] = end
        self.count = count

    def u(self, c):
        """u (k, places) of coefficients (k, count), ends put where they must be, in the nearest turn."""
        c = np.array(c)
        for j, value in self.fixed.items():
            c[:, j] = value + TAU * np.rint((c[:, j] - value) / TAU)
        if self.task.cyclic:
            c[:, -1] = c[:, 0] + TAU * np.rint((c[:, -1] - c[:, 0]) / TAU)
        return c @ self.basis.T

    def fitted(self, u):
        return np.linalg.lstsq(self.basis, u, rcond=None)[0]

    def postures(self, u):
        """Continuous joint angles (k, places, n) with the turns that fit the limits best; least margins of reach."""
        task = self.task
        p, margin = task.solved(self.x, u, self.sign)
        q = np.unwrap(task.joints(p, 0.0), axis=1)
        if task.n == 4:
            q[..., 3] += task.direction
        low, high = q.min(axis=1), q.max(axis=1)
        with np.errstate(invalid="ignore"):
            middle = np.rint((0.5 * (task.lower + task.upper) - 0.5 * (low + high)) / TAU)
        above, below = np.ceil((task.lower - low) / TAU), np.floor((task.upper - high) / TAU)
        turns = np.where(np.isfinite(middle), middle, np.where(np.isfinite(above), above, below))
        return q + TAU * np.where(np.isfinite(turns), turns, 0.0)[:, None], margin

    def objective(self, c, penalty):
        """Cost of straight steps and penalties, shape (k,), of coefficients (k, count)."""
        task = self.task
        q, margin = self.postures(self.u(c))
        over = np.maximum(np.maximum(task.lower + _CLEAR - q, q - task.upper + _CLEAR), 0.0).sum(axis=2)
        over += np.maximum(_CLEAR - margin, 0.0) * 3
        return task.cost_of(np.diff(q, axis=1), np.diff(self.r)).sum(axis=1) + penalty * over.mean(axis=1)

    def minimised(self, c):
        """Coefficients after descent with growing penalties."""
        steps = _DIFFERENCE * np.concatenate([np.zeros((1, self.count)), np.eye(self.count), -np.eye(self.count)])

        def valued(c, penalty):
            values = self.objective(c + steps, penalty)
            forth, back = values[1 : self.count + 1], values[self.count + 1 :]
            return values[0], (forth - back) / (2 * _DIFFERENCE)

        for penalty in _PENALTIES:
            c = minimize(valued, c, args=(penalty,), jac=True, method="L-BFGS-B", options={"maxiter": 100}).x
        return c

    def motion(self, c):
        """The motion through the spline's postures, checked; None if it does not hold."""
        q, margin = self.postures(self.u(c[None]))
        q = q[0]
        if margin.min() < 0 or (q < self.task.lower).any() or (q > self.task.upper).any():
            return None
        return motion_through(self.task, self.r, q)

    def followers(self, rng, count):
        """Coefficients (count, …) of curves that drift at random and are pushed to where something is feasible."""
        task = self.task
        grid = np.linspace(-np.pi, np.pi, _GUESSES, endpoint=False)
        p, margin = task.solved(self.x[:, None], grid[None], self.sign)
        q = task.joints(p, 0.0)
        if task.n == 4:
            q[..., 3] += task.direction
        limited = np.isfinite(task.lower) & np.isfinite(task.upper)
        lower, upper = np.where(limited, task.lower, -np.inf), np.where(limited, task.upper, np.inf)
        middle = np.where(limited, 0.5 * (np.where(limited, lower, 0.0) + np.where(limited, upper, 0.0)), 0.0)
        half = np.where(limited, upper - middle, np.inf)
        ok = (margin > 0) & (np.abs(np.mod(q - middle + np.pi, TAU) - np.pi) <= half).all(axis=2)
        drift = rng.normal(0.0, 1.5, count)
        u = np.empty((count, len(self.r)))
        here = self._first(rng, grid[ok[0]], count)
        for k, r in enumerate(self.r):
            if k:
                here = here + drift * (r - self.r[k - 1])
            if ok[k].any() and (k or not self.fixed):
                choices = grid[ok[k]]
                off = np.mod(choices - here[:, None] + np.pi, TAU) - np.pi
                here = here + off[np.arange(count), np.argmin(np.abs(off), axis=1)]
            u[:, k] = here
        return np.array([self.fitted(row) for row in u])

    def _first(self, rng, feasible, count):
        if 0 in self.fixed:
            return np.full(count, self.fixed[0])
        return rng.choice(feasible, count) if len(feasible) else rng.uniform(-np.pi, np.pi, count)
