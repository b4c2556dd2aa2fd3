"""Straight lines."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import finite_array, read_only
from selfmotion._types import FloatArray, Position
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path, distance, plane_or_space


class Line(Path):
    """The straight line from `start` to `end`, run at constant speed.

    Parameters
    ----------
    start, end : array_like, shape (2,) or (3,)
        Its ends, not the same, in the plane or in space.

    Raises
    ------
    InvalidInputError
        If the ends coincide, or one lies in the plane and the other in space.
    """

    kind = "line"
    highest_order = 3

    def __init__(self, start: Position, end: Position) -> None:
        self.start = read_only(plane_or_space("start", start, 1))
        self.end = read_only(finite_array("end", end, 1, len(self.start)))
        if (self.start == self.end).all():
            raise InvalidInputError("end", "equals start: the path has no length", "give another point", end)
        self.dimension = len(self.start)

    def __repr__(self) -> str:
        return f"Line({self.start.tolist()}, {self.end.tolist()})"

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        t = r[:, None]
        if order == 0:
            return (1 - t) * self.start + t * self.end
        return np.tile(self.end - self.start if order == 1 else np.zeros(self.dimension), (len(r), 1))

    def _fastest(self, low: float, high: float) -> float:
        return float(distance(self.end - self.start))

    def _bending(self, low: float, high: float) -> float:
        return 0.0
