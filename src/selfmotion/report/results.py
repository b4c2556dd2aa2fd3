"""Every number of the report, as one plain object: what is not computed here is not in the report."""

from __future__ import annotations

import os
import platform
from importlib.metadata import version
from typing import Any

from selfmotion._version import __version__
from selfmotion.report import cases, seed_runs
from selfmotion.report.results_3r import case_of_3r, results_of_3r
from selfmotion.report.results_6r import cases_of_6r, results_of_6r
from selfmotion.report.results_shortest import results_of_shortest
from selfmotion.report.study import Study

PACKAGES = ("selfmotion", "numpy", "scipy", "matplotlib")
"""Whose versions decide the last bits of the numbers and the look of the figures."""


def results_of(study: Study) -> dict[str, Any]:
    """Run the study and return its results, made of what JSON knows.

    Wall times and the command are not among them: they belong to a run, not to the study.
    """
    return {
        "seed": study.seed,
        "seeds": study.seeds,
        **results_of_3r(study),
        "low": cases.BOUNDS[0],
        "high": cases.BOUNDS[1],
        "population": cases.POPULATION,
        "iterations": cases.ITERATIONS,
        "samples": cases.SAMPLES,
        "shift": seed_runs.SHIFT,
        "tolerance": seed_runs.TOLERANCE,
        "cases": {**case_of_3r(study), **cases_of_6r(study)},
        "evaluations": max(
            int(runs.evaluations.max())
            for case in study.cases.values()
            for rows in case.runs.values()
            for runs in rows.values()
        ),
        "six": results_of_6r(study),
        "shortest": results_of_shortest(study),
        "machine": {
            "processor": platform.machine(),
            "cpus": os.cpu_count(),
            "system": platform.system(),
            "python": platform.python_version(),
        },
        "versions": {name: version(name) for name in PACKAGES} | {"selfmotion": __version__},
    }
