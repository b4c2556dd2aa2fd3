"""Joint velocities of a timed trajectory."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion.plot.style import COLORS, DASHES, GREY
from selfmotion.timing import TimedTrajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_POINTS = 2000


def draw_velocities(axes: Axes, timed: TimedTrajectory) -> None:
    """Draw joint velocities by time, as parts of their limits if every joint has one; dots where the arm stands still.

    Parameters
    ----------
    axes : Axes
    timed : TimedTrajectory
    """
    t = np.union1d(np.linspace(0.0, timed.duration, _POINTS), timed.law.t)
    limits = timed.limits.velocity
    limited = bool(np.isfinite(limits).all())
    velocity = timed.states(t)[1] / (limits if limited else 1.0)
    for joint, values in enumerate(velocity.T):
        dashes = DASHES[(joint + joint // len(COLORS)) % len(DASHES)]  # where colours come again, others
        color = COLORS[joint % len(COLORS)]
        axes.plot(t, values, label=f"θ{joint + 1}", color=color, linestyle=dashes, linewidth=1.0)
    stands = timed.law.t[timed.law.speed == 0.0]
    axes.plot(stands, np.zeros(len(stands)), "o", color=GREY, markersize=3.0, clip_on=False, zorder=5)
    axes.set_xlim(0.0, timed.duration)
    if limited:
        for bound in (-1.0, 1.0):
            axes.axhline(bound, color=GREY, linewidth=0.6)
        axes.set_ylim(-1.08, 1.08)
        axes.set_yticks([-1.0, -0.5, 0.0, 0.5, 1.0])
    axes.set_xlabel("time [s]")
    axes.set_ylabel("velocity / its limit" if limited else "joint velocity [rad/s]")
    layout: dict[str, Any] = {"ncols": 4, "handlelength": 2.2, "columnspacing": 1.0, "borderaxespad": 0.2}
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), **layout)
