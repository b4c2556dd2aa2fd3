"""The angle domain as a picture: feasible u against r."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.domain import AngleDomain
from selfmotion.intervals import TAU, IntervalSet
from selfmotion.plot.style import COLORS, DASHES, INK, REGION

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

_SAMPLES = 801
_BINS = 720


class DomainOutline:
    """The angle domain of one branch, cut open where it leaves a gap and ready to draw.

    Parameters
    ----------
    domain : AngleDomain
    branch : int
    samples : int
        Number of places along the path.

    Attributes
    ----------
    r : array, shape (k,)
    pieces : list of array
        Per r the feasible intervals, shape (m, 2), as real numbers in one common window of width 2π.
    center : float
        Middle of that window.
    """

    def __init__(self, domain: AngleDomain, branch: int, samples: int = _SAMPLES) -> None:
        self.r = np.unique(np.concatenate([np.linspace(0.0, 1.0, samples), domain.path.breaks]))
        arcs = domain.sample(self.r)[branch]
        sets = [arcs.interval_set(k) for k in range(len(self.r))]
        self.center = _open_side(sets)
        self.pieces = [
            IntervalSet(part.intervals - self.center, TAU).pieces + self.center if part else np.empty((0, 2))
            for part in sets
        ]

    def near(self, u: FloatArray) -> FloatArray:
        """Return directions `u` moved by whole turns into the window, as one continuous curve."""
        lifted = np.unwrap(u)
        return np.asarray(lifted - TAU * np.rint((np.mean(lifted) - self.center) / TAU))

    def quads(self) -> list[FloatArray]:
        """Return the region as quadrilaterals between neighbouring samples, each of shape (4, 2)."""
        result = []
        for k in range(len(self.r) - 1):
            left, right = self.r[k], self.r[k + 1]
            for low, high in self.pieces[k]:
                for low2, high2 in self.pieces[k + 1]:
                    if low <= high2 and low2 <= high:
                        result.append(np.array([[left, low], [right, low2], [right, high2], [left, high]]))
        return result


def _open_side(sets: list[IntervalSet]) -> float:
    """Return the window centre that puts the seam where fewest of `sets` reach."""
    middles = (np.arange(_BINS) + 0.5) / _BINS * TAU - np.pi
    cover = np.sum([part.contains(middles) for part in sets if part], axis=0)
    if not np.any(cover):
        return 0.0
    lowest = cover == cover.min()
    if lowest.all():
        return 0.0
    # The middle of the longest run of least cover, on the circle.
    doubled = np.concatenate([lowest, lowest])
    ends = np.flatnonzero(np.diff(np.concatenate([[0], doubled.astype(int), [0]])))
    starts, stops = ends[::2], ends[1::2]
    longest = int(np.argmax(stops - starts))
    seam = middles[((starts[longest] + stops[longest]) // 2) % _BINS]
    center = seam + np.pi
    return float(center - TAU * np.rint(center / TAU))


def draw_domain(
    axes: Axes,
    domain: AngleDomain,
    branch: int,
    curves: Mapping[str, tuple[FloatArray, FloatArray]] | None = None,
) -> None:
    """Draw the angle domain of one branch, and motions through it (the seed's Fig. 6b and 10b).

    Parameters
    ----------
    axes : Axes
    domain : AngleDomain
    branch : int
    curves : mapping, optional
        Label to (r, u), both of shape (k,).
    """
    from matplotlib.collections import LineCollection, PolyCollection

    outline = DomainOutline(domain, branch)
    quads = outline.quads()
    axes.add_collection(PolyCollection(quads, facecolor=REGION, edgecolor=REGION, linewidth=0.3))
    edges = [quad[pair] for quad in quads for pair in ([0, 1], [3, 2])]
    axes.add_collection(LineCollection(edges, colors=INK, linewidths=0.7))
    values = [quad[:, 1] for quad in quads] or [np.array([-np.pi, np.pi])]
    for k, (label, (r, u)) in enumerate((curves or {}).items()):
        near = outline.near(u)
        values.append(near)
        axes.plot(r, near, color=COLORS[k % len(COLORS)], linestyle=DASHES[k % len(DASHES)], label=label)
    low, high = min(v.min() for v in values), max(v.max() for v in values)
    margin = 0.06 * (high - low)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(low - margin, high + margin)
    axes.set_xlabel("path parameter r")
    axes.set_ylabel("direction of the last free link u [rad]")
    axes.set_title(f"angle domain, {domain.self_motion.branches[branch]} elbow")
    if curves:
        axes.legend(loc="best", handlelength=3)
