"""Joint angles along the path."""

from __future__ import annotations

from typing import TYPE_CHECKING

from selfmotion.plans import Plan
from selfmotion.plot.style import COLORS, DASHES, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_joints(axes: Axes, plan: Plan) -> None:
    """Draw every joint's angle against r (Fig. 12a), with those limits that lie in the picture."""
    r = plan.problem.rows
    q = plan(r)
    limits = plan.problem.arm.limits
    low, high = float(q.min()), float(q.max())
    margin = 0.08 * max(high - low, 1e-3)
    shown: dict[float, list[str]] = {}
    for joint, series in enumerate(q.T):
        name = f"θ{joint + 1}"
        axes.plot(r, series, color=COLORS[joint % len(COLORS)], linestyle=DASHES[joint % len(DASHES)], label=name)
        for bound in (limits.lower[joint], limits.upper[joint]):
            if low - 6 * margin <= bound <= high + 6 * margin:
                shown.setdefault(float(bound), []).append(name)
    for bound, names in shown.items():
        axes.axhline(bound, color=GREY, linewidth=0.6)
        axes.annotate(
            f"limit of {', '.join(names)}", (0.01, bound), xytext=(0, 2), textcoords="offset points",
            xycoords=("axes fraction", "data"), color=GREY, fontsize=6.5,
        )  # fmt: skip
    axes.set_xlim(0, 1)
    axes.margins(y=0.08)
    axes.set_xlabel("path parameter r")
    axes.set_ylabel("joint angle [rad]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=4, handlelength=3, borderaxespad=0.2)
