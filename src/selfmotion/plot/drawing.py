"""A drawing as it was understood: what its lines and curves are, where they start, and what is between them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.exchange import Drawing
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
    labels = set()
    for part in drawing.subpaths:
        for piece in part.pieces:
            name, number = _KINDS[piece.kind]
            x = _points(piece)
            label = None if name in labels else name
            labels.add(name)
            axes.plot(x[:, 0], x[:, 1], color=COLORS[number], linestyle=DASHES[0], linewidth=1.5, label=label, zorder=3)
    _draw_gaps(axes, drawing)
    size = max(float(np.ptp(drawing.bounds[:, :2], axis=0).max()), 1e-300)
    numbered: list[FloatArray] = []
    for k, part in enumerate(drawing.subpaths[:_MOST_NUMBERS]):
        start = part.start[:2]
        axes.plot(*start, "o", color=INK, markersize=3.5, zorder=5)
        _draw_direction(axes, part.pieces[0])
        if all(np.hypot(*(start - other)) > _APART * size for other in numbered):
            axes.annotate(
                str(k), tuple(start), xytext=(5, -10), textcoords="offset points",
                color=INK, zorder=6, bbox=BEHIND_TEXT,
            )  # fmt: skip
            numbered.append(start)
    frame(axes, drawing.bounds[:, :2])
    axes.set_xlabel(f"x [{drawing.arm_unit}]")
    axes.set_ylabel(f"y [{drawing.arm_unit}]")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, handlelength=2.4, borderaxespad=0.2)


def _draw_gaps(axes: Axes, drawing: Drawing) -> None:
    """Draw how the path gets from one subpath to the next."""
    labels = set()
    for k, (gap, travel) in enumerate(zip(drawing.gaps, drawing.travels, strict=True)):
        ends = np.stack([drawing.subpaths[k].end, drawing.subpaths[k + 1].start])
        x = np.concatenate([piece.points for piece in travel])[:, :2] if travel else ends[:, :2]
        name = f"gap: {gap.bridged}" if gap.bridged else "gap, not bridged"
        label = None if name in labels else name
        labels.add(name)
        marker = "" if gap.bridged else "x"
        axes.plot(
            x[:, 0], x[:, 1], color=GREY, linestyle=DASHES[2], linewidth=1.0, marker=marker, markersize=5,
            label=label, zorder=2,
        )  # fmt: skip


def _draw_direction(axes: Axes, piece: Piece) -> None:
    """Draw an arrow half-way along the first line or curve of a subpath."""
    x = _points(piece)[:, :2] if piece.curve is not None else piece.points[:2, :2]
    middle = len(x) // 2
    before, after = (x[middle - 1], x[middle]) if len(x) > 2 else (x[0], x.mean(axis=0))
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 8}
    axes.annotate("", tuple(after), xytext=tuple(before), arrowprops=arrow, zorder=4)


def _points(piece: Piece) -> FloatArray:
    return piece.points if piece.curve is None else piece.curve(np.linspace(0.0, 1.0, 201))
