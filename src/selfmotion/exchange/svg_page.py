"""Pages of SVG: how long the user unit is, where the lower left corner lies, and what pages within it are moved by."""

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
_LENGTH = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([A-Za-z%]*)\s*", re.ASCII)
_STYLED = re.compile(r"(?:^|;)\s*(width|height)\s*:\s*([^;!]*)")

Affine = tuple[FloatArray, FloatArray]
"""``x ↦ M x + shift``"""


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
    size : array, shape (2,), or None
        In user units, if it has one.
    physical : bool
        Whether a length of it has a physical unit, which without a viewBox says nothing of the user unit.
    """

    unit: str | None
    metres: tuple[float, float] | None
    corner: FloatArray
    origin: str
    size: FloatArray | None = None
    physical: bool = False


def page_of(root: Element) -> Page:
    """Return the page of the outermost svg element.

    Raises
    ------
    InvalidInputError
        If its size or viewBox is malformed.
    """
    # A style overrides an attribute.
    said = root.attributes | {name: text.strip() for name, text in _STYLED.findall(root.attributes.get("style", ""))}
    given = {name: said[name] for name in ("width", "height") if name in said and "%" not in said[name] != "auto"}
    size = {name: length(text, name, root.line) for name, text in given.items()}
    named = {name: unit for name, (_, unit) in size.items() if unit in _PHYSICAL}
    if "viewBox" not in root.attributes:
        # Without a viewBox a user unit is a pixel, whatever unit the size is in.
        pixels = np.array(
            [size[name][0] * _pixels(size[name][1]) if name in size else 0.0 for name in ("width", "height")]
        )
        whose = "the lower left corner of the page" if "height" in size else "that of the file, without a page"
        full = pixels if (pixels > 0).all() else None
        return Page(None, None, np.array([0.0, pixels[1]]), whose, full, bool(named))
    x, y, width, height_ = _box(root)
    corner = np.array([x, y + height_])
    inner = np.array([width, height_])
    if not named:
        return Page(None, None, corner, _BOX, inner)
    for name, (value, _) in size.items():
        if not value > 0:
            raise _wrong(root, name, "is not positive", root.attributes[name])
    scales = {name: size[name][0] * _PHYSICAL[unit][0] / {"width": width, "height": height_}[name]
              for name, unit in named.items()}  # fmt: skip
    across, along = scales.get("width", scales.get("height", 0.0)), scales.get("height", scales.get("width", 0.0))
    align, covers = _fitting(root)
    if align != "none":
        across = along = max(across, along) if covers else min(across, along)
    return Page(_PHYSICAL[next(iter(named.values()))][1], (across, along), corner, _BOX, inner, True)


def inner_page(page: Element, sized: Element) -> Affine:
    """Return what moves the coordinates inside a page within the page to those around it.

    Parameters
    ----------
    page : Element
        An svg or symbol element.
    sized : Element
        What says where it is and how large: the same, or the use element that shows it.

    Raises
    ------
    InvalidInputError
        If it has a viewBox and no size.
    """
    shift = np.array([user_units(sized.attributes.get(name, "0"), name, sized.line) for name in ("x", "y")])
    if "viewBox" not in page.attributes:
        return np.eye(2), shift
    size = []
    for name in ("width", "height"):
        text = sized.attributes.get(name, page.attributes.get(name, ""))
        if not text or "%" in text or text == "auto":
            raise _wrong(page, name, "is missing: it is a page within the page, with a viewBox", text or "nothing")
        size.append(user_units(text, name, sized.line))
    x, y, *extent = _box(page)
    room, box = np.array(size), np.array(extent)
    scales = room / box
    align, covers = _fitting(page)
    if align != "none":
        scales = np.full(2, scales.max() if covers else scales.min())
        parts = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}
        at = re.fullmatch("x(Min|Mid|Max)Y(Min|Mid|Max)", align)
        shares = np.array([parts[at[1]], parts[at[2]]] if at else [0.5, 0.5])
        shift = shift + shares * (room - scales * box)
    return np.diag(scales), shift - scales * [x, y]


def _box(element: Element) -> tuple[float, float, float, float]:
    """Return the four numbers of a viewBox."""
    text = element.attributes["viewBox"]
    try:
        x, y, width, height = (float(number) for number in text.replace(",", " ").split())
    except ValueError:
        raise _wrong(element, "viewBox", "is not four numbers", text) from None
    largest = np.abs([x, y, width, height]).max()
    if not (largest <= _LARGEST and min(width, height) >= 1 / _LARGEST):
        raise _wrong(element, "viewBox", f"has no size up to {_LARGEST:g}", text)
    return x, y, width, height


def _fitting(element: Element) -> tuple[str, bool]:
    """Return how a viewBox is aligned in its page, and whether it covers all of that."""
    words = element.attributes.get("preserveAspectRatio", "").split()
    return (words[0] if words else "xMidYMid"), words[1:] == ["slice"]


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
    remedy = "write viewBox as x y width height, all finite, and width and height as lengths"
    return InvalidInputError(f"line {root.line}, {name}", reason, remedy, value)
