"""Figures without pyplot: one look, no global state, the same bytes from the same data."""

from __future__ import annotations

import io
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from selfmotion.plot.data import figure_data

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's colours, told apart by the colour-blind; paired with dashes so that grey print works too.
INK = "#222222"
GREY = "#8a8a8a"
REGION = "#dce6ee"
BEYOND = "#ececec"
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
OBSTACLES = ("#7b3294", "#8c510a", "#4d7c0f", "#b3123b", "#35688c", "#6b6b00")
"""Colours of obstacles, apart from those of joints."""
DASHES = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)), (0, (3, 1)), (0, (8, 2)))

_SETTINGS: dict[Any, Any] = {
    "font.size": 8.0,
    "axes.titlesize": 8.5,
    "axes.labelsize": 8.0,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "svg.hashsalt": "selfmotion",
    "svg.fonttype": "path",
}
COLUMN = 3.5
"""Width of one printed column [inch]."""
_LONGEST = 20  # letters of a name that someone gave


def literal(name: str) -> str:
    """Return a name that someone gave as it is drawn: letter by letter, no formulas, and cut where it is too long."""
    short = name if len(name) <= _LONGEST else name[: _LONGEST - 1] + "…"
    return short.replace("$", r"\$")


def tinted(color: str, part: float = 0.3) -> tuple[float, float, float]:
    """Return a colour mixed with white, `part` of it being the colour."""
    from matplotlib.colors import to_rgb

    red, green, blue = (1.0 - part * (1.0 - level) for level in to_rgb(color))
    return red, green, blue


def shades(count: int) -> list[tuple[float, float, float]]:
    """Return `count` greys from light to dark, for postures in their order."""
    steps = [k / max(count - 1, 1) for k in range(count)]
    return [(level, level, level) for level in (0.78 - 0.65 * step for step in steps)]


@contextmanager
def figure(
    width: float = COLUMN, height: float = 2.6, columns: int = 1, rows: int = 1
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Give a figure and its axes, row by row, in the house's look.

    Parameters
    ----------
    width, height : float
        Size of the whole figure [inch].
    columns, rows : int
        Number of axes side by side, and of rows of them.

    Yields
    ------
    canvas : matplotlib Figure
    axes : list of Axes
    """
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context(_SETTINGS):
        canvas = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(canvas)
        yield canvas, [canvas.add_subplot(rows, columns, k + 1) for k in range(rows * columns)]


def rendered(
    name: str, draw: Callable[..., None], *args: object, forms: Sequence[str] = ("png", "svg"), **size: float
) -> dict[str, bytes]:
    """Return one drawing as ``name.png`` and ``name.svg``, or as one of `forms` only.

    Parameters
    ----------
    name : str
    draw : callable
        Takes an Axes and `args`.
    *args
    forms : sequence of str
        As of :func:`image_files`.
    **size
        Passed on to :func:`figure`.

    Returns
    -------
    dict
    """
    with figure(**size) as (canvas, (axes,)):  # type: ignore[arg-type]
        draw(axes, *args)
        return image_files(name, canvas, forms=forms)


def image_files(
    name: str, canvas: Figure, data: bool = False, forms: Sequence[str] = ("png", "svg")
) -> dict[str, bytes]:
    """Return a finished figure as ``name.png`` and ``name.svg``; call it inside :func:`figure`.

    Parameters
    ----------
    name : str
    canvas : matplotlib Figure
    data : bool
        Whether to add ``name.json``, what the figure shows as :func:`~selfmotion.plot.data.figure_data` reads it back.
    forms : sequence of {"png", "svg"}

    Returns
    -------
    dict
    """
    files = {}
    for suffix, options in (
        ("png", {"dpi": 220, "metadata": {"Software": "selfmotion"}}),
        ("svg", {"metadata": {"Creator": "selfmotion", "Date": None}}),
    ):
        if suffix not in forms:
            continue
        buffer = io.BytesIO()
        canvas.savefig(buffer, format=suffix, **options)
        files[f"{name}.{suffix}"] = buffer.getvalue()
    if data:
        files[f"{name}.json"] = (json.dumps(figure_data(canvas), allow_nan=False) + "\n").encode()
    return files
