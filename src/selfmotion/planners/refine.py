"""Locally shortest motions of any arm from many starts: joint-space splines, refined by Newton's method."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, NoReturn, Self

import numpy as np

from selfmotion._checks import integer, number, positive
from selfmotion._types import BoolArray, FloatArray
from selfmotion.domain import blocked_stretches
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.refinement import ClosedSpline, Collocation, SplineSpace, minimise
from selfmotion.refinement.starts import Start, random_starts, start_from
from selfmotion.verification import verify_motion

_COARSE = 48  # spans that starts are compared on
_MOST_SPANS = 400
_MOST_CORNERS = 48
_LEVELS = 8
_REFINED = 3  # optima that are refined to the end
# Two optima are one if their costs agree to this part and their joints to this angle [rad].
_SAME_COST = 1e-4
_SAME_ANGLE = 0.05
# Rounding of the objectives' kinks on the coarse level, and what each finer level makes of it.
_WIDTH = 0.1
_NARROWER = 0.25
_NARROWEST = 1e-4
_WARM = 1e-5  # weight of the barrier on finer levels


@dataclass
class _Optimum:
    """A locally shortest motion and how often starts ended in it."""

    start: Start
    collocation: Collocation
    c: FloatArray
    cost: float
    found: int = 1
    r: FloatArray = field(default_factory=lambda: np.linspace(0.0, 1.0, 65))

    @property
    def coefficients(self) -> FloatArray:
        return self.collocation.coefficients(self.c)

    @property
    def motion(self) -> ClosedSpline:
        problem = self.collocation
        return ClosedSpline(problem.arm, problem.path, problem.space, self.coefficients, problem.box)

    def is_same(self, other: _Optimum) -> bool:
        if abs(self.cost - other.cost) > _SAME_COST * abs(self.cost):
            return False
        mine, theirs = (o.collocation.space.spline(o.coefficients)(self.r) for o in (self, other))
        steps = self.collocation.arm.limits.steps(mine, theirs)
        return bool(np.abs(steps).max() <= _SAME_ANGLE)


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
        Relative change of the cost from one level of knots to the next at which refinement stops.
    time_limit : float
        Seconds after which no further start or level is begun.

    Raises
    ------
    InvalidInputError
        If a number is out of range.

    Notes
    -----
    For any arm and degree of redundancy, with joint limits, one or any elbow, fixed end postures, cyclic motions and
    weights; motions may ride a limit and cross or ride a fold. All of it is local: the answer is the best of the optima
    found, without a bound. The search stops when the optima that are still unseen are expected to be fewer than a
    half, ``W (N − 1)/(N − W − 2) < W + ½`` for W optima from N starts (Boender, Rinnooy Kan 1987), or when starts or
    time run out; the plan's parameters say which. Method: docs/mathematics.
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

    def plan(self) -> Plan:
        problem = self.problem
        blocked = blocked_stretches(problem.arm, problem.path, problem.samples, problem.elbow_branches)
        if blocked:
            raise InfeasibleError(blocked)
        stopped = self._search()
        self.optima.sort(key=lambda optimum: optimum.cost)
        self.optima[:_REFINED] = [self._refined(optimum) for optimum in self.optima[:_REFINED]]
        self.optima.sort(key=lambda optimum: optimum.cost)
        for optimum in self.optima[:_REFINED]:
            motion = optimum.motion
            if verify_motion(problem, motion).holds:
                return Plan(
                    problem,
                    motion,
                    self.planner.kind,
                    self._parameters(optimum, stopped),
                    self.iterations,
                    time.perf_counter() - self.began,
                )
        self._give_up(stopped)

    def _search(self) -> str:
        """Refine starts on the coarse level until the optima are likely all seen; return why it stopped."""
        space = SplineSpace.with_spans(_COARSE, self._corners())
        for start in self._starts():
            if self.tried >= self.planner.starts:
                return f"all {self.planner.starts} starts were used"
            if self.tried and time.perf_counter() > self.deadline:
                return f"the time limit of {self.planner.time_limit:g} s passed"
            self.tried += 1
            self.furthest = max(self.furthest, start.reached)
            self._add(start, space)
            seen = len(self.optima)
            if self.ended > seen + 2 and seen * (self.ended - 1) / (self.ended - seen - 2) < seen + 0.5:
                return (
                    f"{self.ended} starts ended in {seen} {'optimum' if seen == 1 else 'optima'}: hardly one is unseen"
                )
            if self.progress is not None:
                best = min((optimum.cost for optimum in self.optima), default=np.inf)
                self.progress(self.tried, self.planner.starts, best)
        return f"no more than {self.tried} starts could be found"

    def _starts(self) -> Iterator[Start]:
        if self.planner.initial is not None:
            yield from self._initial_start(self.planner.initial)
        yield from random_starts(self.problem, np.random.default_rng(self.planner.seed))

    def _initial_start(self, planner: Planner) -> Iterator[Start]:
        """Yield the initial planner's motion; what it cannot keep of the ends is added to it."""
        free = copy.copy(self.problem)
        free.end, free.cyclic = None, False
        try:
            plan = planner.plan(free)
        except InvalidInputError as error:
            raise error.inside("planner.initial") from None
        except NothingFeasibleError as error:
            self.initial = {"kind": planner.kind, "failed": error.message}
            return
        self.initial = {"kind": planner.kind, "cost": plan.cost, **plan.parameters}
        yield start_from(self.problem, plan(self.problem.grid), self.problem.grid)

    def _corners(self) -> FloatArray:
        """Return where the path turns sharply, so that knots are put there: the sharpest corners if there are many."""
        path, breaks = self.problem.path, self.problem.path.breaks
        if not len(breaks):
            return breaks
        step = 1e-9
        turn = np.linalg.norm(path(breaks, 1) - path(breaks - step, 1), axis=1)
        return np.sort(breaks[np.argsort(-turn, kind="stable")[:_MOST_CORNERS]])

    def _collocation(self, start: Start, space: SplineSpace, width: float) -> Collocation:
        problem = self.problem
        return Collocation(
            problem.arm, problem.path, problem.objective, problem.weights, start.box, space, start.ends, width
        )

    def _add(self, start: Start, space: SplineSpace) -> None:
        """Refine one start on the coarse level and file the optimum it ends in."""
        collocation = self._collocation(start, space, _WIDTH)
        at = space.collocation
        sampled = np.stack([np.interp(at, start.r, joint) for joint in start.q.T], axis=-1)
        minimum = minimise(collocation, space.interpolating(sampled), tolerance=1e-7)
        if minimum is None:
            return
        self.iterations += minimum.iterations
        self.ended += 1
        optimum = _Optimum(start, collocation, minimum.c, minimum.cost)
        for known in self.optima:
            if known.is_same(optimum):
                known.found += 1
                if optimum.cost < known.cost:
                    known.collocation, known.c, known.cost, known.start = collocation, minimum.c, minimum.cost, start
                return
        self.optima.append(optimum)

    def _refined(self, optimum: _Optimum) -> _Optimum:
        """Return an optimum on knots so fine that the cost no longer changes, or as fine as time allows."""
        objective, width = self.problem.objective, _WIDTH
        for _ in range(_LEVELS):
            if time.perf_counter() > self.deadline:
                break
            space, motion = optimum.collocation.space, optimum.motion
            exact = float(
                space.weights
                @ objective.chord(motion.rates(space.nodes), np.ones(len(space.nodes)), self.problem.weights)
            )
            rough = _rough_spans(motion, self.planner.tolerance)
            close = abs(exact - optimum.cost) <= 0.5 * self.planner.tolerance * exact
            if close and not rough.any():
                break
            if len(rough) + rough.sum() > _MOST_SPANS and not (objective.has_kinks and width > _NARROWEST):
                break
            width = max(_NARROWER * width, _NARROWEST)
            finer = space.bisected(rough) if len(rough) + rough.sum() <= _MOST_SPANS else space
            collocation = self._collocation(optimum.start, finer, width)
            coefficients = finer.interpolating(space.spline(optimum.coefficients)(finer.collocation))
            minimum = minimise(collocation, coefficients, 0.01 * self.planner.tolerance, _WARM)
            if minimum is None:
                break
            self.iterations += minimum.iterations
            optimum = _Optimum(optimum.start, collocation, minimum.c, minimum.cost, optimum.found)
        return optimum

    def _parameters(self, optimum: _Optimum, stopped: str) -> dict[str, Any]:
        return {
            "coefficients": optimum.collocation.space.m,
            "starts": self.tried,
            "ended": self.ended,
            "stopped": stopped,
            "optima": [{"cost": other.cost, "found": other.found} for other in self.optima],
            "seed": self.planner.seed,
            "tolerance": self.planner.tolerance,
            "initial": self.initial,
        }

    def _give_up(self, stopped: str) -> NoReturn:
        if self.optima:
            reason = f"{len(self.optima)} optima were found, but none holds between its collocation points"
        elif self.tried:
            reason = f"none of {self.tried} starts could be led along the path; the best got to r = {self.furthest:.4g}"
        else:
            reason = "no posture to start from was found"
        raise NothingFeasibleError(
            f"{reason} ({stopped})",
            "give more starts, another seed, or an initial planner",
            self.iterations,
            1.0 - self.furthest,
        )


def _rough_spans(motion: ClosedSpline, tolerance: float) -> BoolArray:
    """Return the spans on which the motion is corrected by more than `tolerance` [rad]."""
    edges = motion.space.edges
    parts = np.linspace(0.0, 1.0, 7)[1:-1]
    looked_at = edges[:-1, None] + np.diff(edges)[:, None] * parts
    correction = motion.correction(looked_at.ravel()).reshape(looked_at.shape).max(axis=1)
    return np.asarray(correction > tolerance)
