"""Every number of the report, as one plain object: what is not computed here is not in the report."""

from __future__ import annotations

import os
import platform
from collections import Counter
from dataclasses import asdict
from importlib.metadata import version
from typing import Any

import numpy as np

from selfmotion._version import __version__
from selfmotion.arms import JointLimits
from selfmotion.domain import AngleDomain
from selfmotion.domain.events import WORDS
from selfmotion.report import seed_runs, seed_study
from selfmotion.report.study import Study

PACKAGES = ("selfmotion", "numpy", "scipy", "matplotlib")
"""Whose versions decide the last bits of the numbers and the look of the figures."""


def results_of(study: Study) -> dict[str, Any]:
    """Run the study and return its results, made of what JSON knows.

    Wall times and the command are not among them: they belong to a run, not to the study.
    """
    scan, arm = study.scan, seed_study.arm()
    return {
        "seed": study.seed,
        "seeds": study.seeds,
        "arm": {
            "links": ", ".join(f"{length:g}" for length in arm.links),
            "reach": arm.reach,
            "limits": _limits(arm.limits),
        },
        "limited": _structure(study.limited),
        "offset": seed_study.OFFSET,
        "amplitude": seed_study.AMPLITUDE,
        "low": seed_study.BOUNDS[0],
        "high": seed_study.BOUNDS[1],
        "population": seed_study.POPULATION,
        "iterations": seed_study.ITERATIONS,
        "samples": seed_study.SAMPLES,
        "shift": seed_runs.SHIFT,
        "tolerance": seed_runs.TOLERANCE,
        "scan": asdict(scan),
        "table": {label: _line(label, study) for label in study.plans},
        "best": study.best,
        "comparison": {
            copy: {label: _statistics(runs, scan) for label, runs in rows.items()} for copy, rows in study.runs.items()
        },
        "evaluations": max(int(runs.evaluations.max()) for rows in study.runs.values() for runs in rows.values()),
        "lower_than": {
            other: int(np.sum(study.runs["plain"]["PSO"].fitness < study.runs["plain"][other].fitness))
            for other in seed_study.RIVALS
        },
        "machine": {
            "processor": platform.machine(),
            "cpus": os.cpu_count(),
            "system": platform.system(),
            "python": platform.python_version(),
        },
        "versions": {name: version(name) for name in PACKAGES} | {"selfmotion": __version__},
    }


def _limits(limits: JointLimits) -> str:
    bounds = enumerate(zip(limits.lower, limits.upper, strict=True))
    return ", ".join(f"{low:.4g} ≤ θ{joint + 1} ≤ {high:.4g}" for joint, (low, high) in bounds if limits.limited[joint])


def _structure(domain: AngleDomain) -> dict[str, Any]:
    """Return what happens to an angle domain along its path."""
    structure = domain.structure
    kinds = Counter(event.kind for event in structure.events)
    return {
        "limits": _limits(domain.self_motion.limits),
        "events": len(structure.events),
        "kinds": ", ".join(f"{WORDS[kind]} ({kinds[kind]})" for kind in WORDS if kinds[kind]),
        "components": structure.n_components,
        "connected": "connected" if structure.is_connected else "not connected",
    }


def _line(label: str, study: Study) -> dict[str, Any]:
    """Return a line of Table II: printed, at the printed frequency, computed."""
    printed, plan = seed_study.PRINTED.get(label), study.plans[label]
    return {
        "printed": None if printed is None else asdict(printed),
        "computed_at_printed_f": None if printed is None else float(seed_study.fitness(printed.f)[0]),
        "excess": plan.cost_sampled - study.scan.fitness,
        **plan.summary(),
    }


def _statistics(runs: seed_runs.Runs, scan: seed_study.DenseScan) -> dict[str, Any]:
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
