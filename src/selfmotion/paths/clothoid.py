"""Generalized clothoids: curves whose direction is a polynomial (28)(29)."""

from __future__ import annotations

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from selfmotion._checks import finite_array, number, read_only
from selfmotion._types import FloatArray, Point, Vector
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path
from selfmotion.quadrature import gauss_panels, panel_of

# 16 Gauss–Legendre nodes integrate sin p to rounding while p varies by at most this over the panel.
_VARIATION = 2.0
_MOST_POWERS = 20  # panels are found in the square of it
_MAX_PANELS = 100_000


class Clothoid(Path):
    """A generalized clothoid, equations (28) and (29) of the seed's paper.

    Parameters
    ----------
    center : array_like, shape (2,)
        The point at t = 0, ``(x_c, y_c)``.
    scale : float
        The factor k; not zero.
    coefficients : array_like, shape (d + 1,)
        At most 20 coefficients of the polynomial p, ascending.
    t_range : array_like, shape (2,)
        First and last value of t; descending ranges run the curve backwards.

    Raises
    ------
    InvalidInputError
        If the scale is zero, the range is empty, or p turns so often that the curve cannot be integrated.

    Notes
    -----
    ``x(t) = x_c + k ∫₀ᵗ sin p(u) du``, ``y(t) = y_c + k ∫₀ᵗ cos p(u) du``, and t is linear in r. The integral is
    tabulated at the ends of panels on which p varies little and completed inside a panel by 16-point
    Gauss–Legendre quadrature: positions are accurate to about
    ``1e-14 k |t|``, and to the rounding of p(t) where p is large.
    """

    kind = "clothoid"
    highest_order = 3

    def __init__(self, center: Point, scale: float, coefficients: Vector, t_range: Point) -> None:
        self.center = read_only(finite_array("center", center, 1, 2))
        self.factor = number("scale", scale)
        if self.factor == 0:
            raise InvalidInputError("scale", "is zero: the path has no length", "give the factor k of (28)", scale)
        self.coefficients = read_only(finite_array("coefficients", coefficients, 1))
        if not len(self.coefficients):
            raise InvalidInputError("coefficients", "is empty", "give p in ascending powers", coefficients)
        if len(self.coefficients) > _MOST_POWERS:
            remedy = f"give at most {_MOST_POWERS}, and join several with kind concatenation"
            raise InvalidInputError("coefficients", f"has {len(self.coefficients)} powers", remedy)
        self.t_range = read_only(finite_array("t_range", t_range, 1, 2))
        if self.t_range[0] == self.t_range[1]:
            raise InvalidInputError("t_range", "is empty: the path has no length", "give two values", t_range)
        self._slope = np.asarray(polyder(self.coefficients), dtype=float)
        self._edges = self._panels()
        steps = self._integral(self._edges[:-1], self._edges[1:])
        table = np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])
        self._table = table - table[np.flatnonzero(self._edges == 0.0)[0]]

    def __repr__(self) -> str:
        return (
            f"Clothoid({self.center.tolist()}, {self.factor!r}, {self.coefficients.tolist()}, {self.t_range.tolist()})"
        )

    def _panels(self) -> FloatArray:
        """Return ascending panel ends covering t_range and 0, so that p varies by ≤ 2 rad on each."""
        low, high = min(0.0, *self.t_range), max(0.0, *self.t_range)
        slope = np.abs(self._slope)
        todo = [(low, 0.0), (0.0, high)]
        edges = {low, 0.0, high}
        while todo:
            a, b = todo.pop()
            farthest = max(abs(a), abs(b))
            # |p'| ≤ Σ k |c_k| t^(k−1) is enough for the bound: it is exact where the powers agree in sign.
            middle = 0.5 * (a + b)
            with np.errstate(over="ignore", invalid="ignore"):
                local = np.abs(_taylor(self._slope, middle)) @ (0.5 * (b - a)) ** np.arange(len(slope))
                variation = min(float(polyval(farthest, slope)), float(local)) * (b - a)
            if variation <= _VARIATION:
                continue
            edges.add(middle)
            todo += [(a, middle), (middle, b)]
            if len(edges) > _MAX_PANELS or not a < middle < b or not np.isfinite(variation):
                raise InvalidInputError(
                    "coefficients",
                    "turn the path round tens of thousands of times",
                    "shorten t_range or lower the coefficients",
                    self.coefficients.tolist(),
                )
        return np.array(sorted(edges))

    def _integral(self, start: FloatArray, stop: FloatArray) -> FloatArray:
        """Return ∫ (sin p, cos p) du from `start` to `stop`, both of shape (k,), as shape (k, 2)."""

        def direction(t: FloatArray) -> FloatArray:
            angle = polyval(t, self.coefficients)
            return np.stack([np.sin(angle), np.cos(angle)])

        return gauss_panels(direction, start, stop).T

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        first, last = self.t_range
        rate = last - first
        t = np.where(r == 1.0, last, first + r * rate)
        if order == 0:
            panel = panel_of(self._edges, t)
            return self.center + self.factor * (self._table[panel] + self._integral(self._edges[panel], t))
        angle = polyval(t, self.coefficients)
        if order == 1:
            return self.factor * rate * np.stack([np.sin(angle), np.cos(angle)], axis=-1)
        slope, across = polyval(t, self._slope), np.stack([np.cos(angle), -np.sin(angle)], axis=-1)
        if order == 2:
            turning = self.factor * rate**2 * slope
            return turning[:, None] * across
        along, bend = np.stack([np.sin(angle), np.cos(angle)], axis=-1), polyval(t, polyder(self._slope))
        return self.factor * rate**3 * (bend[:, None] * across - slope[:, None] ** 2 * along)

    def _fastest(self, low: float, high: float) -> float:
        return abs(self.factor * float(self.t_range[1] - self.t_range[0]))

    def _bending(self, low: float, high: float) -> float:
        ends = self.t_range[0] + np.diff(self.t_range) * np.array([low, high])
        steepest = np.abs(_taylor(self._slope, float(ends.mean()))) @ (0.5 * abs(ends[1] - ends[0])) ** np.arange(
            len(self._slope)
        )
        return abs(self.factor) * float(np.diff(self.t_range)[0]) ** 2 * float(steepest)


def _taylor(coefficients: FloatArray, center: float) -> FloatArray:
    """Return the ascending coefficients of the polynomial about `center`, by repeated synthetic division."""
    shifted = coefficients.copy()
    for k in range(len(shifted) - 1):
        for j in range(len(shifted) - 2, k - 1, -1):
            shifted[j] += center * shifted[j + 1]
    return shifted
