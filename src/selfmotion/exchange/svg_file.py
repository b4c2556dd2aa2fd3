"""SVG: paths and basic shapes, in the order in which they are drawn, y pointing up."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Literal, Unpack

import numpy as np

from selfmotion._checks import choice
from selfmotion.exchange.drawing import Drawing, drawing
from selfmotion.exchange.reading import Options, Reading, about, read_checked, settled_unit, spelled_out
from selfmotion.exchange.svg_page import PIXEL, Page, page_of
from selfmotion.exchange.svg_shapes import path_parser
from selfmotion.exchange.svg_walk import Walk
from selfmotion.exchange.svg_xml import parse_svg
from selfmotion.units import UNITS

_BEYOND = 3.0  # a drawing larger than so many of its pages is doubtful


@spelled_out
def read_svg(
    file: str | os.PathLike[str],
    unit: Literal["m", "mm", "cm", "inch", "px"] | None = None,
    **options: Unpack[Reading],
) -> Drawing:
    """Read an SVG drawing.

    Parameters
    ----------
    file : path-like
    unit : {"m", "mm", "cm", "inch", "px"}, optional
        Of the drawing's user units. Needed unless the file has a viewBox and a size in physical units, which say it.
        A pixel is 1/96 inch.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        Naming file and line.
    MissingExtraError
        If the package svgpathtools is missing.

    Notes
    -----
    The origin is the lower left corner of the viewBox, or else of the page; y points up. Lines, Bezier curves and arcs
    are exact, under any transform. Text, images and what is hidden are reported; no document type, no entity is read.
    """
    chosen = Options(**options)
    if unit is not None:
        choice("unit", unit, (*UNITS, "px"))
    with about(file):
        return _read(file, unit, chosen)


def _read(file: str | os.PathLike[str], unit: str | None, options: Options) -> Drawing:
    parse = path_parser()
    root = parse_svg(read_checked(file))
    page = page_of(root)
    named, words = settled_unit(unit, page.unit, "the size of its page with a viewBox")
    metres = page.metres or ((PIXEL if named == "px" else UNITS[named]),) * 2
    factors = np.array([options.factor(metres[0]), -options.factor(metres[1])])
    walk = Walk(root, parse)
    # y points down on the page and up in the path.
    strokes = list(walk.strokes(root, (np.diag(factors), -factors * page.corner)))
    notes = [f"the origin is {page.origin}; y points up"]
    made = drawing(
        os.fspath(file), "SVG", words, max(metres), strokes, options, ignored=walk.ledger.entries(), notes=notes
    )
    return replace(made, warnings=(*made.warnings, *_doubts(made, page, named, float(np.abs(factors).min()))))


def _doubts(made: Drawing, page: Page, unit: str, factor: float) -> list[str]:
    """Return what in the file speaks against its unit."""
    doubts = []
    if page.unit is None and page.physical and unit != "px":
        doubts.append(
            f"the page has a size in physical units but no viewBox: by the standard a user unit is then a pixel, and "
            f"{unit} was asked for"
        )
    if page.size is not None and made.extent > _BEYOND * factor * page.size.max():
        times = made.extent / (factor * page.size.max())
        doubts.append(f"what is drawn extends over {times:.3g} times the page")
    return doubts
