"""Obstacles: what is refused and why, and that they are written as they are read."""

import json

import jsonschema
import numpy as np
import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.exchange import problem_from
from selfmotion.exchange.plan_parts import problem_from_object, problem_object
from selfmotion.exchange.schema import build_obstacle, json_schema
from selfmotion.scene import (
    OBSTACLES,
    BoxObstacle,
    CapsuleObstacle,
    CircleObstacle,
    HalfPlaneObstacle,
    HalfSpaceObstacle,
    PolygonObstacle,
    SphereObstacle,
)
from selfmotion.scene._distance_kernels import segment_distance
from selfmotion.scene.kinds import MESH

SQUARE = [[0, 0], [2, 0], [2, 2], [0, 2]]
ENTRIES = {
    "circle": {"circle": {"center": [50, 10], "radius": 3}},
    "polygon": {"polygon": SQUARE},
    "half_plane": {"half_plane": {"point": [0, -1], "normal": [0, 2]}},
    "sphere": {"sphere": {"center": [0.1, 0.2, 0.3], "radius": 0.1}},
    "half_space": {"half_space": {"point": [0, 0, -0.1], "normal": [0, 0, 1]}},
    "box": {"box": {"center": [0, 0.2, 0.7], "size": [0.25, 0.25, 0.25], "rpy": [0.1, 0.2, 0.3]}},
    "capsule": {"capsule": {"from": [0, 0, 0], "to": [0.1, 0, 1], "radius": 0.05}},
    "mesh": {"mesh": {"file": "part.obj", "position": [0.1, 0, 0], "rpy": [0, 0, 1], "scale": 0.001, "hull": False}},
}
PROBLEM = {
    "arm": {"kind": "planar", "links": [30, 30, 20]},
    "path": {"kind": "line", "start": [50, 0], "end": [40, 30]},
}
TETRAHEDRON = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def distance(obstacle, p, q):
    kind, numbers = obstacle.shape()
    p, q = (np.append(x, np.zeros(3 - len(x))).astype(float) for x in (p, q))
    return segment_distance(kind, numbers, 0, p, q, np.empty(3), np.empty(3))


def test_there_is_an_example_of_every_kind():
    assert list(ENTRIES) == list(OBSTACLES)


@pytest.mark.parametrize("name", [None, "clamp"])
@pytest.mark.parametrize("kind", ENTRIES)
def test_an_entry_is_read_and_written_again(kind, name, tmp_path):
    (tmp_path / "part.obj").write_text(TETRAHEDRON)
    entry = ENTRIES[kind] if name is None else {**ENTRIES[kind], "name": name}
    jsonschema.validate({**PROBLEM, "obstacles": [entry]}, json_schema())
    obstacle = build_obstacle(entry, str(tmp_path))
    assert type(obstacle) is OBSTACLES[kind]
    assert obstacle.name == name
    assert obstacle.label == (name or kind.replace("_", " "))
    assert obstacle.dimension == (2 if kind in ("circle", "polygon", "half_plane") else 3)
    assert obstacle.kind in repr(type(obstacle)).lower().replace("halfp", "half_p").replace("halfs", "half_s")
    if kind != "mesh":
        assert obstacle.as_mapping() == entry
        again = build_obstacle(obstacle.as_mapping())
        assert again == obstacle
        assert again.shape()[0] == obstacle.shape()[0] != MESH
        assert np.array_equal(again.shape()[1], obstacle.shape()[1])


@pytest.mark.parametrize(
    ("obstacle", "p", "q", "truth"),
    [
        (CircleObstacle([1, 1], 0.5), [1, 3], [3, 3], 1.5),
        (PolygonObstacle(SQUARE), [3, 1], [5, 5], 1),
        (PolygonObstacle(SQUARE[::-1]), [1, 1], [1, 1], -1),
        (HalfPlaneObstacle([0, 1], [0, 5]), [0, 2], [3, 4], 1),
        (HalfPlaneObstacle([0, 1], [-3, 0]), [0, 2], [3, 4], -3),
        (SphereObstacle([0, 0, 1], 1), [0, 0, 3], [0, 0, 3], 1),
        (HalfSpaceObstacle([0, 0, -1], [0, 0, 2]), [0, 0, 0], [0, 0, 3], 1),
        (BoxObstacle([0, 0, 0], [2, 4, 6]), [0, 3, 0], [1, 3, 0], 1),
        (BoxObstacle([0, 0, 0], [2, 4, 6], rpy=[0, 0, np.pi / 2]), [3, 0, 0], [3, 1, 0], 1),
        (CapsuleObstacle([0, 0, 0], [0, 0, 2], 0.5), [2, 0, 1], [2, 5, 1], 1.5),
        (CapsuleObstacle([0, 0, 0], [0, 0, 0], 0.5), [2, 0, 0], [2, 5, 0], 1.5),
    ],
    ids=lambda value: type(value).__name__ if hasattr(value, "kind") else "",
)
def test_the_numbers_are_those_of_the_kernels(obstacle, p, q, truth):
    assert distance(obstacle, p, q) == pytest.approx(truth, abs=1e-14)


REFUSED = {
    "circle.radius": ({"circle": {"center": [0, 0], "radius": -1}}, "greater than zero"),
    "circle.radius (zero)": ({"circle": {"center": [0, 0], "radius": 0}}, "greater than zero"),
    "circle.center": ({"circle": {"center": [0, 0, 0], "radius": 1}}, "too many"),
    "circle.centre": ({"circle": {"centre": [0, 0], "radius": 1}}, "did you mean 'center'"),
    "circle.center (missing)": ({"circle": {"radius": 1}}, "missing"),
    "circle": ({"circle": [0, 0, 1]}, "not a mapping"),
    "circel": ({"circel": {}}, "did you mean 'circle'"),
    "box": ({"circle": {"center": [0, 0], "radius": 1}, "box": {}}, "not a known field"),
    "": ({"name": "clamp"}, "no kind"),
    "kind": ({"kind": "circle", "center": [0, 0], "radius": 1}, "is no field of an obstacle"),
    " (list)": ([1, 2], "not a mapping"),
    "name": ({"circle": {"center": [0, 0], "radius": 1}, "name": " "}, "no name"),
    "name (number)": ({"circle": {"center": [0, 0], "radius": 1}, "name": 3}, "not text"),
    "half_plane.normal": ({"half_plane": {"point": [0, 0], "normal": [0, 0]}}, "is zero"),
    "sphere.radius": ({"sphere": {"center": [0, 0, 0], "radius": float("inf")}}, "not finite"),
    "box.size": ({"box": {"center": [0, 0, 0], "size": [1, -1, 1]}}, "greater than zero"),
    "box.rpy": ({"box": {"center": [0, 0, 0], "size": [1, 1, 1], "rpy": [1]}}, "too few"),
    "capsule.from": ({"capsule": {"from": [0, 0, 1e200], "to": [0, 0, 0], "radius": 1}}, "exceeds"),
    "capsule.radius": ({"capsule": {"from": [0, 0, 1], "to": [0, 0, 0], "radius": -1}}, "greater than zero"),
    "polygon": ({"polygon": [[0, 0], [1, 0]]}, "has 2 corners"),
    "polygon (closed)": ({"polygon": [[0, 0], [1, 0], [0, 0]]}, "has 2 corners"),
    "polygon.1": ({"polygon": [[0, 0], [1, 0, 0], [1, 1]]}, "too many"),
    "polygon.1.0": ({"polygon": [[0, 0], ["a", 0], [1, 1]]}, "not a number"),
    "polygon (flat)": ({"polygon": [[0, 0], [1, 1], [3, 3]]}, "no area"),
    "polygon (twice)": ({"polygon": [[0, 0], [1, 0], [1, 0], [0, 1]]}, r"corner 2 twice in a row, at \(1, 0\)"),
    "polygon (last twice)": ({"polygon": [[0, 0], [1, 0], [0, 1], [0, 1]]}, "corner 3 twice"),
    "polygon (crosses)": (
        {"polygon": [[0, 0], [2, 2], [2, 0], [0, 2]]},
        r"the edges from corner 0 to 1 and from corner 2 to 3 do at \(1, 1\)",
    ),
    "polygon (crosses, unequal)": ({"polygon": [[0, 0], [4, 4], [4, 0], [0, 2]]}, r"0 to 1 and from corner 2 to 3 do"),
    "polygon (touches)": ({"polygon": [[0, 0], [4, 0], [4, 2], [2, 0], [0, 2]]}, r"do at \(2, 0\)"),
    "polygon (goes back)": ({"polygon": [[0, 0], [4, 0], [2, 0], [2, 2]]}, r"0 to 1 and from corner 1 to 2 do"),
    "polygon (corner again)": ({"polygon": [[0, 0], [2, 0], [1, 1], [2, 2], [0, 2], [1, 1]]}, r"do at \(1, 1\)"),
    "mesh.file": ({"mesh": {"file": "nowhere.stl"}}, "does not exist"),
    "mesh.scale": ({"mesh": {"file": "nowhere.stl", "scale": 0}}, "greater than zero"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_obstacle_is_refused_by_its_field(case):
    entry, reason = REFUSED[case]
    with pytest.raises(InvalidInputError, match=reason) as caught:
        build_obstacle(entry)
    assert caught.value.field == case.split(" (")[0].strip()


def test_a_polygon_may_go_either_way_round_and_repeat_its_first_corner():
    for corners in (SQUARE, SQUARE[::-1], [*SQUARE, SQUARE[0]], np.array(SQUARE)):
        polygon = PolygonObstacle(corners)
        assert len(polygon.corners) == 4
        assert polygon.area == 4
        with pytest.raises(ValueError, match="read-only"):
            polygon.corners[0] = 1


def saw(teeth):
    """Return a comb of many long edges beside each other, the worst for a sweep along one axis."""
    x = np.arange(teeth, dtype=float)
    upper = np.stack([np.repeat(x, 2), np.tile([0.0, 100.0], teeth)], axis=1)
    return np.concatenate([upper, [[teeth, 100.0], [teeth, -1.0], [-1.0, -1.0], [-1.0, 0.0]]])


def test_large_polygons_are_checked_and_their_crossing_is_found():
    corners = saw(4000)
    assert PolygonObstacle(corners).area > 0
    assert PolygonObstacle(corners[:, ::-1]).area > 0
    corners[1000] += [0.9, 300]  # beyond the edge after it
    corners[1001, 0] -= 1.5
    with pytest.raises(InvalidInputError, match="meets itself"):
        PolygonObstacle(corners)
    with pytest.raises(InvalidInputError, match="more than 10000"):
        PolygonObstacle(saw(5000))


def test_simple_is_what_shapely_calls_valid():
    shapely = pytest.importorskip("shapely")
    rng = np.random.default_rng(2)
    seen = set()
    for _ in range(1500):
        corners = rng.integers(0, 6, (rng.integers(3, 8), 2)).astype(float)
        ring = shapely.Polygon(corners)
        try:
            ours = PolygonObstacle(corners)
        except InvalidInputError:
            # Corners twice in a row are no harm to shapely.
            twice = (corners == np.roll(corners, 1, axis=0)).all(axis=1)[1:].any()
            assert not ring.is_valid or twice
        else:
            assert ring.is_valid
            assert ours.area == pytest.approx(ring.area)
            seen.add(len(corners))
    assert seen >= {3, 4, 5, 6}


@pytest.mark.parametrize("distance_", [0.5, -0.25])
def test_an_offset_covers_the_exact_one_and_hardly_more(distance_):
    pytest.importorskip("shapely")
    notch = PolygonObstacle([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], "notch")
    (grown,) = notch.offset(distance_)
    assert grown.name == "notch"
    for a, b in zip(grown.corners, np.roll(grown.corners, -1, axis=0), strict=True):
        away = [distance(notch, x, x) for x in a + np.linspace(0, 1, 9)[:, None] * (b - a)]
        assert min(away) >= distance_ - 1e-12
        assert max(away) <= distance_ + 0.0013 * abs(distance_)


def test_what_is_shrunk_may_fall_apart_or_vanish():
    pytest.importorskip("shapely")
    lower, upper = [[0, 0], [2, 0], [2, 0.9], [4, 0.9], [4, 0], [6, 0]], [[6, 2], [4, 2], [4, 1.1], [2, 1.1]]
    dumbbell = PolygonObstacle([*lower, *upper, [2, 2], [0, 2]])
    assert len(dumbbell.offset(-0.2)) == 2
    assert dumbbell.offset(-5) == []
    with pytest.raises(InvalidInputError, match="distance"):
        dumbbell.offset(float("nan"))


def test_a_ring_that_closes_is_cut_through_its_hole():
    pytest.importorskip("shapely")
    inner = [[3, 1.9], [3, 1], [1, 1], [1, 3], [3, 3], [3, 2.1]]
    c_shape = PolygonObstacle([[0, 0], [4, 0], [4, 1.9], *inner, [4, 2.1], [4, 4], [0, 4]])
    pieces = c_shape.offset(0.2)
    assert len(pieces) == 2
    assert min(distance(piece, [2, 2], [2, 2]) for piece in pieces) == pytest.approx(0.8, abs=1e-3)
    assert min(distance(piece, [2, 0.5], [2, 0.7]) for piece in pieces) <= 0


def test_without_the_extra_it_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "shapely", None)
    with pytest.raises(InvalidInputError, match=r"need the package shapely.*selfmotion\[scene\]"):
        PolygonObstacle(SQUARE).offset(1)


def test_a_stored_problem_has_its_obstacles_again():
    entries = [
        {"name": "clamp", "circle": {"center": [200, 0], "radius": 1}},
        {"polygon": [[100, 1], [101, 1], [99, 3]]},
    ]
    problem = problem_from({**PROBLEM, "obstacles": entries}).problem
    stored = json.loads(json.dumps(problem_object(problem), default=np.ndarray.tolist))
    assert stored["obstacles"] == entries
    assert problem_from_object(stored).scene.obstacles == problem.scene.obstacles
    assert "obstacles" not in problem_object(problem_from(PROBLEM).problem)
