"""Joint angles along the path."""

from __future__ import annotations

from typing import TYPE_CHECKING

from selfmotion.plans import Plan
from selfmotion.plot.style import COLORS, DASHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_joints(axes: Axes, plan: Plan) -> None:
    """Draw every joint's angle against r (Fig. 12a), with those limits that lie in the picture."""
    r = plan.problem.rows
    q = plan(r)
    limits = plan.problem.arm.limits
    low, high = float(q.min()), float(q.max())
    margin = 0.08 * max(high - low, 1e-3)
    for joint, series in enumerate(q.T):
        color = COLORS[joint % len(COLORS)]
        axes.plot(r, series, color=color, linestyle=DASHES[joint % len(DASHES)], label=f"θ{joint + 1}")
        for bound in (limits.lower[joint], limits.upper[joint]):
            if low - 3 * margin <= bound <= high + 3 * margin:
                axes.axhline(bound, color=color, linewidth=0.6)
                axes.annotate(
                    f"limit of θ{joint + 1}", (0.01, bound), xytext=(0, 2), textcoords="offset points",
                    xycoords=("axes fraction", "data"), color=color, fontsize=6.5,
                )  # fmt: skip
    axes.set_xlim(0, 1)
    axes.margins(y=0.08)
    axes.set_xlabel("path parameter r")
    axes.set_ylabel("joint angle [rad]")
    axes.set_title("joint angles")
    axes.legend(loc="best", ncols=min(plan.problem.arm.n, 3), handlelength=3)
