"""Flow charts of the optimizers, drawn from what their code says it does (Figs 7–9)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import AskTell
from selfmotion.plot.style import COLUMN, INK, REGION, figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

QUESTION = "budget spent: all iterations done?"
AFTER = ("verify the candidates between the samples, best first", "the first that holds is the plan")
"""What the planner does when the optimizer is done."""

_FONT = 7.0
# Room around a text inside its box, beside the boxes for the way back, and between boxes [points].
_PAD = 4.0
_LANE = 16.0
_GAP, _LEAST_GAP = 13.0, 10.0
_SLANT = 9.0


class _Box(NamedTuple):
    """A text broken into lines, and the height of its box [points]."""

    text: str
    height: float


def draw_flow(axes: Axes, optimizer: type[AskTell] | AskTell) -> None:
    """Draw the flow of an ask/tell optimizer inside the planner: start, the loop over its `steps`, verification, plan.

    Parameters
    ----------
    axes : Axes
        High enough for the boxes, see :func:`flow_height`; its figure is laid out here to measure the texts.
    optimizer : AskTell
        Class or instance.

    Raises
    ------
    InvalidInputError
        If the boxes do not fit into the axes.
    """
    from matplotlib.patches import FancyBboxPatch, Polygon

    kind = optimizer if isinstance(optimizer, type) else type(optimizer)
    axes.set_title(kind.__name__)
    boxes, width, height = _measure(axes, kind)
    gap = (height - sum(box.height for box in boxes)) / (len(boxes) - 1)
    if gap < _LEAST_GAP:
        needed = (len(boxes) - 1) * (_LEAST_GAP - gap) / 72
        raise InvalidInputError("axes", f"are {needed:.2f} inch too low for the boxes", "ask flow_height for a height")
    gap = min(gap, 1.5 * _GAP)
    right = width - _LANE
    middle = 0.5 * right
    question = len(kind.steps)
    centers: list[float] = []
    tops: list[float] = []
    top = height
    for k, box in enumerate(boxes):
        bottom, center = top - box.height, top - 0.5 * box.height
        look: dict[str, Any] = {"edgecolor": INK, "linewidth": 0.8, "gid": f"box-{k}"}
        if k == question:
            corners = [(0.5, center), (_SLANT, top), (right - _SLANT, top), (right, center)]
            axes.add_patch(Polygon([*corners, (right - _SLANT, bottom), (_SLANT, bottom)], facecolor=REGION, **look))
        else:
            style = "round,pad=0,rounding_size=3" if 0 < k < len(boxes) - 1 else "round,pad=0,rounding_size=6"
            fill = "white" if 0 < k < len(boxes) - 1 else REGION
            shape = FancyBboxPatch((0.5, bottom), right - 0.5, box.height, boxstyle=style, facecolor=fill, **look)
            axes.add_patch(shape)
        axes.text(middle, center, box.text, ha="center", va="center", fontsize=_FONT, color=INK, gid=f"text-{k}")
        if k:
            _arrow(axes, [(middle, tops[-1] - boxes[k - 1].height), (middle, top)])
        centers.append(center)
        tops.append(top)
        top = bottom - gap
    lane = width - 3.0
    _arrow(axes, [(right, centers[question]), (lane, centers[question]), (lane, centers[1]), (right, centers[1])])
    axes.text(lane - 1, centers[question] - 2, "no", ha="right", va="top", fontsize=_FONT - 0.5, color=INK)
    below = tops[question] - boxes[question].height - 0.5 * gap
    axes.text(middle + 4, below, "yes", ha="left", va="center", fontsize=_FONT - 0.5, color=INK)


def flow_height(optimizer: type[AskTell] | AskTell, width: float = COLUMN) -> float:
    """Return the height of a figure that the flow of an optimizer fills nicely, both in inches.

    Parameters
    ----------
    optimizer : AskTell
        Or its class.
    width : float
        Of the figure [inch].

    Returns
    -------
    float
    """
    kind = optimizer if isinstance(optimizer, type) else type(optimizer)
    with figure(width=width, height=10.0) as (_, (axes,)):
        axes.set_title(kind.__name__)
        boxes, _, height = _measure(axes, kind)
    around = 10.0 - height / 72
    return around + (sum(box.height for box in boxes) + _GAP * (len(boxes) - 1)) / 72


def _measure(axes: Axes, kind: type[AskTell]) -> tuple[list[_Box], float, float]:
    """Return all boxes, with texts that fit the width of the axes, and the size of the axes; data become points."""
    canvas = axes.get_figure(root=True)
    assert canvas is not None
    axes.set_axis_off()
    canvas.draw_without_rendering()  # the layout is known only now
    extent = axes.get_window_extent()
    scale = 72 / canvas.dpi
    width, height = extent.width * scale, extent.height * scale
    axes.set_xlim(0, width)
    axes.set_ylim(0, height)
    texts = [*kind.steps, QUESTION, *AFTER]
    room = width - _LANE - 2 * (_PAD + _SLANT)
    probe = axes.text(0, 0, "", fontsize=_FONT)
    boxes = []
    for text in texts:
        broken: list[str] = []
        for line in text.split("\n"):
            first, *words = line.split(" ")
            broken.append(first)
            for word in words:
                probe.set_text(f"{broken[-1]} {word}")
                if probe.get_window_extent().width * scale <= room:
                    broken[-1] = probe.get_text()
                else:
                    broken.append(word)
        probe.set_text("\n".join(broken))
        boxes.append(_Box(probe.get_text(), probe.get_window_extent().height * scale + 2 * _PAD))
    probe.remove()
    return boxes, width, height


def _arrow(axes: Axes, corners: list[tuple[float, float]]) -> None:
    """Draw a line through `corners` that ends in an arrow."""
    axes.plot(*zip(*corners, strict=True), color=INK, linewidth=0.8)
    look = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8, "mutation_scale": 7, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", corners[-1], xytext=corners[-2], arrowprops=look)
