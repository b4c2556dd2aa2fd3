"""A search of the paper: the frequency of one sinusoid, by every optimizer at one budget, and what is printed of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers import GA, GWO, PSO, Optimizer, Progress, RandomSearch
from selfmotion.planners import Plan, PlanarCandidates, Planner
from selfmotion.problem import Problem

BOUNDS = (0.0, 15.0)
POPULATION, ITERATIONS, SAMPLES = 20, 100, 1000
PAPER = ("GA", "PSO", "GWO")
"""The optimizers of the paper, its PSO undamped as its constants make it."""
IN_TABLE = (*PAPER, "PSO canonical")
"""The paper's three, and the PSO that converges."""
COMPARED = (*IN_TABLE, "random search")
RIVALS = ("GA", "GWO")
"""What the paper's PSO is said to do better than."""


@dataclass(frozen=True)
class Printed:
    """What a line of the paper's Tables II and III says of one search."""

    fitness: float
    f: float


@dataclass(frozen=True)
class DenseScan:
    """The least F on a fine grid of frequencies, the yardstick of the optimizers."""

    f: float
    fitness: float
    evaluations: int


class Case:
    """One search of the paper.

    Parameters
    ----------
    name : str
    printed : mapping
        Optimizer to what the paper prints.
    candidates : callable
        Makes what judges frequencies.
    """

    def __init__(self, name: str, printed: Mapping[str, Printed], candidates: Callable[[], PlanarCandidates]) -> None:
        self.name = name
        self.printed = printed
        self.candidates = candidates

    @cached_property
    def _plain(self) -> PlanarCandidates:
        return self.candidates()

    def fitness(self, f: FloatArray | float) -> FloatArray:
        """Return the paper's F, the chord sum over its samples, at frequencies `f`, shape (p,); see `Candidates`."""
        return self._plain(np.atleast_1d(np.asarray(f, dtype=float))[:, None])

    def dense_scan(self, points: int = 3001) -> DenseScan:
        """Scan F over the bounds and zoom in on the least value until the grid is finer than 1e-10."""
        low, high = BOUNDS
        f, value, evaluations = low, np.inf, 0
        while high - low > 1e-10:
            grid = np.linspace(low, high, points)
            values = self.fitness(grid)
            k = int(np.argmin(values))
            f, value, evaluations = float(grid[k]), float(values[k]), evaluations + points
            low, high = grid[max(k - 1, 0)], grid[min(k + 1, points - 1)]
            points = 101
        return DenseScan(f, value, evaluations)


def optimizers(seed: int) -> dict[str, Optimizer]:
    """Return the optimizers of `COMPARED`, by label, at equal budgets."""
    budget = {"population": POPULATION, "iterations": ITERATIONS, "bounds": BOUNDS, "seed": seed}
    return {
        "GA": GA(**budget),  # type: ignore[arg-type]
        "PSO": PSO(**budget, variant="seed"),  # type: ignore[arg-type]
        "GWO": GWO(**budget),  # type: ignore[arg-type]
        "PSO canonical": PSO(**budget, variant="canonical"),  # type: ignore[arg-type]
        "random search": RandomSearch(**budget),  # type: ignore[arg-type]
    }


def single_runs(
    problem: Problem, planner: Callable[[Optimizer], Planner], seed: int, progress: Progress | None = None
) -> dict[str, Plan]:
    """Return the single run of each optimizer of `IN_TABLE`, as the paper makes it, as a checked plan."""
    found = {}
    for k, label in enumerate(IN_TABLE):

        def report(done: int, total: int, best: float, before: int = k) -> None:
            if progress is not None:
                progress(before * total + done, len(IN_TABLE) * total, best)

        found[label] = planner(optimizers(seed)[label]).plan(problem, report)
    return found
