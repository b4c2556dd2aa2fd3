"""How a search went: best cost against iterations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from selfmotion.optimizers import History
from selfmotion.plot.style import COLORS, DASHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_evolution(axes: Axes, histories: Mapping[str, History], optimum: float | None = None) -> None:
    """Draw the best cost of each search against its iterations (Fig. 11).

    Parameters
    ----------
    axes : Axes
    histories : mapping
        Label to History.
    optimum : float, optional
        With it, the excess over this value is drawn on a logarithmic scale.
    """
    for k, (label, history) in enumerate(histories.items()):
        best = np.asarray(history.best)
        if optimum is not None:
            best = np.maximum(best - optimum, 1e-12)
        axes.plot(
            np.arange(1, len(best) + 1),
            best,
            color=COLORS[k % len(COLORS)],
            linestyle=DASHES[k % len(DASHES)],
            label=label,
        )
    axes.set_xlabel("iteration")
    if optimum is None:
        axes.set_ylabel("best fitness F")
        axes.set_title("fitness evolution")
    else:
        axes.set_yscale("log")
        axes.set_ylabel("best F − dense-scan optimum")
        axes.set_title("excess over the dense-scan optimum")
    axes.legend(loc="best", handlelength=3)
