"""Meshes as obstacles in space: solids of triangles, whose distances are measured by coal."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from selfmotion._checks import finite_array, positive, read_only
from selfmotion._types import BoolArray, FileName, FloatArray, IntArray, SpacePoint
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import from_rpy, matrix, unlikely_rpy
from selfmotion.scene.extra import coal
from selfmotion.scene.kinds import MESH
from selfmotion.scene.mesh_file import load_triangles
from selfmotion.scene.obstacle import Obstacle
from selfmotion.units import unlikely_mesh

MOST_TRIANGLES = 500_000
"""From more triangles a mesh is refused."""
_PLACES = np.linspace(0.0, 1.0, 9)  # of a segment that meets the mesh, where it is looked for what is inside
_SIZE = 1000.0  # of the mesh in coal, whose tolerances are lengths whatever the unit
_SHORT = 1e-4  # taken off from what coal measures there: it found up to 1e-5 too much, of needles
_SHORTER = 2.0 * _SHORT  # by which it is too small at most, with what coal itself may be wrong by
_HULL = "close it, or ask for its convex hull: hull: true"


class MeshObstacle(Obstacle):
    """A solid in space that a mesh of triangles encloses, from an STL or OBJ file.

    Distances need coal, of the extra ``scene``.

    Parameters
    ----------
    file : str
        ``.stl`` or ``.obj``.
    position : array_like, shape (3,)
        Of the mesh's origin [m].
    rpy : array_like, shape (3,)
        Roll, pitch and yaw of the mesh's frame: turns about the fixed x, then y, then z axis [rad].
    scale : float
        What its coordinates are multiplied by, such as 0.001 where they are millimetres.
    hull : bool
        Whether its convex hull is meant. Without, the mesh must be closed: what is inside has to be told.
    name : str, optional

    Attributes
    ----------
    vertices : array, shape (k, 3)
        In the world [m], none twice.
    triangles : array of int, shape (m, 3)

    Raises
    ------
    InvalidInputError
        If the file cannot be read or is no mesh, if it is not closed, or if a value is not finite.
    """

    kind = "mesh"
    dimension = 3
    vertices: FloatArray
    triangles: IntArray
    _rpy = np.zeros(3)  # as given, of a mesh from a file
    fields: ClassVar = {"vertices": "vertices", "triangles": "triangles"}

    def __init__(
        self,
        file: FileName,
        position: SpacePoint = (0.0, 0.0, 0.0),
        rpy: SpacePoint = (0.0, 0.0, 0.0),
        scale: float = 1.0,
        hull: bool = False,
        name: str | None = None,
    ) -> None:
        super().__init__(name)
        origin, turn = finite_array("position", position, 1, 3), matrix(from_rpy("rpy", rpy))
        self._rpy, by = finite_array("rpy", rpy, 1, 3), positive("scale", scale)
        try:
            vertices, triangles = load_triangles(file)
            if hull:
                vertices, triangles = _hull(vertices)
            self._hold(vertices, triangles)
        except InvalidInputError as error:
            raise type(error)("file", f"{file}: {error.reason}", error.remedy, error.value) from None
        self.vertices = read_only(finite_array("scale", by * self.vertices @ turn.T + origin, 2, 3))

    @classmethod
    def of_triangles(cls, vertices: Any, triangles: Any, name: str | None = None) -> MeshObstacle:
        """Return a mesh of triangles in the world.

        Parameters
        ----------
        vertices : array_like, shape (k, 3)
            [m]
        triangles : array_like of int, shape (m, 3)
            Which vertices, all counter-clockwise seen from outside.
        name : str, optional

        Raises
        ------
        InvalidInputError
            If it is not closed, a value is not finite, or a vertex is not there.
        """
        made = cls.__new__(cls)
        Obstacle.__init__(made, name)
        made._hold(finite_array("vertices", vertices, 2, 3), finite_array("triangles", triangles, 2, 3))
        return made

    def _hold(self, vertices: FloatArray, triangles: Any) -> None:
        """Take a mesh over: equal vertices become one, which files of triangles leave to their reader."""
        if len(triangles) > MOST_TRIANGLES:
            raise InvalidInputError(
                "triangles", f"are {len(triangles)}, more than {MOST_TRIANGLES}", "simplify the mesh"
            )
        given = np.asarray(triangles).astype(np.intp)
        if not len(given) or not (given == triangles).all() or given.min() < 0 or given.max() >= len(vertices):
            reason, remedy = "are not numbers of vertices", "give three for each triangle, counted from 0"
            raise InvalidInputError("triangles", reason, remedy)
        found, place = np.unique(vertices[given.ravel()] + 0.0, axis=0, return_inverse=True)
        merged = place.reshape(-1, 3)
        merged = merged[(merged != np.roll(merged, 1, axis=1)).all(axis=1)]
        _refuse_open(merged, found)
        self.vertices, self.triangles = read_only(found), merged

    def shape(self) -> tuple[int, FloatArray]:
        """Return the kind of a mesh, which kernels leave to :meth:`distances`, and no numbers, shape (0,)."""
        return MESH, np.empty(0)

    def doubts(self, reach: float) -> list[str]:
        """Return whether its numbers may be in another unit, and its turns in degrees."""
        extent = float(np.ptp(self.vertices, axis=0).max())
        found = unlikely_mesh(extent, reach), unlikely_rpy(self._rpy)
        return [doubt for doubt in found if doubt is not None]

    @cached_property
    def _corners(self) -> FloatArray:
        return np.ascontiguousarray(self.vertices[self.triangles])

    @cached_property
    def _unit(self) -> float:
        """How much larger the mesh is in coal."""
        return _SIZE / float(np.ptp(self.vertices, axis=0).max())

    @cached_property
    def _model(self) -> Any:
        """What coal has of the mesh, its triangles without area left out: their neighbours cover them."""
        model = coal().BVHModelOBBRSS()
        a, b, c = np.moveaxis(self._unit * (self._corners - self.vertices[0]), 1, 0)
        model.beginModel(len(self.triangles), 3 * len(self.triangles))
        for k in np.flatnonzero(np.cross(b - a, c - a).any(axis=1)):
            model.addTriangle(a[k], b[k], c[k])
        model.endModel()
        return model

    def distances(self, p: FloatArray, q: FloatArray) -> FloatArray:
        """Return the signed distances of segments; see :meth:`nearest`.

        Parameters
        ----------
        p, q : array, shape (k, 3)
            Their ends [m].

        Returns
        -------
        array, shape (k,)
            [m]
        """
        return self.nearest(p, q)[0]

    def nearest(self, p: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the signed distances of segments, and where and along what they are measured.

        Parameters
        ----------
        p, q : array, shape (k, 3)
            Their ends [m].

        Returns
        -------
        distance : array, shape (k,)
            The least distance of a segment disjoint from the solid. Else minus the depth of the deepest of nine points
            of the segment, or zero if none of these is inside [m]. Less by 1e-7 of the mesh's size, and no less than
            zero, either is a bound of the exact one in spite of coal's tolerances.
        at : array, shape (k, 3)
            The points of the segments concerned.
        normal : array, shape (k, 3)
            Unit directions in which moving those points raises the distance.

        Raises
        ------
        MissingExtraError
            Without coal.
        """
        distance, at, on = self._from_surface(p, q)
        normal = _directions(at - on)
        for k in np.flatnonzero((distance <= 0.0) | self._in_box(at)):
            if distance[k] <= 0.0 or self._has_inside(at[k]):
                distance[k] = 0.0
                deepest = self._deepest(p[k] + _PLACES[:, None] * (q[k] - p[k]))
                if deepest is not None:
                    distance[k], at[k], normal[k] = deepest
        return distance, at, normal

    @property
    def shortfall(self) -> float:
        """What distances may be too small by [m]."""
        return _SHORTER / self._unit

    def no_less(self, p: FloatArray, q: FloatArray) -> FloatArray:
        """Return what the distances of segments (k, 3) are no less than, from the mesh's extent alone; shape (k,)."""
        apart = np.maximum(np.minimum(p, q) - self._extent[1], self._extent[0] - np.maximum(p, q))
        return np.maximum(np.linalg.norm(np.maximum(apart, 0.0), axis=1) - _SHORT / self._unit, 0.0)

    def no_more(self, p: FloatArray) -> FloatArray:
        """Return what the distances of points (k, 3) are no more than; shape (k,)."""
        return np.asarray(np.linalg.norm(p - self.vertices[0], axis=1))

    def _deepest(self, points: FloatArray) -> tuple[float, FloatArray, FloatArray] | None:
        """Return minus the depth of the deepest of some points, that point and its way out; None if none is inside."""
        points = points[[self._has_inside(point) for point in points]]
        if not len(points):
            return None
        depth, _, on = self._from_surface(points, points)
        k = int(depth.argmax())
        return (-float(depth[k]), points[k], _directions(on[[k]] - points[[k]])[0]) if depth[k] > 0.0 else None

    def _from_surface(self, p: FloatArray, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how far segments are from the triangles, and the nearest points of them and of the triangles."""
        package, origin, unit = coal(), self.vertices[0], self._unit
        start, d = unit * (p - origin), unit * (q - p)
        length, middle = np.linalg.norm(d, axis=1), start + 0.5 * d
        frames = _frames(d, length)
        model, here, request = self._model, package.Transform3s(), package.DistanceRequest()
        away, points = np.empty(len(p)), np.empty((len(p), 2, 3))
        for k in range(len(p)):
            link = package.Capsule(0.0, length[k]) if length[k] > 0.0 else package.Sphere(0.0)
            result = package.DistanceResult()
            away[k] = package.distance(link, package.Transform3s(frames[k], middle[k]), model, here, request, result)
            points[k, 0], points[k, 1] = result.getNearestPoint1(), result.getNearestPoint2()
        known = (np.abs(points) <= (length + _SIZE + np.abs(start).max(axis=1))[:, None, None]).all(axis=(1, 2))
        points[~known] = middle[~known, None]  # where they meet coal may not say where
        at, on = points[:, 0] / unit + origin, points[:, 1] / unit + origin
        return np.maximum(away - _SHORT, 0.0) / unit, at, on

    @cached_property
    def _extent(self) -> tuple[FloatArray, FloatArray]:
        return self.vertices.min(axis=0), self.vertices.max(axis=0)

    def _in_box(self, points: FloatArray) -> BoolArray:
        return np.asarray(((points >= self._extent[0]) & (points <= self._extent[1])).all(axis=-1))

    def _has_inside(self, point: FloatArray) -> bool:
        from selfmotion.scene._mesh_kernels import winding  # compiled, which reading a mesh does without

        return bool(self._in_box(point)) and abs(winding(self._corners, point)) > 0.5


def _refuse_open(triangles: IntArray, vertices: FloatArray) -> None:
    """Refuse triangles that enclose nothing: in a closed mesh every edge is passed as often one way as the other."""
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    count = len(vertices)
    way = np.sign(edges[:, 1] - edges[:, 0])
    key = edges.min(axis=1) * count + edges.max(axis=1)
    names, place = np.unique(key, return_inverse=True)
    total = np.bincount(place.reshape(-1), weights=way)
    wrong = np.flatnonzero(total)
    if not len(triangles):
        raise InvalidInputError("", "has triangles without area only", "mend it")
    if len(wrong):
        a, b = (vertices[k] for k in divmod(int(names[wrong[0]]), count))
        where = f"({a[0]:.6g}, {a[1]:.6g}, {a[2]:.6g}) to ({b[0]:.6g}, {b[1]:.6g}, {b[2]:.6g})"
        reason = f"is not closed, so that inside is not told: {len(wrong)} of its edges bound triangles on one side, or"
        raise InvalidInputError("", f"{reason} triangles that face different ways, such as from {where}", _HULL)


def _hull(vertices: FloatArray) -> tuple[FloatArray, IntArray]:
    """Return the convex hull of points, its triangles counter-clockwise seen from outside."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(vertices)
    except (QhullError, ValueError):
        raise InvalidInputError("", "has a flat convex hull, which encloses nothing", "give a solid") from None
    corners = vertices[hull.simplices]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    away = np.einsum("ij,ij->i", outward, corners[:, 0] - vertices[hull.vertices].mean(axis=0))
    return vertices, np.where(away[:, None] < 0, hull.simplices[:, ::-1], hull.simplices)


def _frames(d: FloatArray, length: FloatArray) -> FloatArray:
    """Return rotations (k, 3, 3) whose third axes point along d (k, 3) of given length; any where that is zero."""
    z = np.where(length[:, None] > 0.0, d / np.where(length > 0.0, length, 1.0)[:, None], [0.0, 0.0, 1.0])
    x = np.cross(z, np.eye(3)[np.abs(z).argmin(axis=1)])
    x /= np.linalg.norm(x, axis=1)[:, None]
    return np.stack([x, np.cross(z, x), z], axis=2)


def _directions(v: FloatArray) -> FloatArray:
    """Return the directions of vectors (k, 3); of one without length, any."""
    size = np.linalg.norm(v, axis=1)[:, None]
    return np.where(size > 0.0, v / np.where(size > 0.0, size, 1.0), [0.0, 0.0, 1.0])
