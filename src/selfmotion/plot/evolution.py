"""How searches went: best cost against iterations, one search or many of a kind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from selfmotion.plot.style import COLORS, DASHES, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FLOOR = 1e-12
"""Excess over the optimum below which values are rounding; a logarithmic axis ends here."""

# What stands for the cost of a search that has found nothing yet. A quartile between a cost and it lies at least a
# quarter of the way from the one to the other: beyond all costs too.
_NOTHING = 1e300
_BEYOND_COSTS = 0.01 * _NOTHING


def draw_evolution(
    axes: Axes,
    searches: Mapping[str, ArrayLike],
    optimum: float | None = None,
    beside: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Draw the best cost so far against iterations (Fig. 11).

    Parameters
    ----------
    axes : Axes
    searches : mapping
        Label to the best cost after each iteration, NaN before there is one: shape (k,) of one search, or (s, k) of s
        searches, which are drawn as their median with a band between the quartiles.
    optimum : float, optional
        With it, the excess over this value is drawn on a logarithmic scale.
    beside : mapping, optional
        Further searches to compare with, of the same shapes, as thin grey medians.
    """
    for best in (beside or {}).values():
        _, middle, _ = _quartiles(best, optimum)
        axes.plot(np.arange(1, len(middle) + 1), middle, color=GREY, linewidth=0.5, zorder=1.5)
    for k, (label, best) in enumerate(searches.items()):
        low, middle, high = _quartiles(best, optimum)
        iteration = np.arange(1, len(middle) + 1)
        color, dashes = COLORS[k % len(COLORS)], DASHES[(k + k // len(COLORS)) % len(DASHES)]
        if np.ndim(best) == 2:
            axes.fill_between(iteration, low, high, color=color, alpha=0.3, linewidth=0)
        axes.plot(iteration, middle, color=color, linestyle=dashes, label=label)
    axes.set_xlabel("iteration")
    if optimum is None:
        axes.set_ylabel("best F")
    else:
        axes.set_yscale("log")
        axes.set_ylabel("best F − optimum")


def _quartiles(best: ArrayLike, optimum: float | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return lower quartile, median and upper quartile after each iteration, shape (k,) each."""
    values = np.atleast_2d(np.asarray(best, dtype=float))
    if optimum is not None:
        values = np.maximum(values - optimum, FLOOR)
    # A search that has found nothing yet ranks last: the median begins where half of them have found something.
    ranked = np.percentile(np.where(np.isnan(values), _NOTHING, values), [25, 50, 75], axis=0)
    low, middle, high = np.where(ranked < _BEYOND_COSTS, ranked, np.nan)
    return low, middle, high
