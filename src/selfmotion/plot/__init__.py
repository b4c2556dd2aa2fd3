"""Pictures: one function per figure, each on a given Axes. Nothing below imports this package."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms import RedundantArm
from selfmotion.arms.protocols import u_period
from selfmotion.breaks import Break
from selfmotion.certificate.verdict import verdict
from selfmotion.domain import SampledDomain, angle_domain
from selfmotion.paths.base import PLANE
from selfmotion.plans import Plan
from selfmotion.plot.connectivity import draw_sampled_joints, draw_samples
from selfmotion.plot.curve_domain import draw_sampled_domain, sampled_domain_figure
from selfmotion.plot.data import figure_data
from selfmotion.plot.domain import draw_domain
from selfmotion.plot.drawing import draw_drawing
from selfmotion.plot.evolution import draw_evolution
from selfmotion.plot.flow import draw_flow, flow_height
from selfmotion.plot.joints import draw_each_joint, draw_joints, draw_parameter
from selfmotion.plot.modules import draw_modules
from selfmotion.plot.obstacles import draw_links, draw_obstacles
from selfmotion.plot.optimum import draw_optimum, draw_tube
from selfmotion.plot.path import draw_path, draw_postures
from selfmotion.plot.proof import draw_proof
from selfmotion.plot.spread import draw_spread
from selfmotion.plot.style import COLUMN, figure, image_files, rendered
from selfmotion.plot.sweep import draw_extreme_postures, draw_posture_interval, draw_sweep
from selfmotion.plot.timed import draw_velocities
from selfmotion.plot.workspace import draw_workspace
from selfmotion.problem import Problem

_COLUMNS = 4  # of panels, one per joint


def plan_figure_names(arm: RedundantArm) -> list[str]:
    """Return the names of the files that :func:`plan_figures` makes for an arm.

    Parameters
    ----------
    arm : RedundantArm

    Returns
    -------
    list of str
    """
    names = ["joints"] if arm.dimension != PLANE else ["postures", "joints"]
    if _has_domain(arm):
        names.append("motion_in_domain")
    return [f"{name}.{suffix}" for name in names for suffix in ("png", "svg")]


def plan_figures(plan: Plan) -> dict[str, bytes]:
    """Return the pictures of a plan, PNG and SVG, as file name to bytes.

    Of arms in space these are the joint angles and the redundancy parameter, and the motion in the angle domain of each
    branch if that is told; no postures.

    Parameters
    ----------
    plan : Plan

    Returns
    -------
    dict
    """
    if plan.problem.arm.dimension != PLANE:
        return _space_figures(plan)
    files = rendered("postures", draw_postures, plan, height=3.2) | rendered("joints", draw_joints, plan)
    if plan.certificate is not None:
        files |= rendered("motion_in_domain", draw_optimum, plan, height=3.2)
    elif _has_domain(plan.problem.arm):
        r = plan.problem.rows
        domain = angle_domain(plan.problem.arm, plan.problem.path)
        on, u = plan.problem.arm.branch_of(plan(r)), plan.u(r)[:, 0]
        used = np.unique(on)
        with figure(width=COLUMN * len(used), columns=len(used)) as (canvas, panels):
            for branch, axes in zip(used, panels, strict=True):
                draw_domain(axes, domain, int(branch), {"this plan": (r, np.where(on == branch, u, np.nan))})
            files |= image_files("motion_in_domain", canvas)
    return files


def _space_figures(plan: Plan) -> dict[str, bytes]:
    """Return the pictures of a plan of an arm in space."""
    panels = plan.problem.arm.n + 1
    rows = -(-panels // _COLUMNS)
    with figure(width=2 * COLUMN, height=0.4 + 1.5 * rows, columns=_COLUMNS, rows=rows) as (canvas, axes):
        draw_each_joint(axes[: panels - 1], plan)
        draw_parameter(axes[panels - 1], plan)
        for empty in axes[panels:]:
            empty.set_axis_off()
        for lowest in axes[panels - _COLUMNS : panels]:
            lowest.set_xlabel("path parameter r")
        if plan.certificate is not None:
            proof = plan.certificate
            said = verdict(plan.cost, plan.cost_error, proof.bound, rigorous=proof.rigorous)
            canvas.suptitle(f"cost {said}", fontsize=8.5)
        files = image_files("joints", canvas)
    arm = plan.problem.arm
    if _has_domain(arm):
        sampled = SampledDomain(angle_domain(arm, plan.problem.path), range(len(arm.branches)))
        r = plan.problem.rows
        files |= sampled_domain_figure(sampled, (r, plan.u(r)[:, 0], arm.branch_of(plan(r))), "motion_in_domain")
    return files


def _has_domain(arm: RedundantArm) -> bool:
    """Return whether an arm's angle domain is told: of one redundant degree, an angle, if its postures are enclosed."""
    return arm.n_u == 1 and arm.rigorous and u_period(arm) == TAU


def motion_figures(
    name: str, problem: Problem, r: FloatArray, q: FloatArray, breaks: Sequence[Break] = ()
) -> dict[str, bytes]:
    """Return postures and joints of a sampled motion side by side, its breaks marked, as file name to bytes.

    Parameters
    ----------
    name : str
        Of the files, without their endings.
    problem : Problem
    r : array, shape (k,)
    q : array, shape (k, n)
        Joint angles [rad].
    breaks : sequence of Break

    Returns
    -------
    dict
    """
    with figure(width=7.0, height=3.2, columns=2) as (canvas, (left, right)):
        draw_samples(left, problem, r, q, breaks)
        draw_sampled_joints(right, problem, r, q, breaks)
        return image_files(name, canvas)


__all__ = [
    "draw_domain",
    "draw_drawing",
    "draw_each_joint",
    "draw_evolution",
    "draw_extreme_postures",
    "draw_flow",
    "draw_joints",
    "draw_links",
    "draw_modules",
    "draw_obstacles",
    "draw_optimum",
    "draw_parameter",
    "draw_path",
    "draw_posture_interval",
    "draw_postures",
    "draw_proof",
    "draw_sampled_domain",
    "draw_sampled_joints",
    "draw_samples",
    "draw_spread",
    "draw_sweep",
    "draw_tube",
    "draw_velocities",
    "draw_workspace",
    "figure",
    "figure_data",
    "flow_height",
    "image_files",
    "motion_figures",
    "plan_figure_names",
    "plan_figures",
    "rendered",
    "sampled_domain_figure",
]
