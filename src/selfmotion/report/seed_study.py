"""The seed's study of the 3R arm (section VI-A): its data, its printed results, and the same computed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from selfmotion.arms import PlanarArm
from selfmotion.optimizers import GA, GWO, PSO, Optimizer, Progress
from selfmotion.paths import Bezier
from selfmotion.planners import Candidates, Plan, Sinusoid
from selfmotion.problem import Problem
from selfmotion.profiles import SinusoidProfile

OFFSET, AMPLITUDE, BOUNDS = 0.3, 0.4, (0.0, 15.0)
POPULATION, ITERATIONS, SAMPLES = 20, 100, 1000


@dataclass(frozen=True)
class Printed:
    """A line of the seed's Table II."""

    fitness: float
    f: float


PRINTED = {
    "GA": Printed(4.8486, 0.5562),
    "PSO": Printed(4.84829399, 0.5329),
    "GWO": Printed(4.84829414, 0.5330),
}


def problem() -> Problem:
    """Return the 3R arm of Table I, limits (27), on its fifth-degree Bezier path."""
    arm = PlanarArm([30, 30, 20], [None, (0.0, np.pi), None])
    path = Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
    return Problem(arm, path, samples=SAMPLES)


def optimizers(seed: int) -> dict[str, Optimizer]:
    """Return the optimizers compared, by label: the seed's three, and the PSO that converges."""
    budget = {"population": POPULATION, "iterations": ITERATIONS, "bounds": BOUNDS, "seed": seed}
    return {
        "GA": GA(**budget),  # type: ignore[arg-type]
        "PSO": PSO(**budget, variant="seed"),  # type: ignore[arg-type]
        "GWO": GWO(**budget),  # type: ignore[arg-type]
        "PSO canonical": PSO(**budget, variant="canonical"),  # type: ignore[arg-type]
    }


def run(seed: int, progress: Progress | None = None) -> dict[str, Plan]:
    """Return each optimizer's plan for the seed's problem."""
    case = problem()
    plans = {}
    for label, optimizer in optimizers(seed).items():
        planner = Sinusoid([OFFSET], amplitude=[AMPLITUDE], optimizer=optimizer)
        plans[label] = planner.plan(case, progress)
    return plans


def fitness(f: np.ndarray | float) -> np.ndarray:
    """Return the seed's F, the chord sum over 1000 samples, at frequencies `f`; see `Candidates`."""
    profile = SinusoidProfile([OFFSET], [AMPLITUDE])
    return Candidates(problem(), profile, branch=0)(np.atleast_1d(np.asarray(f, dtype=float))[:, None])


@dataclass(frozen=True)
class DenseScan:
    """The least F on a fine grid of frequencies, the yardstick of the optimizers."""

    f: float
    fitness: float
    evaluations: int


def dense_scan(points: int = 3001) -> DenseScan:
    """Scan F over the bounds and zoom in on the least value until the grid is finer than 1e-10."""
    low, high = BOUNDS
    f, value, evaluations = low, np.inf, 0
    while high - low > 1e-10:
        grid = np.linspace(low, high, points)
        values = fitness(grid)
        k = int(np.argmin(values))
        f, value, evaluations = float(grid[k]), float(values[k]), evaluations + points
        low, high = grid[max(k - 1, 0)], grid[min(k + 1, points - 1)]
        points = 101
    return DenseScan(f, value, evaluations)
