"""Whole runs of a swarm on the candidates of a planner, without the interpreter: threads run them side by side."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion.arms._motion_kernels import blank_sheet
from selfmotion.optimizers._kernels import move, threshold
from selfmotion.planners._candidate_kernels import judge


@kernel
def _sheet_for(family, samples, panels):  # type: ignore[no-untyped-def]
    """Return a sheet for as many places as are looked at together."""
    most = max(samples.shape[1], 3 * len(panels.half) * len(panels.weights))
    return blank_sheet(family.joints.shape[1], most)


@kernel
def run(
    code, x, v, remembered, remembered_values, draws, t, constants, lower, upper,
    family, samples, few, number, nodes, panels, accuracy, out, values, exact,
):  # type: ignore[no-untyped-def]  # fmt: skip
    """Run len(draws) generations from generation t on, changing the swarm in place.

    Fills `out` (g, p, d), `values` (g, p) and `exact` (g, p): the candidates, their values, and whether these are more
    than lower bounds.
    """
    sheet = _sheet_for(family, samples, panels)
    for g in range(len(draws)):
        for i in range(len(x)):
            for j in range(x.shape[1]):
                out[g, i, j] = x[i, j]
            bar = threshold(code, i, remembered_values)
            values[g, i], exact[g, i] = judge(
                family, x[i], samples, few, number, nodes, panels, accuracy, bar, sheet
            )
        move(code, x, v, remembered, remembered_values, values[g], draws[g], t + g, constants, lower, upper)


@kernel
def judge_all(population, thresholds, family, samples, few, number, nodes, panels, accuracy, values, exact):  # type: ignore[no-untyped-def]
    """Judge a population (p, d), filling `values` and `exact` (p,)."""
    sheet = _sheet_for(family, samples, panels)
    for i in range(len(population)):
        values[i], exact[i] = judge(
            family, population[i], samples, few, number, nodes, panels, accuracy, thresholds[i], sheet
        )
