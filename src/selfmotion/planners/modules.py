"""The seed's planner for many links: modules of three on given moving bases, planned one after the other (VI-B)."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from selfmotion._checks import angles, choice
from selfmotion._types import Vector
from selfmotion.errors import InvalidInputError, NothingFeasibleError
from selfmotion.motion import Motion
from selfmotion.optimizers import Optimizer, Progress, counting
from selfmotion.paths import Path
from selfmotion.planners.base import SearchingPlanner
from selfmotion.planners.candidates import RANKINGS, Candidates, Carrier, Ranking, candidates_of
from selfmotion.planners.chain import Chain, refuse_what_modules_cannot_keep
from selfmotion.planners.parametric import Sinusoid
from selfmotion.plans import Plan
from selfmotion.problem import Problem
from selfmotion.profiles import Profile
from selfmotion.verification import verify_motion


class _Module(Sinusoid):
    """Plans the next module of a chain, judged with its true joints and with the modules before it."""

    def __init__(
        self,
        offset: float,
        amplitude: float,
        optimizer: Optimizer,
        chain: Chain,
        before: list[Motion],
        branches: list[int],
        absolute: bool,
        ranking: Ranking,
    ) -> None:
        super().__init__([offset], amplitude=[amplitude], optimizer=optimizer, ranking=ranking)
        self._chain = chain
        self._before = before
        self._branches = branches
        self._absolute = absolute

    def candidates_for(self, problem: Problem, profile: Profile, branch: int) -> Candidates:
        """Return what judges a population on one branch."""
        if not self._before:
            return super().candidates_for(problem, profile, branch)
        before, limits = self._before[-1], self._chain.limits[len(self._before)]
        carrier = Carrier(limits, lambda r, order: before.u(r, order)[:, 0], self._absolute)
        return candidates_of(problem, profile, branch, self.ranking, carrier)

    def starting_branches(self, problem: Problem, profile: Profile) -> list[int]:
        """Return those on which the module may start with the limits of its true first joint."""
        return self._branches

    def holds(self, problem: Problem, motion: Motion) -> bool:
        """Return whether the arm up to and with this module moves as it may."""
        together = [*self._before, motion]
        part = self._chain.first(len(together))
        return verify_motion(part, self._chain.motion(together)).holds


class Modules(SearchingPlanner):
    """The seed's moving base for a planar arm of 3k links: a sinusoid in each module of three.

    Parameters
    ----------
    moving_bases : sequence of Path
        k − 1 paths at the same r as the tool's: of the end of module 1, 2, …, k − 1, where the next one begins.
    offset : array_like, shape (k,)
        Absolute direction of each module's last link at r = 0, θ_gi [rad].
    amplitude : array_like, shape (k,)
        A of each module [rad], none zero.
    optimizer : Optimizer
        Searches the frequency of one module after the other.
    first_joints : {"relative", "absolute"}
        How the first joint of modules 2, 3, … counts in the cost of a module: as the true joint, or as an absolute
        angle, as in the paper's Fig. 17.
    ranking : {"integral", "samples"}
        What candidates are ranked by, the integral or the seed's chord sum over the problem's samples.

    Raises
    ------
    InvalidInputError
        If offset and amplitude differ in length, or an amplitude is zero.

    Notes
    -----
    The end of module i keeps to ``b_i(r)``, so that each module is a 3R arm that follows ``b_i(r) − b_{i−1}(r)`` in a
    frame with axes parallel to the world's (section IV-A, Figs. 13 and 14), and (22) gives the direction of its last
    link, ``u_i(r) = offset_i + amplitude_i sin(2π f_i r)``. Modules are planned in order, so the direction of the
    link that carries a module is known when its turn comes: the true first joint is the direction of its first link
    less ``u_{i−1}(r)``. Limits of that joint are limits of the true one in both readings.

    Module 1 has the elbow that the problem asks for. Later modules are searched on both elbows that their offset may
    start on, each with the whole budget. Module 1 searches with the optimizer's seed s, module i with the first word
    that ``numpy.random.SeedSequence([s, i − 1])`` generates.

    The answer is a motion of the whole arm in true joints. The next module builds on a module's best candidate that,
    together with the modules before it, holds between the samples too.
    """

    kind = "modules"

    def __init__(
        self,
        moving_bases: Sequence[Path],
        offset: Vector,
        amplitude: Vector,
        optimizer: Optimizer,
        first_joints: Literal["relative", "absolute"] = "relative",
        ranking: Ranking = "integral",
    ) -> None:
        if not isinstance(moving_bases, list | tuple) or not all(isinstance(base, Path) for base in moving_bases):
            raise InvalidInputError("moving_bases", "is not a list of paths", "give one path per module but the last")
        super().__init__(optimizer)
        self.moving_bases = tuple(moving_bases)
        self.offset = angles("offset", offset)
        self.amplitude = angles("amplitude", amplitude, len(self.offset))
        if not self.amplitude.all():
            module = int(np.argmin(np.abs(self.amplitude))) + 1
            reason = f"is zero for module {module}: no frequency changes its curve"
            raise InvalidInputError("amplitude", reason, "give one that is not", amplitude)
        self.first_joints = choice("first_joints", first_joints, ("relative", "absolute"))
        self.ranking: Ranking = choice("ranking", ranking, RANKINGS)  # type: ignore[assignment]

    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion; see :meth:`Planner.plan`.

        Raises
        ------
        InvalidInputError
            If the arm has another number of links than 3k, something is not given once per module, an offset is outside
            the angle domain, a moving base leaves what the modules before and after it can reach, the weights of a
            module are all zero, or the problem has a start, an end or a cyclic motion, which this planner cannot keep.
        InfeasibleError
            If the whole arm cannot follow the path.
        NothingFeasibleError
            If in some module no candidate is feasible.
        """
        began = time.perf_counter()
        chain = Chain(problem, self.moving_bases)
        if len(self.offset) != chain.count:
            reason = f"has {len(self.offset)} entries for {chain.count} modules of three links"
            raise InvalidInputError("planner.offset", reason, "give offset and amplitude once per module")
        refuse_what_modules_cannot_keep(problem, self.kind)
        chain.refuse_blocked()
        branches = chain.starting_branches(self.offset)
        searches = [len(some) for some in branches]
        plans: list[Plan] = []
        motions: list[Motion] = []
        for i, module in enumerate(chain.modules):
            done, total = self.optimizer.iterations * np.cumsum([0, *searches])[[i, -1]]
            alone = self._plan_next(chain, module, motions, branches[i], counting(progress, int(done), int(total)))
            assert isinstance(alone.motion, Motion)
            plans.append(alone)
            motions.append(alone.motion)
        plan = Plan(
            problem,
            chain.motion(motions),
            self.kind,
            {},
            sum(module.evaluations for module in plans),
            history=tuple(history for module in plans for history in module.history),
        )
        plan.parameters.update(self._parameters(plan, plans, branches))
        plan.wall_time_s = time.perf_counter() - began
        return plan

    def _plan_next(
        self, chain: Chain, module: Problem, before: list[Motion], branches: list[int], progress: Progress | None
    ) -> Plan:
        i = len(before)
        optimizer = self.optimizer if i == 0 else self.optimizer.with_seed(_derived(self.optimizer.seed, i))
        planner = _Module(
            float(self.offset[i]),
            float(self.amplitude[i]),
            optimizer,
            chain,
            list(before),
            branches,
            self.first_joints == "absolute",
            self.ranking,
        )
        try:
            return planner.plan(module, progress)
        except NothingFeasibleError as error:
            raise NothingFeasibleError(
                f"module {i + 1}: {error.message}", error.remedy, error.evaluations, error.least_violation
            ) from None

    def _parameters(self, plan: Plan, plans: list[Plan], branches: list[list[int]]) -> dict[str, Any]:
        """Return what was chosen, and what each module costs in both readings."""
        names = plan.problem.arm.branches
        modules = [
            {
                "f": module.parameters["f"],
                "offset": float(self.offset[i]),
                "amplitude": float(self.amplitude[i]),
                "elbow": module.parameters["elbow"],
                "elbows_searched": [names[branch] for branch in branches[i]],
                "seed": module.parameters["optimizer"]["seed"],
                **module_costs(plan, module, i),
            }
            for i, module in enumerate(plans)
        ]
        return {
            **{f"f{i + 1}": module["f"] for i, module in enumerate(modules)},
            "elbow": modules[0]["elbow"],
            "modules": modules,
            "first_joints": self.first_joints,
            "optimizer": {"kind": self.optimizer.kind, **self.optimizer.settings()},
        }


def module_costs(plan: Plan, alone: Plan, i: int) -> dict[str, dict[str, float]]:
    """Return a module's share of a plan's cost, as chord sum and as integral, in both readings of its first joint.

    Parameters
    ----------
    plan : Plan
        Of the whole arm.
    alone : Plan
        Of the module in its own frame, its first joint absolute.
    i : int
        The module, counted from 0.
    """
    grid, weights = plan.problem.grid, np.zeros(plan.problem.arm.n)
    weights[3 * i : 3 * i + 3] = alone.problem.weights
    objective = plan.problem.objective
    edges = plan.problem.path.grid(max(64, plan.problem.samples // 4))
    return {
        "cost_sampled": {
            "absolute": alone.cost_sampled,
            "true": float(objective.sampled(plan(grid), grid, weights)),
        },
        "cost": {
            "absolute": alone.cost,
            "true": objective.integral(plan.rates, np.union1d(edges, alone.problem.path.breaks), weights).value,
        },
    }


def _derived(seed: int, i: int) -> int:
    """Return the seed of module i > 0."""
    return int(np.random.SeedSequence([seed, i]).generate_state(1)[0])
