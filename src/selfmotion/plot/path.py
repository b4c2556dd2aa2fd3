"""The path, and the arm on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion.arms import PlanarArm
from selfmotion.constrained.arm import unconstrained
from selfmotion.plans import Plan
from selfmotion.plot.obstacles import draw_links, draw_obstacles, in_view
from selfmotion.plot.plane import BEHIND_TEXT, draw_base, draw_chain, draw_circle, frame
from selfmotion.plot.style import COLORS, GREY, INK, shades
from selfmotion.problem import Problem

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POSTURES = 14


def draw_path(axes: Axes, problem: Problem) -> None:
    """Draw the path that the tool follows, its start and end, and the obstacles around it (Fig. 10a).

    Parameters
    ----------
    axes : Axes
    problem : Problem
    """
    x = problem.path(problem.path.grid(800))
    draw_obstacles(axes, problem.arm)
    axes.plot(x[:, 0], x[:, 1], color=COLORS[0], linewidth=1.8, zorder=3)
    axes.plot(*x[0], "o", color=COLORS[0], markersize=4, zorder=4)
    axes.plot(*x[-1], "s", color=COLORS[0], markersize=4, markerfacecolor="white", zorder=4)
    ends = {"start = end": x[0]} if problem.path.is_closed else {"start": x[0], "end": x[-1]}
    for label, point in ends.items():
        up = 5 if label == "start" else -10  # the one above, the other below, in case they are near each other
        axes.annotate(label, point, xytext=(6, up), textcoords="offset points", color=INK, zorder=6, bbox=BEHIND_TEXT)
    frame(axes, np.vstack([x, in_view(problem.arm)]))


def draw_postures(axes: Axes, plan: Plan) -> None:
    """Draw the arm's postures along its motion (Fig. 12b): light at the start, dark at the end.

    Parameters
    ----------
    axes : Axes
    plan : Plan
        Of a planar arm.
    """
    draw_path(axes, plan.problem)
    arm = plan.problem.arm
    points = arm.joint_positions(plan(np.linspace(0, 1, _POSTURES)))
    for chain, color in zip(points, shades(_POSTURES), strict=True):
        draw_links(axes, arm, chain, color=color)
        draw_chain(axes, chain, color=color)
    draw_base(axes)
    frame(axes, np.vstack([points.reshape(-1, 2), plan.problem.path(np.linspace(0, 1, 201)), in_view(arm)]))
    title = "postures from light to dark"
    bare = unconstrained(arm)
    if isinstance(bare, PlanarArm):
        center, _, outer = bare.annulus
        corners = np.stack(np.meshgrid(axes.get_xlim(), axes.get_ylim()), axis=-1) - center
        if np.hypot(*corners.T).max() > outer:  # else nothing of it would be seen
            draw_circle(axes, center, outer, color=GREY, linestyle=":")
            title += "; dotted: reach"
    axes.set_title(title)
