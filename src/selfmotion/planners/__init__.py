"""Planners: each turns a problem into a verified plan.

A new planner is one file and one line in `PLANNERS`.
"""

from __future__ import annotations

from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import Progress
from selfmotion.planners.base import Planner
from selfmotion.planners.candidates import Candidates, PlanarCandidates
from selfmotion.planners.chain import module_problems
from selfmotion.planners.comparison import Compared, compare_ladder, compare_plan, compare_rows
from selfmotion.planners.distance import Distance, distance_from_optimum
from selfmotion.planners.globally_optimal import Global
from selfmotion.planners.ladder import LadderMotion, ladder
from selfmotion.planners.modules import Modules
from selfmotion.planners.moving_base import MovingBase
from selfmotion.planners.parametric import Parametric, Sinusoid
from selfmotion.planners.refine import Refine
from selfmotion.planners.series import BSpline, Harmonics
from selfmotion.planners.widest import Widest
from selfmotion.plans import Plan
from selfmotion.problem import Problem

PLANNERS: dict[str, type[Planner]] = {
    planner.kind: planner for planner in (Sinusoid, Harmonics, BSpline, Modules, MovingBase, Refine, Global, Widest)
}
"""Every planner by the ``kind`` of a problem file."""


def plan(problem: Problem, planner: Planner, progress: Progress | None = None) -> Plan:
    """Plan a joint motion along a path: the seed's section IV-D in one call.

    Parameters
    ----------
    problem : Problem
    planner : Planner
    progress : callable, optional
        Called with (done, total, best cost so far) as the work goes on.

    Returns
    -------
    Plan
        Verified from forward kinematics, between its samples too.

    Raises
    ------
    InvalidInputError
        If the problem asks for what the planner cannot do.
    InfeasibleError
        If the path is proved to be blocked.
    NothingFeasibleError
        If no feasible motion was found; this proves nothing.
    """
    for name, given, wanted in (("problem", problem, Problem), ("planner", planner, Planner)):
        if not isinstance(given, wanted):
            raise InvalidInputError(name, f"is a {type(given).__name__}", "call plan(problem, planner)")
    return planner.plan(problem, progress)


__all__ = [
    "PLANNERS",
    "BSpline",
    "Candidates",
    "Compared",
    "Distance",
    "Global",
    "Harmonics",
    "LadderMotion",
    "Modules",
    "MovingBase",
    "Parametric",
    "Plan",
    "PlanarCandidates",
    "Planner",
    "Refine",
    "Sinusoid",
    "Widest",
    "compare_ladder",
    "compare_plan",
    "compare_rows",
    "distance_from_optimum",
    "ladder",
    "module_problems",
    "plan",
]
