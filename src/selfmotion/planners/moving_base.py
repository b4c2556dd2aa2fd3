"""Many links without a given moving base: it is chosen together with the motions of the modules on it."""

from __future__ import annotations

import itertools
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from selfmotion._checks import choice, integer, positive
from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import PlanarArm
from selfmotion.errors import InvalidInputError, NothingFeasibleError
from selfmotion.motion import Motion
from selfmotion.optimizers import INFEASIBLE, Optimizer, Progress, Result, counting, violation_of
from selfmotion.paths import Bezier, Path
from selfmotion.planners.base import SearchingPlanner, refuse_own_bounds
from selfmotion.planners.chain import (
    Chain,
    allowed_elbows,
    module_arms,
    refuse_what_modules_cannot_keep,
    splittable,
)
from selfmotion.planners.chain_candidates import PLACES, ChainCandidates, Choice, first_guess
from selfmotion.planners.modules import module_costs
from selfmotion.planners.parametric import MOST_CHECKS, SAMPLES_PER_CYCLE
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.verification import verify_motion

# Control points of higher degrees hardly move the curve one by one.
_MOST_POINTS = 24
# Each combination of elbows costs the whole budget.
_MOST_COMBINATIONS = 16
# Candidates that hold at the places looked at are looked at more closely, and if they hold there too verified.
_MOST_LOOKS = 20_000


class MovingBase(SearchingPlanner):
    """Chooses Bezier moving bases together with the sinusoids of all modules, for the cost in true joints.

    Parameters
    ----------
    optimizer : Optimizer
        Without bounds of its own: it searches a box of [−1, 1] in every variable.
    control_points : int
        Of each moving base.
    spread : float
        How far, in each coordinate and in parts of a module's mean length, a control point may go from its first guess.
    amplitude : float
        Largest amplitude A of a sinusoid [rad].
    frequency : float
        Largest frequency f of a sinusoid.
    around : sequence of Path
        First guesses of the k − 1 moving bases, to which Bezier curves are fitted. By default the tool's path drawn
        towards the arm's base by each module's share of the length.
    elbows : {"each", "alike"}
        Which combinations of the modules' elbows are searched, each with the whole budget: each that the problem and
        the limits of the modules' middle joints allow, or of these only those in which all modules have the same.

    Raises
    ------
    InvalidInputError
        If a parameter is out of its range.

    Notes
    -----
    The modules are those of :class:`~selfmotion.planners.modules.Modules`. There are ``2 m (k − 1) + 3k`` variables:
    the m control points of each moving base and ``offset, amplitude, f`` of each module. The offset is measured from
    the direction of the module's target at r = 0, in parts of the arc on which it is in reach. Candidates are ranked by
    their chord sum at 200 places, or at as many as the problem has samples if they are fewer; the cheapest that holds
    everywhere becomes the plan.

    On the paper's 6R case, where the given moving base ends at 15.35 in true joints, there are many local optima.
    ``python benchmarks/moving_base.py`` searches it with a population of 60 and 1000 iterations over 8 seeds.
    Differential evolution does best: it ends between 9.885 and 10.621, median 10.291. Canonical PSO ends between 10.405
    and 10.971 (10.653), CMA-ES between 10.600 and 10.869 (10.642). A run takes 4 to 8 s. In smaller boxes differential
    evolution ends higher: with frequencies up to 2 its median is 10.696 with 6 control points and 10.941 with 4.
    """

    kind = "moving_base"

    def __init__(
        self,
        optimizer: Optimizer,
        control_points: int = 8,
        spread: float = 0.7,
        amplitude: float = float(np.pi),
        frequency: float = 4.0,
        around: Sequence[Path] = (),
        elbows: Literal["each", "alike"] = "each",
    ) -> None:
        super().__init__(optimizer)
        refuse_own_bounds(optimizer, self.kind, "spread, amplitude and frequency")
        if not isinstance(around, list | tuple) or not all(isinstance(path, Path) for path in around):
            raise InvalidInputError("around", "is not a list of paths", "give one path per module but the last")
        self.control_points = integer("control_points", control_points, 2, _MOST_POINTS)
        self.spread = positive("spread", spread)
        self.amplitude = positive("amplitude", amplitude)
        self.frequency = positive("frequency", frequency)
        self.around = tuple(around)
        self.elbows = choice("elbows", elbows, ("each", "alike"))

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`."""
        began = time.perf_counter()
        arm = splittable(problem)
        if arm.n < 6:
            raise InvalidInputError(
                "arm.links", "has 3 entries: no base moves", "use planner: sinusoid, or 6, 9, … links"
            )
        refuse_what_modules_cannot_keep(problem, self.kind)
        self._refuse_coarse_samples(problem)
        combinations = self._combinations(problem, arm)
        optimizer = self.optimizer.with_bounds((-1.0, 1.0))
        results = []
        for i, elbows in enumerate(combinations):
            candidates = self.candidates_for(problem, elbows)
            counted = counting(progress, i * optimizer.iterations, len(combinations) * optimizer.iterations)
            results.append(optimizer.minimize(candidates, candidates.dimension, counted))
        evaluations = sum(result.evaluations for result in results)
        found = self._first_that_holds(problem, combinations, results, evaluations)
        plan = Plan(
            problem, found.motion, self.kind, {}, evaluations, history=tuple(result.history for result in results)
        )
        plan.parameters.update(self._parameters(plan, found, combinations, optimizer))
        plan.wall_time_s = time.perf_counter() - began
        return plan

    def candidates_for(self, problem: Problem, elbows: Sequence[int], places: int | None = None) -> ChainCandidates:
        """Return what judges a population whose modules have these elbows, as the optimizer does or at `places`."""
        arm = splittable(problem)
        return ChainCandidates(
            problem,
            first_guess(problem, self.control_points, self.around),
            self.spread * arm.reach / (arm.n // 3),
            self.amplitude,
            self.frequency,
            elbows,
            places or _places(problem),
        )

    def _refuse_coarse_samples(self, problem: Problem) -> None:
        places, least = _places(problem), int(np.ceil(SAMPLES_PER_CYCLE * self.frequency))
        if places < least:
            name = "samples" if problem.samples < least <= PLACES else "planner.frequency"
            reason = f"does not let {places} samples resolve the fastest sinusoid"
            remedy = f"give at least {least}" if name == "samples" else f"give at most {PLACES // SAMPLES_PER_CYCLE}"
            raise InvalidInputError(name, reason, remedy)

    def _combinations(self, problem: Problem, arm: PlanarArm) -> list[tuple[int, ...]]:
        """Return the branches of the modules, combination by combination."""
        allowed = [allowed_elbows(module) for module in module_arms(arm)]
        allowed[0] = [branch for branch in allowed[0] if branch in problem.elbow_branches]
        every = itertools.product(*allowed)
        chosen = [some for some in every if self.elbows == "each" or len(set(some)) == 1]
        if not chosen:
            raise InvalidInputError(
                "elbow", "leaves some module no elbow that its limits allow", "change elbow or limits"
            )
        if len(chosen) > _MOST_COMBINATIONS:
            reason = f"makes {len(chosen)} combinations to search with the whole budget, over {_MOST_COMBINATIONS}"
            raise InvalidInputError(
                "planner.elbows", reason, "write elbows: alike, or limit the modules' middle joints"
            )
        return chosen

    def _first_that_holds(
        self, problem: Problem, combinations: list[tuple[int, ...]], results: list[Result], evaluations: int
    ) -> _Found:
        """Return the cheapest candidate that holds between the places looked at too."""
        values = np.concatenate([result.values for result in results])
        feasible = int((values < INFEASIBLE).sum())
        if not feasible:
            least = violation_of(float(values.min()))
            raise NothingFeasibleError(
                f"none of {evaluations} candidates is feasible; the best leaves reach or limits by {least:.3g}",
                "give more iterations, another spread, or a guess of the moving base in around",
                evaluations,
                least,
            )
        population = np.concatenate([result.population for result in results])
        owner = np.repeat(np.arange(len(results)), [result.evaluations for result in results])
        close = [self.candidates_for(problem, elbows, 4 * problem.samples) for elbows in combinations]
        checks = 0
        for j in np.argsort(values, kind="stable")[: min(feasible, _MOST_LOOKS)]:
            candidates = close[owner[j]]
            if candidates(population[j : j + 1])[0] >= INFEASIBLE:
                continue
            found = _moved(problem, candidates, population[j])
            if verify_motion(problem, found.motion).holds:
                return found
            checks += 1
            if checks == MOST_CHECKS:
                break
        raise NothingFeasibleError(
            f"{feasible} of {evaluations} candidates hold at {_places(problem)} places, but the best of "
            "them break between them",
            "give another seed or more iterations",
            evaluations,
            0.0,
        )

    def _parameters(
        self, plan: Plan, found: _Found, combinations: list[tuple[int, ...]], optimizer: Optimizer
    ) -> dict[str, Any]:
        names = plan.problem.arm.branches
        chosen = found.chosen
        modules = [
            {
                "f": float(chosen.frequency[0, i]),
                "offset": float(chosen.offset[0, i]),
                "amplitude": float(chosen.amplitude[0, i]),
                "elbow": names[motion.branch],
                **module_costs(plan, Plan(module, motion, self.kind, {}), i),
            }
            for i, (module, motion) in enumerate(zip(found.chain.modules, found.motions, strict=True))
        ]
        return {
            **{f"f{i + 1}": module["f"] for i, module in enumerate(modules)},
            "elbow": modules[0]["elbow"],
            "moving_bases": [{"kind": Bezier.kind, "control_points": points.tolist()} for points in chosen.points[0]],
            "modules": modules,
            "control_points": self.control_points,
            "spread": self.spread,
            "largest_amplitude": self.amplitude,
            "largest_frequency": self.frequency,
            "elbows_searched": [[names[branch] for branch in elbows] for elbows in combinations],
            "optimizer": {"kind": optimizer.kind, **optimizer.settings()},
        }


def _places(problem: Problem) -> int:
    """Return at how many places the search looks."""
    return min(problem.samples, PLACES)


@dataclass(frozen=True, eq=False)
class Wave:
    """(22) as a callable of (r, order); unlike in a profile, whose frequency is searched, the amplitude may be zero.

    Attributes
    ----------
    offset, amplitude, frequency : array, shape (n_u,)
    """

    offset: FloatArray
    amplitude: FloatArray
    frequency: FloatArray

    def __call__(self, r: FloatArray, order: int) -> FloatArray:
        """Return u or du/dr, shape (k, n_u)."""
        rate = TAU * self.frequency
        phase = rate * r[:, None]
        if order == 0:
            return np.asarray(self.offset + self.amplitude * np.sin(phase))
        return np.asarray(self.amplitude * rate * np.cos(phase))


class _Found(NamedTuple):
    """A candidate and its motion."""

    chosen: Choice
    chain: Chain
    motions: list[Motion]
    motion: Motion


def _moved(problem: Problem, candidates: ChainCandidates, a: FloatArray) -> _Found:
    """Return the motion of one candidate."""
    chosen = candidates.choice(a[None])
    chain = Chain(problem, [Bezier(points) for points in chosen.points[0]])
    motions = []
    for i, module in enumerate(chain.modules):
        amplitude, frequency = chosen.amplitude[0, i : i + 1], chosen.frequency[0, i : i + 1]
        curve = Wave(chosen.offset[0, i : i + 1], amplitude, frequency)
        motions.append(Motion(module.arm, module.path, curve, candidates.elbows[i], 2 * problem.samples))
    return _Found(chosen, chain, motions, chain.motion(motions))
