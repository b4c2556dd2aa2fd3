"""Locally shortest motions of any arm from many starts: joint-space splines, refined by Newton's method."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator
from typing import Any, Literal, NoReturn, Self

import numpy as np

from selfmotion._checks import integer, number, positive
from selfmotion.constrained import constraints_of, unconstrained
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.refinement import Optima, Start, random_starts, start_from
from selfmotion.verification import Failure

_LOOKED_AT = 400  # parts of the path that an initial planner's motion is looked at
_AT_THE_RIM = 1e-6  # parts of the reach within which the arm has no room left to move
_ENDS: tuple[Literal["start", "end", "cyclic"], ...] = (
    "start",
    "end",
    "cyclic",
)  # what an initial planner need not keep
_FOLLOWERS = (8, 64)  # least and most postures led along the path at once
_FEWEST_STARTS = 12  # of two basins of the same size, one is missed by all of them once in two thousand searches


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
    weights; motions may ride a limit and cross or ride a fold. Of an arm's further constraints on postures they keep
    clear, between collocation points too, by some 1e-7 of the constraints' scale where they touch. All of it is local:
    the answer is the best of the optima found, without a bound. The search stops when the optima that are still unseen
    are expected to be fewer than a half, ``W (N − 1)/(N − W − 2) < W + ½`` for W optima from N ≥ 12 starts (Boender,
    Rinnooy Kan 1987), or when starts or time run out; the plan's parameters say which. Method: docs/mathematics.
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
        self.optima = Optima(problem, planner.tolerance, self.deadline)
        self.tried = 0
        self.furthest = 0.0
        self.initial: dict[str, Any] | None = None

    def plan(self) -> Plan:
        problem = self.problem
        blocked = problem.blocked
        if blocked:
            raise InfeasibleError(blocked)
        stopped = self._search()
        best, failure = self.optima.best()
        if best is None:
            self._give_up(stopped, failure)
        parameters = {"coefficients": best.collocation.space.m, **self._parameters(stopped)}
        seconds = time.perf_counter() - self.began
        return Plan(problem, best.motion, self.planner.kind, parameters, self.optima.iterations, seconds)

    def _search(self) -> str:
        """Refine starts on the coarse level until the optima are likely all seen; return why it stopped."""
        for start in self._starts():
            if self.tried >= self.planner.starts:
                return "the one start was used" if self.tried == 1 else f"all {self.tried} starts were used"
            if self.tried and time.perf_counter() > self.deadline:
                return f"the time limit of {self.planner.time_limit:g} s passed"
            self.tried += 1
            self.furthest = max(self.furthest, start.reached)
            self.optima.add(start)
            if self._hardly_one_is_unseen():
                seen = "1 optimum" if self._seen == 1 else f"{self._seen} optima"
                return f"{self.optima.ended} starts ended in {seen}, and less than half an optimum is expected unseen"
            if self.progress is not None:
                best = min((optimum.cost for optimum in self.optima.found), default=np.inf)
                self.progress(self.tried, self.planner.starts, best)
        return f"no more than {self.tried} starts could be found"

    def _hardly_one_is_unseen(self) -> bool:
        """Return whether fewer than half an optimum is expected unseen (Boender, Rinnooy Kan 1987)."""
        w, n = self._seen, self.optima.ended
        return n >= max(_FEWEST_STARTS, w + 3) and w * (n - 1) / (n - w - 2) < w + 0.5

    @property
    def _seen(self) -> int:
        """How many optima starts ended in, without those where the iterations ran out."""
        return sum(optimum.found > 0 for optimum in self.optima.found)

    def _starts(self) -> Iterator[Start]:
        if self.planner.initial is not None:
            yield from self._initial_start(self.planner.initial)
        followers = int(np.clip(2 * self.planner.starts, *_FOLLOWERS))
        yield from random_starts(self.problem, np.random.default_rng(self.planner.seed), followers, self.deadline)

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

    def _parameters(self, stopped: str) -> dict[str, Any]:
        return {
            "starts": self.tried,
            "ended": self.optima.ended,
            "stopped": stopped,
            "optima": [{"cost": other.cost, "found": other.found} for other in self.optima.found],
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
        if unconstrained(problem.arm).has_structure and (dead_end := problem.structure.dead_end) is not None:
            why = f" ({' and '.join(map(str, dead_end[1]))})" if dead_end[1] else ""
            remedy = f"the angle domain leads no further than r = {dead_end[0]:.6g}{why}: widen limits or move the path"
        if failure is not None:
            reason = (
                f"the best of {len(self.optima.found)} motions does not hold between its collocation points: {failure}"
            )
        elif not self.tried:
            given = " and ".join(name for name in ("start", "end") if getattr(problem, name) is not None)
            what = (
                f"the given {given} cannot be had" if given else "no posture that holds the tool on the path was found"
            )
            reason, remedy = f"{what} inside the joint limits", "widen the limits, or move the path"
        elif self.furthest < 1.0:
            reason = f"none of {self.tried} starts could be led along the path; the best got to r = {self.furthest:.4g}"
        else:
            more = ", and the arm's further constraints" if constraints_of(problem.arm) else ""
            reason = f"none of {self.tried} starts could be bent to keep task, limits and ends{more}"
        raise NothingFeasibleError(
            f"{reason} ({stopped})",
            remedy,
            self.optima.iterations,
            1.0 - self.furthest,
        )
