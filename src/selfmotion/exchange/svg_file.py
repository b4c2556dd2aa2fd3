"""SVG: paths and basic shapes, in the order in which they are drawn, y pointing up."""

from __future__ import annotations

import os
import re
import warnings
from collections.abc import Callable, Iterator
from typing import Any, Literal

import numpy as np

from selfmotion._checks import choice
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.drawing import (
    MOST_SEGMENTS,
    TOO_MANY,
    Drawing,
    Ledger,
    Options,
    drawing,
    needs_extra,
    read_checked,
    settled_unit,
)
from selfmotion.exchange.files import UNITS
from selfmotion.exchange.pieces import Piece, bezier, elliptic, line
from selfmotion.exchange.svg_page import PIXEL, page_of, user_units
from selfmotion.exchange.svg_xml import Element, parse_svg

_GROUPS = ("svg", "g", "a", "switch")
_SHAPES = ("path", "line", "polyline", "polygon", "rect", "circle", "ellipse")
# Elements that draw nothing themselves; what stands in them is drawn where something refers to it.
_SILENT = (
    "", "defs", "symbol", "title", "desc", "metadata", "clipPath", "mask", "marker", "pattern", "linearGradient",
    "radialGradient", "filter", "script", "view", "animate", "animateTransform", "animateMotion", "set",
)  # fmt: skip
_PATH_DATA = re.compile(r"[MmZzLlHhVvCcSsQqTtAaEe0-9+\-.,\s]*")
_NUMBERS = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_POINTS = re.compile(rf"\s*(?:{_NUMBERS.pattern}(?:[\s,]+|(?=[+-])|$))*\s*")
_UNSEEN = ("hidden", "collapse")
_HIDDEN = re.compile(r"(?:^|;)\s*(?:display\s*:\s*none|visibility\s*:\s*(?:hidden|collapse))")
_MOVED = re.compile(r"(?:^|;)\s*(?:transform|translate|rotate|scale|d|cx|cy|r|x|y)\s*:")
_ADVICE = {
    "text": ", not converted to paths", "image": ", a picture of pixels", "style": ", whose rules are not read",
}  # fmt: skip
_DEEPEST_USE = 20
_MOST_USES = 100_000
_LARGEST = 1e12
_THIN = 1e-12

Affine = tuple[FloatArray, FloatArray]
"""``x ↦ M x + shift``"""


def read_svg(
    file: str | os.PathLike[str],
    unit: Literal["m", "mm", "cm", "inch", "px"] | None = None,
    *,
    arm_unit: Literal["m", "mm", "cm", "inch"] = "m",
    scale: float = 1.0,
    tolerance: float | None = None,
    gaps: Literal["error", "line"] = "error",
    lift: float | None = None,
    subpath: int | None = None,
) -> Drawing:
    """Read an SVG drawing.

    Parameters
    ----------
    file : path-like
    unit : {"m", "mm", "cm", "inch", "px"}, optional
        Of the drawing's user units. Needed unless the file has a viewBox and a size in physical units, which say it.
        A pixel is 1/96 inch.
    arm_unit : {"m", "mm", "cm", "inch"}
        Of the path.
    scale : float
        A further factor, on the drawing about its origin.
    tolerance : float, optional
        How far apart ends may be that are meant to meet, and how far what is flattened may stray; in the unit of the
        path. By default 0.1 mm on the drawing.
    gaps : {"error", "line"}
        Whether straight lines join subpaths that do not meet.
    lift : float, optional
        Makes a space curve in the plane z = 0 of it, which rises by this much, crosses and comes down between subpaths;
        in the unit of the path.
    subpath : int, optional
        Only this one, counted from 0.

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
    source = os.fspath(file)
    options = Options(arm_unit, scale, tolerance, gaps, lift, subpath)
    if unit is not None:
        choice("unit", unit, (*UNITS, "px"))
    try:
        return _read(file, source, unit, options)
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None


def _read(file: str | os.PathLike[str], source: str, unit: str | None, options: Options) -> Drawing:
    parse = _svgpathtools()
    try:
        text = read_checked(file).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InvalidInputError("", "is not UTF-8 text", "is it an SVG file? one ending in .svgz is packed") from None
    root = parse_svg(text)
    page = page_of(root)
    named, words = settled_unit(unit, page.unit, "the size of its page with a viewBox", source)
    metres = page.metres or ((PIXEL if named == "px" else UNITS[named]),) * 2
    factors = np.array([options.factor(metres[0]), -options.factor(metres[1])])
    walk = _Walk(root, parse)
    # y points down on the page and up in the path.
    strokes = list(walk.strokes(root, (np.diag(factors), -factors * page.corner)))
    notes = [f"the origin is {page.origin}; y points up"]
    return drawing(source, "SVG", words, strokes, options, ignored=walk.ledger.entries(), notes=notes)


def _svgpathtools() -> Callable[[str], Any]:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from svgpathtools import parse_path
    except ImportError:
        raise needs_extra("svgpathtools") from None
    return parse_path


class _Walk:
    """A walk through the tree of elements.

    Attributes
    ----------
    ledger : Ledger
        What was passed by.
    """

    def __init__(self, root: Element, parse: Callable[[str], Any]) -> None:
        self.ledger = Ledger()
        self._root, self._parse = root, parse
        self._used_times = 0
        self._named: dict[str, Element] = {}
        self._count = 0
        waiting = [root]
        while waiting:
            element = waiting.pop()
            self._named.setdefault(element.attributes.get("id", ""), element)
            waiting += element.children

    def strokes(self, element: Element, above: Affine, uses: int = 0) -> Iterator[list[Piece]]:
        """Yield the strokes of an element and what is inside, `above` what its coordinates go through."""
        attributes, name = element.attributes, element.name
        if name in _SILENT:
            return
        style = attributes.get("style", "")
        if _HIDDEN.search(style) or attributes.get("display") == "none" or attributes.get("visibility") in _UNSEEN:
            self.ledger.note(f"<{name}> that is hidden", element.line)
            return
        if _MOVED.search(style):
            raise _wrong(element, "is moved or shaped by its style", "write transform and d as attributes")
        here = _after(above, self._transform(element))
        if name == "use":
            yield from self._used(element, here, uses)
        elif name in _GROUPS:
            if name == "svg" and element is not self._root:
                raise _wrong(element, "is a page within the page", "ungroup it in the drawing program")
            for child in element.children:
                yield from self.strokes(child, here, uses)
        elif name in _SHAPES:
            if not max(np.abs(part).max() for part in here) <= _LARGEST:
                raise _wrong(element, f"is enlarged beyond {_LARGEST:g}", "correct the transforms around it")
            for stroke in self._shape(element, here):
                self._count += sum(piece.weight for piece in stroke)
                if self._count > MOST_SEGMENTS:
                    raise InvalidInputError("", TOO_MANY, "cut it into several files")
                yield stroke
        else:
            self.ledger.note(f"<{name}>{_ADVICE.get(name, '')}", element.line)

    def _transform(self, element: Element) -> Affine:
        from svgpathtools.parser import parse_transform

        text = element.attributes.get("transform")
        try:
            with np.errstate(invalid="ignore", over="ignore"):
                matrix = parse_transform(text, strict=True)
        except ValueError:
            matrix = np.full((3, 3), np.nan)
        if not np.abs(matrix).max() <= _LARGEST:
            raise _wrong(element, "has a transform that is not read", "write matrix(a b c d e f)", text)
        return matrix[:2, :2], matrix[:2, 2]

    def _used(self, element: Element, here: Affine, uses: int) -> Iterator[list[Piece]]:
        """Yield the strokes of what a use element refers to."""
        name = element.attributes.get("href", "")
        target = self._named.get(name[1:]) if name.startswith("#") and len(name) > 1 else None
        if target is None:
            raise _wrong(element, "refers to nothing in the file", "name an element of the file by #id", name)
        self._used_times += 1
        if uses >= _DEEPEST_USE or self._used_times > _MOST_USES:
            raise _wrong(element, "refers to itself, or too often to others", "write its shapes out")
        shift = np.array([_size(element, "x"), _size(element, "y")])
        here = _after(here, (np.eye(2), shift))
        if target.name != "symbol":
            yield from self.strokes(target, here, uses + 1)
            return
        if "viewBox" in target.attributes:
            raise _wrong(target, "is a symbol with a page of its own", "ungroup it in the drawing program")
        for child in target.children:
            yield from self.strokes(child, here, uses + 1)

    def _shape(self, element: Element, here: Affine) -> Iterator[list[Piece]]:
        """Yield the strokes of one shape."""
        name = element.name
        if name == "path":
            yield from self._path(element, here)
            return
        if name in ("circle", "ellipse"):
            radii = [_size(element, "r")] * 2 if name == "circle" else [_size(element, "rx"), _size(element, "ry")]
            center = np.array([_size(element, "cx"), _size(element, "cy")])
            pieces = [_elliptic(here, center, radii, 0.0, 0.0, 2 * np.pi)]
        elif name == "rect":
            pieces = _rectangle(element, here)
        elif name == "line":
            ends = [[_size(element, f"x{k}"), _size(element, f"y{k}")] for k in (1, 2)]
            pieces = [line(_moved(here, np.array(ends)))]
        else:
            points = _points(element)
            if name == "polygon":
                points = np.vstack([points, points[:1]])
            pieces = [line(_moved(here, points))] if len(points) else []
        kept = [piece for piece in pieces if piece is not None]
        if kept:
            yield kept

    def _path(self, element: Element, here: Affine) -> Iterator[list[Piece]]:
        """Yield the strokes of path data."""
        stroke: list[Piece] = []
        corners: list[complex] = []

        def flush() -> None:
            if corners and (cut := line(_moved(here, _pairs(corners)))) is not None:
                stroke.append(cut)
            corners.clear()

        end: complex | None = None
        for segment in self._segments(element):
            if segment.start != end:
                flush()
                if stroke:
                    yield stroke
                stroke = []
            if type(segment).__name__ == "Line":
                corners += [segment.end] if corners else [segment.start, segment.end]
            else:
                flush()
                curve = _curve(segment, here)
                stroke += [] if curve is None else [curve]
            end = segment.end
        flush()
        if stroke:
            yield stroke

    def _segments(self, element: Element) -> Any:
        """Return the segments of path data as svgpathtools reads it."""
        data = element.attributes.get("d", "")
        remedy = "write M x y, then L, C, Q, A and the like with all their numbers"
        if data.strip() in ("", "none"):
            return ()
        if not _PATH_DATA.fullmatch(data) or data.strip()[0] not in "Mm":
            raise _wrong(element, "has path data that is not read", remedy, data)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of arcs without radius, which are lines
                segments = self._parse(data)
        except (ValueError, IndexError, OverflowError):
            raise _wrong(element, "has path data that is not read", remedy, data[-200:]) from None
        except AssertionError:
            reason, advice = "has an arc that ends where it starts", "write a full circle as two arcs"
            raise _wrong(element, reason, advice, data) from None
        if any(
            float(number) > _LARGEST for number in _NUMBERS.findall(data) if len(number) > 12 or "e" in number.lower()
        ):
            raise _wrong(element, f"has coordinates beyond {_LARGEST:g}", "correct them", data)
        return segments


def _curve(segment: Any, here: Affine) -> Piece | None:
    """Return what svgpathtools made of a curve, exactly."""
    if hasattr(segment, "bpoints"):
        return bezier(_moved(here, _pairs(segment.bpoints())))
    radii = np.abs([segment.radius.real, segment.radius.imag])
    if not (np.isfinite(radii).all() and radii.min() > _THIN * radii.max()):  # as thin as a line
        return line(_moved(here, _pairs([segment.start, segment.end])))
    # Radii that are too small grow; starting from what is far too small, as large as can be told.
    radii = radii * max(1.0, _THIN * abs(segment.end - segment.start) / radii.max())
    rotation = np.deg2rad(segment.rotation)
    turn = _rotation(rotation)
    # In the frame of its axes, divided by its radii, the arc is one of the unit circle.
    first, last = (_pairs([end])[0] @ turn / radii for end in (segment.start, segment.end))
    half = 0.5 * (last - first)
    size = float(np.hypot(*half))
    if size > 1.0:  # too small an ellipse grows until it fits (SVG 2, 9.5.1)
        radii, first, last, half, size = radii * size, first / size, last / size, half / size, 1.0
    side = np.array([-half[1], half[0]]) / size if size else np.zeros(2)
    way = 1.0 if bool(segment.large_arc) != bool(segment.sweep) else -1.0
    center = 0.5 * (first + last) + way * np.sqrt(max(1.0 - size * size, 0.0)) * side
    start, stop = (float(np.arctan2(*(end - center)[::-1])) for end in (first, last))
    sweep = (stop - start) % (2 * np.pi) if segment.sweep else -((start - stop) % (2 * np.pi))
    return _elliptic(here, center * radii @ turn.T, radii, rotation, start, sweep)


def _elliptic(
    here: Affine, center: FloatArray, radii: Any, rotation: float, start: float, sweep: float
) -> Piece | None:
    matrix = here[0] @ _rotation(rotation) @ np.diag(radii)
    return elliptic(_moved(here, center), matrix, start, sweep)


def _rectangle(element: Element, here: Affine) -> list[Piece | None]:
    """Return the sides and rounded corners of a rectangle as SVG runs them: from the upper left to the right."""
    x, y, width, height = (_size(element, name) for name in ("x", "y", "width", "height"))
    if not (width > 0 and height > 0):
        return []
    given = [_size(element, name) if element.attributes.get(name, "auto") != "auto" else None for name in ("rx", "ry")]
    rx = given[0] if given[0] is not None else given[1] or 0.0
    ry = given[1] if given[1] is not None else rx
    rx, ry = min(rx, width / 2), min(ry, height / 2)
    if not (rx > 0 and ry > 0):
        corners = [[x, y], [x + width, y], [x + width, y + height], [x, y + height], [x, y]]
        return [line(_moved(here, np.array(corners)))]
    pieces: list[Piece | None] = []
    inner = [(x + width - rx, y + ry), (x + width - rx, y + height - ry), (x + rx, y + height - ry), (x + rx, y + ry)]
    at = np.array([x + rx, y])
    for k, center in enumerate(np.array(inner)):
        start = (k - 1) * np.pi / 2
        first = center + _quarter(rx, ry, k - 1)
        pieces.append(line(_moved(here, np.stack([at, first]))))
        pieces.append(_elliptic(here, center, [rx, ry], 0.0, start, np.pi / 2))
        at = center + _quarter(rx, ry, k)
    return pieces


def _quarter(rx: float, ry: float, quarters: int) -> FloatArray:
    """Return the point of an ellipse about 0 after some quarters of a turn."""
    return np.array([(rx, 0.0), (0.0, ry), (-rx, 0.0), (0.0, -ry)][quarters % 4])


def _points(element: Element) -> FloatArray:
    text = element.attributes.get("points", "")
    numbers = [float(number) for number in _NUMBERS.findall(text)] if _POINTS.fullmatch(text) else None
    if numbers is None or len(numbers) % 2:
        raise _wrong(element, "has points that are not pairs of numbers", "write x,y x,y …", text)
    points = np.array(numbers).reshape(-1, 2)
    if points.size and not np.abs(points).max() <= _LARGEST:
        raise _wrong(element, f"has coordinates beyond {_LARGEST:g}", "correct them", text)
    return points


def _size(element: Element, name: str) -> float:
    value = user_units(element.attributes.get(name, "0"), name, element.line)
    if name in ("r", "rx", "ry", "width", "height") and value < 0:
        raise _wrong(element, f"has a negative {name}", "give a positive one", str(value))
    return value


def _after(above: Affine, inner: Affine) -> Affine:
    """Return `inner` followed by `above`."""
    return above[0] @ inner[0], above[0] @ inner[1] + above[1]


def _moved(here: Affine, points: FloatArray) -> FloatArray:
    return points @ here[0].T + here[1]


def _pairs(numbers: Any) -> FloatArray:
    values = np.asarray(numbers, dtype=complex)
    return np.stack([values.real, values.imag], axis=1)


def _rotation(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def _wrong(element: Element, reason: str, remedy: str, value: str | None = None) -> InvalidInputError:
    return InvalidInputError(f"line {element.line}, <{element.name}>", reason, remedy, value)
