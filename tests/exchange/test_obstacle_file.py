"""Polygons as obstacles from files."""

import json

import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.exchange import load_obstacles

pytest.importorskip("shapely")

RING = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
HOLE = [[1, 1], [1, 3], [3, 3], [3, 1], [1, 1]]
POLYGON = {"type": "Polygon", "coordinates": [RING]}


def read(folder, name, data):
    file = folder / name
    file.write_text(data if isinstance(data, str) else json.dumps(data))
    return load_obstacles(file)


def test_a_polygon_in_either_form(tmp_path):
    (one,) = read(tmp_path, "a.wkt", "POLYGON ((0 0, 4 0, 4 4, 0 4, 0 0))\n")
    (other,) = read(tmp_path, "a.geojson", POLYGON)
    assert one == other
    assert one.area == 16


def test_features_with_names_and_several_parts(tmp_path):
    parts = {"type": "MultiPolygon", "coordinates": [[RING], [[[x + 10, y] for x, y in RING]]]}
    features = [
        {"type": "Feature", "properties": {"name": "clamp"}, "geometry": POLYGON},
        {"type": "Feature", "properties": None, "geometry": parts},
    ]
    found = read(tmp_path, "a.json", {"type": "FeatureCollection", "features": features})
    assert [one.name for one in found] == ["clamp", None, None]
    assert [one.area for one in found] == [16, 16, 16]


def test_a_polygon_with_holes_is_cut_through_them(tmp_path):
    small = [[0.2, 0.2], [0.2, 0.4], [0.4, 0.4], [0.2, 0.2]]
    found = read(tmp_path, "a.json", {"type": "Polygon", "coordinates": [RING, HOLE, small]})
    assert len(found) == 3
    assert sum(one.area for one in found) == pytest.approx(16 - 4 - 0.02)


def test_height_is_left_out(tmp_path):
    (one,) = read(tmp_path, "a.wkt", "POLYGON Z ((0 0 5, 4 0 5, 4 4 5, 0 0 5))")
    assert one.area == 8


@pytest.mark.parametrize(
    ("name", "data", "reason"),
    [
        ("a.wkt", "POLYGON ((0 0, 4 0", "is no WKT"),
        ("a.wkt", "", "is no WKT"),
        ("a.wkt", "POINT (1 2)", "has a Point, which has no inside"),
        ("a.wkt", "LINESTRING (1 2, 3 4)", "has a LineString"),
        ("a.wkt", "POLYGON EMPTY", "no polygon"),
        ("a.wkt", "POLYGON ((0 0, 2 2, 2 0, 0 2, 0 0))", "meets itself"),
        ("a.json", "{", "is no JSON"),
        ("a.json", "[" * 100_000, "is no JSON"),
        ("a.json", {"type": "Polygone"}, "is no GeoJSON"),
        ("a.json", {"type": "FeatureCollection", "features": 3}, "is no GeoJSON"),
        ("a.json", {"type": "FeatureCollection", "features": []}, "no polygon"),
        ("a.json", 3, "is no GeoJSON"),
        ("a.json", {"type": "Feature", "geometry": None}, "is no GeoJSON|no polygon"),
        ("a.json", {"type": "Polygon", "coordinates": [RING, [[3, 3], [3, 6], [6, 3], [3, 3]]]}, "is not valid"),
    ],
)
def test_what_holds_no_polygons_is_refused(tmp_path, name, data, reason):
    with pytest.raises(InvalidInputError, match=reason) as caught:
        read(tmp_path, name, data)
    assert caught.value.source == str(tmp_path / name)


def test_a_file_that_is_not_there(tmp_path):
    with pytest.raises(InvalidInputError, match="does not exist"):
        load_obstacles(tmp_path / "no.wkt")
