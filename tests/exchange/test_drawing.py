"""What all drawings share: gaps, lifts, subpaths, units, what is said of them, and their place in problem files."""

import dataclasses
import inspect
import json
import subprocess
import sys
import typing
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from drawn import svg

import selfmotion as sm
from selfmotion.exchange import read_drawing, read_svg
from selfmotion.exchange.path_kinds import FILE_PATHS
from selfmotion.exchange.pieces import Piece, elliptic, fitted, flattened, line
from selfmotion.exchange.reading import Options, Reading
from selfmotion.exchange.schema import build, json_schema

EXAMPLES = Path(__file__).parents[2] / "examples"
DRAWINGS = EXAMPLES / "drawings"
TWO = svg('<path d="M 0 90 h 10"/>\n<path d="M 20 90 a 10 10 0 0 1 20 0"/>')


@pytest.fixture
def two(tmp_path):
    file = tmp_path / "two.svg"
    file.write_text(TWO)
    return file


def test_gaps_are_an_error_until_something_is_said(two):
    drawing = read_svg(two, arm_unit="mm")
    assert drawing.gaps[0].bridged is None
    with pytest.raises(sm.InvalidInputError) as caught:
        drawing.path  # noqa: B018
    said = str(caught.value)
    assert said.startswith(f"{two}: has 1 gap between its 2 subpaths: subpath 0 ends at (10, 10), the next starts at")
    assert "(20, 10), 10 mm away" in said
    for way in ("subpath", "gaps: line", "lift"):
        assert way in said
    assert "not bridged" in "\n".join(drawing.lines())


def test_gaps_joined_by_lines(two):
    drawing = read_svg(two, arm_unit="mm", gaps="line")
    assert drawing.path.length == pytest.approx(20 + 10 * np.pi)
    assert drawing.length == pytest.approx(10 + 10 * np.pi)
    assert drawing.gaps[0].bridged == "line"
    assert drawing.path.dimension == 2


def test_a_lift_makes_a_space_curve(two):
    drawing = read_svg(two, arm_unit="mm", lift=5.0)
    path = drawing.path
    assert path.dimension == 3
    assert drawing.gaps[0].bridged == "lift"
    assert path.length == pytest.approx(10 + 5 + 10 + 5 + 10 * np.pi)
    x = path(np.linspace(0, 1, 5001))
    assert x[:, 2].max() == pytest.approx(5)
    up = x[x[:, 2] > 1e-9]
    np.testing.assert_allclose([up[:, 0].min(), up[:, 0].max()], [10, 20], atol=1e-9)
    np.testing.assert_allclose(x[x[:, 0] > 20 + 1e-9, 2], 0, atol=1e-12)
    single = read_svg(two, arm_unit="mm", lift=5.0, subpath=0).path
    np.testing.assert_array_equal(single([0.0, 1.0]), [[0, 10, 0], [10, 10, 0]])


def test_one_subpath(two):
    assert read_svg(two, arm_unit="mm", subpath=1).path.length == pytest.approx(10 * np.pi)
    with pytest.raises(sm.InvalidInputError, match="subpath: is 2, and there are 2 subpaths, counted from 0"):
        read_svg(two, subpath=2)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"gaps": "jump"}, "gaps: is not known"),
        ({"lift": 0.0}, "lift: is zero"),
        ({"lift": np.nan}, "lift: contains NaN"),
        ({"lift": 1.0, "gaps": "line"}, "gaps: is given beside lift"),
        ({"scale": 0.0}, "scale: must be greater than zero"),
        ({"tolerance": -1.0}, "tolerance: must be greater than zero"),
        ({"tolerance": np.inf}, "tolerance: contains NaN or infinity"),
        ({"subpath": -1}, "subpath: is outside"),
        ({"subpath": True}, "subpath: is not a whole number"),
        ({"arm_unit": "yard"}, "arm_unit: is not known"),
    ],
)
def test_options_are_checked(two, options, message):
    with pytest.raises(sm.InvalidInputError, match=message):
        read_svg(two, **options)


def test_units_and_the_default_tolerance(two):
    """0.1 mm on the drawing, whatever the path is measured in."""
    for unit, size in (("m", 1e-3), ("mm", 1.0), ("cm", 0.1), ("inch", 1 / 25.4)):
        drawing = read_svg(two, arm_unit=unit, gaps="line", scale=3.0)
        assert drawing.tolerance == pytest.approx(0.3 * size)
        assert drawing.length == pytest.approx(3 * size * (10 + 10 * np.pi))
        np.testing.assert_allclose(drawing.path(0.0), [0, 30 * size], atol=1e-12)


def test_a_summary_is_plain_data(two):
    summary = read_svg(two, arm_unit="mm").summary()
    assert json.loads(json.dumps(summary)) == summary
    assert summary["segments"] == {"line": 1, "arc": 1}
    assert summary["gaps"] == [{"after": 0, "length": 10.0, "bridged": None}]
    np.testing.assert_allclose(summary["bounds"], [[0, 10], [40, 20]], atol=1e-12)
    assert [part["closed"] for part in summary["subpaths"]] == [False, False]


def test_flattening_keeps_its_bound():
    for tolerance in (1.0, 1e-2, 1e-5):
        for matrix, sweep in ((np.eye(2), 6.0), (np.array([[3.0, 1], [0, 0.5]]), -2.0)):
            curve = elliptic(np.array([1.0, 2.0]), 10 * matrix, 0.4, sweep).curve
            points, bound = flattened(curve, tolerance)
            assert bound <= tolerance
            r = np.linspace(0, 1, len(points))
            inner = curve(0.5 * (r[:-1] + r[1:])) - 0.5 * (points[:-1] + points[1:])
            assert np.hypot(*inner.T).max() <= bound


def test_joints_move_lines_and_bridge_arcs():
    arc = elliptic(np.zeros(2), np.eye(2), 0.0, np.pi / 2)
    other = elliptic(np.array([0.0, 2.01]), np.eye(2), -np.pi / 2, -np.pi / 2)
    done = fitted([arc, other], 0.1)
    assert [piece.kind for piece in done.pieces] == ["arc", "line", "arc"]
    assert done.joints == (pytest.approx(0.01),)
    straight = line(np.array([[0.0, 1.02], [-5.0, 1.0]]))
    done = fitted([arc, straight], 0.1)
    assert [piece.kind for piece in done.pieces] == ["arc", "line"]
    assert (done.pieces[1].start == done.pieces[0].end).all()
    tiny = Piece("line", np.array([[0.0, 1.0], [0.0, 1.01]]))
    assert [piece.kind for piece in fitted([arc, tiny, other], 0.1).pieces] == ["arc", "line", "arc"]
    assert line(np.zeros((3, 2))) is None


def test_files_are_told_apart_by_their_names(tmp_path, two):
    assert read_drawing(two).form == "SVG"
    assert read_drawing(DRAWINGS / "bracket.dxf").form == "DXF"
    assert read_drawing(DRAWINGS / "pocket.nc").form == "G-code"
    for name, text in (("a.csv", "x,y\n0,0\n3,4\n"), ("a.json", "[[0, 0], [3, 4]]")):
        (tmp_path / name).write_text(text)
        drawing = read_drawing(tmp_path / name, arm_unit="mm")
        assert drawing.length == pytest.approx(5000)
    np.save(tmp_path / "a.npy", np.array([[0, 0, 0], [3, 4, 0]]))
    assert read_drawing(tmp_path / "a.npy", "mm").path.length == pytest.approx(5e-3)
    (tmp_path / "p.csv").write_text("x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,1\n3,4,0,1,0,0,0\n")
    poses = read_drawing(tmp_path / "p.csv")
    assert poses.path.dimension == 7
    assert poses.length == 5
    with pytest.raises(
        sm.InvalidInputError, match=r"whose end says no format; rename it to end in one of \.svg, \.dxf"
    ):
        read_drawing(tmp_path / "a.pdf")
    with pytest.raises(sm.InvalidInputError, match="does not exist"):
        read_drawing(tmp_path / "none.svg")


FORMS = {
    "svg": {"file": "letter.svg", "unit": "mm", "scale": 2.0, "tolerance": 1e-4, "subpath": 0},
    "dxf": {"file": "bracket.dxf", "arm_unit": "cm", "gaps": "line"},
    "gcode": {"file": "pocket.nc", "dimension": 2},
}


@pytest.mark.parametrize("kind", FORMS)
def test_kinds_of_a_problem_file(kind, tmp_path, monkeypatch):
    data = {"kind": kind, **FORMS[kind]}
    problem = {"arm": {"kind": "planar", "links": [1, 1, 1]}, "path": data}
    jsonschema.validate(problem, json_schema())
    monkeypatch.chdir(tmp_path)
    path = build("path", data, str(DRAWINGS))
    assert path.kind == kind
    assert path.path.length == path.length
    inside = build("path", {"kind": "transformed", "path": data, "translation": [1, 1]}, str(DRAWINGS))
    np.testing.assert_allclose(inside(0.5), path(0.5) + 1)
    with pytest.raises(sm.InvalidInputError, match=rf"file: {DRAWINGS}.*, unit: is inch, and the file says mm"):
        build("path", {**data, "unit": "inch"}, str(DRAWINGS))
    with pytest.raises(sm.InvalidInputError, match="tolerence: is not a known field; did you mean 'tolerance'"):
        build("path", {**data, "tolerence": 1}, str(DRAWINGS))


def test_a_drawing_in_space(tmp_path):
    """The letter, lifted between its strokes, put before a Panda; and a program with its own lifts."""
    letter = {"kind": "svg", "file": "letter.svg", "lift": 0.02}
    frame = {"translation": [0.4, 0, 0.3]}
    position = {"kind": "placed", "path": letter, "frame": frame}
    path = build("path", {"kind": "pose", "position": position, "orientation": [0, 1, 0, 0]}, str(DRAWINGS))
    assert path.dimension == 7
    np.testing.assert_allclose(path(0.0)[:3], [0.43, 0.02, 0.3])
    assert path(np.linspace(0, 1, 2001))[:, 2].max() == pytest.approx(0.32)
    pocket = build("path", {"kind": "placed", "path": {"kind": "gcode", "file": "pocket.nc"}}, str(DRAWINGS))
    assert pocket.dimension == 3
    assert sm.Problem(sm.named_arm("panda"), path).path is path


def test_gaps_in_a_problem_file_name_both_files(tmp_path, two):
    file = tmp_path / "problem.json"
    file.write_text(
        json.dumps({"arm": {"kind": "planar", "links": [1, 1, 1]}, "path": {"kind": "svg", "file": "two.svg"}})
    )
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.load_problem(file)
    assert str(caught.value).startswith(f"{file}: path.file: {two}: has 1 gap between its 2 subpaths")


def test_a_drawing_in_the_wrong_unit_is_out_of_reach_and_that_is_explained():
    arm = {"kind": "planar", "links": [0.3, 0.3, 0.2]}
    path = {"kind": "transformed", "path": {"kind": "svg", "file": "letter.svg", "subpath": 0}, "translation": [0.3, 0]}
    from selfmotion.exchange import problem_from

    assert problem_from({"arm": arm, "path": path}, str(DRAWINGS)).problem.path.dimension == 2
    path["path"]["arm_unit"] = "mm"
    with pytest.raises(sm.InvalidInputError, match=r"has no point in reach.*are the units of arm and path the same"):
        problem_from({"arm": arm, "path": path}, str(DRAWINGS))


def test_the_examples_drawings_are_what_their_script_draws():
    sys.path.insert(0, str(DRAWINGS))
    try:
        from draw import FILES
    finally:
        sys.path.remove(str(DRAWINGS))
    for name, text in FILES.items():
        assert (DRAWINGS / name).read_text(encoding="utf-8") == text


READ = {
    "letter.svg": ({"gaps": "line"}, 253.858339, 30),
    "bracket.dxf": ({"subpath": 0}, 387.12389, 0),
    "pocket.nc": ({"dimension": 2}, 398.643241, 0),
}


@pytest.mark.parametrize("name", READ)
def test_every_example_drawing_is_planned_on_a_planar_arm(name):
    options, length, gaps = READ[name]
    drawing = read_drawing(DRAWINGS / name, arm_unit="mm", **options)
    assert drawing.length == pytest.approx(length, abs=1e-6)
    assert drawing.path.length == pytest.approx(length + gaps, abs=1e-6)
    arm = sm.PlanarArm([120, 120, 80], [None, (0, np.pi), None])
    plan = sm.plan(sm.Problem(arm, sm.Transformed(drawing.path, translation=[130, -60])), sm.Global(gap=1e-2))
    assert plan.verification.holds
    assert plan.gap <= 1e-2


def test_readers_and_kinds_take_the_same_options():
    """Written once, spelled out for help and for the schema of problem files, with the defaults of the one place."""
    expected = {field.name: field.default for field in dataclasses.fields(Options)}
    assert set(typing.get_type_hints(Reading)) == set(expected)
    taken = [sm.read_svg, sm.read_dxf, sm.read_gcode, read_drawing, *(FILE_PATHS[kind] for kind in FORMS)]
    for reader in taken:
        parameters = inspect.signature(reader).parameters
        assert {name: parameters[name].default for name in expected} == expected, reader
    fields = json_schema()["$defs"]["path_gcode"]["properties"]
    assert {"file", "unit", "dimension", *expected} < set(fields)
    assert fields["gaps"]["enum"] == ["error", "line"]


def test_tables_take_the_options_that_mean_something_to_them(tmp_path):
    file = tmp_path / "плоский путь.csv"
    file.write_text("x,y\n0,0\n3,4\n")
    options = {"arm_unit": "mm", "gaps": "line", "subpath": 0, "scale": 2.0}
    assert read_drawing(file, "mm", **options).path.length == pytest.approx(10)
    assert read_drawing(file, lift=0.1).path.dimension == 3
    with pytest.raises(sm.InvalidInputError, match="subpath: is 1, and there are 1 subpaths"):
        read_drawing(file, subpath=1)
    with pytest.raises(sm.InvalidInputError, match="dimension: is for G-code"):
        read_drawing(file, dimension=2)
    file.write_text("x,y,z\n0,0,0\n3,4,0\n")
    with pytest.raises(sm.InvalidInputError, match="lift: is for a path of the plane"):
        read_drawing(file, lift=0.1)
    (tmp_path / "turn.csv").write_text("x,y,z,qx,qy,qz,qw\n1,2,3,0,0,0,1\n1,2,3,1,0,0,0\n")
    assert read_drawing(tmp_path / "turn.csv").path.dimension == 7


def test_a_path_a_thousand_times_too_small_is_a_warning(tmp_path):
    """Metres taken for millimetres, on the arm's side or the drawing's; never refused, and no word where it fits."""
    arm = sm.PlanarArm([300, 300, 200])
    letter = DRAWINGS / "letter.svg"
    for arm_unit, doubtful in (("m", True), ("mm", False), ("inch", False)):
        path = sm.Transformed(read_svg(letter, arm_unit=arm_unit, subpath=0).path, translation=[300, 0])
        found = sm.Problem(arm, path).warnings
        assert bool(found) is doubtful
        assert bool(read_svg(letter, arm_unit=arm_unit).for_arm(arm.reach).warnings) is doubtful
    small = sm.Problem(arm, sm.Line([300, 0], [300.0, 0.08]))
    assert small.warnings[0].startswith(
        "the path extends over 0.08 (length 0.08), the arm reaches 800, 10000 times as far; 1000 times larger, at 80"
    )
    assert sm.Problem(arm, sm.Line([300, 0], [300.0, 5.0])).warnings == ()
    turn = sm.PoseWaypoints([[0.4, 0, 0.4, 0, 1, 0, 0], [0.4, 0, 0.4, 0, 0.8, 0.6, 0]])
    assert sm.Problem(sm.named_arm("panda"), turn).warnings == ()


def test_a_drawing_of_many_strokes_is_drawn_in_few_lines(tmp_path):
    """One line per stroke took minutes, and one line for all of them more cells than the renderer has."""
    from selfmotion.plot import draw_drawing, figure, rendered

    rng = np.random.default_rng(3)
    shapes = "".join(
        f'<line x1="{x:.3f}" y1="{y:.3f}" x2="{y:.3f}" y2="{x:.3f}"/>' for x, y in rng.uniform(0, 99, (8000, 2))
    )
    (tmp_path / "many.svg").write_text(svg(shapes))
    drawing = read_svg(tmp_path / "many.svg", arm_unit="mm")
    with figure(width=5.0, height=4.0) as (_, (axes,)):
        draw_drawing(axes, drawing)
        assert len(axes.lines) < 40
        assert "gap, not bridged, the first 1000" in axes.get_legend_handles_labels()[1]
    assert rendered("many", draw_drawing, drawing, forms=["png"], width=5.0, height=4.0).keys() == {"many.png"}


def test_a_plunge_gets_no_arrow_and_the_cut_after_it_does(tmp_path):
    from selfmotion.plot import draw_drawing, figure

    (tmp_path / "plunge.nc").write_text("G21\nG0 X0 Y0 Z5\nG1 Z0\nX40\nY40\n")
    with figure(width=5.0, height=4.0) as (_, (axes,)):
        draw_drawing(axes, read_drawing(tmp_path / "plunge.nc", arm_unit="mm"))
        (arrow,) = [text for text in axes.texts if getattr(text, "arrow_patch", None) is not None]
    assert arrow.xy == pytest.approx((20, 0))


def test_readers_import_nothing_heavy():
    heavy = "{'svgpathtools', 'ezdxf', 'matplotlib', 'numba'} & set(sys.modules)"
    code = f"import sys, selfmotion as sm; sm.read_svg, sm.read_dxf, sm.read_gcode; sys.exit(str({heavy} or ''))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.stderr.strip() == ""
