"""Obstacles that a few numbers describe, and all obstacles by the key that they have in a problem file."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from selfmotion._checks import finite_array, positive, read_only
from selfmotion._types import FloatArray, Point, SpacePoint, Vector
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import from_rpy, matrix, unlikely_rpy
from selfmotion.scene.kinds import BOX, CAPSULE, HALF_SPACE, SPHERE
from selfmotion.scene.mesh import MeshObstacle
from selfmotion.scene.obstacle import Obstacle
from selfmotion.scene.polygon import PolygonObstacle


class _Round(Obstacle):
    """All points within a radius of a centre."""

    fields: ClassVar = {"center": "center", "radius": "radius"}

    def __init__(self, center: Vector, radius: float, name: str | None = None) -> None:
        super().__init__(name)
        self.center = read_only(finite_array("center", center, 1, self.dimension))
        self.radius = positive("radius", radius)

    def shape(self) -> tuple[int, FloatArray]:
        """Return the kind and the numbers of a sphere: centre and radius, shape (4,)."""
        return SPHERE, np.array([*_in_space(self.center), self.radius])


class CircleObstacle(_Round):
    """A disc in the plane.

    Parameters
    ----------
    center : array_like, shape (2,)
    radius : float
        Greater than zero.
    name : str, optional

    Raises
    ------
    InvalidInputError
        If a value is not finite or the radius not positive.
    """

    kind = "circle"
    dimension = 2

    def __init__(self, center: Point, radius: float, name: str | None = None) -> None:
        super().__init__(center, radius, name)


class SphereObstacle(_Round):
    """A ball in space.

    Parameters
    ----------
    center : array_like, shape (3,)
        [m]
    radius : float
        Greater than zero [m].
    name : str, optional

    Raises
    ------
    InvalidInputError
        If a value is not finite or the radius not positive.
    """

    kind = "sphere"
    dimension = 3

    def __init__(self, center: SpacePoint, radius: float, name: str | None = None) -> None:
        super().__init__(center, radius, name)


class _Side(Obstacle):
    """All points on one side of a line or a plane: n·(p − point) ≤ 0."""

    fields: ClassVar = {"point": "point", "normal": "normal"}

    def __init__(self, point: Vector, normal: Vector, name: str | None = None) -> None:
        super().__init__(name)
        self.point = read_only(finite_array("point", point, 1, self.dimension))
        self.normal = read_only(finite_array("normal", normal, 1, self.dimension))
        if not self.normal.any():
            raise InvalidInputError("normal", "is zero", "give the direction in which it is free", normal)

    def shape(self) -> tuple[int, FloatArray]:
        """Return the kind and the numbers of a half-space: unit normal and offset, shape (4,)."""
        unit = _in_space(self.normal / np.abs(self.normal).max())
        unit /= np.linalg.norm(unit)
        return HALF_SPACE, np.array([*unit, unit @ _in_space(self.point)])


class HalfPlaneObstacle(_Side):
    """All of the plane on one side of a line, such as a wall.

    Parameters
    ----------
    point : array_like, shape (2,)
        On the line.
    normal : array_like, shape (2,)
        Across the line, to the side that is free; of any length but zero.
    name : str, optional

    Raises
    ------
    InvalidInputError
        If a value is not finite or the normal zero.
    """

    kind = "half_plane"
    dimension = 2

    def __init__(self, point: Point, normal: Point, name: str | None = None) -> None:
        super().__init__(point, normal, name)


class HalfSpaceObstacle(_Side):
    """All of space on one side of a plane, such as a floor.

    Parameters
    ----------
    point : array_like, shape (3,)
        In the plane [m].
    normal : array_like, shape (3,)
        Across the plane, to the side that is free; of any length but zero.
    name : str, optional

    Raises
    ------
    InvalidInputError
        If a value is not finite or the normal zero.
    """

    kind = "half_space"
    dimension = 3

    def __init__(self, point: SpacePoint, normal: SpacePoint, name: str | None = None) -> None:
        super().__init__(point, normal, name)


class BoxObstacle(Obstacle):
    """A box in space, turned as one likes.

    Parameters
    ----------
    center : array_like, shape (3,)
        [m]
    size : array_like, shape (3,)
        Whole lengths of its edges, greater than zero [m].
    rpy : array_like, shape (3,)
        Roll, pitch and yaw: turns about the fixed x, then y, then z axis [rad].
    name : str, optional

    Raises
    ------
    InvalidInputError
        If a value is not finite or a size not positive.
    """

    kind = "box"
    dimension = 3
    fields: ClassVar = {"center": "center", "size": "size", "rpy": "rpy"}

    def __init__(
        self, center: SpacePoint, size: SpacePoint, rpy: SpacePoint = (0.0, 0.0, 0.0), name: str | None = None
    ) -> None:
        super().__init__(name)
        self.center = read_only(finite_array("center", center, 1, 3))
        self.size = read_only(finite_array("size", size, 1, 3))
        if not (self.size > 0).all():
            raise InvalidInputError("size", "must be greater than zero", "give three positive lengths", size)
        self.rotation = read_only(matrix(from_rpy("rpy", rpy)))
        self.rpy = read_only(finite_array("rpy", rpy, 1, 3))

    def shape(self) -> tuple[int, FloatArray]:
        """Return the kind and the numbers of a box: centre, half sizes, rotation row by row, shape (15,)."""
        return BOX, np.concatenate([self.center, 0.5 * self.size, self.rotation.ravel()])

    def doubts(self, reach: float) -> list[str]:
        """Return whether its turns may be in degrees."""
        doubt = unlikely_rpy(self.rpy)
        return [] if doubt is None else [doubt]


class CapsuleObstacle(Obstacle):
    """A rod in space with round ends: all points within a radius of a segment.

    Parameters
    ----------
    start, end : array_like, shape (3,)
        Ends of the segment, ``from`` and ``to`` in a problem file [m]. They may be the same.
    radius : float
        Greater than zero [m].
    name : str, optional

    Raises
    ------
    InvalidInputError
        If a value is not finite or the radius not positive.
    """

    kind = "capsule"
    dimension = 3
    fields: ClassVar = {"start": "from", "end": "to", "radius": "radius"}

    def __init__(self, start: SpacePoint, end: SpacePoint, radius: float, name: str | None = None) -> None:
        super().__init__(name)
        self.start = read_only(finite_array("start", start, 1, 3))
        self.end = read_only(finite_array("end", end, 1, 3))
        self.radius = positive("radius", radius)

    def shape(self) -> tuple[int, FloatArray]:
        """Return the kind and the numbers of a capsule: both ends and the radius, shape (7,)."""
        return CAPSULE, np.array([*self.start, *self.end, self.radius])


OBSTACLES: dict[str, type[Obstacle]] = {
    obstacle.kind: obstacle
    for obstacle in (
        CircleObstacle,
        PolygonObstacle,
        HalfPlaneObstacle,
        SphereObstacle,
        HalfSpaceObstacle,
        BoxObstacle,
        CapsuleObstacle,
        MeshObstacle,
    )
}
"""Every obstacle by its key in a problem file."""


def _in_space(point: FloatArray) -> FloatArray:
    """Return a point of the plane as the one of space with z = 0; one of space as it is."""
    return np.concatenate([point, np.zeros(3 - len(point))])
