"""What every picture of the plane is made of: chains of links, circles, angles, a frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.plot.style import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BEHIND_TEXT = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.8}
"""Box that keeps a label readable on top of lines."""
# Height of a line of text and width from which a label is wide [points]; angles that hold a wide one [rad].
_LINE = 8.0
_WIDE = 12.0
_ROOMY = 0.6


def frame(axes: Axes, points: FloatArray, margin: float = 0.14) -> None:
    """Show all of `points`, shape (..., 2), with room for labels around them, both axes to the same scale."""
    points = points.reshape(-1, 2)
    low, high = points.min(axis=0), points.max(axis=0)
    room = margin * float((high - low).max())
    axes.set_xlim(low[0] - room, high[0] + room)
    axes.set_ylim(low[1] - room, high[1] + room)
    axes.set_aspect("equal", adjustable="box")
    axes.set_xlabel("x")
    axes.set_ylabel("y")


def draw_chain(axes: Axes, points: FloatArray, **look: Any) -> None:
    """Draw an arm from its base to its tool, `points` of shape (n + 1, 2), a dot at every joint."""
    axes.plot(points[:, 0], points[:, 1], **{"marker": "o", "linewidth": 0.9, "markersize": 1.8, **look})


def draw_base(axes: Axes) -> None:
    """Mark the base of the arm."""
    axes.plot(0, 0, "^", color=INK, markersize=6, zorder=5)


def draw_circle(axes: Axes, center: FloatArray, radius: float, **look: Any) -> None:
    """Draw a whole circle."""
    ring = ray(center, np.linspace(-np.pi, np.pi, 721), radius)
    axes.plot(ring[:, 0], ring[:, 1], **{"color": INK, "linewidth": 0.8, **look})


def draw_angle(
    axes: Axes, center: FloatArray, start: float, angle: float, radius: float, label: str, width: float = 8.0
) -> None:
    """Mark the signed `angle` from direction `start` at `center` by an arc with an arrow at its end, and a label.

    Parameters
    ----------
    axes : Axes
    center : array, shape (2,)
    start, angle : float
        Direction of the first leg and signed angle from it to the second [rad].
    radius : float
        Of the arc, in data units.
    label : str
        Stands outside the arc; a wide one with no room between the legs stands before the first leg.
    width : float
        Of the label [points].
    """
    arc = ray(center, start + np.linspace(0.0, angle, 181), radius)
    axes.plot(arc[:, 0], arc[:, 1], color=INK, linewidth=0.7, zorder=3)
    before = ray(center, start + angle - np.copysign(min(0.12, abs(angle)), angle), radius)
    tip = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.0, "shrinkA": 0, "shrinkB": 0, "mutation_scale": 6}
    axes.annotate("", tuple(arc[-1]), xytext=tuple(before), arrowprops=tip, zorder=3)
    crowded = width > _WIDE and abs(angle) < _ROOMY
    middle = start - np.copysign(0.3, angle) if crowded else start + 0.5 * angle
    draw_label(axes, label, ray(center, middle, radius), np.array([np.cos(middle), np.sin(middle)]), width)


def draw_label(
    axes: Axes, text: str, point: FloatArray, side: FloatArray, width: float = 8.0, gap: float = 3.0
) -> None:
    """Write a label beside `point`, on the side that the unit vector `side` shows.

    Parameters
    ----------
    axes : Axes
    text : str
    point, side : array, shape (2,)
    width, gap : float
        About the width of the text, and how far from the point it begins [points].
    """
    away = gap + 0.5 * width * abs(side[0]) + 0.5 * _LINE * abs(side[1])
    axes.annotate(
        text, tuple(point), xytext=tuple(away * side), textcoords="offset points", ha="center", va="center",
        color=INK, bbox=BEHIND_TEXT, zorder=6,
    )  # fmt: skip


def ray(center: FloatArray, angle: FloatArray | float, length: float) -> FloatArray:
    """Return the points at `length` from `center` in directions `angle`, shape (..., 2)."""
    return np.asarray(center) + length * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def whole_turn(angle: float) -> float:
    """Return an angle moved into (−π, π]."""
    return float(angle - TAU * np.ceil(angle / TAU - 0.5))
