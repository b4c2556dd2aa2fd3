"""Paths through given points: the exact polyline, or the C² cubic spline."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from selfmotion._checks import choice, finite_array, read_only
from selfmotion._types import FloatArray, Points
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path
from selfmotion.quadrature import panel_of


class Waypoints(Path):
    """A path through points.

    Parameters
    ----------
    points : array_like, shape (k, 2)
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

    def __init__(self, points: Points, interpolation: Literal["linear", "spline"] = "linear") -> None:
        self.points = read_only(finite_array("points", points, 2, 2))
        self.interpolation = choice("interpolation", interpolation, ("linear", "spline"))
        if len(self.points) < 2:
            raise InvalidInputError("points", f"has {len(self.points)} point", "give at least two", points)
        chords = np.hypot(*np.diff(self.points, axis=0).T)
        if not chords.all():
            at = int(np.flatnonzero(chords == 0)[0])
            raise InvalidInputError("points", f"repeats point {at} as point {at + 1}", "drop one of the two")
        knots = np.concatenate([[0.0], np.cumsum(chords)]) / chords.sum()
        knots[-1] = 1.0
        if not (np.diff(knots) > 0).all():
            at = int(np.flatnonzero(np.diff(knots) <= 0)[0])
            raise InvalidInputError("points", f"{at} and {at + 1} are too close to tell apart", "drop one of them")
        self.knots = read_only(knots)
        self._spline: Callable[..., FloatArray] | None = None
        if self.interpolation == "spline":
            self._spline, self._coefficients = self._fit()

    def __repr__(self) -> str:
        return f"Waypoints({self.points.tolist()}, {self.interpolation!r})"

    def _fit(self) -> tuple[Callable[..., FloatArray], FloatArray]:
        """Return the spline, and its pieces' coefficients (4, k − 1, 2), the cubic ones first."""
        from scipy.interpolate import CubicSpline

        closed = len(self.points) > 2 and (self.points[0] == self.points[-1]).all()
        spline = CubicSpline(self.knots, self.points, bc_type="periodic" if closed else "not-a-knot")
        return spline, np.asarray(spline.c)

    @property
    def breaks(self) -> FloatArray:
        """The inner waypoints, which are corners of the polyline or jumps of the spline's third derivative."""
        return self.knots[1:-1]

    @property
    def waypoints(self) -> FloatArray:
        """Path parameters of all given points."""
        return self.knots

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        if self._spline is not None:
            return np.asarray(self._spline(r, order))
        piece = panel_of(self.knots, r)
        width = (self.knots[piece + 1] - self.knots[piece])[:, None]
        if order == 2:
            return np.zeros((len(r), 2))
        if order == 1:
            return (self.points[piece + 1] - self.points[piece]) / width
        t = (r[:, None] - self.knots[piece][:, None]) / width
        return (1 - t) * self.points[piece] + t * self.points[piece + 1]

    def _fastest(self, low: float, high: float) -> float:
        pieces = np.flatnonzero((self.knots[:-1] <= high) & (self.knots[1:] >= low))
        left, right = self.knots[pieces], self.knots[pieces + 1]
        if self._spline is None:
            speeds = (self.points[pieces + 1] - self.points[pieces]) / (right - left)[:, None]
            return float(np.hypot(speeds[:, 0], speeds[:, 1]).max())
        # On each piece the speed is a parabola: a Bezier curve of three control points.
        left, right = np.clip(low, left, right), np.clip(high, left, right)
        half = 0.5 * (right - left)[:, None]
        cubic, square, linear = (self._coefficients[k][pieces] for k in range(3))
        start = (left - self.knots[pieces])[:, None]
        one = (3 * cubic * start + 2 * square) * start + linear
        two = one + half * (6 * cubic * start + 2 * square)
        stop = start + 2 * half
        three = (3 * cubic * stop + 2 * square) * stop + linear
        return float(max(np.hypot(points[:, 0], points[:, 1]).max() for points in (one, two, three)))
