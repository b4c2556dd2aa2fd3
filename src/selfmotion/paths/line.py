"""Straight lines."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import finite_array, read_only
from selfmotion._types import FloatArray, Point
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path


class Line(Path):
    """The straight line from `start` to `end`, run at constant speed.

    Parameters
    ----------
    start, end : array_like, shape (2,)
        Its ends, not the same.

    Raises
    ------
    InvalidInputError
        If the ends coincide.
    """

    kind = "line"

    def __init__(self, start: Point, end: Point) -> None:
        self.start = read_only(finite_array("start", start, 1, 2))
        self.end = read_only(finite_array("end", end, 1, 2))
        if (self.start == self.end).all():
            raise InvalidInputError("end", "equals start: the path has no length", "give another point", end)

    def __repr__(self) -> str:
        return f"Line({self.start.tolist()}, {self.end.tolist()})"

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        t = r[:, None]
        if order == 0:
            return (1 - t) * self.start + t * self.end
        return np.tile(self.end - self.start if order == 1 else np.zeros(2), (len(r), 1))

    def _fastest(self, low: float, high: float) -> float:
        return float(np.hypot(*(self.end - self.start)))
