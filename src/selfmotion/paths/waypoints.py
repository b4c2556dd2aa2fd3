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
        self._spline = self._fit() if self.interpolation == "spline" else None

    def __repr__(self) -> str:
        return f"Waypoints({self.points.tolist()}, {self.interpolation!r})"

    def _fit(self) -> Callable[..., FloatArray]:
        from scipy.interpolate import CubicSpline

        closed = len(self.points) > 2 and (self.points[0] == self.points[-1]).all()
        spline: Callable[..., FloatArray] = CubicSpline(
            self.knots, self.points, bc_type="periodic" if closed else "not-a-knot"
        )
        return spline

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
