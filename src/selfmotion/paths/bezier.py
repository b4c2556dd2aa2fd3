"""Bezier curves of any degree."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebinterpolate, chebval

from selfmotion._checks import read_only
from selfmotion._types import FloatArray, Positions
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path, distance, plane_or_space

# Above this degree the same polynomial is summed as a Chebyshev series: linear instead of quadratic time.
_MOST_CASTELJAU = 24
_MOST_POINTS = 1000  # the series is found in cubic time: of these in a second


class Bezier(Path):
    """A Bezier curve.

    Parameters
    ----------
    control_points : array_like, shape (d + 1, 2) or (d + 1, 3)
        Two to 1000 points, not all the same; d is the degree.

    Raises
    ------
    InvalidInputError
        If there are fewer than two control points or more than 1000, or they all coincide.

    Notes
    -----
    ``x(r) = Σ_k C(d, k) r^k (1 − r)^(d−k) B_k``; de Casteljau's convex combinations keep it stable at any degree; above
    degree 24 it is interpolated from them, exactly but for rounding, as a Chebyshev series. Derivatives are Bezier
    curves of the differences ``d (B_{k+1} − B_k)``.
    """

    kind = "bezier"
    highest_order = 3

    def __init__(self, control_points: Positions) -> None:
        points = plane_or_space("control_points", control_points, 2)
        if len(points) < 2:
            raise InvalidInputError("control_points", f"has {len(points)} point", "give at least two", control_points)
        if len(points) > _MOST_POINTS:
            remedy = f"give at most {_MOST_POINTS}; kind waypoints goes through points, kind concatenation joins curves"
            raise InvalidInputError("control_points", f"has {len(points)} points", remedy)
        if (points == points[0]).all():
            raise InvalidInputError(
                "control_points", "all coincide: the path has no length", "move one of them", control_points
            )
        self.control_points = read_only(points)
        self.dimension = points.shape[1]
        self._chebyshev: list[Any] = []
        if len(points) - 1 > _MOST_CASTELJAU:
            nodes: Any = lambda t: self._casteljau((t + 1) / 2, 0)  # noqa: E731
            series = chebinterpolate(nodes, len(points) - 1)
            self._chebyshev = [series, 2 * chebder(series), 4 * chebder(series, 2), 8 * chebder(series, 3)]

    def __repr__(self) -> str:
        return f"Bezier({self.control_points.tolist()})"

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        if self._chebyshev:
            return np.asarray(chebval(2 * r - 1, self._chebyshev[order]).T)
        return self._casteljau(r, order)

    def _casteljau(self, r: FloatArray, order: int) -> FloatArray:
        points = self.control_points
        for _ in range(order):
            degree = len(points) - 1
            points = degree * np.diff(points, axis=0) if degree > 0 else np.zeros((1, self.dimension))
        layer = np.repeat(points[:, :, None], len(r), axis=2)  # r last: long loops
        while len(layer) > 1:
            layer = (1 - r) * layer[:-1] + r * layer[1:]
        return np.ascontiguousarray(layer[0].T)

    def _fastest(self, low: float, high: float) -> float:
        """Bound the speed by the control points of the derivative, a Bezier curve itself, cut down to the part."""
        return self._largest(1, low, high)

    def _bending(self, low: float, high: float) -> float:
        return self._largest(2, low, high)

    def _largest(self, order: int, low: float, high: float) -> float:
        """Bound a derivative by its control points."""
        points = self.control_points
        for degree in range(len(points) - 1, len(points) - 1 - order, -1):
            points = degree * np.diff(points, axis=0)
        if not len(points):
            return 0.0
        if high < 1.0:
            points = _first_part(points, high)
        if low > 0.0:
            points = _first_part(points[::-1], 1.0 - low / high)[::-1]
        return float(distance(points).max())


def _first_part(points: FloatArray, t: float) -> FloatArray:
    """Return the control points of a Bezier curve's part from its start to its parameter `t`."""
    found = [points[0]]
    while len(points) > 1:
        points = (1.0 - t) * points[:-1] + t * points[1:]
        found.append(points[0])
    return np.array(found)
