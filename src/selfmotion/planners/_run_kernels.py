"""Whole runs of a swarm on the candidates of a planner, without the interpreter: threads run them side by side."""

from __future__ import annotations

from selfmotion._compiled import kernel
from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms._motion_kernels import blank_sheet
from selfmotion.optimizers._kernels import Flock, learn, move, threshold
from selfmotion.planners._candidate_kernels import Search, judge


@kernel
def run(
    flock: Flock, draws: FloatArray, t: int, search: Search, out: FloatArray, values: FloatArray, exact: BoolArray
) -> None:
    """Run len(draws) generations from generation t on, changing the flock in place.

    Fills `out` (g, p, d), `values` (g, p) and `exact` (g, p): the candidates, their values, and whether these are more
    than lower bounds.
    """
    sheet = blank_sheet(search.family.joints.shape[1])
    for g in range(len(draws)):
        for i in range(len(flock.x)):
            candidate = out[g, i]
            for j in range(len(candidate)):
                candidate[j] = flock.x[i, j]
            value, known = judge(search, candidate, threshold(flock, i), sheet)
            learn(flock, i, value)
            values[g, i], exact[g, i] = value, known
        move(flock, draws[g], t + g)


@kernel
def judge_all(
    population: FloatArray, thresholds: FloatArray, search: Search, values: FloatArray, exact: BoolArray
) -> None:
    """Judge a population (p, d), filling `values` and `exact` (p,)."""
    sheet = blank_sheet(search.family.joints.shape[1])
    for i in range(len(population)):
        values[i], exact[i] = judge(search, population[i], thresholds[i], sheet)
