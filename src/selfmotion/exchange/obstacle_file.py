"""Polygons as obstacles from GeoJSON and WKT files, read by shapely."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Any

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import read_text
from selfmotion.exchange.reading import about
from selfmotion.scene.extra import shapely
from selfmotion.scene.obstacle import LONGEST_NAME
from selfmotion.scene.polygon import PolygonObstacle, polygons_of


def load_obstacles(file: str | os.PathLike[str]) -> list[PolygonObstacle]:
    """Read polygons of the plane from a file.

    Parameters
    ----------
    file : path-like
        ``.geojson`` or ``.json`` holds a geometry, a feature or a collection of features in GeoJSON; the property
        ``name`` of a feature becomes the name of its obstacles. Anything else is one geometry in WKT. Numbers are
        lengths in the unit of the arm, and z is left out.

    Returns
    -------
    list of PolygonObstacle
        One for each polygon; one with holes is cut through them, and each of its pieces is one.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, holds anything but polygons, or none, or one that meets itself.
    MissingExtraError
        Without shapely, of the extra ``scene``.
    """
    suffix = os.path.splitext(os.fspath(file))[1].lower()
    with about(file):
        text = read_text(file)
        found: list[PolygonObstacle] = []
        for geometry, name in _from_geojson(text) if suffix in (".json", ".geojson") else [(_from_wkt(text), None)]:
            found += _polygons(geometry, name)
        if not found:
            raise InvalidInputError("", "holds no polygon", "is it the right file?")
    return found


def _polygons(geometry: Any, name: str | None) -> list[PolygonObstacle]:
    """Return the polygons of a geometry, those with holes only if they are what shapely can cut."""
    package = shapely()
    for part in package.get_parts(package.get_parts(geometry)):
        if part.geom_type == "Polygon" and len(part.interiors) and not part.is_valid:
            reason = f"has a polygon with holes that is not valid: {package.is_valid_reason(part)}"
            raise InvalidInputError("", reason, "mend it, by shapely.make_valid for example")
    return polygons_of(geometry, name)


def _from_wkt(text: str) -> Any:
    package = shapely()
    try:
        return package.from_wkt(text.strip())
    except package.errors.ShapelyError as error:
        reason = f"is no WKT: {' '.join(str(error).split())}"
        raise InvalidInputError("", reason, "write POLYGON ((x y, x y, …)), or name a file .geojson") from None


def _from_geojson(text: str) -> Iterator[tuple[Any, str | None]]:
    """Give geometries, and names where there are any."""
    package = shapely()
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        raise InvalidInputError("", "is no JSON", "is it the right file?") from None
    features = data.get("features") if isinstance(data, dict) and data.get("type") == "FeatureCollection" else [data]
    for feature in features if isinstance(features, list) else [features]:
        geometry, name = feature, None
        if isinstance(feature, dict) and feature.get("type") == "Feature":
            geometry, properties = feature.get("geometry"), feature.get("properties")
            name = properties.get("name") if isinstance(properties, dict) else None
        try:
            found = package.from_geojson(json.dumps(geometry))
        except package.errors.ShapelyError as error:
            reason = f"is no GeoJSON: {' '.join(str(error).split())}"
            raise InvalidInputError("", reason, 'write {"type": "Polygon", "coordinates": [[[x, y], …]]}') from None
        usable = isinstance(name, str) and name.strip() and len(name) <= LONGEST_NAME
        yield found, name if usable else None
