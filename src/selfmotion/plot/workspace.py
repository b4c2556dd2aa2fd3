"""What the arm reaches: the nearest maximum reachable workspace and the co-regular circles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.arms import PlanarArm, Radii
from selfmotion.paths import Path
from selfmotion.plot.obstacles import draw_obstacles
from selfmotion.plot.plane import draw_base, draw_circle, frame, ray
from selfmotion.plot.style import COLORS, GREY, INK, REGION

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Circles whose radii differ by less than this part of the reach share one label.
_SAME = 1e-9
# Where the labels' lines start on their circles [rad], and where labels stand, in parts of the reach.
_HIGHEST = 0.9
_LABELS = 1.12


def draw_workspace(axes: Axes, arm: PlanarArm, path: Path | None = None) -> None:
    """Draw the nearest maximum reachable workspace, shaded, and the co-regular circles, dashed (Fig. 3).

    Parameters
    ----------
    axes : Axes
    arm : PlanarArm
        With one redundant degree.
    path : Path, optional
        Drawn on top.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy.
    """
    from matplotlib.patches import Wedge
    from matplotlib.ticker import MaxNLocator

    radii = arm.radii()
    center, outer = radii.center, radii.outer
    if radii.nearest < outer:  # False where it is NaN
        shown = Wedge(tuple(center), outer, 0, 360, width=outer - radii.nearest, facecolor=REGION, edgecolor="none")
        axes.add_patch(shown)
        draw_circle(axes, center, radii.nearest, linewidth=1.0)
    draw_circle(axes, center, outer, linewidth=1.2)
    for rho in set(radii.coregular):
        draw_circle(axes, center, rho, color=GREY, linestyle=(0, (4, 2)), linewidth=0.9)
    labels = _labels(radii)
    angles = np.linspace(_HIGHEST, -_HIGHEST, len(labels))
    for (text, radius), angle in zip(labels, angles, strict=True):
        axes.annotate(
            text,
            tuple(ray(center, angle, radius)),
            xytext=tuple(center + outer * np.array([_LABELS, angle])),
            va="center",
            color=INK,
            arrowprops={"arrowstyle": "-", "color": GREY, "linewidth": 0.5, "shrinkA": 1, "shrinkB": 0},
        )
    if path is not None:
        x = path(path.grid(800))
        axes.plot(x[:, 0], x[:, 1], color=COLORS[0], linewidth=1.8, zorder=3)
    draw_obstacles(axes, arm)
    draw_base(axes)
    frame(axes, center + outer * np.array([[-1.0, -1.0], [1.0, 1.0]]), margin=0.03)
    axes.set_xlim(right=center[0] + 1.95 * outer)
    for axis, middle in zip((axes.xaxis, axes.yaxis), center, strict=True):  # no numbers beside the labels
        ticks = MaxNLocator(5).tick_values(middle - outer, middle + outer)
        axis.set_ticks(ticks[np.abs(ticks - middle) <= outer])
    none = np.isnan(radii.nearest)
    axes.set_title("reach and co-regular circles; $R^*_{min}$: none" if none else "nearest maximum reachable workspace")


def _labels(radii: Radii) -> list[tuple[str, float]]:
    """Return one label per circle with its radius, from outside in."""
    named = [("$R_{max}$", radii.outer), ("$R^*_{min}$", radii.nearest)]
    named += [(f"$ρ_{k + 1}$", rho) for k, rho in enumerate(radii.coregular)]
    return [(" = ".join([*names, f"{radius:.4g}"]), radius) for names, radius in same_circles(named)]


def same_circles(named: Sequence[tuple[str, float]]) -> list[tuple[list[str], float]]:
    """Return each circle once with all its names, from outside in; one without a radius, NaN, is none."""
    known = sorted((item for item in named if not np.isnan(item[1])), key=lambda item: -item[1])
    groups: list[tuple[list[str], float]] = []
    for name, radius in known:
        if groups and groups[-1][1] - radius <= _SAME * known[0][1]:
            groups[-1][0].append(name)
        else:
            groups.append(([name], radius))
    return groups
