"""Waypoint files: what is read, and every file that is refused, with its line."""

import json

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.exchange import load_waypoints
from selfmotion.exchange.schema import build, json_schema

HEADER = "x,y,z,qx,qy,qz,qw"
GOOD = f"{HEADER}\n1,2,3,0,0,0,1\n4,5,6,0.6,0,0.8,0\n"
ROWS = [[1, 2, 3, 1, 0, 0, 0], [4, 5, 6, 0, 0.6, 0, 0.8]]
SAME = {
    "plain": GOOD,
    "semicolons": GOOD.replace(",", ";"),
    "tabs": GOOD.replace(",", "\t"),
    "spaces": GOOD.replace(",", " , "),
    "carriage returns": GOOD.replace("\n", "\r\n"),
    "byte order mark": "\ufeff" + GOOD,
    "capitals": GOOD.replace("x,y,z", "X,Y,Z"),
    "quotes": GOOD.replace(HEADER, ",".join(f'"{name}"' for name in HEADER.split(","))),
    "comments": "# poses\n\n" + GOOD.replace("\n4", "  # first\n#\n\n4"),
    "other order": "qw,x,qx,y,qy,z,qz\n1,1,0,2,0,3,0\n0,4,0.6,5,0,6,0.8\n",
    "time": f"t,{HEADER}\n0,1,2,3,0,0,0,1\n0.1,4,5,6,0.6,0,0.8,0\n",
    "index of text": f"index,{HEADER}\nP1,1,2,3,0,0,0,1\nP2,4,5,6,0.6,0,0.8,0\n",
    "no last line end": GOOD.rstrip("\n"),
    "nearly unit": GOOD.replace("0.8,0", "0.8000005,0"),
}


@pytest.fixture
def write(tmp_path):
    def make(text, name="poses.csv"):
        file = tmp_path / name
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return file

    return make


@pytest.mark.parametrize("case", SAME)
def test_every_way_to_write_the_same_poses(write, case):
    found = load_waypoints(write(SAME[case]))
    np.testing.assert_allclose(found, ROWS, atol=1e-6 if case == "nearly unit" else 0)
    np.testing.assert_allclose(np.linalg.norm(found[:, 3:], axis=1), 1, rtol=1e-15)


@pytest.mark.parametrize(("unit", "factor"), [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("inch", 0.0254)])
def test_units_scale_positions_only(write, unit, factor):
    found = load_waypoints(write(GOOD), unit)
    np.testing.assert_allclose(found, scaled(factor), rtol=1e-15)
    np.testing.assert_allclose(load_waypoints(write("y,x\n2,1\n4,3\n"), unit), factor * np.array([[1, 2], [3, 4]]))


def scaled(factor):
    return np.hstack([factor * np.array(ROWS)[:, :3], np.array(ROWS)[:, 3:]])


def test_points_of_the_plane_and_of_space(write):
    np.testing.assert_array_equal(load_waypoints(write("x,y\n1,2\n3,4\n")), [[1, 2], [3, 4]])
    np.testing.assert_array_equal(load_waypoints(write("z;y;x\n1;2;3\n4;5;6\n")), [[3, 2, 1], [6, 5, 4]])


finite = st.floats(-1e3, 1e3)


@given(st.lists(st.tuples(finite, finite, finite), min_size=2, max_size=5), st.randoms(use_true_random=False))
def test_what_is_written_with_17_digits_is_read_exactly(points, random):
    import os
    import tempfile

    names = list("xyz")
    random.shuffle(names)
    lines = [",".join(names)] + [",".join(f"{dict(zip('xyz', p, strict=True))[n]:.17g}" for n in names) for p in points]
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "points.csv")
        with open(file, "w", encoding="utf-8") as out:
            out.write("\n".join(lines))
        np.testing.assert_array_equal(load_waypoints(file), points)


BAD = {
    "is empty": "",
    "is empty ": "# nothing\n\n",
    "has 0 rows below its header": HEADER,
    "has 1 rows below its header": f"{HEADER}\n1,2,3,0,0,0,1\n",
    "line 1: names no columns x, y, z": "1,2,3,0,0,0,1\n4,5,6,0,0,0,1\n",
    "line 2: names no columns x, y, z": "# a\na,b\n1,2\n1,2\n",
    "line 1: lacks the columns qz": "x,y,z,qx,qy,qw\n1,2,3,0,0,1\n1,2,3,0,0,1\n",
    "line 1: lacks the columns z": "x,y,qx,qy,qz,qw\n1,2,0,0,0,1\n1,2,0,0,0,1\n",
    "line 1: lacks the columns y": "x\n1\n2\n",
    "line 1: lacks the columns x, y": "z\n1\n2\n",
    "line 1: names columns that are not known: 'speed', 'tool'": "x,y,speed,tool\n1,2,3,4\n1,2,3,4\n",
    "line 1: names columns that are not known: 't'": "x,y,t\n1,2,3\n1,2,3\n",
    "line 1: names columns that are not known: ''": "x,y,\n1,2,\n3,4,\n",
    "line 1: names the column x twice": "x,y,x\n1,2,3\n1,2,3\n",
    "line 3: has 6 columns, and the header has 7": f"{HEADER}\n1,2,3,0,0,0,1\n1,2,3,0,0,1\n",
    "line 4, column qy: is not a finite number (got 'left')": f"{HEADER}\n1,2,3,0,0,0,1\n#\n1,2,3,0,left,0,1\n",
    "line 2, column z: is not a finite number (got 'nan')": f"{HEADER}\n1,2,nan,0,0,0,1\n1,2,3,0,0,0,1\n",
    "line 2, column z: is not a finite number (got 'inf')": f"{HEADER}\n1,2,inf,0,0,0,1\n1,2,3,0,0,0,1\n",
    "line 2, column x: is not a finite number (got '1e300')": f"{HEADER}\n1e300,2,0,0,0,0,1\n1,2,3,0,0,0,1\n",
    "line 2, column x: is not a finite number (got '1,5')": "x;y\n1,5;2\n3;4\n",
    "line 2, column y: is empty": "x,y\n1,\n3,4\n",
    "line 3: holds no unit quaternion: its norm is 0.99": f"{HEADER}\n1,2,3,0,0,0,1\n1,2,3,0,0,0,0.99\n",
    "line 2: holds no unit quaternion: its norm is 0": f"{HEADER}\n1,2,3,0,0,0,0\n1,2,3,0,0,0,1\n",
    "is not a UTF-8 text file": b"\x89PNG\r\n\x1a\n\x00\xff",
    "is not a text file": b"x,y\n\x00\x00\x00",
}


@pytest.mark.parametrize("message", BAD)
def test_bad_files_are_refused_by_file_and_line(write, message):
    file = write(BAD[message])
    with pytest.raises(sm.InvalidInputError) as caught:
        load_waypoints(file)
    assert str(caught.value).startswith(f"{file}: {message.strip()}")
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


def test_missing_files_folders_and_units_are_refused(tmp_path, write):
    with pytest.raises(sm.InvalidInputError, match="does not exist"):
        load_waypoints(tmp_path / "none.csv")
    with pytest.raises(sm.InvalidInputError, match="is a folder"):
        load_waypoints(tmp_path)
    with pytest.raises(sm.InvalidInputError, match="unit: is not known"):
        load_waypoints(write(GOOD), "km")


@given(st.binary(max_size=60) | st.text(alphabet="xyzqw,;\t\n#0123456789.-e", max_size=60).map(str.encode))
def test_any_bytes_are_a_table_or_an_input_error(data):
    import os
    import tempfile

    handle, name = tempfile.mkstemp()
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        assert np.isfinite(load_waypoints(name)).all()
    except sm.InvalidInputError as error:
        assert "\n" not in str(error)  # noqa: PT017
    finally:
        os.unlink(name)


def test_a_path_of_kind_file(write, tmp_path):
    write(GOOD)
    data = {"kind": "file", "file": "poses.csv", "interpolation": "spline", "unit": "mm"}
    frame = {"translation": [0, 0, 1], "rpy": [0, 0, np.pi / 2]}
    jsonschema.validate(
        {"arm": {"kind": "planar", "links": [1, 1, 1]}, "path": {**data, "frame": frame}}, json_schema()
    )
    path = build("path", data, str(tmp_path))
    assert path.kind == "file"
    np.testing.assert_allclose(path([0.0, 1.0]), scaled(1e-3), atol=1e-16)
    np.testing.assert_array_equal(path.waypoints, [0, 1])
    assert path.turning(0, 1) == pytest.approx(np.pi)
    assert path.fastest(0, 1) == pytest.approx(path.length)
    assert path.bending(0, 1) == pytest.approx(0, abs=1e-12)
    moved = build("path", {**data, "frame": frame, "tool": {"translation": [0, 0, 0.1]}}, str(tmp_path))
    np.testing.assert_allclose(moved(0.0)[:3], [-0.002, 0.001, 1.103], atol=1e-15)
    # In it, a path of positions takes an orientation.
    write("x,y,z\n0,0,0\n1,0,0\n", "points.csv")
    inner = {"kind": "pose", "position": {"kind": "file", "file": "points.csv"}, "orientation": [0, 1, 0, 0]}
    assert build("path", inner, str(tmp_path))(0.5).tolist() == [0.5, 0, 0, 0, 1, 0, 0]


def test_files_are_relative_to_the_problem_file(write, tmp_path, monkeypatch):
    write("x,y\n50,0\n60,0\n60,5\n", "points.csv")
    problem = {"arm": {"kind": "planar", "links": [30, 30, 20]}, "path": {"kind": "file", "file": "points.csv"}}
    file = write(json.dumps(problem), "problem.json")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    np.testing.assert_array_equal(sm.load_problem(file).problem.path([0.0, 1.0]), [[50, 0], [60, 5]])
    monkeypatch.chdir(tmp_path)
    np.testing.assert_array_equal(sm.load_problem("problem.json").problem.path(1.0), [60, 5])
    problem["path"] = {"kind": "reversed", "path": {"kind": "file", "file": str(tmp_path / "points.csv")}}
    file = write(json.dumps(problem), "absolute.json")
    np.testing.assert_array_equal(sm.load_problem(file).problem.path(0.0), [60, 5])


def test_errors_of_a_file_name_it_and_its_line(write, tmp_path):
    bad = write("x,y\n50,0\n60,up\n", "points.csv")
    problem = {"arm": {"kind": "planar", "links": [30, 30, 20]}, "path": {"kind": "file", "file": "points.csv"}}
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.load_problem(write(json.dumps(problem), "problem.json"))
    assert str(bad) in str(caught.value)
    assert "line 3, column y" in str(caught.value)
    write("x,y\n50,0\n50,0\n", "points.csv")
    with pytest.raises(sm.InvalidInputError, match="repeats point 0 as point 1"):
        build("path", problem["path"], str(tmp_path))
    with pytest.raises(sm.InvalidInputError, match="file: is not text"):
        build("path", {"kind": "file", "file": 3}, str(tmp_path))
    for field in ("unit", "parameter", "interpolation"):
        with pytest.raises(sm.InvalidInputError, match=f"{field}: is not known"):
            build("path", {**problem["path"], field: "parsec"}, str(tmp_path))


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_quotes_and_marks_as_spreadsheets_write_them(write, end):
    rows = ['\ufeff"X";"y"', '"0.5";"1"', "2;3", ""]
    np.testing.assert_array_equal(load_waypoints(write(end.join(rows).encode())), [[0.5, 1], [2, 3]])


@pytest.mark.parametrize("cell", ["1_000", "５", "0,5", '"0,5"', "1.000,5"])
def test_numbers_of_other_customs_are_refused(write, cell):
    with pytest.raises(sm.InvalidInputError, match=r"line 2, column x: is not a finite number") as caught:
        load_waypoints(write(f"x;y\n{cell};2\n3;4\n"))
    assert ("write decimals with a point" in str(caught.value)) == ("," in cell)


def test_the_path_is_in_the_unit_of_the_arm(write):
    file = str(write("x,y\n0,0\n300,400\n"))
    path = build("path", {"kind": "file", "file": file, "unit": "mm", "arm_unit": "cm", "scale": 2.0})
    assert path.path.length == pytest.approx(100)
    poses = f"{HEADER}\n0,0,0,0,0,0,1\n3,4,0,0,0,0,1\n"
    path = build("path", {"kind": "file", "file": str(write(poses)), "unit": "cm", "arm_unit": "mm"})
    np.testing.assert_allclose(path(1.0), [30, 40, 0, 1, 0, 0, 0])
