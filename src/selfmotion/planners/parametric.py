"""The seed's planner: a profile inside the angle domain, its coefficients chosen by an optimizer (section IV-D)."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from selfmotion._checks import finite_array
from selfmotion._types import FloatArray, Vector
from selfmotion.angles import wrap
from selfmotion.domain import blocked_stretches
from selfmotion.errors import InfeasibleError, InvalidInputError, NothingFeasibleError
from selfmotion.motion import Motion
from selfmotion.optimizers import INFEASIBLE, Optimizer, Progress, Result, counting, penalised, violation_of
from selfmotion.planners.base import SearchingPlanner
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.profiles import Profile, SinusoidProfile
from selfmotion.verification import verify_motion

SAMPLES_PER_CYCLE = 8
"""Samples needed per oscillation, so that the chord sum sees what the motion does."""
MOST_CHECKS = 200
"""Candidates that hold at the samples but not between them are passed over, at most this many."""
# The same per smooth piece of the path.
_SAMPLES_PER_PIECE = 4
# Candidates are evaluated in blocks of about this many joint angles: what stays in the processor's cache.
_BLOCK = 16_000
# A candidate is inside the domain if it leaves it by rounding only: radians, or parts of the reach.
_ROUNDING = 1e-12
# An offset and a start that differ by less are the same [rad].
_SAME = 1e-9


class Candidates:
    """The seed's objective on one branch: what a population of coefficient vectors costs.

    Parameters
    ----------
    problem : Problem
    profile : Profile
    branch : int

    Attributes
    ----------
    r : array, shape (k,)
        The samples.
    x : array, shape (k, 2)
        The path there.
    """

    def __init__(self, problem: Problem, profile: Profile, branch: int) -> None:
        self.problem = problem
        self.profile = profile
        self.branch = branch
        self.r = problem.grid
        self.x = problem.path(self.r)
        self._start = None if problem.start is None else problem.start.q

    def __call__(self, population: FloatArray) -> FloatArray:
        """Return the values of a population, shape (p, d), as the optimizers rank them.

        The value of a feasible candidate is its chord sum over the samples. One that leaves the angle domain is ranked,
        after all feasible ones, by how far it leaves: by the largest shortfall of reach (in parts of the reach) plus
        each joint's largest overrun of its limits [rad].
        """
        return in_blocks(self.block, population, len(self.r) * self.problem.arm.n)

    def block(self, population: FloatArray) -> FloatArray:
        """Return the same for as many candidates as are judged at once; what judges otherwise overrides this."""
        arm = self.problem.arm
        q, margin = arm.solve_with_margin(self.x, self.profile(population, self.r), self.branch)
        lifted = arm.limits.lift(q, self._start)
        cost = self.problem.objective.sampled(lifted.q, self.r, self.problem.weights)
        return penalised(cost, outside(margin / arm.reach, lifted.excess))


def in_blocks(judge: Callable[[FloatArray], FloatArray], population: FloatArray, angles: int) -> FloatArray:
    """Return the values of a population, shape (p, d), judged in blocks that stay in the processor's cache.

    Parameters
    ----------
    judge : callable
        Maps a block, shape (b, d), to values, shape (b,).
    population : array, shape (p, d)
    angles : int
        Number of joint angles of one candidate.
    """
    rows = max(1, _BLOCK // angles)
    return np.concatenate([judge(population[k : k + rows]) for k in range(0, len(population), rows)])


def outside(margin: FloatArray, excess: FloatArray) -> FloatArray:
    """Return how far sampled motions leave the angle domain, shape (p,), zero inside.

    Parameters
    ----------
    margin : array, shape (p, k)
        Signed distance to the limit of reach, in parts of the reach.
    excess : array, shape (p, n)
        Overrun of each joint [rad].
    """
    short = np.maximum(-margin.min(axis=1), 0.0)
    violation = np.where(short > _ROUNDING, short, 0.0)
    violation += np.where(excess > _ROUNDING, excess, 0.0).sum(axis=1)
    return violation


class _Found(NamedTuple):
    """One judged candidate."""

    value: float
    branch: int
    a: FloatArray


class Parametric(SearchingPlanner):
    """Chooses the coefficients of a profile family by an optimizer on a box.

    Parameters
    ----------
    optimizer : Optimizer

    Attributes
    ----------
    vectors : tuple of str
        The fields that hold one number per redundant degree.
    slower : str
        What makes the profiles slower, as a remedy.

    Notes
    -----
    Every branch that the problem allows, and on which the profile's start is feasible, is searched with the
    optimizer's whole budget. The optimizer sees the chord sum over the problem's samples, as the seed's does;
    the best candidate that also holds *between* the samples becomes the plan.
    """

    vectors: ClassVar[tuple[str, ...]] = ("offset",)
    slower: ClassVar[str] = "lower planner.optimizer.bounds"

    @abstractmethod
    def profile_for(self, problem: Problem) -> Profile:
        """Return the profile family to search for this problem."""

    def optimizer_for(self, profile: Profile) -> Optimizer:
        """Return the optimizer with the box in which it searches this family."""
        return self.optimizer

    def candidates_for(self, problem: Problem, profile: Profile, branch: int) -> Candidates:
        """Return what judges a population on one branch."""
        return Candidates(problem, profile, branch)

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
        blocked = blocked_stretches(problem.arm, problem.path, problem.samples, problem.elbow_branches)
        if blocked:
            raise InfeasibleError(blocked)
        branches = self.starting_branches(problem, profile)
        results = {
            branch: optimizer.minimize(
                self.candidates_for(problem, profile, branch),
                len(profile.parameter_names),
                counting(progress, k * optimizer.iterations, len(branches) * optimizer.iterations),
            )
            for k, branch in enumerate(branches)
        }
        evaluations = sum(result.evaluations for result in results.values())
        best, motion = self._first_that_holds(problem, profile, results, evaluations)
        parameters: dict[str, Any] = {
            **{name: float(v) for name, v in zip(profile.parameter_names, best.a, strict=True)},
            "elbow": problem.arm.branches[best.branch],
            **profile.settings(),
            "optimizer": {"kind": optimizer.kind, **optimizer.settings()},
        }
        history = tuple(results[branch].history for branch in branches)
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
        self, problem: Problem, profile: Profile, results: dict[int, Result], evaluations: int
    ) -> tuple[_Found, Motion]:
        """Return the cheapest candidate whose motion holds between the samples too."""
        found = [
            _Found(float(value), branch, a)
            for branch, result in results.items()
            for value, a in zip(result.values, result.population, strict=True)
            if value < INFEASIBLE
        ]
        if not found:
            least = violation_of(min(result.value for result in results.values()))
            raise NothingFeasibleError(
                f"none of {evaluations} candidates stays inside the angle domain; the best leaves it by {least:.3g}",
                "try another offset, a smaller amplitude or span, or other bounds",
                evaluations,
                least,
            )
        found.sort(key=lambda candidate: candidate.value)
        start = None if problem.start is None else problem.start.q
        for candidate in found[:MOST_CHECKS]:
            a = candidate.a

            def curve(r: FloatArray, order: int, a: FloatArray = a) -> FloatArray:
                return profile(a, r, order)

            nodes = max(2 * problem.samples, int(16 * profile.cycles(a)))
            motion = Motion(problem.arm, problem.path, curve, candidate.branch, nodes, start)
            if self.holds(problem, motion):
                return candidate, motion
        raise NothingFeasibleError(
            f"{len(found)} of {evaluations} candidates hold at the samples, but the best "
            f"{min(len(found), MOST_CHECKS)} break between them",
            "give more samples",
            evaluations,
            0.0,
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

    Raises
    ------
    InvalidInputError
        If offset and amplitude differ in length or all amplitudes are zero.
    """

    kind = "sinusoid"
    vectors = ("offset", "amplitude")

    def __init__(self, offset: Vector | None = None, *, amplitude: Vector, optimizer: Optimizer) -> None:
        super().__init__(optimizer)
        self.amplitude = finite_array("amplitude", amplitude, 1)
        self.offset = None if offset is None else SinusoidProfile(offset, self.amplitude).offset

    def profile_for(self, problem: Problem) -> SinusoidProfile:
        """Return the sinusoids with this amplitude that start at the offset."""
        if self.offset is not None:
            return SinusoidProfile(self.offset, self.amplitude)
        if problem.start is None:
            raise InvalidInputError("planner.offset", "is missing", "give it, or a start")
        return SinusoidProfile(problem.start.u, self.amplitude)
