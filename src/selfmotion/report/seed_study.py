"""The paper's study of the 3R arm (section VI-A): its data, its printed results, and the same computed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import PlanarArm
from selfmotion.exchange import Trajectory
from selfmotion.optimizers import GA, GWO, PSO, Optimizer, Progress, RandomSearch
from selfmotion.paths import Bezier
from selfmotion.planners import Candidates, Plan, Sinusoid
from selfmotion.problem import Problem
from selfmotion.profiles import SinusoidProfile

OFFSET, AMPLITUDE, BOUNDS = 0.3, 0.4, (0.0, 15.0)
POPULATION, ITERATIONS, SAMPLES = 20, 100, 1000


@dataclass(frozen=True)
class Printed:
    """A line of the paper's Table II."""

    fitness: float
    f: float


PRINTED = {
    "GA": Printed(4.8486, 0.5562),
    "PSO": Printed(4.84829399, 0.5329),
    "GWO": Printed(4.84829414, 0.5330),
}
"""Table II, by optimizer."""
IN_TABLE = (*PRINTED, "PSO canonical")
"""The paper's three, its PSO undamped as its constants make it, and the PSO that converges."""
COMPARED = (*IN_TABLE, "random search")
RIVALS = ("GA", "GWO")
"""What the paper's PSO is said to do better than."""

MISPRINTS = (
    ("(2)", "l₁ cos θg", "l₃, the last link"),
    ("(5)(6)", "c₂₁, s₂₁", "c₂, s₂"),
    ("(8)(19)", "θg = θ1 − θ2 − θ3", "θ1 + θ2 + θ3, as (7) says"),
    ("(13)", "θ3 = ±(2π − Δ3)", "±(π − Δ3)"),
    ("(23)", "χ = 2/(2 − φ − √…), negative for φ > 4", "its absolute value"),
    ("(24)", "|X − A·D|", "no absolute value; D has it"),
    ("(25)", "A = 2A·r1 − a", "A = 2a·r1 − a"),
    ("(26)", "D = C·X − X", "|C·X_leader − X|"),
)
"""Where the paper prints one thing and must mean another: equation, printed, meant."""


def arm() -> PlanarArm:
    """Return the 3R arm with its limits (27)."""
    return PlanarArm([30, 30, 20], [None, (0.0, np.pi), None])


def problem() -> Problem:
    """Return the arm on the fifth-degree Bezier path of Table I."""
    path = Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
    return Problem(arm(), path, samples=SAMPLES)


def free_problem() -> Problem:
    """Return the arm without limits on the same path, as sections II and IV look at it."""
    return Problem(PlanarArm(arm().links), problem().path, samples=SAMPLES)


def improper_motion(case: Problem) -> Trajectory:
    """Return postures along the path, the sinusoid at the printed frequency, a tenth of them with the other elbow."""
    r = np.linspace(0.0, 1.0, 121)
    u = SinusoidProfile([OFFSET], [AMPLITUDE])([PRINTED["PSO"].f], r)
    wrong = (r > 0.45) & (r < 0.55)
    positive, negative = (case.arm.solve(case.path(r), u, branch)[0] for branch in (0, 1))
    return Trajectory(r, np.where(wrong[:, None], negative, positive))


def limited_problem() -> Problem:
    """Return the arm with limits of our own on the same path: few, and enough for most kinds of events."""
    return Problem(PlanarArm(arm().links, [(-0.5, 0.8), (-1.0, 2.0), (-2.0, 0.9)]), problem().path, samples=SAMPLES)


def optimizers(seed: int, bounds: tuple[float, float] = BOUNDS) -> dict[str, Optimizer]:
    """Return the optimizers of `COMPARED`, by label, at equal budgets."""
    budget = {"population": POPULATION, "iterations": ITERATIONS, "bounds": bounds, "seed": seed}
    return {
        "GA": GA(**budget),  # type: ignore[arg-type]
        "PSO": PSO(**budget, variant="seed"),  # type: ignore[arg-type]
        "GWO": GWO(**budget),  # type: ignore[arg-type]
        "PSO canonical": PSO(**budget, variant="canonical"),  # type: ignore[arg-type]
        "random search": RandomSearch(**budget),  # type: ignore[arg-type]
    }


def plans(seed: int, progress: Progress | None = None) -> dict[str, Plan]:
    """Return the single run of each optimizer of `IN_TABLE`, as the paper makes it, as a checked plan."""
    case, found = problem(), {}
    for k, label in enumerate(IN_TABLE):

        def report(done: int, total: int, best: float, before: int = k) -> None:
            if progress is not None:
                progress(before * total + done, len(IN_TABLE) * total, best)

        planner = Sinusoid([OFFSET], amplitude=[AMPLITUDE], optimizer=optimizers(seed)[label])
        found[label] = planner.plan(case, report)
    return found


@cache
def _candidates() -> Candidates:
    return Candidates(problem(), SinusoidProfile([OFFSET], [AMPLITUDE]), branch=0)


def fitness(f: FloatArray | float) -> FloatArray:
    """Return the paper's F, the chord sum over its samples, at frequencies `f`, shape (p,); see `Candidates`."""
    return _candidates()(np.atleast_1d(np.asarray(f, dtype=float))[:, None])


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
