"""What every planner is."""

from __future__ import annotations

import copy
from abc import ABC, abstractmethod
from typing import ClassVar, Self

from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import Optimizer, Progress
from selfmotion.plans import Plan
from selfmotion.problem import Problem


class Planner(ABC):
    """Turns a problem into a plan."""

    kind: ClassVar[str]

    @abstractmethod
    def plan(self, problem: Problem, progress: Progress | None = None) -> Plan:
        """Plan a motion.

        Parameters
        ----------
        problem : Problem
        progress : callable, optional
            Called with (done, total, best cost so far) as the work goes on.

        Returns
        -------
        Plan
            Verified: its ``verification`` holds.

        Raises
        ------
        InvalidInputError
            If the problem asks for what this planner cannot do.
        InfeasibleError
            If the path is proved to be blocked.
        NothingFeasibleError
            If no feasible motion was found; this proves nothing.
        """

    def with_seed(self, seed: int) -> Self:
        """Return the same planner with another random seed; itself if it uses none."""
        return self


class SearchingPlanner(Planner):
    """A planner whose choices an optimizer makes.

    Parameters
    ----------
    optimizer : Optimizer

    Raises
    ------
    InvalidInputError
        If it is none.
    """

    def __init__(self, optimizer: Optimizer) -> None:
        if not isinstance(optimizer, Optimizer):
            raise InvalidInputError("optimizer", "is not an optimizer", "give one, such as PSO(…)", optimizer)
        self.optimizer = optimizer

    def with_seed(self, seed: int) -> Self:
        """Return the same planner with another random seed."""
        other = copy.copy(self)
        other.optimizer = self.optimizer.with_seed(seed)
        return other


def refuse_own_bounds(optimizer: Optimizer, kind: str, instead: str) -> None:
    """Refuse an optimizer with bounds of its own for a planner `kind` whose box follows from its fields `instead`."""
    if optimizer.has_own_bounds:
        raise InvalidInputError(
            "optimizer.bounds",
            f"is of no use to planner {kind}, whose box is given by {instead}",
            "leave it out",
            optimizer.bounds.tolist(),
        )
