"""SVG shapes and path data as pieces, exactly, under any affine map."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.pieces import Piece, bezier, elliptic, line
from selfmotion.exchange.reading import needs_extra
from selfmotion.exchange.svg_page import Affine, user_units
from selfmotion.exchange.svg_xml import Element

SHAPES = ("path", "line", "polyline", "polygon", "rect", "circle", "ellipse")
LARGEST = 1e12
"""Of a coordinate."""
_PATH_DATA = re.compile(r"[MmZzLlHhVvCcSsQqTtAaEe0-9+\-.,\s]*")
_NUMBERS = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_POINTS = re.compile(rf"\s*(?:{_NUMBERS.pattern}(?:[\s,]+|(?=[+-])|$))*\s*")
_ARCS = re.compile(r"[Aa]([0-9eE+\-.,\s]*)")
# Of an arc: two radii, a rotation, two flags that are 0 or 1 and may stand without space, an end.
_NEXT = r"[\s,]*"
_NUMBER = f"(?>{_NUMBERS.pattern}){_NEXT}"
_ARC = re.compile(rf"\s*(?:{_NUMBER * 3}[01]{_NEXT}[01]{_NEXT}{_NUMBER * 2})+")
_THIN = 1e-12
_REMEDY = "write M x y, then L, C, Q, A and the like with all their numbers"

Parse = Callable[[str], Any]
"""svgpathtools' parser of path data."""


def path_parser() -> Parse:
    """Return svgpathtools' parser of path data.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            from svgpathtools import parse_path
    except ImportError:
        raise needs_extra("svgpathtools") from None
    return parse_path


def transform_of(element: Element) -> Affine:
    """Return the transform that an element states.

    Raises
    ------
    InvalidInputError
        If it is not read, or has an origin of its own.
    """
    from svgpathtools.parser import parse_transform

    text = element.attributes.get("transform")
    if text and element.attributes.get("transform-origin"):
        raise wrong(element, "has a transform-origin", "write it into its transform, as rotate(angle x y)")
    try:
        with np.errstate(invalid="ignore", over="ignore"):
            matrix = parse_transform(text, strict=True)
    except ValueError:
        matrix = np.full((3, 3), np.nan)
    if not np.abs(matrix).max() <= LARGEST:
        raise wrong(element, "has a transform that is not read", "write matrix(a b c d e f)", text)
    return matrix[:2, :2], matrix[:2, 2]


def after(above: Affine, inner: Affine) -> Affine:
    """Return `inner` followed by `above`."""
    return above[0] @ inner[0], above[0] @ inner[1] + above[1]


def shape_strokes(element: Element, here: Affine, parse: Parse) -> Iterator[list[Piece]]:
    """Yield the strokes of one shape, its coordinates going through `here`."""
    name = element.name
    if name == "path":
        yield from _path(element, here, parse)
        return
    if name in ("circle", "ellipse"):
        radii = [_size(element, "r")] * 2 if name == "circle" else _radii(element)
        if min(radii) == 0:
            return
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


def _path(element: Element, here: Affine, parse: Parse) -> Iterator[list[Piece]]:
    """Yield the strokes of path data."""
    stroke: list[Piece] = []
    corners: list[complex] = []

    def flush() -> None:
        if corners and (cut := line(_moved(here, _pairs(corners)))) is not None:
            stroke.append(cut)
        corners.clear()

    end: complex | None = None
    for segment in _segments(element, parse):
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


def _segments(element: Element, parse: Parse) -> Any:
    """Return the segments of path data as svgpathtools reads it."""
    data = element.attributes.get("d", "")
    if data.strip() in ("", "none"):
        return ()
    arcs = (found[1] for found in _ARCS.finditer(data))
    if not _PATH_DATA.fullmatch(data) or data.strip()[0] not in "Mm" or not all(map(_ARC.fullmatch, arcs)):
        raise wrong(element, "has path data that is not read", _REMEDY, data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of arcs without radius, which are lines
            segments = parse(data)
    except (ValueError, IndexError, OverflowError):
        raise wrong(element, "has path data that is not read", _REMEDY, data[-200:]) from None
    except AssertionError:
        reason, advice = "has an arc that ends where it starts", "write a full circle as two arcs"
        raise wrong(element, reason, advice, data) from None
    if any(
        abs(float(number)) > LARGEST for number in _NUMBERS.findall(data) if len(number) > 12 or "e" in number.lower()
    ):
        raise wrong(element, f"has coordinates beyond {LARGEST:g}", "correct them", data)
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
    rx, ry = _radii(element)
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


def _radii(element: Element) -> tuple[float, float]:
    """Return rx and ry, of which one that is auto or missing is what the other is."""
    given = [_size(element, name) if element.attributes.get(name, "auto") != "auto" else None for name in ("rx", "ry")]
    rx = given[0] if given[0] is not None else given[1] or 0.0
    return rx, rx if given[1] is None else given[1]


def _quarter(rx: float, ry: float, quarters: int) -> FloatArray:
    """Return the point of an ellipse about 0 after some quarters of a turn."""
    return np.array([(rx, 0.0), (0.0, ry), (-rx, 0.0), (0.0, -ry)][quarters % 4])


def _points(element: Element) -> FloatArray:
    text = element.attributes.get("points", "")
    numbers = [float(number) for number in _NUMBERS.findall(text)] if _POINTS.fullmatch(text) else None
    if numbers is None or len(numbers) % 2:
        raise wrong(element, "has points that are not pairs of numbers", "write x,y x,y …", text)
    points = np.array(numbers).reshape(-1, 2)
    if points.size and not np.abs(points).max() <= LARGEST:
        raise wrong(element, f"has coordinates beyond {LARGEST:g}", "correct them", text)
    return points


def _size(element: Element, name: str) -> float:
    value = user_units(element.attributes.get(name, "0"), name, element.line)
    if name in ("r", "rx", "ry", "width", "height") and value < 0:
        raise wrong(element, f"has a negative {name}", "give a positive one", str(value))
    return value


def _moved(here: Affine, points: FloatArray) -> FloatArray:
    return points @ here[0].T + here[1]


def _pairs(numbers: Any) -> FloatArray:
    values = np.asarray(numbers, dtype=complex)
    return np.stack([values.real, values.imag], axis=1)


def _rotation(angle: float) -> FloatArray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def wrong(element: Element, reason: str, remedy: str, value: str | None = None) -> InvalidInputError:
    """Return the error of an element, named by its line."""
    return InvalidInputError(f"line {element.line}, <{element.name}>", reason, remedy, value)
