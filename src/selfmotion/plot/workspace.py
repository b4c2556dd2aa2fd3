"""The plane: the path, and the arm on it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import PlanarArm
from selfmotion.plans import Plan
from selfmotion.plot.style import COLORS, GREY, INK
from selfmotion.problem import Problem

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POSTURES = 14


def draw_path(axes: Axes, problem: Problem) -> None:
    """Draw the path that the tool follows, its start and end, and the limit of reach (Fig. 10a)."""
    x = problem.path(problem.path.grid(800))
    axes.plot(x[:, 0], x[:, 1], color=COLORS[0], linewidth=1.8, zorder=3)
    axes.plot(*x[0], "o", color=COLORS[0], markersize=4, zorder=4)
    axes.plot(*x[-1], "s", color=COLORS[0], markersize=4, markerfacecolor="white", zorder=4)
    ends = {"start = end": x[0]} if problem.path.is_closed else {"start": x[0], "end": x[-1]}
    for label, point in ends.items():
        box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
        axes.annotate(label, point, xytext=(6, -10), textcoords="offset points", color=INK, zorder=6, bbox=box)
    _frame(axes, x)


def _frame(axes: Axes, points: FloatArray) -> None:
    """Show all of `points` with a margin, both axes to the same scale."""
    low, high = points.reshape(-1, 2).min(axis=0), points.reshape(-1, 2).max(axis=0)
    margin = 0.14 * float((high - low).max())  # room for the labels of the ends
    axes.set_xlim(low[0] - margin, high[0] + margin)
    axes.set_ylim(low[1] - margin, high[1] + margin)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x")
    axes.set_ylabel("y")


def draw_postures(axes: Axes, plan: Plan) -> None:
    """Draw the arm's postures along its motion (Fig. 12b): light at the start, dark at the end."""
    from matplotlib.colors import to_rgb

    draw_path(axes, plan.problem)
    points = plan.problem.arm.joint_positions(plan(np.linspace(0, 1, _POSTURES)))
    dark, light = np.array(to_rgb(INK)), np.array(to_rgb("#d9d9d9"))
    for k, chain in enumerate(points):
        t = k / (_POSTURES - 1)
        axes.plot(
            chain[:, 0], chain[:, 1], "-o", color=tuple(light + t * (dark - light)), linewidth=0.9, markersize=1.8
        )
    if isinstance(plan.problem.arm, PlanarArm):
        center, _, outer = plan.problem.arm.annulus
        angle = np.linspace(-np.pi, np.pi, 721)
        rim = center + outer * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        axes.plot(rim[:, 0], rim[:, 1], color=GREY, linestyle=":", linewidth=0.8)
    axes.plot(0, 0, "^", color=INK, markersize=6, zorder=5)
    _frame(axes, np.vstack([points.reshape(-1, 2), plan.problem.path(np.linspace(0, 1, 201))]))
    axes.set_title("postures from light to dark; dotted: reach")
