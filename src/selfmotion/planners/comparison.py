"""Motions side by side: a plan with its proof, and sampled motions that ladders or others made."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import NothingFeasibleError
from selfmotion.judgement import Tolerances, judge, measured
from selfmotion.mending.filling import filled
from selfmotion.objectives import L2Travel
from selfmotion.planners.distance import distance_from_optimum
from selfmotion.planners.ladder import ladder
from selfmotion.plans import Plan
from selfmotion.problem import Problem

_SAME = 1e-9  # path parameters that differ by less are the same


@dataclass(frozen=True)
class Compared:
    """One motion of a comparison.

    Attributes
    ----------
    name : str
    holds : bool
        Of a plan, whether its verification holds; of rows, whether :func:`~selfmotion.judgement.judge` accepts them.
    why_not : str or None
        The first failure, or why there is no such motion.
    cost, cost_error : float or None
        The objective along the continuous motion, for rows that of :func:`~selfmotion.planners.distance_from_optimum`,
        and an estimate of the error.
    cost_sampled : float or None
        Its chord sum, of a plan over the samples, else over the rows.
    l2_waypoints : float or None
        ``Σ‖w∘Δθ‖`` over the path's given points; None if it has none, or rows leave one of them out.
    max_joint_step : float or None
        Between two rows [rad].
    jumps : int or None
        Steps that no continuous motion explains.
    gap : float or None
        ``(cost + cost_error − lower_bound)/cost``: what the best of all motions may save, at most.
    seconds : float or None
        What it took to make it.
    estimated_gap : float or None
        Instead of ``gap`` for an arm that is not rigorous; None for all others.
    """

    name: str
    holds: bool
    why_not: str | None = None
    cost: float | None = None
    cost_error: float | None = None
    cost_sampled: float | None = None
    l2_waypoints: float | None = None
    max_joint_step: float | None = None
    jumps: int | None = None
    gap: float | None = None
    seconds: float | None = None
    estimated_gap: float | None = None

    def summary(self) -> dict[str, Any]:
        """Return it as ``selfmotion compare --json`` prints it, an estimate only if there is one."""
        return {key: value for key, value in asdict(self).items() if key != "estimated_gap" or value is not None}


def compare_plan(plan: Plan) -> Compared:
    """Return what a plan is compared by.

    Parameters
    ----------
    plan : Plan

    Returns
    -------
    Compared
    """
    check = plan.verification
    return Compared(
        plan.planner,
        check.holds,
        str(check.failures[0]) if check.failures else None,
        plan.cost,
        plan.cost_error,
        plan.cost_sampled,
        plan.l2_waypoints,
        check.max_joint_step,
        sum(failure.check == "continuity" for failure in check.failures),
        plan.gap,
        plan.wall_time_s,
        plan.estimated_gap,
    )


def compare_rows(
    name: str,
    plan: Plan,
    r: FloatArray,
    q: FloatArray,
    tolerances: Tolerances | None = None,
    seconds: float | None = None,
) -> Compared:
    """Return what a sampled motion is compared by.

    Parameters
    ----------
    name : str
    plan : Plan
        Of the same problem, with a bound.
    r : array, shape (k,)
    q : array, shape (k, n)
        As for :func:`~selfmotion.judgement.judge`.
    tolerances : Tolerances, optional
    seconds : float, optional
        What it took to make it.

    Returns
    -------
    Compared

    Raises
    ------
    InvalidInputError
        If r and q are no motion.
    """
    problem = plan.problem
    verdict, motion = judge(problem, r, q, tolerances), measured(problem, r, q, tolerances)
    distance = distance_from_optimum(problem, r, q, plan, tolerances) if verdict.holds else None
    return Compared(
        name,
        verdict.holds,
        str(verdict.failures[0]) if verdict.failures else distance.reason if distance else None,
        distance.cost if distance else None,
        distance.cost_error if distance else None,
        verdict.cost_sampled,
        l2_over_waypoints(problem, motion.r, motion.q),
        verdict.max_joint_step,
        len(filled(problem, motion.r, motion.q).broken),
        distance.gap if distance else None,
        seconds,
        distance.estimated_gap if distance else None,
    )


def compare_ladder(plan: Plan, values: int, tolerances: Tolerances | None = None) -> Compared:
    """Return what the plain ladder with `values` values of u is compared by; see :func:`compare_rows`.

    Parameters
    ----------
    plan : Plan
        Of the same problem, with a bound.
    values : int
        Of u, per waypoint.
    tolerances : Tolerances, optional

    Returns
    -------
    Compared
        Without a cost if the ladder finds no motion.
    """
    name = f"ladder of {values}"
    try:
        found = ladder(plan.problem, values)
    except NothingFeasibleError as error:
        return Compared(name, False, error.message)
    return compare_rows(name, plan, found.r, found.q, tolerances, found.seconds)


def l2_over_waypoints(problem: Problem, r: FloatArray, q: FloatArray) -> float | None:
    """Return ``Σ‖w∘Δθ‖`` of rows over the path's given points, None where one of these has no row."""
    at = problem.path.waypoints
    if len(at) < 2:
        return None
    rows = np.clip(np.searchsorted(r, at - _SAME), 0, len(r) - 1)
    if (np.abs(r[rows] - at) > _SAME).any():
        return None
    return float(L2Travel().sampled(q[rows], at, problem.weights))


__all__ = ["Compared", "compare_ladder", "compare_plan", "compare_rows", "l2_over_waypoints"]
