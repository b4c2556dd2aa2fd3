"""The numbers of the 6R study: Table III in both readings of the fourth joint, sums, and what the modules cost."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from selfmotion.plans import Plan
from selfmotion.report import seed_6r
from selfmotion.report.cases import Case, DenseScan
from selfmotion.report.results_arm import arm_facts
from selfmotion.report.results_case import comparison, line
from selfmotion.report.study import Study
from selfmotion.report.study_6r import modules_sum


def cases_of_6r(study: Study) -> dict[str, Any]:
    """Return the lines of Table III, case by case, with the yardsticks and the comparisons."""
    fixed, moving = study.cases[seed_6r.FIXED.name], study.cases[seed_6r.MOVING.name]
    true = seed_6r.true_joints(fixed.scan.f)
    true_scan = true.dense_scan()
    plans = study.six.plans

    def table(case: Case, scan: DenseScan, module: int, reading: str) -> dict[str, Any]:
        found = {}
        for label, plan in plans[reading].items():
            part = plan.parameters["modules"][module]
            fitness = part["cost_sampled"][reading]
            found[label] = line(case, scan, label, part["f"], fitness, _at_printed(label) if case is true else None)
        return found

    return {
        fixed.case.name: {"table": table(fixed.case, fixed.scan, 0, "absolute"), **comparison(fixed)},
        moving.case.name: {"table": table(moving.case, moving.scan, 1, "absolute"), **comparison(moving)},
        true.name: {"table": table(true, true_scan, 1, "true"), "scan": asdict(true_scan)},
    }


def _at_printed(label: str) -> Case | None:
    """Return the search in true joints while the first module moves as printed."""
    printed = seed_6r.PRINTED_FIXED.get(label)
    return None if printed is None else seed_6r.true_joints(printed.f)


def results_of_6r(study: Study) -> dict[str, Any]:
    """Return the arm, what the modules cost together, the best motion checked, and what motions bound less cost."""
    six = study.six
    return {
        "arm": arm_facts(seed_6r.arm()),
        "offset_fixed": seed_6r.OFFSET[0],
        "offset_moving": seed_6r.OFFSET[1],
        "amplitude": seed_6r.AMPLITUDE[0],
        "sums": {
            reading: {label: _sums(label, plan) for label, plan in plans.items()}
            for reading, plans in six.plans.items()
        },
        "best": six.best,
        "motion": six.plan.summary(),
        "whole_arm": {name: plan.summary() for name, plan in six.whole_arm._asdict().items()},
    }


def _sums(label: str, plan: Plan) -> dict[str, Any]:
    """Return F of both modules of a plan together: printed, as chord sums and as integrals, in both readings."""
    printed = None
    if label in seed_6r.PRINTED_FIXED:
        printed = seed_6r.PRINTED_FIXED[label].fitness + seed_6r.PRINTED_MOVING[label].fitness
    return {
        "printed": printed,
        **{
            reading: {
                "sampled": modules_sum(plan, reading),
                "integral": modules_sum(plan, reading, "cost"),
            }
            for reading in seed_6r.READINGS
        },
    }
