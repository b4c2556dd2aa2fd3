"""How many runs of several methods end: every run, its median and its quartiles, on several problems."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.plot.evolution import FLOOR
from selfmotion.plot.style import COLORS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_MARKS = ("o", "s", "D", "^")
_BAND = 0.62  # of the height of a method's row is used by its groups


def draw_spread(axes: Axes, excess: Mapping[str, Mapping[str, ArrayLike]]) -> None:
    """Draw final excesses on a logarithmic axis, a row per method, its groups below each other.

    Parameters
    ----------
    axes : Axes
    excess : mapping
        Group (such as ``plain``) to method to the excess of each run over the optimum, shape (s,). What is below
        ``FLOOR`` is drawn there. Mark: median; bar: quartiles; faint dots: the runs.
    """
    methods = list(dict.fromkeys(method for rows in excess.values() for method in rows))
    step = _BAND / len(excess)
    for g, (group, rows) in enumerate(excess.items()):
        color, mark = COLORS[g % len(COLORS)], _MARKS[g % len(_MARKS)]
        for k, method in enumerate(methods):
            values = np.maximum(np.asarray(rows[method], dtype=float), FLOOR)
            y = k + (g - 0.5 * (len(excess) - 1)) * step
            low, middle, high = np.percentile(values, [25, 50, 75])
            # Runs of one value would hide each other: they are spread over the row in the order they were made.
            spread = y + 0.6 * step * np.linspace(-0.5, 0.5, len(values))
            axes.plot(values, spread, ".", color=color, alpha=0.5, markersize=3.2, markeredgewidth=0)
            axes.plot([low, high], [y, y], "-", color=color, linewidth=2.2, solid_capstyle="butt")
            axes.plot(
                [middle], [y], mark, color=color, markersize=4.2, markeredgewidth=1.0,
                markerfacecolor="white" if g else color, label="" if k else group,
            )  # fmt: skip
    axes.set_xscale("log")
    axes.set_yticks(range(len(methods)), methods)
    axes.set_ylim(len(methods) - 0.5, -0.5)
    axes.set_xlabel("final F − optimum")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=len(excess), borderaxespad=0.2)
