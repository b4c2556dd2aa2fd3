"""What a finished figure shows, as plain data: so that "the same figure" can be tested to the last bit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion._types import FloatArray

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.collections import Collection
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.text import Text


def figure_data(canvas: Figure) -> dict[str, Any]:
    """Read back everything that a figure shows.

    Parameters
    ----------
    canvas : matplotlib Figure
        Finished; draw or save it first, so that limits and ticks are those of the picture.

    Returns
    -------
    dict
        ``size`` [inch], ``texts``, and for each of ``axes`` its title, labels, scales, limits, ticks and legend, with
        the data of its ``lines``, ``collections``, ``patches``, ``images`` and ``texts`` in the order they were added.
        Made of dicts, lists, strings and numbers only; what is not finite is None. The same figure, the same data.
    """
    return {
        "size": _plain(canvas.get_size_inches()),
        "texts": [_text(text) for text in canvas.texts],
        "axes": [_axes(axes) for axes in canvas.axes],
    }


def _axes(axes: Axes) -> dict[str, Any]:
    from matplotlib.axes import Axes

    legend = axes.get_legend()
    return {
        "title": axes.get_title(),
        "x": _axis(axes, "x"),
        "y": _axis(axes, "y"),
        "legend": [] if legend is None else [text.get_text() for text in legend.get_texts()],
        "lines": [_line(line) for line in axes.lines],
        "collections": [_collection(collection) for collection in axes.collections],
        "patches": [_patch(patch) for patch in axes.patches],
        "images": [_image(image) for image in axes.images],
        "texts": [_text(text) for text in axes.texts],
        "insets": [_axes(inset) for inset in axes.child_axes if isinstance(inset, Axes)],
    }


def _axis(axes: Axes, name: str) -> dict[str, Any]:
    axis = axes.xaxis if name == "x" else axes.yaxis
    return {
        "label": axis.get_label_text(),
        "scale": axis.get_scale(),
        "limits": _plain(axes.get_xlim() if name == "x" else axes.get_ylim()),
        "ticks": _plain(axis.get_ticklocs()),
        "tick_labels": [label.get_text() for label in axis.get_ticklabels()],
    }


def _line(line: Line2D) -> dict[str, Any]:
    return {"label": _label(line), "x": _plain(line.get_xdata(orig=False)), "y": _plain(line.get_ydata(orig=False))}


def _collection(collection: Collection) -> dict[str, Any]:
    """Return the shapes of a collection and where they are put: areas, line collections, scatter marks."""
    return {
        "kind": type(collection).__name__,
        "label": _label(collection),
        "vertices": [_plain(path.vertices) for path in collection.get_paths()],
        "offsets": _plain(collection.get_offsets()),
        "values": _plain(collection.get_array()),
    }


def _patch(patch: Patch) -> dict[str, Any]:
    shape = patch.get_path().transformed(patch.get_patch_transform())
    return {"kind": type(patch).__name__, "label": _label(patch), "vertices": _plain(shape.vertices)}


def _image(image: AxesImage) -> dict[str, Any]:
    return {"label": _label(image), "extent": _plain(image.get_extent()), "values": _plain(image.get_array())}


def _text(text: Text) -> dict[str, Any]:
    """Return a text and its place; an annotation's `at` is the point that it speaks of."""
    place = {"text": text.get_text(), "position": _plain(text.get_position())}
    at = getattr(text, "xy", None)
    return place if at is None else {**place, "at": _plain(at)}


def _label(artist: Artist) -> str:
    """Return the label that was given; matplotlib's own, with a leading underscore, say nothing."""
    label = str(artist.get_label())
    return "" if label.startswith("_") else label


def _plain(values: Any) -> Any:
    """Return numbers as nested lists of Python numbers, None where one is masked or not finite."""
    if values is None:
        return None
    array: FloatArray = np.ma.filled(np.ma.asarray(values, dtype=float), np.nan)
    plain = array.astype(object)
    plain[~np.isfinite(array)] = None
    return plain.tolist()
