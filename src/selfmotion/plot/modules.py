"""A long arm as modules of three links, each in a frame that moves with its base: the seed's Fig. 13."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.paths import Path
from selfmotion.plans import Plan
from selfmotion.plot.plane import draw_base, draw_chain, draw_label, frame
from selfmotion.plot.style import COLORS, DASHES, GREY, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_AXIS = 0.07  # length of a frame's axes, in parts of the reach


def draw_modules(axes: Axes, plan: Plan, moving_bases: Sequence[Path], r: float = 0.5) -> None:
    """Draw one posture of a planar arm as modules, the frame of each, and the paths they follow (Fig. 13).

    Parameters
    ----------
    axes : Axes
    plan : Plan
        Of a planar arm with three links per module.
    moving_bases : sequence of Path
        Of the end of each module but the last.
    r : float
        Path parameter of the posture.
    """
    chain = plan.problem.arm.joint_positions(plan(np.array([r])))[0]
    size = _AXIS * plan.problem.arm.reach
    shown = [chain]
    for path, look in (*((base, DASHES[1]) for base in moving_bases), (plan.problem.path, "-")):
        x = path(path.grid(400))
        name = "path of the tool" if path is plan.problem.path else "path of a moving base"
        label = None if path in moving_bases[1:] else name
        axes.plot(x[:, 0], x[:, 1], color=INK, linestyle=look, linewidth=1.0, label=label, zorder=1.5)
        shown.append(x)
    for module in range(len(moving_bases) + 1):
        links, color = chain[3 * module : 3 * module + 4], COLORS[module % len(COLORS)]
        name = f"module {module + 1}"
        draw_chain(axes, links, color=color, linewidth=2.0, markersize=3.5, label=name, zorder=3)
        shown.append(_draw_frame(axes, links[0], size, "′" * module))
    axes.plot(*chain[-1], "s", color=INK, markersize=4, zorder=5)
    draw_base(axes)
    frame(axes, np.vstack(shown), margin=0.08)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, handlelength=3, borderaxespad=0.2)


def _draw_frame(axes: Axes, origin: FloatArray, size: float, primes: str) -> FloatArray:
    """Draw the axes of a frame, parallel to the world's, and return the points to be shown."""
    tips = origin + size * np.eye(2)
    for tip, name, side in zip(tips, "xy", np.eye(2), strict=True):
        arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 7}
        axes.annotate("", tuple(tip), xytext=tuple(origin), arrowprops=arrow, zorder=4)
        draw_label(axes, f"{name}{primes}", tip, side, gap=2.0)
    axes.plot(*origin, "o", color=GREY, markersize=1.5, zorder=4)
    return np.asarray(tips)
