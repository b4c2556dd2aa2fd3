"""The numbers of one case: a line of the paper's table, and how the optimizers end over many seeds."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from selfmotion.plot.evolution import FLOOR
from selfmotion.report import cases, seed_runs
from selfmotion.report.case_study import CaseStudy


def line(
    case: cases.Case,
    scan: cases.DenseScan,
    label: str,
    f: float,
    fitness: float,
    at_printed: cases.Case | None = None,
) -> dict[str, Any]:
    """Return a line of a table: printed, at the printed frequency, computed.

    Parameters
    ----------
    case : Case
    scan : DenseScan
        Its yardstick.
    label : str
        The optimizer.
    f, fitness : float
        What its single run found.
    at_printed : Case, optional
        What judges the printed frequency, if not `case`.
    """
    printed = case.printed.get(label)
    at_printed = at_printed or case
    return {
        "printed": None if printed is None else asdict(printed),
        "computed_at_printed_f": None if printed is None else float(at_printed.fitness(printed.f)[0]),
        "f": f,
        "fitness": fitness,
        "excess": fitness - scan.fitness,
    }


def comparison(study: CaseStudy) -> dict[str, Any]:
    """Return the yardstick of a case, how the optimizers end, and whom the paper's PSO beats with how many seeds."""
    plain = study.runs["plain"]
    return {
        "scan": asdict(study.scan),
        "comparison": {
            copy: {label: _statistics(runs, study.scan) for label, runs in rows.items()}
            for copy, rows in study.runs.items()
        },
        "lower_than": {
            other: int(np.sum(plain["PSO"].fitness < plain[other].fitness - FLOOR)) for other in cases.RIVALS
        },
    }


def _statistics(runs: seed_runs.Runs, scan: cases.DenseScan) -> dict[str, Any]:
    """Return how the runs of one optimizer end, measured from the dense-scan optimum."""
    excess = runs.fitness - scan.fitness
    best, lower, median, upper, worst = np.percentile(excess, [0, 25, 50, 75, 100]).tolist()
    return {
        "best": best,
        "lower_quartile": lower,
        "median": median,
        "upper_quartile": upper,
        "worst": worst,
        "found": int(np.sum(np.abs(excess) <= seed_runs.TOLERANCE)),
        "median_f_error": float(np.median(np.abs(runs.f - scan.f))),
        "f": runs.f.tolist(),
        "fitness": runs.fitness.tolist(),
    }
