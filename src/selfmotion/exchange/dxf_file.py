"""DXF: lines, polylines with bulges, arcs, circles, ellipses and splines, chained where their ends meet."""

from __future__ import annotations

import logging
import os
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Literal

import numpy as np

from selfmotion._checks import choice
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.chaining import chained
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
    shown,
)
from selfmotion.exchange.files import UNITS
from selfmotion.exchange.pieces import Piece, bezier, elliptic, line

# $INSUNITS: our name of the unit and metres in it.
_INSUNITS = {
    1: ("inch", 0.0254), 2: ("foot", 0.3048), 3: ("mile", 1609.344), 4: ("mm", 1e-3), 5: ("cm", 1e-2), 6: ("m", 1.0),
    7: ("km", 1e3), 8: ("microinch", 2.54e-8), 9: ("mil", 2.54e-5), 10: ("yard", 0.9144), 13: ("micron", 1e-6),
    14: ("dm", 0.1),
}  # fmt: skip
_KINDS = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
_FRAME = 16  # flag of a vertex that belongs to the frame of a spline, not to the curve
_LARGEST = 1e12


def read_dxf(
    file: str | os.PathLike[str],
    unit: Literal["m", "mm", "cm", "inch"] | None = None,
    *,
    arm_unit: Literal["m", "mm", "cm", "inch"] = "m",
    scale: float = 1.0,
    tolerance: float | None = None,
    gaps: Literal["error", "line"] = "error",
    lift: float | None = None,
    subpath: int | None = None,
) -> Drawing:
    """Read a DXF drawing.

    Parameters
    ----------
    file : path-like
        Text or binary DXF.
    unit : {"m", "mm", "cm", "inch"}, optional
        Of the drawing's numbers. Needed unless the file says it by $INSUNITS.
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
        Naming the file, and the entity by its handle.
    MissingExtraError
        If the package ezdxf is missing.

    Notes
    -----
    Read is the model space, blocks included. Entities are chained where their ends meet, whichever way each was drawn;
    a chain runs as its first entity in the file does, and chains keep the order of their first entities. Rational
    splines are flattened; everything else is exact.
    """
    source = os.fspath(file)
    options = Options(arm_unit, scale, tolerance, gaps, lift, subpath)
    if unit is not None:
        choice("unit", unit, UNITS)
    try:
        return _read(file, source, unit, options)
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None


def _read(file: str | os.PathLike[str], source: str, unit: str | None, options: Options) -> Drawing:
    document = _document(file)
    stated = _INSUNITS.get(int(document.header.get("$INSUNITS", 0)))
    named, words = settled_unit(unit, None if stated is None else stated[0], "$INSUNITS", source)
    factor = options.factor(UNITS[named] if stated is None else stated[1])
    entities = _Entities(factor, options.within)
    strokes = list(entities.strokes(document))
    chains, forks = chained(strokes, options.within)
    notes = ["the origin is that of the file"]
    if forks:
        at = shown(forks[0])
        notes.append(f"more than two ends meet at {len(forks)} points, the first {at}; there the file's order was kept")
    return drawing(
        source, "DXF", words, chains, options,
        ignored=entities.ledger.entries(), notes=notes, chord_error=entities.chord_error,
    )  # fmt: skip


def _document(file: str | os.PathLike[str]) -> Any:
    try:
        from ezdxf.filemanagement import readfile
    except ImportError:
        raise needs_extra("ezdxf") from None
    # What a file has wrong is said by our errors; without this its log would go to the terminal.
    logging.getLogger("ezdxf").addHandler(logging.NullHandler())
    data = read_checked(file)
    binary = data.startswith(b"AutoCAD Binary DXF")
    if not data.strip():
        raise InvalidInputError("", "is empty", "is it the right file?")
    if not binary and (b"\0" in data or b"SECTION" not in data[:100_000]):
        raise InvalidInputError("", "is not a DXF file", "is it the right file? a DWG is to be saved as DXF first")
    if not binary and data.split()[-1:] != [b"EOF"]:
        raise InvalidInputError("", "does not end with EOF: a part of it is missing", "copy or export it again")
    try:
        return readfile(os.fspath(file))
    except Exception as error:  # whatever a broken file makes of a parser
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInputError("", f"is not a DXF file that can be read ({reason})", "export it again") from None


class _Entities:
    """The model space as strokes.

    Attributes
    ----------
    ledger : Ledger
        What was passed by.
    chord_error : float
    """

    def __init__(self, factor: float, within: float) -> None:
        self.ledger = Ledger()
        self.chord_error = 0.0
        self._factor, self._within = factor, within
        self._height: float | None = None

    def strokes(self, document: Any) -> Iterator[list[Piece]]:
        """Yield the strokes of the model space in the order of the file."""
        from ezdxf.disassemble import recursive_decompose

        hidden = {layer.dxf.name.lower() for layer in document.layers if layer.is_off() or layer.is_frozen()}
        count = 0
        entities: Iterator[Any] = iter(recursive_decompose(document.modelspace()))
        for entity in entities:
            kind = entity.dxftype()
            if str(entity.dxf.get("layer", "0")).lower() in hidden or entity.dxf.get("invisible", 0):
                self.ledger.note(f"{kind} that is hidden")
                continue
            if kind not in _KINDS or (kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)):
                self.ledger.note(kind)
                continue
            try:
                pieces = [piece for piece in self._pieces(entity, kind) if piece is not None]
            except InvalidInputError as error:
                raise _wrong(entity, f"{error.field} {error.reason}".strip(), error.remedy) from None
            except Exception as error:  # whatever a broken entity makes of its parser
                raise _wrong(entity, f"is not read ({error})", "correct it in the drawing program") from None
            count += sum(piece.weight for piece in pieces)
            if count > MOST_SEGMENTS:
                raise InvalidInputError("", TOO_MANY, "cut it into several files")
            if pieces:
                yield pieces

    def _pieces(self, entity: Any, kind: str) -> list[Piece | None]:
        if kind == "LINE":
            return [line(self._plane(entity, [entity.dxf.start, entity.dxf.end]))]
        if kind in ("LWPOLYLINE", "POLYLINE"):
            return self._polyline(entity, kind)
        if kind in ("ARC", "CIRCLE"):
            return [self._circular(entity, kind)]
        if kind == "ELLIPSE":
            return [self._ellipse(entity)]
        return self._spline(entity)

    def _polyline(self, entity: Any, kind: str) -> list[Piece | None]:
        if kind == "LWPOLYLINE":
            rows = np.array(entity.get_points("xyb"), dtype=float).reshape(-1, 3)
            given = [(x, y, entity.dxf.elevation) for x, y in rows[:, :2]]
            bulges, closed = rows[:, 2], bool(entity.closed)
            corners = self._plane(entity, given, entity.ocs())
        else:
            vertices = [vertex for vertex in entity.vertices if not vertex.dxf.get("flags", 0) & _FRAME]
            given = [vertex.dxf.location for vertex in vertices]
            bulges = np.array([vertex.dxf.get("bulge", 0.0) for vertex in vertices])
            closed = bool(entity.is_closed)
            corners = self._plane(entity, given, entity.ocs() if entity.is_2d_polyline else None)
        bulges = bulges * self._side(entity)
        if closed and len(corners):
            corners = np.vstack([corners, corners[:1]])
        pieces: list[Piece | None] = []
        at, last = 0, len(corners) - 1
        for k in [*np.flatnonzero(bulges[:last]).tolist(), last]:
            if k > at:
                pieces.append(line(corners[at : k + 1]))
            if k < last:
                pieces.append(_bulged(corners[k], corners[k + 1], float(bulges[k])))
            at = k + 1
        return pieces

    def _circular(self, entity: Any, kind: str) -> Piece | None:
        center = self._plane(entity, [entity.dxf.center], entity.ocs())[0]
        radius = float(entity.dxf.radius) * self._factor
        start, sweep = 0.0, 2 * np.pi
        if kind == "ARC":
            start, end = np.deg2rad([entity.dxf.start_angle, entity.dxf.end_angle]).tolist()
            sweep = (end - start) % (2 * np.pi) or 2 * np.pi
        side = self._side(entity)
        return elliptic(center, _finite(radius) * np.diag([side, 1.0]), _finite(start), sweep)

    def _ellipse(self, entity: Any) -> Piece | None:
        center, first = self._plane(entity, [entity.dxf.center, entity.dxf.center + entity.dxf.major_axis])
        major = first - center
        minor = np.array([-major[1], major[0]]) * float(entity.dxf.ratio) * self._side(entity)
        start = float(entity.dxf.start_param)
        sweep = (float(entity.dxf.end_param) - start) % (2 * np.pi) or 2 * np.pi
        return elliptic(center, np.stack([major, minor], axis=1), _finite(start), _finite(sweep))

    def _spline(self, entity: Any) -> list[Piece | None]:
        spline = entity.construction_tool()
        if not spline.is_rational and spline.is_clamped:
            self._plane(entity, spline.control_points)
            return [bezier(self._plane(entity, points)) for points in spline.bezier_decomposition()]
        knots = np.unique(spline.knots())
        first, last = spline.knots()[spline.degree], spline.knots()[-spline.degree - 1]
        knots = knots[(knots >= first) & (knots <= last)]

        def at(t: FloatArray) -> FloatArray:
            return self._plane(entity, list(spline.points(t.tolist())))

        points, error = _sampled(at, knots, self._within)
        self.chord_error = max(self.chord_error, error)
        return [line(points, "flattened")]

    def _plane(self, entity: Any, points: Any, ocs: Any = None) -> FloatArray:
        """Return points of the drawing's plane in the unit of the path; all must be at one height."""
        world = list(points if ocs is None else ocs.points_to_wcs(points))
        found = np.array([tuple(point) for point in world], dtype=float).reshape(len(world), -1) * self._factor
        if not (np.isfinite(found).all() and np.abs(found).max(initial=0.0) <= _LARGEST):
            raise InvalidInputError("", f"has coordinates that are no numbers up to {_LARGEST:g}", "correct them")
        if found.shape[1] > 2 and len(found):
            height = found[0, 2] if self._height is None else self._height
            self._height = height
            if np.abs(found[:, 2] - height).max() > self._within:
                remedy = "flatten the drawing: all must be at one height"
                raise InvalidInputError("", f"leaves the plane z = {height:.6g}", remedy)
        return found[:, :2]

    def _side(self, entity: Any) -> float:
        """Return 1 for an entity seen from above, −1 for a mirrored one."""
        x, y, z = tuple(entity.dxf.get("extrusion", (0.0, 0.0, 1.0)))
        if not (abs(x) <= 1e-9 * abs(z) and abs(y) <= 1e-9 * abs(z)):
            raise InvalidInputError("", "is tilted out of the drawing's plane", "flatten the drawing")
        return -1.0 if z < 0 else 1.0


def _bulged(start: FloatArray, end: FloatArray, bulge: float) -> Piece | None:
    """Return the arc from `start` to `end` of which the bulge is the tangent of a quarter of its angle."""
    sweep = 4 * np.arctan(_finite(bulge))
    chord = end - start
    if not np.hypot(*chord) > 0:
        return None
    # The centre is to the left of the chord for short counter-clockwise arcs.
    offset = (1 / bulge - bulge) / 4
    center = 0.5 * (start + end) + offset * np.array([-chord[1], chord[0]])
    radius = float(np.hypot(*(start - center)))
    if radius * (1 - np.cos(sweep / 2)) <= 1e-12 * radius and abs(bulge) < 1:  # a line but for rounding
        return line(np.stack([start, end]))
    begin = float(np.arctan2(*(start - center)[::-1]))
    return elliptic(center, radius * np.eye(2), begin, float(sweep))


def _sampled(at: Any, knots: FloatArray, within: float) -> tuple[FloatArray, float]:
    """Return points on a curve, close enough that between them it strays from chords by half of `within` at most.

    Its distance is measured at three points over every chord, and once more at fifteen for what is returned.
    """
    t = np.unique(np.concatenate([np.linspace(a, b, 5) for a, b in pairwise(knots)]))
    for _ in range(30):
        off = _strays(at, t, 3)
        wide = off > 0.5 * within
        if not wide.any() or len(t) > 1_000_000:
            break
        t = np.sort(np.concatenate([t, 0.5 * (t[:-1] + t[1:])[wide]]))
    return at(t), float(_strays(at, t, 15).max())


def _strays(at: Any, t: FloatArray, inner: int) -> FloatArray:
    """Return how far a curve strays from each chord, at `inner` points of it."""
    ends = at(t)
    chord = np.diff(ends, axis=0)
    size = np.maximum(np.hypot(chord[:, 0], chord[:, 1]), 1e-300)
    worst = np.zeros(len(t) - 1)
    for part in np.arange(1, inner + 1) / (inner + 1):
        off = at(t[:-1] + part * np.diff(t)) - ends[:-1]
        worst = np.maximum(worst, np.abs(off[:, 0] * chord[:, 1] - off[:, 1] * chord[:, 0]) / size)
    return worst


def _finite(value: float) -> float:
    if not abs(value) <= _LARGEST:
        raise InvalidInputError("", "has a number that is none", "correct it in the drawing program")
    return value


def _wrong(entity: Any, reason: str, remedy: str) -> InvalidInputError:
    return InvalidInputError(f"{entity.dxftype()} of handle {entity.dxf.get('handle', '?')}", reason, remedy)
