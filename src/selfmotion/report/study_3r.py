"""The results on the 3R arm, each computed when it is first asked for."""

from __future__ import annotations

from functools import cached_property

from selfmotion.domain import AngleDomain, angle_domain
from selfmotion.exchange import Trajectory
from selfmotion.mending import Repair, repair
from selfmotion.optimizers import Progress
from selfmotion.planners import Plan
from selfmotion.problem import Problem
from selfmotion.report import seed_3r


class Study3R:
    """The paper's 3R study, but for the many seeds.

    Parameters
    ----------
    seed : int
        Of every search.
    progress : callable, optional
    """

    def __init__(self, seed: int, progress: Progress | None = None) -> None:
        self._seed = seed
        self._progress = progress

    @cached_property
    def problem(self) -> Problem:
        """The arm on its path."""
        return seed_3r.problem()

    @cached_property
    def domain(self) -> AngleDomain:
        """Every feasible posture along the path."""
        return angle_domain(self.problem.arm, self.problem.path)

    @cached_property
    def free(self) -> Problem:
        """The arm without limits on the path."""
        return seed_3r.free_problem()

    @cached_property
    def improper(self) -> Trajectory:
        """Postures of the arm without limits, some of them with the other elbow."""
        return seed_3r.improper_motion(self.free)

    @cached_property
    def repaired(self) -> Repair:
        """The same motion made continuous by self-motion."""
        return repair(self.free, *self.improper)

    @cached_property
    def limited(self) -> AngleDomain:
        """Every feasible posture of the arm with limits of our own."""
        case = seed_3r.limited_problem()
        return angle_domain(case.arm, case.path)

    @cached_property
    def plans(self) -> dict[str, Plan]:
        """The single run of each optimizer (Table II), by label."""
        return seed_3r.plans(self._seed, self._progress)

    @cached_property
    def best(self) -> str:
        """Label of the plan with the least F."""
        return min(self.plans, key=lambda label: self.plans[label].cost_sampled)
