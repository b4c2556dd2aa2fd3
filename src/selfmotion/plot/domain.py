"""The angle domain as a picture: feasible u against r."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.domain import AngleDomain
from selfmotion.intervals import IntervalSet
from selfmotion.plot.style import COLORS, DASHES, INK, REGION

if TYPE_CHECKING:
    from collections.abc import Mapping

    from matplotlib.axes import Axes

_SAMPLES = 801
_BINS = 720


_Rows = list[tuple[float, float, float]]


class Strip(NamedTuple):
    """A part of the region that is one interval wide.

    Attributes
    ----------
    rows : array, shape (k, 3)
        (r, lower, upper).
    low_edge, high_edge : bool
        Whether its lower and upper side bound the region.
    """

    rows: FloatArray
    low_edge: bool = True
    high_edge: bool = True


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
        self.r = domain.path.grid(samples - 1)
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

    def strips(self) -> list[Strip]:
        """Return the region as strips that neither split nor merge, and what joins them.

        A strip goes on while its interval overlaps exactly one interval of the next sample and is the only one to
        do so; single points belong to none. Where intervals split or merge, joining pieces bridge the two samples;
        only their outer edges are edges of the region.
        """
        done: list[Strip] = []
        running: list[_Rows] = []
        for k, r in enumerate(self.r):
            here = [(float(r), float(low), float(high)) for low, high in self.pieces[k] if high > low]
            links = [[t for t in here if t[1] <= rows[-1][2] and rows[-1][1] <= t[2]] for rows in running]
            following: list[_Rows] = []
            continued = []
            for rows, matches in zip(running, links, strict=True):
                if len(matches) == 1 and sum(matches[0] in other for other in links) == 1:
                    following.append([*rows, matches[0]])
                    continued.append(matches[0])
                    continue
                done.append(Strip(np.array(rows)))
                for match in matches:
                    sources = [other[-1] for other, found in zip(running, links, strict=True) if match in found]
                    lowest = rows[-1] == min(sources) and match == min(matches)
                    highest = rows[-1] == max(sources) and match == max(matches)
                    done.append(Strip(np.array([rows[-1], match]), lowest, highest))
            following += [[piece] for piece in here if piece not in continued]
            running = following
        return done + [Strip(np.array(rows)) for rows in running]

    def fronts(self) -> list[tuple[float, float, float]]:
        """Return the edges across u as (r, lower, upper): where intervals open, close, split or merge."""
        found = []
        for k in range(len(self.r) - 1):
            for at, beyond, r in ((k, k + 1, self.r[k]), (k + 1, k, self.r[k + 1])):
                for low, high in self.pieces[at]:
                    near = [piece for piece in self.pieces[beyond] if piece[0] <= high and low <= piece[1]]
                    if not near:
                        found.append((r, low, high))
                    found += [(self.r[beyond], a[1], b[0]) for a, b in itertools.pairwise(near)]
        return [(float(r), float(low), float(high)) for r, low, high in found if high > low]

    def open_edge(self, u: FloatArray) -> FloatArray:
        """Return `u`, NaN where it is only the seam at which the window is cut and no end of an interval."""
        return np.where(np.abs(np.abs(u - self.center) - np.pi) < 1e-9, np.nan, u)

    def points(self) -> FloatArray:
        """Return where a single posture is feasible, such as a fold, as rows (r, u)."""
        columns = zip(self.r, self.pieces, strict=True)
        found = [(r, low) for r, pieces in columns for low, high in pieces if low == high]
        return np.array(found).reshape(-1, 2)


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
    return float(wrap(center))


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
    outline = DomainOutline(domain, branch)
    strips = outline.strips()
    for strip in strips:
        r, low, high = strip.rows.T
        axes.fill_between(r, low, high, color=REGION, linewidth=0.3)
        for edge, shown in ((low, strip.low_edge), (high, strip.high_edge)):
            if shown:
                axes.plot(r, outline.open_edge(edge), color=INK, linewidth=0.8)
    for r, low, high in outline.fronts():
        axes.plot([r, r], [low, high], color=INK, linewidth=0.8)
    points = outline.points()
    axes.plot(points[:, 0], points[:, 1], ".", color=INK, markersize=1.2, markeredgewidth=0)
    values = [strip.rows[:, 1:] for strip in strips] + [points[:, 1]]
    for k, (label, (r, u)) in enumerate((curves or {}).items()):
        near = outline.near(u)
        values.append(near)
        axes.plot(r, near, color=COLORS[k % len(COLORS)], linestyle=DASHES[k % len(DASHES)], label=label)
    extent = np.concatenate([np.ravel(part) for part in values])
    low, high = (extent.min(), extent.max()) if len(extent) else (-np.pi, np.pi)
    margin = 0.06 * max(high - low, 1e-3)
    axes.set_xlim(0.0, 1.0)
    axes.set_ylim(low - margin, high + margin)
    axes.set_xlabel("path parameter r")
    axes.set_ylabel("redundancy parameter u [rad]")
    remark = "" if strips else ": single postures only" if len(points) else ": empty"
    axes.set_title(f"angle domain, {domain.self_motion.branches[branch]} elbow{remark}")
    if curves:
        axes.legend(loc="best", handlelength=3)
