"""How a proof went: the gap between the best motion known and the lower bound, round by round."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Literal

import numpy as np

from selfmotion._checks import choice
from selfmotion.certificate.result import Certificate
from selfmotion.plot.domain import legend_below
from selfmotion.plot.style import COLORS, DASHES

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LEAST = 1e-12
_MARKS = ("o", "s", "^", "D", "v", "P")
_WORK = {"cells": "cells looked at so far", "seconds": "time [s]"}


def draw_proof(axes: Axes, proofs: Mapping[str, Certificate], against: Literal["cells", "seconds"] = "cells") -> None:
    """Draw how the gap closed: (cost − bound)/bound after each round, on logarithmic axes.

    Parameters
    ----------
    axes : Axes
    proofs : mapping
        Label to certificate.
    against : {"cells", "seconds"}
        What the work is measured by: cells of all rounds so far, which are the same on every machine, or time.

    Raises
    ------
    InvalidInputError
        If `against` is neither.

    Notes
    -----
    A round that knows no motion yet, or no bound, has no gap.
    """
    against = choice("against", against, tuple(_WORK))  # type: ignore[assignment]
    for k, (label, proof) in enumerate(proofs.items()):
        rows = np.array([(level.cells, level.seconds, level.cost, level.bound) for level in proof.levels]).reshape(
            -1, 4
        )
        work = np.cumsum(rows[:, 0]) if against == "cells" else rows[:, 1]
        cost, bound = rows[:, 2], rows[:, 3]
        known = np.isfinite(cost) & (bound > 0.0)
        gap = np.maximum((cost[known] - bound[known]) / bound[known], _LEAST)
        axes.plot(
            work[known], gap, label=label, color=COLORS[k % len(COLORS)], linestyle=DASHES[k % len(DASHES)],
            marker=_MARKS[k % len(_MARKS)], markersize=3.5,
        )  # fmt: skip
    _label_decades(axes)
    axes.set_xlabel(_WORK[against])
    axes.set_ylabel("(cost − bound)/bound")
    axes.grid(axis="y", color="#e4e4e4", linewidth=0.5)
    axes.set_axisbelow(True)
    legend_below(axes, columns=2)


def _label_decades(axes: Axes) -> None:
    """Make both axes logarithmic: decades of the gap, round numbers of the work."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    axes.set_yscale("log")
    low, high = axes.get_xlim()
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0,) if high > 300 * low else (1.0, 2.0, 5.0)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.10g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    least, most = axes.get_ylim()
    axes.set_ylim(10 ** np.floor(np.log10(least)), 10 ** np.ceil(np.log10(most)))
