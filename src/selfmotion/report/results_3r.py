"""The numbers of the 3R study: Table II, and the angle domain of the arm with limits of our own."""

from __future__ import annotations

from collections import Counter
from typing import Any

from selfmotion.domain import AngleDomain
from selfmotion.domain.events import WORDS
from selfmotion.report import seed_3r
from selfmotion.report.results_arm import arm_facts, limits_text
from selfmotion.report.results_case import comparison, line
from selfmotion.report.study import Study


def case_of_3r(study: Study) -> dict[str, Any]:
    """Return the lines of Table II, per optimizer printed, at the printed frequency, computed, and the comparison."""
    found = study.cases[seed_3r.CASE.name]
    table = {
        label: line(found.case, found.scan, label, plan.parameters["f"], plan.cost_sampled) | plan.summary()
        for label, plan in study.three.plans.items()
    }
    return {found.case.name: {"table": table, **comparison(found)}}


def results_of_3r(study: Study) -> dict[str, Any]:
    """Return the arm, its sinusoids, who found the best of them, and what happens to the domain with our limits."""
    return {
        "arm": arm_facts(seed_3r.arm()),
        "limited": _structure(study.three.limited),
        "offset": seed_3r.OFFSET,
        "amplitude": seed_3r.AMPLITUDE,
        "best": study.three.best,
    }


def _structure(domain: AngleDomain) -> dict[str, Any]:
    """Return what happens to an angle domain along its path."""
    structure = domain.structure
    kinds = Counter(event.kind for event in structure.events)
    return {
        "limits": limits_text(domain.self_motion.limits),
        "events": len(structure.events),
        "kinds": ", ".join(f"{WORDS[kind]} ({kinds[kind]})" for kind in WORDS if kinds[kind]),
        "components": structure.n_components,
        "connected": "connected" if structure.is_connected else "not connected",
    }
