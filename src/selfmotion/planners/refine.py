"""Locally shortest motions of any arm from many starts: joint-space splines, refined by Newton's method."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, NoReturn, Self

import numpy as np

from selfmotion._checks import integer, number, positive
from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.domain import blocked_stretches
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.refinement import ClosedSpline, Collocation, SplineSpace, minimise
from selfmotion.refinement.starts import Start, random_starts, start_from
from selfmotion.verification import Failure, verify_motion

_COARSE = 48  # spans that starts are compared on
_MOST_SPANS = 400
_MOST_CORNERS = 48
_JUST_BEFORE = 1e-9  # a corner, in r
_TURN = 1e-3  # change of x' at a corner, as a part of the path's length
_LOOKED_AT = 400  # parts of the path that an initial planner's motion is looked at
_AT_THE_RIM = 1e-6  # parts of the reach within which the arm has no room left to move
_ENDS: tuple[Literal["start", "end", "cyclic"], ...] = (
    "start",
    "end",
    "cyclic",
)  # what an initial planner need not keep
_FOLLOWERS = (8, 64)  # least and most postures led along the path at once
_LEVELS = 8
_ROUGH = 1e-6  # correction [rad] of spans that are bisected, or those corrected by half the largest if that is less
_COARSE_TOLERANCE = 1e-7  # of Newton's method on the coarse level
_REFINED = 3  # optima that are refined to the end, at most, once one of them holds
_CAUTION = 10.0  # times as much as refinement changed one cost it may change another
_CAUTION_WITH_KINKS = 0.3  # what rounding off a kink changes, it changes of all costs alike
# Two optima are one if their costs agree to this part and their joints to this angle [rad].
_SAME_COST = 1e-4
_SAME_ANGLE = 0.05
_FEWEST_STARTS = 12  # of two basins of the same size, one is missed by all of them once in two thousand searches
_COMPARED_AT = np.linspace(0.0, 1.0, 65)
# Rounding of the objectives' kinks on the coarse level, as a part of the path's length by the arm's reach, which is
# about how fast joints move; and what each finer level makes of it.
_WIDTH = 0.1
_NARROWER = 0.25
_NARROWEST = 3e-4
_LEAST_WITH_KINKS = 1e-4  # tolerance that is worth its time for objectives with kinks
_WARM = 1e-5  # weight of the barrier on finer levels
_MOST_FINE = 100  # iterations on a finer level


@dataclass
class _Optimum:
    """A locally shortest motion and how often starts ended in it."""

    start: Start
    collocation: Collocation
    c: FloatArray
    cost: float
    found: int

    @property
    def coefficients(self) -> FloatArray:
        return self.collocation.coefficients(self.c)

    @property
    def motion(self) -> ClosedSpline:
        """The motion; free joints start in [−π, π], unless the problem says otherwise."""
        problem, coefficients = self.collocation, self.coefficients
        if problem.ends.start is None and problem.ends.end is None:
            turns = np.where(problem.arm.limits.limited, 0.0, np.rint(coefficients[:, 0] / TAU))
            coefficients = coefficients - TAU * turns[:, None]
        return ClosedSpline(problem.arm, problem.path, problem.space, coefficients, problem.box)

    def is_same(self, other: _Optimum) -> bool:
        if abs(self.cost - other.cost) > _SAME_COST * abs(self.cost):
            return False
        mine, theirs = (o.collocation.space.spline(o.coefficients)(_COMPARED_AT) for o in (self, other))
        steps = theirs - mine
        # Shifted by whole turns a motion costs the same.
        return bool(np.abs(steps - TAU * np.rint(steps[0] / TAU)).max() <= _SAME_ANGLE)


class Refine(Planner):
    """Refines motions from many starts to locally shortest ones and returns the best.

    Parameters
    ----------
    initial : Planner, optional
        A planner whose motion is the first start, such as ``Sinusoid`` or ``Harmonics`` with a metaheuristic.
    starts : int
        Largest number of starts.
    seed : int
        Of the random starts.
    tolerance : float
        Relative change of the cost from one level of knots to the next at which refinement stops, at 400 spans at the
        latest; for l1 and l2 at least 1e-4.
    time_limit : float
        Seconds after which the best motion so far is the answer. The first start is always tried, and neither the
        initial planner nor the search for starts is interrupted.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Notes
    -----
    For arms of any degree of redundancy, with joint limits, one or any elbow, fixed end postures, cyclic motions and
    weights; motions may ride a limit and cross or ride a fold. All of it is local: the answer is the best of the optima
    found, without a bound. The search stops when the optima that are still unseen are expected to be fewer than a
    half, ``W (N − 1)/(N − W − 2) < W + ½`` for W optima from N ≥ 12 starts (Boender, Rinnooy Kan 1987), or when
    starts or time run out; the plan's parameters say which. Method: docs/mathematics.
    """

    kind = "refine"

    def __init__(
        self,
        initial: Planner | None = None,
        starts: int = 24,
        seed: int = 0,
        tolerance: float = 1e-6,
        time_limit: float = 60.0,
    ) -> None:
        if initial is not None and not isinstance(initial, Planner):
            raise InvalidInputError("initial", "is not a planner", "give one, such as Sinusoid(…)", initial)
        self.initial = initial
        self.starts = integer("starts", starts, 1, 100_000)
        self.seed = integer("seed", seed, 0, 2**63 - 1)
        self.tolerance = number("tolerance", tolerance, 1e-9, 1e-1)
        self.time_limit = positive("time_limit", time_limit)

    def with_seed(self, seed: int) -> Self:
        """Return the same planner with another seed, of the initial planner too."""
        other = copy.copy(self)
        other.seed = integer("seed", seed, 0, 2**63 - 1)
        other.initial = None if self.initial is None else self.initial.with_seed(seed)
        return other

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`."""
        import scipy.linalg  # noqa: F401 (its BLAS must be loaded to be limited)
        from threadpoolctl import threadpool_limits

        # The matrices are small: several threads on each would only wait for one another.
        with threadpool_limits(1, "blas"):
            return _Search(self, problem, progress).plan()


class _Search:
    """One run of the planner."""

    def __init__(self, planner: Refine, problem: Problem, progress: Progress | None) -> None:
        self.planner, self.problem, self.progress = planner, problem, progress
        self.began = time.perf_counter()
        self.deadline = self.began + planner.time_limit
        self.optima: list[_Optimum] = []
        self.tried = self.ended = self.iterations = 0
        self.furthest = 0.0
        self.initial: dict[str, Any] | None = None
        self._scale = float(problem.weights.max())  # the solver's weights are 1 at most

    def plan(self) -> Plan:
        problem = self.problem
        blocked = blocked_stretches(problem.arm, problem.path, problem.samples, problem.elbow_branches)
        if blocked:
            raise InfeasibleError(blocked)
        stopped = self._search()
        best, failure = self._best()
        if best is None:
            self._give_up(stopped, failure)
        parameters = {"coefficients": best.collocation.space.m, **self._parameters(stopped)}
        seconds = time.perf_counter() - self.began
        return Plan(problem, best.motion, self.planner.kind, parameters, self.iterations, seconds)

    def _best(self) -> tuple[_Optimum | None, Failure | None]:
        """Refine the optima that could turn out to be the best, and return the best that holds; or why one does not."""
        self.optima.sort(key=lambda optimum: optimum.cost)
        best: _Optimum | None = None
        failure: Failure | None = None
        shift = 0.0  # what refinement has changed of a cost so far
        caution = _CAUTION_WITH_KINKS if self.problem.objective.has_kinks else _CAUTION
        for k, optimum in enumerate(self.optima):
            if best is not None and (k >= _REFINED or optimum.cost - caution * shift > best.cost):
                break
            finer = self._refined(optimum)
            shift = max(shift, abs(finer.cost - optimum.cost))
            self.optima[k] = finer
            check = verify_motion(self.problem, finer.motion)
            if check.holds and (best is None or finer.cost < best.cost):
                best = finer
            elif not check.holds:
                failure = failure or check.failures[0]
        self.optima.sort(key=lambda optimum: optimum.cost)
        return best, failure

    def _search(self) -> str:
        """Refine starts on the coarse level until the optima are likely all seen; return why it stopped."""
        space = SplineSpace.with_spans(_COARSE, self._corners())
        for start in self._starts():
            if self.tried >= self.planner.starts:
                return "the one start was used" if self.tried == 1 else f"all {self.tried} starts were used"
            if self.tried and time.perf_counter() > self.deadline:
                return f"the time limit of {self.planner.time_limit:g} s passed"
            self.tried += 1
            self.furthest = max(self.furthest, start.reached)
            self._add(start, space)
            if self._hardly_one_is_unseen():
                seen = "1 optimum" if self._seen == 1 else f"{self._seen} optima"
                return f"{self.ended} starts ended in {seen}, and less than half an optimum is expected unseen"
            if self.progress is not None:
                best = min((optimum.cost for optimum in self.optima), default=np.inf)
                self.progress(self.tried, self.planner.starts, best)
        return f"no more than {self.tried} starts could be found"

    def _hardly_one_is_unseen(self) -> bool:
        """Return whether fewer than half an optimum is expected unseen (Boender, Rinnooy Kan 1987)."""
        w, n = self._seen, self.ended
        return n >= max(_FEWEST_STARTS, w + 3) and w * (n - 1) / (n - w - 2) < w + 0.5

    @property
    def _seen(self) -> int:
        """How many optima starts ended in, without those where the iterations ran out."""
        return sum(optimum.found > 0 for optimum in self.optima)

    def _starts(self) -> Iterator[Start]:
        if self.planner.initial is not None:
            yield from self._initial_start(self.planner.initial)
        followers = int(np.clip(2 * self.planner.starts, *_FOLLOWERS))
        yield from random_starts(self.problem, np.random.default_rng(self.planner.seed), followers)

    def _initial_start(self, planner: Planner) -> Iterator[Start]:
        """Yield the initial planner's motion; what it cannot keep of the ends is added to it."""
        try:
            plan = self._planned(planner)
        except NothingFeasibleError as error:
            self.initial = {"kind": planner.kind, "failed": error.message}
            return
        self.initial = {"kind": planner.kind, "cost": plan.cost, **plan.parameters}
        r = self.problem.path.grid(_LOOKED_AT)
        yield start_from(self.problem, plan(r), r)

    def _planned(self, planner: Planner) -> Plan:
        """Plan with the initial planner, without those of the ends' constraints that it cannot keep."""
        problem = self.problem
        while True:
            try:
                return planner.plan(problem)
            except InvalidInputError as error:
                refused = [name for name in _ENDS if name == error.field and getattr(problem, name)]
                if not refused:
                    raise InvalidInputError(
                        "planner.initial", f"cannot plan this problem: {error.field} {error.reason}", error.remedy
                    ) from None
                problem = problem.without(refused[0])

    def _corners(self) -> FloatArray:
        """Return where the path turns sharply, so that knots are put there: the sharpest corners if there are many."""
        path, breaks = self.problem.path, self.problem.path.breaks
        if not len(breaks):
            return breaks
        before = np.maximum(breaks - _JUST_BEFORE, 0.0)
        turn = np.linalg.norm(path(breaks, 1) - path(before, 1), axis=1)
        sharp = np.argsort(-turn, kind="stable")[:_MOST_CORNERS]
        return np.sort(breaks[sharp[turn[sharp] > _TURN * path.length]])

    def _collocation(self, start: Start, space: SplineSpace, width: float) -> Collocation:
        problem, weights = self.problem, self.problem.weights / self._scale
        rate = problem.path.length / problem.arm.reach
        return Collocation(
            problem.arm, problem.path, problem.objective, weights, start.box, space, start.ends, width * rate
        )

    def _add(self, start: Start, space: SplineSpace) -> None:
        """Refine one start on the coarse level and file the optimum it ends in."""
        collocation = self._collocation(start, space, _WIDTH)
        at = space.collocation
        sampled = np.stack([np.interp(at, start.r, joint) for joint in start.q.T], axis=-1)
        minimum = minimise(
            collocation, space.interpolating(sampled), tolerance=_COARSE_TOLERANCE, deadline=self.deadline
        )
        if minimum is None:
            return
        self.iterations += minimum.iterations
        self.ended += minimum.converged
        cost = minimum.cost * self._scale
        optimum = _Optimum(start, collocation, minimum.c, cost, found=int(minimum.converged))
        for k, known in enumerate(self.optima):
            if known.is_same(optimum):
                found = known.found + optimum.found
                self.optima[k] = replace(optimum if cost < known.cost else known, found=found)
                return
        self.optima.append(optimum)

    def _refined(self, optimum: _Optimum) -> _Optimum:
        """Return an optimum on knots so fine that the cost no longer changes, or as fine as time allows."""
        tolerance, width = self.planner.tolerance, _NARROWEST
        if self.problem.objective.has_kinks:
            tolerance, width = max(tolerance, _LEAST_WITH_KINKS), _WIDTH
        before = np.inf
        for _ in range(_LEVELS):
            if time.perf_counter() > self.deadline:
                break
            space, motion = optimum.collocation.space, optimum.motion
            cost = self._cost_of(motion)
            settled = abs(cost - before) <= tolerance * cost or abs(cost - optimum.cost) <= 0.1 * tolerance * cost
            correction = _corrections(motion)
            rough = correction > min(_ROUGH, 0.5 * correction.max())
            if width <= _NARROWEST and (settled or len(rough) + rough.sum() > _MOST_SPANS):
                break
            finer = space.bisected(rough) if len(rough) + rough.sum() <= _MOST_SPANS else space
            before, width = cost, max(_NARROWER * width, _NARROWEST)
            collocation = self._collocation(optimum.start, finer, width)
            coefficients = finer.interpolating(space.spline(optimum.coefficients)(finer.collocation))
            minimum = minimise(collocation, coefficients, 0.01 * tolerance, _WARM, _MOST_FINE, self.deadline)
            if minimum is None:
                break
            self.iterations += minimum.iterations
            optimum = _Optimum(optimum.start, collocation, minimum.c, minimum.cost * self._scale, optimum.found)
        return replace(optimum, cost=self._cost_of(optimum.motion))

    def _cost_of(self, motion: ClosedSpline) -> float:
        """Return the true cost of a motion, by the quadrature of its spline."""
        space = motion.space
        rates = motion.rates(space.nodes)
        return float(space.weights @ self.problem.objective.chord(rates, np.ones(len(rates)), self.problem.weights))

    def _parameters(self, stopped: str) -> dict[str, Any]:
        return {
            "starts": self.tried,
            "ended": self.ended,
            "stopped": stopped,
            "optima": [{"cost": other.cost, "found": other.found} for other in self.optima],
            "initial": self.initial,
            "settings": {name: getattr(self.planner, name) for name in ("starts", "seed", "tolerance", "time_limit")},
        }

    def _give_up(self, stopped: str, failure: Failure | None) -> NoReturn:
        problem, remedy = self.problem, "give more starts, another seed, or an initial planner"
        if problem.cyclic == "exact" and not problem.arm.limits.limited.all():
            remedy += "; or let free joints gain whole turns, with cyclic: modulo"
        r = problem.path.grid(_LOOKED_AT)
        shortfall = problem.arm.shortfall(problem.path(r))
        if shortfall.max() > -_AT_THE_RIM * problem.arm.reach:
            remedy = f"keep away from the limit of reach, which the path touches at r = {r[shortfall.argmax()]:.4g}"
        if problem.arm.n_u == 1 and (dead_end := problem.structure.dead_end) is not None:
            why = f" ({' and '.join(map(str, dead_end[1]))})" if dead_end[1] else ""
            remedy = f"the angle domain leads no further than r = {dead_end[0]:.6g}{why}: widen limits or move the path"
        if failure is not None:
            reason = f"the best of {len(self.optima)} motions does not hold between its collocation points: {failure}"
        elif not self.tried:
            given = " and ".join(name for name in ("start", "end") if getattr(problem, name) is not None)
            what = (
                f"the given {given} cannot be had" if given else "no posture that holds the tool on the path was found"
            )
            reason, remedy = f"{what} inside the joint limits", "widen the limits, or move the path"
        elif self.furthest < 1.0:
            reason = f"none of {self.tried} starts could be led along the path; the best got to r = {self.furthest:.4g}"
        else:
            reason = f"none of {self.tried} starts could be bent to keep task, limits and ends"
        raise NothingFeasibleError(
            f"{reason} ({stopped})",
            remedy,
            self.iterations,
            1.0 - self.furthest,
        )


def _corrections(motion: ClosedSpline) -> FloatArray:
    """Return how much the motion is corrected on each span of its spline, at most [rad]."""
    edges = motion.space.edges
    looked_at = edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0.0, 1.0, 7)[1:-1]
    return motion.correction(looked_at.ravel()).reshape(looked_at.shape).max(axis=1)
