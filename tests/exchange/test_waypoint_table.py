"""Waypoints as JSON and NumPy arrays: round trips, and every file that is refused."""

import io
import json
import time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.exchange import load_waypoints
from selfmotion.exchange.schema import build

NAMES = ["x", "y", "z", "qx", "qy", "qz", "qw"]
POSES = [[1, 2, 3, 0, 0, 0, 1], [4, 5, 6, 0.6, 0, 0.8, 0]]
OURS = [[1, 2, 3, 1, 0, 0, 0], [4, 5, 6, 0, 0.6, 0, 0.8]]


@pytest.fixture
def write(tmp_path):
    def make(data, name):
        file = tmp_path / name
        if isinstance(data, np.ndarray):
            np.save(file, data)
        else:
            file.write_bytes(data if isinstance(data, bytes) else data.encode())
        return file

    return make


def structured(rows, names=tuple(NAMES)):
    return np.array([tuple(row) for row in rows], dtype=[(name, float) for name in names])


SAME = {
    "columns.json": json.dumps({"columns": NAMES, "points": POSES}),
    "objects.json": json.dumps([dict(zip(NAMES, row, strict=True)) for row in POSES]),
    "order.JSON": json.dumps({"columns": NAMES[::-1], "points": [row[::-1] for row in POSES]}),
    "unit.json": json.dumps({"columns": NAMES, "points": POSES, "unit": "m"}),
    "fields.npy": structured(POSES),
    "order.NPY": structured([row[::-1] for row in POSES], NAMES[::-1]),
    "capitals.npy": structured(POSES, [name.upper() for name in NAMES]),
    "poses.csv": ",".join(NAMES) + "\n" + "\n".join(",".join(map(str, row)) for row in POSES),
}


@pytest.mark.parametrize("name", SAME)
def test_every_way_to_write_the_same_poses(write, name):
    if name == "order.NPY":  # numpy would add its own ending
        stream = io.BytesIO()
        np.save(stream, SAME[name])
        file = write(stream.getvalue(), name)
    else:
        file = write(SAME[name], name)
    np.testing.assert_array_equal(load_waypoints(file), OURS)


finite = st.floats(-1e3, 1e3, allow_subnormal=False)


@given(st.sampled_from([2, 3]).flatmap(lambda n: st.lists(st.tuples(*[finite] * n), min_size=2, max_size=6)))
def test_round_trips(points):
    import os
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        name = os.path.join(folder, "Punkte 点 1")
        with open(f"{name}.json", "w", encoding="utf-8") as out:
            json.dump([list(point) for point in points], out)
        np.save(f"{name}.npy", np.array(points))
        for suffix in ("json", "npy"):
            np.testing.assert_allclose(load_waypoints(f"{name}.{suffix}"), points, rtol=0, atol=1e-12)


def test_a_path_s_own_points_come_back(write, seed_path):
    x = seed_path(np.linspace(0, 1, 200))
    for name, data in (("a.npy", x), ("a.json", json.dumps(x.tolist())), ("b.npy", np.asfortranarray(x))):
        path = build("path", {"kind": "file", "file": str(write(data, name))})
        np.testing.assert_allclose(path(path.waypoints), x, atol=1e-12)
    small = write(x.astype(np.float32), "c.npy")
    np.testing.assert_allclose(load_waypoints(small), x, rtol=1e-6)
    assert load_waypoints(write(np.array([[1, 2], [3, 4]]), "d.npy")).tolist() == [[1, 2], [3, 4]]


def test_units(write):
    points = [[1.0, 2.0], [3.0, 4.0]]
    stated = write(json.dumps({"unit": "mm", "points": points}), "a.json")
    np.testing.assert_allclose(load_waypoints(stated), np.array(points) / 1000)
    np.testing.assert_allclose(load_waypoints(stated, "mm"), np.array(points) / 1000)
    np.testing.assert_allclose(load_waypoints(write(np.array(points), "a.npy"), "inch"), np.array(points) * 0.0254)
    with pytest.raises(sm.InvalidInputError, match="unit: is inch, and the file says mm"):
        load_waypoints(stated, "inch")
    with pytest.raises(sm.InvalidInputError, match="unit: is not known"):
        load_waypoints(write('{"unit": "parsec", "points": [[1, 2], [3, 4]]}', "b.json"))


def saved(array):
    stream = io.BytesIO()
    np.save(stream, array, allow_pickle=True)
    return stream.getvalue()


def claiming(shape):
    """Return a NumPy file whose header promises more than it holds."""
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"shape": shape, "fortran_order": False, "descr": "<f8"})
    return stream.getvalue() + bytes(64)


BAD = [
    ("a.json", "", "line 1, column 1: is not JSON"),
    ("a.json", '[[1, 2],\n [3, 4', "line 2, column 7: is not JSON"),
    ("a.json", "[[1, 2], [3, NaN]]", "holds NaN, which is no number"),
    ("a.json", "[[1, 2], [3, -Infinity]]", "holds -Infinity, which is no number"),
    ("a.json", "[[1, 2], [3, 1e999]]", "row 1: holds no finite numbers"),
    ("a.json", f"[[1, 2], [3, 1{'0' * 400}]]", "row 1: holds no finite numbers"),
    ("a.json", f"[[1, 2], [3, 1{'0' * 5000}]]", "holds a number of too many digits"),
    ("a.json", "[" * 100_000, "is nested too deeply"),
    ("a.json", "5", "holds no list of points"),
    ("a.json", "[]", "holds no list of points"),
    ("a.json", "[[1, 2]]", "has 1 rows"),
    ("a.json", "[1, 2]", "row 0: is neither [x, y] nor [x, y, z]"),
    ("a.json", "[[1, 2], [1, 2, 3]]", "row 1: does not have 2 numbers"),
    ("a.json", '[[1, 2], [1, "2"]]', "row 1: holds what is no number"),
    ("a.json", "[[1, 2], [1, true]]", "row 1: holds what is no number"),
    ("a.json", json.dumps(POSES), "row 0: does not say which number is which"),
    ("a.json", '[{"x": 1, "y": 2}, {"x": 1}]', "row 1: has other names than row 0"),
    ("a.json", '[{"x": 1, "y": 2, "f": 0}] * 2', "line 1, column 28: is not JSON"),
    ("a.json", json.dumps([{"x": 1, "y": 2, "f": 0}] * 2), "columns: names columns that are not known: 'f'"),
    ("a.json", '{"points": [[1, 2], [3, 4]], "speed": 1}', "has the unknown field 'speed'"),
    ("a.json", '{"points": [[1, 2], [3, 4]], "points": [[5, 6], [7, 8]]}', "names 'points' twice"),
    ("a.json", '[{"x": 1, "x": 2, "y": 3}]', "names 'x' twice"),
    ("a.npy", saved(np.zeros((3, 3), dtype=[("x", "f8"), ("y", "f8")])), "is no table of points: its shape is (3, 3)"),
    ("a.json", '{"columns": ["x", "y"]}', "has no points"),
    ("a.json", '{"columns": "xy", "points": [[1, 2], [3, 4]]}', "columns: is not a list of names"),
    ("a.json", '{"columns": ["x", "x"], "points": [[1, 2], [3, 4]]}', "columns: names the column x twice"),
    ("a.json", '{"columns": ["x"], "points": [[1], [3]]}', "columns: lacks the columns y"),
    ("a.json", b"\xff\xfe[1]", "is not a UTF-8 text file"),
    ("a.npy", b"", "is not a NumPy file"),
    ("a.npy", b"PK\x03\x04", "is not a NumPy file"),
    ("a.npy", b"\x93NUMPY\x01\x00\x10\x00{'descr': 'evil'", "has a header that is not read"),
    ("a.npy", saved(np.ones((4, 2)))[:-8], "holds 56 bytes of numbers, and its header says 64"),
    ("a.npy", claiming((10**12, 2)), "holds 64 bytes of numbers, and its header says 16000000000000"),
    ("a.npy", saved(np.array([[1, 2], [None, 4]])), "holds Python objects, which are not read"),
    ("a.npy", saved(np.array([["1", "2"], ["3", "4"]])), "holds <U1, not numbers"),
    ("a.npy", saved(np.ones((3, 2), dtype=complex)), "holds complex128, not numbers"),
    ("a.npy", saved(np.ones((3, 7))), "does not say which number is which"),
    ("a.npy", saved(np.ones((3, 4))), "is no table of points: its shape is (3, 4)"),
    ("a.npy", saved(np.ones(6)), "is no table of points"),
    ("a.npy", saved(np.ones((1, 2))), "has 1 rows"),
    ("a.npy", saved(np.array([[1, 2], [3, np.nan]])), "row 1: holds no finite numbers"),
    ("a.npy", saved(np.array([[1, 2], [-np.inf, 3]])), "row 1: holds no finite numbers"),
    ("a.npy", saved(structured([row[:6] for row in POSES], NAMES[:6])), "fields: lacks the columns qw"),
    ("a.npy", saved(structured([[1, 2], [3, 4]], ["x", "v"])), "fields: names columns that are not known: 'v'"),
    ("a.npy", saved(structured([[*POSES[0][:6], 0.9], POSES[1]])), "row 0: holds no unit quaternion"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "data", "message"), BAD, ids=range(len(BAD)))
def test_bad_files_are_refused_by_file_and_row(write, name, data, message):
    file = write(data, name)
    with pytest.raises(sm.InvalidInputError) as caught:
        load_waypoints(file)
    assert str(caught.value).startswith(f"{file}: {message}")
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


@pytest.mark.filterwarnings("error")
def test_a_header_of_an_old_version_is_read_without_a_word(write):
    data = saved(np.array([[1.0, 2.0], [3.0, 4.0]])).replace(b"(2, 2), }", b"(2L,2L),}")
    assert load_waypoints(write(data, "old.npy")).tolist() == [[1, 2], [3, 4]]


def test_many_points_are_read_in_bounded_time(write):
    r = np.linspace(0, 1, 200_000)
    x = np.stack([r, np.sin(9 * r)], axis=1)
    before = time.process_time()
    path = build("path", {"kind": "file", "file": str(write(x, "a.npy"))})
    assert path(0.5).shape == (2,)
    assert path.path.length > 1
    assert load_waypoints(write(json.dumps(x.tolist()), "a.json")).shape == x.shape
    assert time.process_time() - before < 12
