"""Rose curves."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import finite_array, number, positive, read_only, sweep_angle
from selfmotion._types import FloatArray, Point
from selfmotion.paths.base import Path, largest_cosine


class Rose(Path):
    """A rose (rhodonea) curve.

    Parameters
    ----------
    center : array_like, shape (2,)
    radius : float
        Length of a petal, positive.
    petals : float
        The k of ``ρ = a cos(kφ)``: an odd k has k petals, an even one 2k.
    sweep : float
        Angle φ run through [rad]; π closes an odd rose, 2π an even one.
    rotation : float
        Direction of the first petal [rad].

    Raises
    ------
    InvalidInputError
        If the radius is not positive or the sweep is zero.

    Notes
    -----
    With ``ρ = a cos(kφ)`` the curve is a sum of two rotations,
    ``x = c + a/2 (e(rotation + (1+k)φ) + e(rotation + (1−k)φ))``, e(α) the unit vector of direction α.
    """

    kind = "rose"
    highest_order = 3

    def __init__(
        self, center: Point, radius: float, petals: float, sweep: float = 2 * np.pi, rotation: float = 0.0
    ) -> None:
        self.center = read_only(finite_array("center", center, 1, 2))
        self.radius = positive("radius", radius)
        self.petals = number("petals", petals, -1e3, 1e3)
        self.sweep = sweep_angle("sweep", sweep)
        self.rotation = number("rotation", rotation, -1e3, 1e3)

    def __repr__(self) -> str:
        return (
            f"Rose({self.center.tolist()}, {self.radius!r}, {self.petals!r}, sweep={self.sweep!r}, "
            f"rotation={self.rotation!r})"
        )

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        total = np.zeros((len(r), 2))
        for turns in (1 + self.petals, 1 - self.petals):
            rate = turns * self.sweep
            angle = self.rotation + rate * r + order * np.pi / 2
            total += self.radius / 2 * rate**order * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        return total + self.center if order == 0 else total

    def _fastest(self, low: float, high: float) -> float:
        # Two rotations of rates a and b, 2kφ apart: |x'|² = (radius/2)² (a² + b² + 2ab cos 2kφ)
        a, b = (1 + self.petals) * self.sweep, (1 - self.petals) * self.sweep
        ends = 2.0 * self.petals * self.sweep * np.array([low, high])
        most = largest_cosine(float(ends.min()), float(ends.max()), negative=a * b < 0)
        return 0.5 * self.radius * float(np.sqrt(max(a * a + b * b + 2 * abs(a * b) * most, 0.0)))

    def _bending(self, low: float, high: float) -> float:
        rates = np.array([1 + self.petals, 1 - self.petals]) * self.sweep
        return 0.5 * self.radius * float((rates**2).sum())
