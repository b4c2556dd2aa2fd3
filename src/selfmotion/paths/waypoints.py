"""Paths through given points: the exact polyline, or the C² cubic spline."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Literal

import numpy as np

from selfmotion._checks import choice, read_only
from selfmotion._types import FloatArray, Positions
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path, distance, plane_or_space
from selfmotion.quadrature import panel_of


class Pieces:
    """A curve through points at given parameters, linear or cubic from one to the next.

    Parameters
    ----------
    knots : array, shape (k,)
        Ascending from 0 to 1.
    points : array, shape (k, d)
    smooth : bool
        Whether it is the C² cubic spline.
    closed : bool
        Whether that spline is periodic; else it has not-a-knot ends.
    """

    def __init__(self, knots: FloatArray, points: FloatArray, smooth: bool, closed: bool) -> None:
        self.knots = knots
        self.points = points
        self._spline: Callable[..., FloatArray] | None = None
        if smooth:
            from scipy.interpolate import CubicSpline

            spline = CubicSpline(knots, points, bc_type="periodic" if closed else "not-a-knot")
            # Its pieces' coefficients (4, k − 1, d), the cubic ones first.
            self._spline, self._coefficients = spline, np.asarray(spline.c)

    def evaluate(self, r: FloatArray, order: int) -> FloatArray:
        """Return the derivative of `order` 0 to 3 at `r` (k,), shape (k, d)."""
        if self._spline is not None:
            return np.asarray(self._spline(r, order))
        piece = panel_of(self.knots, r)
        width = (self.knots[piece + 1] - self.knots[piece])[:, None]
        if order > 1:
            return np.zeros((len(r), self.points.shape[1]))
        if order == 1:
            return (self.points[piece + 1] - self.points[piece]) / width
        t = (r[:, None] - self.knots[piece][:, None]) / width
        return (1 - t) * self.points[piece] + t * self.points[piece + 1]

    def fastest(self, low: float, high: float) -> float:
        """Return a bound on the speed over [low, high]."""
        pieces = np.flatnonzero((self.knots[:-1] <= high) & (self.knots[1:] >= low))
        left, right = self.knots[pieces], self.knots[pieces + 1]
        if self._spline is None:
            speeds = (self.points[pieces + 1] - self.points[pieces]) / (right - left)[:, None]
            return float(distance(speeds).max())
        # On each piece the speed is a parabola: a Bezier curve of three control points.
        left, right = np.clip(low, left, right), np.clip(high, left, right)
        half = 0.5 * (right - left)[:, None]
        cubic, square, linear = (self._coefficients[k][pieces] for k in range(3))
        start = (left - self.knots[pieces])[:, None]
        one = (3 * cubic * start + 2 * square) * start + linear
        two = one + half * (6 * cubic * start + 2 * square)
        stop = start + 2 * half
        three = (3 * cubic * stop + 2 * square) * stop + linear
        return float(max(distance(points).max() for points in (one, two, three)))

    def bending(self, low: float, high: float) -> float:
        """Return the largest second derivative over [low, high]: it is linear on each piece."""
        if self._spline is None:
            return 0.0
        pieces = np.flatnonzero((self.knots[:-1] <= high) & (self.knots[1:] >= low))
        left, right = self.knots[pieces], self.knots[pieces + 1]
        cubic, square = self._coefficients[0][pieces], self._coefficients[1][pieces]
        ends = (np.clip(end, left, right) - left for end in (low, high))
        return float(max(distance(6 * cubic * end[:, None] + 2 * square).max() for end in ends))


class Waypoints(Path):
    """A path through points.

    Parameters
    ----------
    points : array_like, shape (k, 2) or (k, 3)
        At least two; neighbours must differ.
    interpolation : {"linear", "spline"}
        ``linear`` is the exact polyline; ``spline`` the cubic spline with continuous second derivative,
        periodic if the last point is the first, else with not-a-knot ends.

    Raises
    ------
    InvalidInputError
        If there are fewer than two points or two neighbours coincide.

    Notes
    -----
    The parameter r is proportional to the chord length, so a polyline is run at constant speed.
    """

    kind = "waypoints"
    highest_order = 3

    def __init__(self, points: Positions, interpolation: Literal["linear", "spline"] = "linear") -> None:
        self.points = read_only(plane_or_space("points", points, 2))
        self.interpolation = choice("interpolation", interpolation, ("linear", "spline"))
        if len(self.points) < 2:
            raise InvalidInputError("points", f"has {len(self.points)} point", "give at least two", points)
        chords = distance(np.diff(self.points, axis=0))
        if not chords.all():
            at = int(np.flatnonzero(chords == 0)[0])
            raise InvalidInputError("points", f"repeats point {at} as point {at + 1}", "drop one of the two")
        knots = np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
        knots[-1] = 1.0
        if not (np.diff(knots) > 0).all():
            at = int(np.flatnonzero(np.diff(knots) <= 0)[0])
            raise InvalidInputError("points", f"{at} and {at + 1} are too close to tell apart", "drop one of them")
        self.knots = read_only(knots)
        closed = len(self.points) > 2 and bool((self.points[0] == self.points[-1]).all())
        self._pieces = Pieces(self.knots, self.points, self.interpolation == "spline", closed)
        self.dimension = self.points.shape[1]

    def __repr__(self) -> str:
        return f"Waypoints({self.points.tolist()}, {self.interpolation!r})"

    @cached_property
    def length(self) -> float:
        """Arc length: of a polyline the sum of its chords, however many they are."""
        if self.interpolation == "linear":
            return float(distance(np.diff(self.points, axis=0)).sum())
        return self.integrated_length()

    @property
    def breaks(self) -> FloatArray:
        """The inner waypoints, which are corners of the polyline or jumps of the spline's third derivative."""
        return self.knots[1:-1]

    @property
    def waypoints(self) -> FloatArray:
        """Path parameters of all given points."""
        return self.knots

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return self._pieces.evaluate(r, order)

    def _fastest(self, low: float, high: float) -> float:
        return self._pieces.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self._pieces.bending(low, high)
