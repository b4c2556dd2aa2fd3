"""The results on the 6R arm, each computed when it is first asked for."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from selfmotion.domain import AngleDomain, angle_domain
from selfmotion.optimizers import Progress
from selfmotion.paths import Bezier
from selfmotion.planners import Plan
from selfmotion.problem import Problem
from selfmotion.report import seed_6r


class Study6R:
    """The paper's 6R study, but for the many seeds.

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
        """The arm on the clothoid."""
        return seed_6r.problem()

    @cached_property
    def base(self) -> Bezier:
        """The curve on which the second module's base moves."""
        return seed_6r.moving_base()

    @cached_property
    def domains(self) -> tuple[AngleDomain, ...]:
        """Every feasible posture of each module along its path."""
        return tuple(angle_domain(module.arm, module.path) for module in seed_6r.modules())

    @cached_property
    def absolute(self) -> dict[str, Plan]:
        """The single runs (Table III) by optimizer, the fourth joint absolute: plans of the whole arm."""
        return seed_6r.plans("absolute", self._seed, self._progress)

    @cached_property
    def true(self) -> dict[str, Plan]:
        """The same searched with the true fourth joint."""
        return seed_6r.plans("true", self._seed, self._progress)

    @property
    def plans(self) -> dict[str, dict[str, Plan]]:
        """Both, by how the fourth joint counts."""
        return {"absolute": self.absolute, "true": self.true}

    @cached_property
    def best(self) -> str:
        """Label of the plan with the least F of both modules together, the fourth joint absolute."""
        return min(self.absolute, key=lambda label: modules_sum(self.absolute[label], "absolute"))

    @property
    def plan(self) -> Plan:
        """That plan."""
        return self.absolute[self.best]

    @cached_property
    def whole_arm(self) -> seed_6r.WholeArm:
        """Motions without given modules, one of them from the best plan's start posture."""
        return seed_6r.whole_arm(self.plan(np.zeros(1))[0], self._seed, self._progress)


def modules_sum(plan: Plan, reading: str, kind: str = "cost_sampled") -> float:
    """Return F of all modules of a plan together.

    Parameters
    ----------
    plan : Plan
    reading : {"absolute", "true"}
        How the fourth joint counts.
    kind : {"cost_sampled", "cost"}
        As chord sums or as integrals.
    """
    return float(sum(module[kind][reading] for module in plan.parameters["modules"]))
