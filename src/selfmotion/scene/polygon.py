"""Polygons as obstacles of the plane."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from selfmotion._checks import finite_array, number, read_only
from selfmotion._types import FloatArray, Points
from selfmotion.errors import InvalidInputError
from selfmotion.scene.extra import shapely
from selfmotion.scene.kinds import POLYGON
from selfmotion.scene.obstacle import Obstacle

MOST_CORNERS = 10_000
"""From more corners a polygon is refused: every distance looks at every edge."""
_FLAT = 1e-14  # width by length that is none but for rounding
_ARC = 16  # straight parts of a quarter of a circle, in what is grown


class PolygonObstacle(Obstacle):
    """A polygon in the plane with all that is inside; it need not be convex.

    Parameters
    ----------
    corners : array_like, shape (k, 2)
        In their order, either way round, at most 10,000; the last may repeat the first.
    name : str, optional

    Attributes
    ----------
    corners : array, shape (k, 2)
        Counter-clockwise, none twice.

    Raises
    ------
    InvalidInputError
        If there are fewer than three corners or too many, a value is not finite, a corner comes twice in a row, the
        polygon has no area, or its edges touch or cross: then it says which do, and where.
    """

    kind = "polygon"
    dimension = 2
    fields: ClassVar = {"corners": ""}

    def __init__(self, corners: Points, name: str | None = None) -> None:
        super().__init__(name)
        given = finite_array("corners", corners, 2, 2)
        if len(given) > 1 and (given[0] == given[-1]).all():
            given = given[:-1]
        if len(given) < 3:
            raise InvalidInputError("corners", f"has {len(given)} corners", "give three or more", corners)
        if len(given) > MOST_CORNERS:
            raise InvalidInputError("corners", f"has {len(given)} corners, more than {MOST_CORNERS}", "simplify it")
        for k in np.flatnonzero((given == np.roll(given, 1, axis=0)).all(axis=1)):
            remedy = "leave one of the two out"
            raise InvalidInputError("corners", f"has corner {k} twice in a row, at {_text(given[k])}", remedy)
        if _are_on_a_line(given):
            raise InvalidInputError("corners", "encloses no area", "give corners that are not on one line", corners)
        _refuse_meetings(given)
        self.corners = read_only(given if _area(given) > 0 else np.ascontiguousarray(given[::-1]))

    def shape(self) -> tuple[int, FloatArray]:
        """Return the kind and the numbers of a polygon: how many corners, then x y of each, shape (1 + 2k,)."""
        return POLYGON, np.array([len(self.corners), *self.corners.ravel()])

    @property
    def area(self) -> float:
        """Its area, greater than zero."""
        return float(_area(self.corners))

    def offset(self, distance: float) -> list[PolygonObstacle]:
        """Return what is within a distance of it, or with a negative one, what is deeper inside than that.

        Parameters
        ----------
        distance : float

        Returns
        -------
        list of PolygonObstacle
            Together they cover all of that, and nothing beyond it by more than 0.13 % of the distance: round corners
            are made of straight parts. Where it shrinks there may be several or none; a hole that closes where it grows
            cuts it in two.

        Raises
        ------
        InvalidInputError
            If the distance is not finite.
        MissingExtraError
            Without shapely, of the extra ``scene``.
        """
        far = number("distance", distance)
        # Chords of an arc are inside of it: of what grows they would leave out something, of what shrinks they do not.
        around = far / np.cos(np.pi / (4 * _ARC)) if far > 0 else far
        grown = shapely().buffer(shapely().Polygon(self.corners), around, quad_segs=_ARC)
        return polygons_of(grown, self.name)


def polygons_of(geometry: object, name: str | None = None) -> list[PolygonObstacle]:
    """Return a geometry of shapely, polygons of one or several parts, as obstacles; none for an empty one.

    Polygons with holes are cut in two through each hole, along a line on which both parts then end.

    Raises
    ------
    InvalidInputError
        If there is anything else in it, or what is not allowed of a polygon.
    """
    found: list[PolygonObstacle] = []
    for part in shapely().get_parts(geometry):
        if part.geom_type.startswith("Multi") or part.geom_type == "GeometryCollection":
            found += polygons_of(part, name)
        elif part.geom_type != "Polygon":
            reason = f"has a {part.geom_type}, which has no inside"
            raise InvalidInputError("", reason, "give polygons, or grow it by shapely.buffer first")
        elif not part.is_empty:
            found += _without_holes(part, name)
    return found


def _without_holes(part: object, name: str | None) -> list[PolygonObstacle]:
    """Return a polygon as one obstacle, or as those that are left and right of a line through its first hole."""
    outer = np.array(part.exterior.coords)[:, :2]  # type: ignore[attr-defined]
    if not len(part.interiors):  # type: ignore[attr-defined]
        return [PolygonObstacle(outer, name)]
    hole = np.array(part.interiors[0].coords)[:, 0]  # type: ignore[attr-defined]
    at = 0.5 * (hole.min() + hole.max())
    (left, low), (right, high) = outer.min(axis=0) - 1.0, outer.max(axis=0) + 1.0
    sides = (shapely().box(left, low, at, high), shapely().box(at, low, right, high))
    return [one for side in sides for one in polygons_of(shapely().intersection(part, side), name)]


def _are_on_a_line(corners: FloatArray) -> bool:
    """Return whether all corners are on one line, but for rounding."""
    x, y = (corners - corners[0]).T
    far = np.hypot(x, y).argmax()
    return bool((np.abs(x * y[far] - y * x[far]) <= _FLAT * (x[far] ** 2 + y[far] ** 2)).all())


def _refuse_meetings(corners: FloatArray) -> None:
    """Refuse a polygon whose edges touch or cross, by the order of its corners as given."""
    from selfmotion.scene._polygon_kernels import first_meeting  # compiled, which reading circles does without

    ends = np.stack([corners, np.roll(corners, -1, axis=0)])
    spans = np.ptp(ends, axis=0).sum(axis=0) / np.ptp(corners, axis=0)
    swept = corners if spans[0] <= spans[1] else np.ascontiguousarray(corners[:, ::-1])  # along the better axis
    order = np.argsort(np.minimum(swept, np.roll(swept, -1, axis=0))[:, 0], kind="stable")
    place = np.empty(2)
    i, j = sorted(first_meeting(swept, order, place))
    if i < 0:
        return
    where = place if swept is corners else place[::-1]
    edges = " and ".join(f"from corner {k} to {(k + 1) % len(corners)}" for k in (i, j))
    reason = f"meets itself: the edges {edges} do at {_text(where)}"
    raise InvalidInputError("corners", reason, "give a polygon that does not; corners are counted from 0")


def _area(corners: FloatArray) -> float:
    """Return the area of a polygon, negative if it goes clockwise."""
    x, y = (corners - corners[0]).T
    return 0.5 * float(x @ np.roll(y, -1) - np.roll(x, -1) @ y)


def _text(point: FloatArray) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"
