"""The numbers of the shortest motions: what families of curves reach, what nothing goes below."""

from __future__ import annotations

from typing import Any

from selfmotion.plans import Plan
from selfmotion.report import seed_shortest
from selfmotion.report.study import Study


def results_of_shortest(study: Study) -> dict[str, Any]:
    """Return per case what its motions cost, as integrals and as chord sums, and the proved bounds."""
    return {
        name: {
            "start": seed_shortest.QUESTIONS[name].offset,
            **{kind: _costs(plan) for kind, plan in answer._asdict().items()},
        }
        for name, answer in study.shortest.answers.items()
    }


def _costs(plan: Plan) -> dict[str, Any]:
    costs = {"cost": plan.cost, "cost_sampled": plan.cost_sampled}
    if plan.lower_bound is None:
        return costs
    return {**costs, "cost_error": plan.cost_error, "lower_bound": plan.lower_bound}
