"""Circles, circular arcs and ellipses: one curve, three signatures."""

from __future__ import annotations

import numpy as np

from selfmotion._checks import finite_array, number, positive, positive_pair, read_only, sweep_angle
from selfmotion._types import FloatArray, Point
from selfmotion.paths.base import Path, largest_cosine


class Ellipse(Path):
    """An ellipse or a part of one.

    Parameters
    ----------
    center : array_like, shape (2,)
    radii : array_like, shape (2,)
        The two semi-axes, positive.
    rotation : float
        Angle from the x-axis to the first semi-axis [rad].
    start_angle : float
        Eccentric angle of the first point [rad].
    sweep : float
        Eccentric angle run through [rad], positive counter-clockwise; not zero, at most 1e4.

    Raises
    ------
    InvalidInputError
        If a radius is not positive or the sweep is zero.

    Notes
    -----
    ``x(φ) = c + Rot(rotation) (a cos φ, b sin φ)``, φ linear in r.
    """

    kind = "ellipse"
    highest_order = 3

    def __init__(
        self,
        center: Point,
        radii: Point,
        rotation: float = 0.0,
        start_angle: float = 0.0,
        sweep: float = 2 * np.pi,
    ) -> None:
        self.center = read_only(finite_array("center", center, 1, 2))
        self.radii = read_only(positive_pair("radii", radii))
        self.rotation = number("rotation", rotation, -1e3, 1e3)
        self.start_angle = number("start_angle", start_angle, -1e3, 1e3)
        self.sweep = sweep_angle("sweep", sweep)

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}(center={self.center.tolist()}, radii={self.radii.tolist()}, "
            f"rotation={self.rotation!r}, start_angle={self.start_angle!r}, sweep={self.sweep!r})"
        )

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        angle = self.start_angle + self.sweep * r + order * np.pi / 2
        local = self.sweep**order * self.radii * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        c, s = np.cos(self.rotation), np.sin(self.rotation)
        turned = local @ np.array([[c, s], [-s, c]])
        return turned + self.center if order == 0 else turned

    def _fastest(self, low: float, high: float) -> float:
        # |dx/dφ|² = (a² + b²)/2 + (b² − a²)/2 cos 2φ
        a, b = self.radii
        ends = 2.0 * (self.start_angle + self.sweep * np.array([low, high]))
        most = largest_cosine(float(ends.min()), float(ends.max()), negative=bool(a > b))
        square = 0.5 * (a * a + b * b + abs(a * a - b * b) * most)
        return abs(self.sweep) * float(np.sqrt(square))

    def _bending(self, low: float, high: float) -> float:
        return self.sweep**2 * float(self.radii.max())


class Circle(Ellipse):
    """A full circle.

    Parameters
    ----------
    center : array_like, shape (2,)
    radius : float
        Positive.
    start_angle : float
        Direction from the centre to the first point [rad].
    clockwise : bool
        Sense of rotation.

    Raises
    ------
    InvalidInputError
        If the radius is not positive.
    """

    kind = "circle"

    def __init__(self, center: Point, radius: float, start_angle: float = 0.0, clockwise: bool = False) -> None:
        radius = positive("radius", radius)
        super().__init__(center, [radius, radius], 0.0, start_angle, -2 * np.pi if clockwise else 2 * np.pi)


class Arc(Ellipse):
    """A circular arc.

    Parameters
    ----------
    center : array_like, shape (2,)
    radius : float
        Positive.
    start_angle : float
        Direction from the centre to the first point [rad].
    sweep : float
        Angle run through [rad], positive counter-clockwise; not zero, at most 1e4.

    Raises
    ------
    InvalidInputError
        If the radius is not positive or the sweep is zero.
    """

    kind = "arc"

    def __init__(self, center: Point, radius: float, start_angle: float, sweep: float) -> None:
        radius = positive("radius", radius)
        super().__init__(center, [radius, radius], 0.0, start_angle, sweep)
