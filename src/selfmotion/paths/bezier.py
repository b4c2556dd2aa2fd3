"""Bezier curves of any degree, by de Casteljau's algorithm."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import finite_array, read_only
from selfmotion._types import FloatArray, Points
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path


class Bezier(Path):
    """A Bezier curve.

    Parameters
    ----------
    control_points : array_like, shape (d + 1, 2)
        At least two points, not all the same; d is the degree.

    Raises
    ------
    InvalidInputError
        If there are fewer than two control points, or they all coincide.

    Notes
    -----
    ``x(r) = Σ_k C(d, k) r^k (1 − r)^(d−k) B_k``; de Casteljau's convex combinations keep it stable at any
    degree. Derivatives are Bezier curves of the differences ``d (B_{k+1} − B_k)``.
    """

    kind = "bezier"

    def __init__(self, control_points: Points) -> None:
        points = finite_array("control_points", control_points, 2, 2)
        if len(points) < 2:
            raise InvalidInputError("control_points", f"has {len(points)} point", "give at least two", control_points)
        if (points == points[0]).all():
            raise InvalidInputError(
                "control_points", "all coincide: the path has no length", "move one of them", control_points
            )
        self.control_points = read_only(points)

    def __repr__(self) -> str:
        return f"Bezier({self.control_points.tolist()})"

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        points = self.control_points
        for _ in range(order):
            degree = len(points) - 1
            points = degree * np.diff(points, axis=0) if degree > 0 else np.zeros((1, 2))
        layer = np.repeat(points[:, None, :], len(r), axis=1)
        t = r[:, None]
        while len(layer) > 1:
            layer = (1 - t) * layer[:-1] + t * layer[1:]
        return layer[0]
