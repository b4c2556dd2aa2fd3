"""A drawing as it was understood: what its lines and curves are, where they start, and what is between them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.exchange import Drawing, Subpath
from selfmotion.exchange.pieces import Piece
from selfmotion.plot.plane import BEHIND_TEXT, frame
from selfmotion.plot.style import COLORS, DASHES, GREY, INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Kind of a piece to its name in the legend and its place among the colours.
_KINDS = {
    "line": ("lines", 0),
    "arc": ("arcs", 1),
    "ellipse": ("ellipses", 3),
    "bezier": ("Bezier curves", 2),
    "flattened": ("flattened", 4),
}
_MOST_NUMBERS = 12  # subpaths that are numbered
_MOST_GAPS = 1000
_LONGEST = 5000  # points of one line of many runs
_MOST_POINTS = 200_000  # on curves
_CLEAR = 0.12  # how far an arrow is from the start, among shorter lines, in parts of the drawing
_SEEN = 0.1  # a line shorter than this part of the longest one beside it gets no arrow
_APART = 0.08  # starts nearer than this part of the drawing would have their numbers on each other


def draw_drawing(axes: Axes, drawing: Drawing) -> None:
    """Draw what a file was understood as, seen from above.

    Lines and curves by their kind; a dot and a number where a subpath starts, an arrow for its direction, dots for what
    the path does between subpaths, crosses where nothing was said of it.

    Parameters
    ----------
    axes : Axes
    drawing : Drawing
    """
    pieces = [piece for part in drawing.subpaths for piece in part.pieces]
    curves = sum(piece.curve is not None for piece in pieces)
    count = int(np.clip(_MOST_POINTS / max(curves, 1), 9, 201))
    runs: dict[str, list[FloatArray]] = {}
    for piece in pieces:
        runs.setdefault(piece.kind, []).append(_points(piece, count)[:, :2])
    for kind, found in runs.items():
        name, number = _KINDS[kind]
        for k, x in enumerate(_parted(found)):
            label = None if k else name
            axes.plot(x[:, 0], x[:, 1], color=COLORS[number], linestyle=DASHES[0], linewidth=1.5, label=label, zorder=3)
    _draw_gaps(axes, drawing)
    size = max(float(np.ptp(drawing.bounds[:, :2], axis=0).max()), 1e-300)
    numbered: list[FloatArray] = []
    for k, part in enumerate(drawing.subpaths[:_MOST_NUMBERS]):
        start = part.start[:2]
        axes.plot(*start, "o", color=INK, markersize=3.5, zorder=5)
        _draw_direction(axes, part, _CLEAR * size)
        if all(np.hypot(*(start - other)) > _APART * size for other in numbered):
            axes.annotate(
                str(k), tuple(start), xytext=(5, -10), textcoords="offset points",
                color=INK, zorder=6, bbox=BEHIND_TEXT,
            )  # fmt: skip
            numbered.append(start)
    frame(axes, drawing.bounds[:, :2])
    height = ""
    if drawing.bounds.shape[1] > 2:
        travelled = [piece.points[:, 2] for travel in drawing.travels for piece in travel or ()]
        heights = np.concatenate([drawing.bounds[:, 2], *travelled])
        low, high = heights.min(), heights.max()
        height = f"\nseen from above: z, from {low:.4g} to {high:.4g} {drawing.arm_unit}, is not shown"
    axes.set_xlabel(f"x [{drawing.arm_unit}]{height}")
    axes.set_ylabel(f"y [{drawing.arm_unit}]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, handlelength=2.4, borderaxespad=0.2)


def _draw_gaps(axes: Axes, drawing: Drawing) -> None:
    """Draw how the path gets from one subpath to the next."""
    runs: dict[str | None, list[FloatArray]] = {}
    for k, (gap, travel) in enumerate(zip(drawing.gaps[:_MOST_GAPS], drawing.travels, strict=False)):
        ends = np.stack([drawing.subpaths[k].end, drawing.subpaths[k + 1].start])
        x = np.concatenate([piece.points for piece in travel]) if travel else ends
        runs.setdefault(gap.bridged, []).append(x[:, :2])
    first = f", the first {_MOST_GAPS}" if len(drawing.gaps) > _MOST_GAPS else ""
    for bridged, found in runs.items():
        for k, x in enumerate(_parted(found)):
            label = f"gap: {bridged}{first}" if bridged else f"gap, not bridged{first}"
            axes.plot(
                x[:, 0], x[:, 1], color=GREY, linestyle=DASHES[2], linewidth=1.0, marker="" if bridged else "x",
                markersize=5, label=None if k else label, zorder=4,
            )  # fmt: skip


def _draw_direction(axes: Axes, part: Subpath, clear: float) -> None:
    """Draw an arrow half-way along the first line or curve of a subpath that is not seen end-on, as a plunge is.

    Among lines shorter than `clear` it is that far along them, where the dot at the start does not hide it.
    """
    for piece in part.pieces:
        x = _points(piece)[:, :2]
        steps = np.hypot(*np.diff(x, axis=0).T)
        if piece.curve is None:
            seen = np.flatnonzero(steps > _SEEN * steps.max(initial=0.0))
            if len(seen) and steps.max() > 0:
                first, far = seen[0], np.cumsum(steps)
                if steps[first] < clear:
                    first = max(first, np.searchsorted(far, min(clear, 0.5 * far[-1])))
                x = np.linspace(x[first], x[first + 1], 21)
            else:
                x = x[:1]
        if len(x) > 1:
            break
    else:
        return
    middle = len(x) // 2
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 10}
    axes.annotate("", tuple(x[middle]), xytext=tuple(x[middle - 1]), arrowprops=arrow, zorder=4)


def _points(piece: Piece, count: int = 201) -> FloatArray:
    return piece.points if piece.curve is None else piece.curve(np.linspace(0.0, 1.0, count))


def _parted(runs: list[FloatArray]) -> Iterator[FloatArray]:
    """Yield runs of points as few arrays, NaN between the runs of one.

    One line is drawn faster than thousands; one that is too long is more than the renderer has cells for.
    """
    apart = np.full((1, 2), np.nan)
    waiting: list[FloatArray] = []
    count = 0
    for run in runs:
        waiting += [run, apart]
        count += len(run) + 1
        if count > _LONGEST:
            yield np.concatenate(waiting[:-1])
            waiting, count = [], 0
    if waiting:
        yield np.concatenate(waiting[:-1])
