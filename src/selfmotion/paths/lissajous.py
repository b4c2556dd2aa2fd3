"""Lissajous figures."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import finite_array, number, positive_pair, read_only
from selfmotion._types import FloatArray, Point
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import Path, largest_cosine


class Lissajous(Path):
    """A Lissajous figure.

    Parameters
    ----------
    center : array_like, shape (2,)
    radii : array_like, shape (2,)
        Half width and half height, positive.
    frequencies : array_like, shape (2,)
        Oscillations in x and in y over the path; not both zero.
    phase : float
        Phase of the x oscillation at r = 0 [rad].

    Raises
    ------
    InvalidInputError
        If a radius is not positive or nothing oscillates.

    Notes
    -----
    ``x = x_c + a sin(2π p r + phase)``, ``y = y_c + b sin(2π q r)``.
    """

    kind = "lissajous"
    highest_order = 3

    def __init__(self, center: Point, radii: Point, frequencies: Point, phase: float = 0.0) -> None:
        self.center = read_only(finite_array("center", center, 1, 2))
        self.radii = read_only(positive_pair("radii", radii))
        self.frequencies = read_only(finite_array("frequencies", frequencies, 1, 2))
        for frequency in self.frequencies:
            number("frequencies", float(frequency), -1e4, 1e4)
        if not self.frequencies.any():
            raise InvalidInputError("frequencies", "are both zero: the path has no length", "give one", frequencies)
        self.phase = number("phase", phase, -1e3, 1e3)

    def __repr__(self) -> str:
        return f"Lissajous({self.center.tolist()}, {self.radii.tolist()}, {self.frequencies.tolist()}, {self.phase!r})"

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        rates = 2 * np.pi * self.frequencies
        waves = self.radii * rates**order * np.sin(r[:, None] * rates + np.array([self.phase, 0.0]) + order * np.pi / 2)
        return waves + self.center if order == 0 else waves

    def _fastest(self, low: float, high: float) -> float:
        speeds = []
        for radius, frequency, phase in zip(self.radii, self.frequencies, (self.phase, 0.0), strict=True):
            # |cos α|² = (1 + cos 2α)/2
            ends = 2.0 * (2 * np.pi * frequency * np.array([low, high]) + phase)
            square = 0.5 * (1.0 + largest_cosine(float(ends.min()), float(ends.max())))
            speeds.append(2 * np.pi * abs(frequency) * radius * np.sqrt(square))
        return float(np.hypot(*speeds))

    def _bending(self, low: float, high: float) -> float:
        return float(np.hypot(*(self.radii * (2 * np.pi * self.frequencies) ** 2)))
