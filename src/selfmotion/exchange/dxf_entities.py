"""DXF entities as strokes: what each kind is made of, in the plane of the drawing."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.dxf_blocks import Blocks, wrong
from selfmotion.exchange.ledger import Ledger
from selfmotion.exchange.pieces import Piece, bezier, elliptic, line
from selfmotion.exchange.reading import Budget

_KINDS = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
# What else is drawn with lines, and why they are not read.
_ADVICE = {
    "DIMENSION": ", an annotation", "LEADER": ", an annotation", "MULTILEADER": ", an annotation",
    "MLINE": ", to be exploded in the drawing program", "HELIX": ", to be exploded in the drawing program",
}  # fmt: skip
_FRAME = 16  # flag of a vertex that belongs to the frame of a spline, not to the curve
_LARGEST = 1e12


class Entities:
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
        budget = Budget()
        for entity in Blocks(document, self.ledger).entities():
            kind = entity.dxftype()
            if kind not in _KINDS or (kind == "POLYLINE" and not (entity.is_2d_polyline or entity.is_3d_polyline)):
                self.ledger.note(kind + _ADVICE.get(kind, ""))
                continue
            try:
                pieces = [piece for piece in self._pieces(entity, kind) if piece is not None]
            except InvalidInputError as error:
                raise wrong(entity, f"{error.field} {error.reason}".strip(), error.remedy) from None
            except Exception as error:  # whatever a broken entity makes of its parser
                raise wrong(entity, f"is not read ({error})", "correct it in the drawing program") from None
            budget.spend(sum(piece.weight for piece in pieces))
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
        radius = _finite(float(entity.dxf.radius) * self._factor)
        if radius < 0:
            raise InvalidInputError("", "has a negative radius", "correct it in the drawing program")
        start, sweep = 0.0, 2 * np.pi
        if kind == "ARC":
            start, end = np.deg2rad([entity.dxf.start_angle, entity.dxf.end_angle]).tolist()
            sweep = (end - start) % (2 * np.pi) or 2 * np.pi
        side = self._side(entity)
        return elliptic(center, radius * np.diag([side, 1.0]), _finite(start), sweep)

    def _ellipse(self, entity: Any) -> Piece | None:
        center, first = self._plane(entity, [entity.dxf.center, entity.dxf.center + entity.dxf.major_axis])
        major = first - center
        minor = np.array([-major[1], major[0]]) * float(entity.dxf.ratio) * self._side(entity)
        start = float(entity.dxf.start_param)
        sweep = (float(entity.dxf.end_param) - start) % (2 * np.pi) or 2 * np.pi
        return elliptic(center, np.stack([major, minor], axis=1), _finite(start), _finite(sweep))

    def _spline(self, entity: Any) -> list[Piece | None]:
        spline = entity.construction_tool()
        weights, knots = np.array(spline.weights(), dtype=float), np.array(spline.knots(), dtype=float)
        _check_spline(weights, knots, spline.degree)
        # One whose weights are all the same is a polynomial.
        if spline.is_clamped and (not len(weights) or np.ptp(weights) <= 1e-12 * weights[0]):
            self._plane(entity, spline.control_points)
            plain = type(spline)(spline.control_points, order=spline.order, knots=spline.knots())
            return [bezier(self._plane(entity, points)) for points in plain.bezier_decomposition()]
        inside = np.unique(knots[spline.degree : len(knots) - spline.degree])

        def at(t: FloatArray) -> FloatArray:
            return self._plane(entity, list(spline.points(t.tolist())))

        points, error = _sampled(at, inside, self._within)
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


def _check_spline(weights: FloatArray, knots: FloatArray, degree: int) -> None:
    """Refuse a spline that is none: weights that make poles, knots that go back, stand still or tear it apart."""
    remedy = "correct it in the drawing program"
    if len(weights) and not (np.isfinite(weights).all() and weights.min() > 0):
        raise InvalidInputError("", "has weights that are not positive", remedy)
    inside = knots[degree : len(knots) - degree]
    if not (np.isfinite(knots).all() and (np.diff(knots) >= 0).all() and inside[-1] > inside[0]):
        raise InvalidInputError("", "has knots that do not ascend", remedy)
    inner = inside[(inside > inside[0]) & (inside < inside[-1])]
    if len(inner) and np.unique(inner, return_counts=True)[1].max() > degree:
        raise InvalidInputError("", "comes apart at a knot", "draw it as two splines")


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
