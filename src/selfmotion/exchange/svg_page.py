"""The page of an SVG file: how long its user unit is, and where its lower left corner lies."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.svg_xml import Element

_INCH = 0.0254
PIXEL = _INCH / 96
"""Metres in a CSS pixel."""
# Metres in the units that a length may have, and our name for them.
_PHYSICAL = {
    "mm": (1e-3, "mm"), "cm": (1e-2, "cm"), "in": (_INCH, "inch"), "pt": (_INCH / 72, "pt"), "pc": (_INCH / 6, "pc"),
    "Q": (2.5e-4, "Q"),
}  # fmt: skip
_LARGEST = 1e12
_BOX = "the lower left corner of the viewBox"
_LENGTH = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z%]*)\s*")


class Page(NamedTuple):
    """What the outermost svg element says.

    Attributes
    ----------
    unit : str or None
        The physical unit of its size, if it has one.
    metres : tuple of float or None
        The lengths of a user unit along x and y [m], if the size has a physical unit.
    corner : array, shape (2,)
        The lower left corner in user units.
    origin : str
        What it is the corner of.
    """

    unit: str | None
    metres: tuple[float, float] | None
    corner: FloatArray
    origin: str


def page_of(root: Element) -> Page:
    """Return the page of the outermost svg element.

    Raises
    ------
    InvalidInputError
        If its size or viewBox is malformed.
    """
    given = {name: root.attributes[name] for name in ("width", "height") if "%" not in root.attributes.get(name, "%")}
    size = {name: length(text, name, root.line) for name, text in given.items()}
    box = root.attributes.get("viewBox")
    if box is None:
        height = "height" in size
        corner = np.array([0.0, size["height"][0] * _pixels(size["height"][1]) if height else 0.0])
        # Without a viewBox a user unit is a pixel, whatever unit the size is in.
        return Page(
            None, None, corner, "the lower left corner of the page" if height else "that of the file, without a page"
        )
    numbers = box.replace(",", " ").split()
    try:
        x, y, width, height_ = (float(number) for number in numbers)
    except ValueError:
        raise _wrong(root, "viewBox", "is not four numbers", box) from None
    largest = np.abs([x, y, width, height_]).max()
    if not (largest <= _LARGEST and min(width, height_) >= 1 / _LARGEST):
        raise _wrong(root, "viewBox", f"has no size up to {_LARGEST:g}", box)
    corner = np.array([x, y + height_])
    named = {name: unit for name, (_, unit) in size.items() if unit in _PHYSICAL}
    if not named:
        return Page(None, None, corner, _BOX)
    for name, (value, _) in size.items():
        if not value > 0:
            raise _wrong(root, name, "is not positive", root.attributes[name])
    scales = {name: size[name][0] * _PHYSICAL[unit][0] / {"width": width, "height": height_}[name]
              for name, unit in named.items()}  # fmt: skip
    across, along = scales.get("width", scales.get("height", 0.0)), scales.get("height", scales.get("width", 0.0))
    if root.attributes.get("preserveAspectRatio", "").split()[:1] != ["none"]:
        slice_ = root.attributes.get("preserveAspectRatio", "").endswith("slice")
        across = along = max(across, along) if slice_ else min(across, along)
    return Page(_PHYSICAL[next(iter(named.values()))][1], (across, along), corner, _BOX)


def length(text: str, name: str, line: int) -> tuple[float, str]:
    """Return a length's number and unit.

    Raises
    ------
    InvalidInputError
        If it is none.
    """
    found = _LENGTH.fullmatch(text)
    value = float(found[1]) if found else np.nan
    unit = found[2] if found else ""
    if not np.isfinite(value) or abs(value) > _LARGEST or (unit not in _PHYSICAL and unit not in ("", "px")):
        remedy = f"write a number, or one with {', '.join(_PHYSICAL)} or px"
        raise InvalidInputError(f"line {line}, {name}", "is not a length", remedy, text)
    return value, unit


def user_units(text: str, name: str, line: int) -> float:
    """Return a length inside the drawing in user units, of which a pixel is one."""
    value, unit = length(text, name, line)
    return value * _pixels(unit)


def _pixels(unit: str) -> float:
    return _PHYSICAL[unit][0] / PIXEL if unit in _PHYSICAL else 1.0


def _wrong(root: Element, name: str, reason: str, value: str) -> InvalidInputError:
    remedy = "write viewBox as x y width height, all finite"
    return InvalidInputError(f"line {root.line}, {name}", reason, remedy, value)
