"""Every number of the report, as one plain object: what is not computed here is not in the report."""

from __future__ import annotations

import os
import platform
from collections import Counter
from importlib.metadata import version
from typing import Any

from selfmotion._version import __version__
from selfmotion.arms import JointLimits, PlanarArm
from selfmotion.domain import AngleDomain
from selfmotion.domain.events import WORDS
from selfmotion.report import cases, seed_3r, seed_6r, seed_runs
from selfmotion.report.results_6r import cases_of_6r, results_of_6r
from selfmotion.report.results_case import comparison, line
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
        "arm": _arm(seed_3r.arm()),
        "limited": _structure(study.limited),
        "offset": seed_3r.OFFSET,
        "amplitude": seed_3r.AMPLITUDE,
        "low": cases.BOUNDS[0],
        "high": cases.BOUNDS[1],
        "population": cases.POPULATION,
        "iterations": cases.ITERATIONS,
        "samples": cases.SAMPLES,
        "shift": seed_runs.SHIFT,
        "tolerance": seed_runs.TOLERANCE,
        "best": study.best,
        "cases": {
            seed_3r.CASE.name: {"table": _table_of_3r(study), **comparison(study.cases[seed_3r.CASE.name])},
            **cases_of_6r(study),
        },
        "evaluations": max(
            int(runs.evaluations.max())
            for case in study.cases.values()
            for rows in case.runs.values()
            for runs in rows.values()
        ),
        "six": {"arm": _arm(seed_6r.arm()), **results_of_6r(study)},
        "machine": {
            "processor": platform.machine(),
            "cpus": os.cpu_count(),
            "system": platform.system(),
            "python": platform.python_version(),
        },
        "versions": {name: version(name) for name in PACKAGES} | {"selfmotion": __version__},
    }


def _arm(arm: PlanarArm) -> dict[str, Any]:
    return {
        "links": ", ".join(f"{length:g}" for length in arm.links),
        "joints": arm.n,
        "reach": arm.reach,
        "limits": _limits(arm.limits),
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


def _table_of_3r(study: Study) -> dict[str, Any]:
    """Return Table II: per optimizer printed, at the printed frequency, computed."""
    found = study.cases[seed_3r.CASE.name]
    return {
        label: line(found.case, found.scan, label, plan.parameters["f"], plan.cost_sampled) | plan.summary()
        for label, plan in study.plans.items()
    }
