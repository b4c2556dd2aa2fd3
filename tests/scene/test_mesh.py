"""Meshes as obstacles: files, what is closed, and distances against those of the same solid by other means."""

import struct

import numpy as np
import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.scene import BoxObstacle, MeshObstacle
from selfmotion.scene._distance_kernels import segment_distance
from selfmotion.scene.mesh_file import load_triangles

CORNERS = np.array([[x, y, z] for x in (-1.0, 1) for y in (-1.0, 1) for z in (-1.0, 1)])
QUADS = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TRIANGLES = np.concatenate([QUADS[:, [0, 1, 2]], QUADS[:, [0, 2, 3]]])
HALF = np.array([0.5, 0.7, 1.0])


def obj(corners=CORNERS * HALF, faces=QUADS, first=1):
    lines = ["# a box", *(f"v {x} {y} {z}" for x, y, z in corners), "vn 0 0 1"]
    return "\n".join([*lines, *("f " + " ".join(f"{k + first}//1" for k in face) for face in faces)]) + "\n"


def stl_binary(triangles):
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *np.ravel(corners), 0) for corners in triangles)
    return b"solid of a kind".ljust(80) + struct.pack("<I", len(triangles)) + rows


def stl_text(triangles):
    loops = ("".join(f"  vertex {x} {y} {z}\n" for x, y, z in corners) for corners in triangles)
    facets = (f"facet normal 0 0 0\n outer loop\n{loop} endloop\nendfacet\n" for loop in loops)
    return ("solid box\n" + "".join(facets) + "endsolid box\n").encode()


FILES = {
    "box.obj": obj().encode(),
    "negative.obj": obj(first=-8).encode(),
    "box.stl": stl_binary((CORNERS * HALF)[TRIANGLES]),
    "text.STL": stl_text((CORNERS * HALF)[TRIANGLES]),
}


@pytest.fixture
def folder(tmp_path):
    for name, data in FILES.items():
        (tmp_path / name).write_bytes(data)
    return tmp_path


@pytest.mark.parametrize("name", FILES)
def test_every_form_of_file_holds_the_same_box(folder, name):
    mesh = MeshObstacle(str(folder / name))
    assert len(mesh.vertices) == 8
    assert len(mesh.triangles) == 12
    assert np.sort(np.abs(mesh.vertices).max(axis=0)) == pytest.approx(HALF, abs=1e-7)


BROKEN = {
    "gap.obj": (obj(faces=QUADS[1:]), "is not closed"),
    "turned.obj": (obj(faces=[QUADS[0][::-1], *QUADS[1:]]), "is not closed"),
    "none.obj": ("v 0 0 0\n", "no triangles"),
    "word.obj": ("v 0 0 x\n", "line 1: has a vertex without three numbers"),
    "two.obj": ("v 0 0\n", "line 1: has a vertex without"),
    "later.obj": ("v 0 0 0\nf 1 2 3\n", "line 2: has a face without three of the vertices"),
    "zero.obj": ("v 0 0 0\nf 0 1 1\n", "line 2: has a face"),
    "infinite.obj": (obj(np.where(CORNERS > 0, np.inf, 0.0)), "not finite"),
    "flat.obj": (obj(CORNERS * 0, QUADS), "without area"),
    "short.stl": (stl_binary((CORNERS * HALF)[TRIANGLES])[:-1].replace(b"solid", b"a box"), "is no STL"),
    "empty.stl": (b"", "is no STL"),
    "text.stl": (stl_text((CORNERS * HALF)[TRIANGLES]).replace(b"-0.5", b"half"), "not made of numbers"),
    "torn.stl": (
        stl_text((CORNERS * HALF)[TRIANGLES]).replace(b"vertex -0.5 -0.7 -1.0", b"vertex 1 2", 1),
        "without three",
    ),
    "box.ply": (b"ply", "neither .stl nor .obj"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_no_solid_is_refused(tmp_path, name):
    data, reason = BROKEN[name]
    (tmp_path / name).write_bytes(data.encode() if isinstance(data, str) else data)
    with pytest.raises(InvalidInputError, match=reason) as caught:
        MeshObstacle(str(tmp_path / name))
    assert caught.value.field == "file"
    assert name in str(caught.value)


@pytest.mark.parametrize("name", ["nowhere.stl", ".", "a\0.obj"])
def test_what_is_no_file_is_refused(tmp_path, name):
    with pytest.raises(InvalidInputError):
        MeshObstacle(str(tmp_path / name))


def test_the_convex_hull_closes_what_is_open(tmp_path):
    (tmp_path / "gap.obj").write_text(obj(faces=QUADS[2:]))
    mesh = MeshObstacle(str(tmp_path / "gap.obj"), hull=True)
    assert len(mesh.triangles) == 12
    (tmp_path / "flat.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n")
    with pytest.raises(InvalidInputError, match="flat convex hull"):
        MeshObstacle(str(tmp_path / "flat.obj"), hull=True)


def test_triangles_of_a_mesh_are_checked():
    made = MeshObstacle.of_triangles(CORNERS, TRIANGLES, "box")
    again = MeshObstacle.of_triangles(**made.as_mapping()["mesh"], name="box")
    assert again == made
    assert again.as_mapping() == made.as_mapping()
    for triangles in ([[0, 1, 8]], [[0, 1, -1]], [[0, 1, 1.5]], []):
        with pytest.raises(InvalidInputError):
            MeshObstacle.of_triangles(CORNERS, triangles)


@pytest.mark.parametrize("scale", [1e-9, 1e-3, 1.0, 1e6])
def test_distances_are_those_of_the_box_itself(folder, scale):
    pytest.importorskip("coal")
    rng = np.random.default_rng(1)
    rpy, center = [0.3, -0.4, 1.0], np.array([0.2, -0.1, 0.5])
    mesh = MeshObstacle(str(folder / "box.obj"), position=center * scale, rpy=rpy, scale=scale)
    box = BoxObstacle(center * scale, 2 * HALF * scale, rpy)
    p = rng.normal(size=(600, 3)) * scale
    q = p + rng.normal(size=(600, 3)) * rng.choice([0.0, 1e-3, 0.1, 1, 3], (600, 1)) * scale
    found, at, normal = mesh.nearest(p, q)
    assert np.array_equal(mesh.distances(p, q), found)
    truth, near, out = np.empty(600), np.empty((600, 3)), np.empty((600, 3))
    for k in range(600):
        truth[k] = segment_distance(*box.shape(), 0, p[k], q[k], near[k], out[k])
    free = truth > 0
    assert 0.5 < free.mean() < 0.95
    assert (found[free] <= truth[free]).all()
    assert (found[free] >= truth[free] - 3e-7 * scale).all()
    assert (found[~free] <= 0).all()
    assert (found[~free] >= truth[~free]).all()
    assert (found - truth)[~free].mean() < 0.05 * scale
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(600))
    # What is said of the point is true of it.
    kind, numbers = box.shape()
    for k in range(600):
        here = segment_distance(kind, numbers, 0, at[k], at[k], near[k], out[k])
        assert here == pytest.approx(found[k], rel=0, abs=3e-7 * scale) or (found[k] == 0 and here <= 0)


def test_a_needle_that_is_touched_says_where():
    """Coal's nearest points are beyond all numbers for some links that all but touch a needle."""
    pytest.importorskip("coal")
    rng = np.random.default_rng(3)
    needle = MeshObstacle.of_triangles(CORNERS * [1, 1e-3, 1e-3], TRIANGLES)
    p = CORNERS[rng.integers(8, size=2000)] * [1, 1e-3, 1e-3] * (1 + 10.0 ** rng.uniform(-9, -6, (2000, 1)))
    q = p * rng.uniform(0.1, 10, (2000, 1))
    found, at, normal = needle.nearest(p, q)
    assert np.abs(found).max() < 1e-2
    assert np.abs(at).max() < 20
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(2000))


def test_inside_of_a_hollow_is_outside():
    """Of a shell whose inner wall faces inwards the hollow is free, the wall is not."""
    pytest.importorskip("coal")
    vertices = np.concatenate([CORNERS, 0.5 * CORNERS])
    shell = MeshObstacle.of_triangles(vertices, np.concatenate([TRIANGLES, TRIANGLES[:, ::-1] + 8]))
    p = np.array([[0, 0, 0], [0.75, 0, 0], [0, 0, 0], [3, 0, 0]], dtype=float)
    q = np.array([[0.1, 0, 0], [0.75, 0, 0], [3, 0, 0], [3, 0, 0]], dtype=float)
    found = shell.distances(p, q)
    assert found[0] == pytest.approx(0.4)
    assert found[1] == pytest.approx(-0.25)
    assert -0.25 < found[2] < -0.1
    assert found[3] == pytest.approx(2)


def test_without_the_extra_it_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "coal", None)
    mesh = MeshObstacle.of_triangles(CORNERS, TRIANGLES)
    with pytest.raises(InvalidInputError, match=r"need the package coal.*selfmotion\[scene\]"):
        mesh.distances(np.zeros((1, 3)), np.ones((1, 3)))


def test_a_file_s_vertices_are_numbers_of_its_own(folder):
    vertices, triangles = load_triangles(str(folder / "box.stl"))
    assert vertices.shape == (36, 3)
    assert triangles.tolist() == np.arange(36).reshape(12, 3).tolist()
