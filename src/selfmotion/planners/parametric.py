"""The seed's planner: a profile inside the angle domain, its coefficients chosen by an optimizer (section IV-D)."""

from __future__ import annotations

import heapq
import itertools
import time
from abc import abstractmethod
from collections.abc import Iterator
from typing import Any, ClassVar, NamedTuple

import numpy as np

from selfmotion._checks import choice, finite_array
from selfmotion._types import FloatArray, Vector
from selfmotion.angles import wrap
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError
from selfmotion.motion import Motion
from selfmotion.optimizers import INFEASIBLE, Optimizer, Progress, Result, counting, violation_of
from selfmotion.planners.base import SearchingPlanner
from selfmotion.planners.candidates import RANKINGS, Candidates, Ranking, candidates_of
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.profiles import Profile, ProfileCurve, SinusoidProfile
from selfmotion.verification import verify_motion

SAMPLES_PER_CYCLE = 8
"""Samples needed per oscillation, so that the chord sum sees what the motion does."""
MOST_CHECKS = 200
"""Candidates that hold at the samples but not between them are passed over, at most this many."""
# The same per smooth piece of the path.
_SAMPLES_PER_PIECE = 4
# An offset and a start that differ by less are the same [rad].
_SAME = 1e-9


class _Found(NamedTuple):
    """One judged candidate; they sort by value, then by branch and the order in which they were met."""

    value: float
    branch: int
    number: int
    a: FloatArray


class _Search(NamedTuple):
    """The search on one branch."""

    branch: int
    candidates: Candidates
    result: Result

    def ascending(self) -> Iterator[_Found]:
        """Yield the feasible candidates, the cheapest first; what is known by a lower bound only is judged when due."""
        population, values, exact = self.result.judged
        due: list[_Found] = []
        for k in np.argsort(values, kind="stable"):
            if values[k] >= INFEASIBLE:
                break
            while due and due[0].value <= values[k]:
                yield heapq.heappop(due)
            value = float(values[k]) if exact[k] else float(self.candidates(population[k : k + 1])[0])
            found = _Found(value, self.branch, int(k), population[k])
            if exact[k]:
                yield found
            elif value < INFEASIBLE:
                heapq.heappush(due, found)
        while due:
            yield heapq.heappop(due)


class Parametric(SearchingPlanner):
    """Chooses the coefficients of a profile family by an optimizer on a box.

    Parameters
    ----------
    optimizer : Optimizer
    ranking : {"integral", "samples"}
        What candidates are ranked by: the objective as an integral, as accurately as their rank needs, or as the seed's
        chord sum over the problem's samples.

    Attributes
    ----------
    vectors : tuple of str
        The fields that hold one number per redundant degree.
    slower : str
        What makes the profiles slower, as a remedy.

    Raises
    ------
    InvalidInputError
        If `ranking` is neither.

    Notes
    -----
    Every branch that the problem allows, and on which the profile's start is feasible, is searched with the
    optimizer's whole budget. A candidate is feasible if it is at the problem's samples; the best one that also holds
    *between* them becomes the plan. Candidates of arms that are not planar are ranked by their chord sum in any case.
    """

    vectors: ClassVar[tuple[str, ...]] = ("offset",)
    slower: ClassVar[str] = "lower planner.optimizer.bounds"

    def __init__(self, optimizer: Optimizer, ranking: Ranking = "integral") -> None:
        super().__init__(optimizer)
        self.ranking: Ranking = choice("ranking", ranking, RANKINGS)  # type: ignore[assignment]

    @abstractmethod
    def profile_for(self, problem: Problem) -> Profile:
        """Return the profile family to search for this problem."""

    def optimizer_for(self, profile: Profile) -> Optimizer:
        """Return the optimizer with the box in which it searches this family."""
        return self.optimizer

    def candidates_for(self, problem: Problem, profile: Profile, branch: int) -> Candidates:
        """Return what judges a population on one branch."""
        return candidates_of(problem, profile, branch, self.ranking)

    def starting_branches(self, problem: Problem, profile: Profile) -> list[int]:
        """Return the branches to search: those that the problem allows and on which the profile's start is feasible.

        Raises
        ------
        InvalidInputError
            If there is none.
        """
        start = profile.start
        if start is None:
            return problem.start_branches
        branches = [branch for branch in problem.start_branches if problem.may_start_at(start, branch)]
        if not branches:
            raise InvalidInputError(
                "planner.offset",
                "is outside the angle domain at r = 0",
                problem.feasible_at(0.0),
                start.tolist(),
            )
        return branches

    def holds(self, problem: Problem, motion: Motion) -> bool:
        """Return whether a motion that holds at the samples also does between them."""
        return verify_motion(problem, motion).holds

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`."""
        began = time.perf_counter()
        self._check_lengths(problem)
        profile = self.profile_for(problem)
        optimizer = self.optimizer_for(profile)
        self._check(problem, profile, optimizer)
        blocked = problem.blocked
        if blocked:
            raise InfeasibleError(blocked)
        branches = self.starting_branches(problem, profile)
        searches = []
        for k, branch in enumerate(branches):
            counted = counting(progress, k * optimizer.iterations, len(branches) * optimizer.iterations)
            candidates = self.candidates_for(problem, profile, branch)
            result = optimizer.minimize(candidates, len(profile.parameter_names), counted)
            searches.append(_Search(branch, candidates, result))
        evaluations = sum(search.result.evaluations for search in searches)
        best, motion = self._first_that_holds(problem, profile, searches, evaluations)
        parameters: dict[str, Any] = {
            **{name: float(v) for name, v in zip(profile.parameter_names, best.a, strict=True)},
            "elbow": problem.arm.branches[best.branch],
            **profile.settings(),
            "optimizer": {"kind": optimizer.kind, **optimizer.settings()},
        }
        history = tuple(search.result.history for search in searches)
        return Plan(problem, motion, self.kind, parameters, evaluations, time.perf_counter() - began, history)

    def _check_lengths(self, problem: Problem) -> None:
        """Refuse vectors that are made for another arm."""
        for name in self.vectors:
            value = getattr(self, name)
            if value is not None and len(value) != problem.arm.n_u:
                raise InvalidInputError(
                    f"planner.{name}",
                    f"has length {len(value)} for an arm with n_u = {problem.arm.n_u}",
                    "give one number per redundant degree: a planar arm with n links needs n − 2, "
                    "and n − 3 if its last link keeps a direction",
                    value.tolist(),
                )

    def _check(self, problem: Problem, profile: Profile, optimizer: Optimizer) -> None:
        """Refuse ends and cycles that the family does not keep, and samples too few for its profiles or the path."""
        start = profile.start
        if problem.start is not None and start is not None and np.abs(wrap(start - problem.start.u)).max() > _SAME:
            raise InvalidInputError(
                "planner.offset",
                f"disagrees with start, whose u is {problem.start.u.tolist()}",
                "leave one of the two out",
                start.tolist(),
            )
        if problem.end is not None and profile.end is None:
            raise InvalidInputError("end", f"cannot be kept by planner {self.kind}", "leave it out")
        if problem.end is not None and problem.end.q is not None:
            remedy = "give end: {u: […]}, which leaves the turns of the joints open"
            raise InvalidInputError("end.q", f"cannot be kept by planner {self.kind}", remedy)
        if problem.cyclic:
            raise InvalidInputError(
                "cyclic", f"cannot be kept by planner {self.kind}", "set cyclic: false", problem.cyclic
            )
        try:
            lower, upper = optimizer.box(len(profile.parameter_names))
        except InvalidInputError as error:
            raise error.inside("planner.optimizer") from None
        cycles = int(np.ceil(SAMPLES_PER_CYCLE * max(profile.cycles(lower), profile.cycles(upper))))
        pieces = _SAMPLES_PER_PIECE * (len(problem.path.breaks) + 1)
        if problem.samples < cycles:
            reason = "cannot resolve the fastest profile that may be chosen"
            remedy = f"give at least {cycles}, or {self.slower}"
            raise InvalidInputError("samples", reason, remedy, problem.samples)
        if problem.samples < pieces and len(problem.path.breaks):
            reason = f"cannot resolve a path of {len(problem.path.breaks) + 1} pieces"
            raise InvalidInputError("samples", reason, f"give at least {pieces}", problem.samples)

    def _first_that_holds(
        self, problem: Problem, profile: Profile, searches: list[_Search], evaluations: int
    ) -> tuple[_Found, Motion]:
        """Return the cheapest candidate whose motion holds between the samples too."""
        start = None if problem.start is None else problem.start.q
        ranked = heapq.merge(*(search.ascending() for search in searches), key=lambda found: found[:3])
        checked = 0
        for candidate in itertools.islice(ranked, MOST_CHECKS):
            checked += 1
            curve = ProfileCurve(profile, candidate.a)
            nodes = max(2 * problem.samples, int(16 * profile.cycles(candidate.a)))
            motion = Motion(problem.arm, problem.path, curve, candidate.branch, nodes, start)
            if self.holds(problem, motion):
                return candidate, motion
        if checked:
            raise NothingFeasibleError(
                f"the best {checked} of {evaluations} candidates hold at the samples, but break between them",
                "give more samples",
                evaluations,
                0.0,
            )
        least = violation_of(min(search.result.value for search in searches))
        raise NothingFeasibleError(
            f"none of {evaluations} candidates stays inside the angle domain; the best leaves it by {least:.3g}",
            "try another offset, a smaller amplitude or span, or other bounds",
            evaluations,
            least,
        )


class Sinusoid(Parametric):
    """The seed's planner: the sinusoid (22) with its frequency chosen by an optimizer.

    Parameters
    ----------
    offset : array_like, shape (n_u,), optional
        The redundancy vector at r = 0, θ_gi [rad]; by default that of the problem's start.
    amplitude : array_like, shape (n_u,)
        A [rad].
    optimizer : Optimizer
        Searches the frequency f of each component.
    ranking : {"integral", "samples"}
        What candidates are ranked by, the integral or the seed's chord sum over the problem's samples.

    Raises
    ------
    InvalidInputError
        If offset and amplitude differ in length or all amplitudes are zero.
    """

    kind = "sinusoid"
    vectors = ("offset", "amplitude")

    def __init__(
        self,
        offset: Vector | None = None,
        *,
        amplitude: Vector,
        optimizer: Optimizer,
        ranking: Ranking = "integral",
    ) -> None:
        super().__init__(optimizer, ranking)
        self.amplitude = finite_array("amplitude", amplitude, 1)
        self.offset = None if offset is None else SinusoidProfile(offset, self.amplitude).offset

    def profile_for(self, problem: Problem) -> SinusoidProfile:
        """Return the sinusoids with this amplitude that start at the offset."""
        if self.offset is not None:
            return SinusoidProfile(self.offset, self.amplitude)
        if problem.start is None:
            raise InvalidInputError("planner.offset", "is missing", "give it, or a start")
        return SinusoidProfile(problem.start.u, self.amplitude)
