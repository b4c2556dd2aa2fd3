"""Holes that obstacles make in an angle domain: filled in the obstacle's colour, the largest ones named."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.domain.holes import Hole
from selfmotion.plot.style import GREY, INK, OBSTACLES, literal, tinted
from selfmotion.plot.window import Window

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Piece(NamedTuple):
    """A part of a hole as it is drawn: r, low and high, (k,) each, and whether both are its ends."""

    r: FloatArray
    low: FloatArray
    high: FloatArray
    has_ends: bool


_MOST_NAMED = 4
_SEEN = 0.008  # part of the picture that a hole with a name takes at least
_HELD = 0.6  # part of a name that its hole must hold
_FONT = 6.5
_LETTER = 0.55  # width of a letter as a part of its height
_BESIDE = 0.55  # of a name, from its middle to the edge of the picture
_OBSTACLE = re.compile(r"obstacle (\d+)(?: \((.+)\))?$", re.DOTALL)
_SIDE = re.compile(r"(.+?) against (.+)$", re.DOTALL)


def number_of(met: str) -> int | None:
    """Return which obstacle is met, counted from 0; None if it is none."""
    found = _OBSTACLE.match(met)
    return int(found[1]) - 1 if found else None


def color_of(met: str) -> str:
    """Return the colour of what is met, the same as in pictures of the arm."""
    number = number_of(met)
    return GREY if number is None else OBSTACLES[number % len(OBSTACLES)]


def name_of(met: str) -> str:
    """Return what is met by its own name if it has one: ``"clamp"`` of ``"obstacle 2 (clamp)"``."""
    found = _OBSTACLE.match(met)
    return found[2] if found and found[2] else met


def contact_name(cause: str) -> str:
    """Return a cause in short: ``"clamp × link 3"`` of ``"link 3 against obstacle 2 (clamp)"``."""
    found = _SIDE.match(cause)
    return f"{literal(name_of(found[2]))} × {literal(found[1])}" if found else literal(cause)


def in_window(hole: Hole, window: Window) -> tuple[list[Piece], tuple[float, float]]:
    """Return the pieces of a hole in a window of u, and the place of its name."""
    pieces = [
        Piece(strip.r, low, high, bool(strip.causes[0]))
        for strip in hole.strips for low, high in window.copies(strip) if (high > low).any()
    ]  # fmt: skip
    return pieces, (hole.at[0], float(window.wrapped(np.asarray(hole.at[1]))))


def fill_holes(axes: Axes, holes: Iterable[tuple[Hole, Sequence[Piece], tuple[float, float]]]) -> None:
    """Fill holes, and write into the largest of them what causes them.

    Parameters
    ----------
    axes : Axes
        With its limits set.
    holes : iterable of tuple
        Each with its pieces and the place of its name in the chart; all are named in a legend, too.
    """
    from matplotlib.patheffects import withStroke

    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    written: list[tuple[float, float, float]] = []
    box = axes.get_window_extent().transformed(axes.figure.dpi_scale_trans.inverted())
    line = _FONT / 72
    for hole, pieces, (r, u) in sorted(holes, key=lambda one: -one[0].size):
        color, label, area = color_of(hole.by), contact_name(hole.cause), 0.0
        for along, low, high, has_ends in pieces:
            axes.fill_between(
                along, low, high, where=high > low, color=tinted(color), linewidth=0.3, label=label, zorder=2.5
            )
            for edge in (low, high) if has_ends else ():
                axes.plot(along, np.where(high > low, edge, np.nan), color=color, linewidth=0.7, zorder=2.6)
            label = "_"
            area += float(np.sum(0.5 * (high[1:] - low[1:] + high[:-1] - low[:-1]) * np.diff(along)))
        text = contact_name(hole.cause)
        wide, tall = _LETTER * line * len(text) / box.width, 1.3 * line / box.height
        x, y = (r - left) / (right - left), (u - bottom) / (top - bottom)
        x, y = min(max(x, _BESIDE * wide), 1.0 - _BESIDE * wide), min(max(y, tall), 1.0 - tall)
        room = max((_across(piece, u, r) for piece in pieces), default=0.0) / (right - left)
        free = room > _HELD * wide and all(abs(x - a) > 0.5 * (wide + w) or abs(y - b) > tall for a, b, w in written)
        if len(written) < _MOST_NAMED and free and area > _SEEN * (right - left) * (top - bottom):
            axes.text(
                x, y, text, transform=axes.transAxes, ha="center", va="center", fontsize=_FONT, color=INK, zorder=6,
                path_effects=[withStroke(linewidth=1.8, foreground=tinted(color))],
            )  # fmt: skip
            written.append((x, y, wide))


def _across(piece: Piece, u: float, r: float) -> float:
    """Return how wide a piece is at u, about r."""
    x, low, high, _ = piece
    inside = (low <= u) & (u <= high)
    k = int(np.abs(x - r).argmin())
    if not inside[k]:
        return 0.0
    outside = np.flatnonzero(~inside)
    before, after = outside[outside < k], outside[outside > k]
    return float(x[after[0] if len(after) else -1] - x[before[-1] if len(before) else 0])
