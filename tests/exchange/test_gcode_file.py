"""G-code: arcs against circles, modes, units, what is reported, and every program that is refused."""

import time

import numpy as np
import pytest
from drawn import assert_circle, off_circle, turning
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.exchange import read_gcode
from selfmotion.exchange.gcode_words import blocks


@pytest.fixture
def read(tmp_path):
    def make(text, name="program.nc", **options):
        file = tmp_path / name
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_gcode(file, **{"arm_unit": "mm", **options})

    return make


CIRCLES = {
    "I and J, whole": ("G21 G90\nG0 X75 Y50\nG3 I-25 J0", 1),
    "I alone, whole, clockwise": ("G21\nG0 X75 Y50\nG2 X75 Y50 I-25", 1),
    "I and J, in two": ("G21\nG0 X75 Y50\nG3 X25 Y50 I-25 J0\nX75 Y50 I25", 2),
    "R, in two": ("G21\nG0 X75 Y50\nG3 X25 R25\nG3 X75 R25", 2),
    "R short and long": ("G21\nG0 X75 Y50\nG3 X50 Y75 R25\nG3 X75 Y50 R-25", 2),
    "R short and long, clockwise": ("G21\nG0 X75 Y50\nG2 X50 Y25 R25\nG2 X75 Y50 R-25", 2),
    "relative": ("G21 G91\nG0 X75 Y50\nG3 X-50 Y0 I-25 J0\nG3 X50 I25", 2),
    "absolute centre": ("G21 G90 G90.1\nG0 X75 Y50\nG3 X25 Y50 I50 J50\nG3 X75 Y50 I50 J50", 2),
    "small letters, no spaces": ("g21\ng0x75y50\ng3x25y50i-25j0\ng3x+75.y50.0i25", 2),
    "comments and numbers of lines": ("%\nO1\nN1 G21;mm\nN2 G0 X75 (start) Y50\nN3 G3 I-25\nM30\n%", 1),
    "inch": ("G20\nG0 X2.952755905511811 Y1.968503937007874\nG3 I-0.984251968503937", 1),
    "digits rounded off": ("G21\nG0 X75 Y50\nG3 X50 Y75 I-25.0 J0.0\nG3 X75 Y50 I0 J-25", 2),
}


@pytest.mark.parametrize("case", CIRCLES)
def test_every_way_to_cut_a_circle(read, case):
    text, parts = CIRCLES[case]
    drawing = read(text)
    assert_circle(drawing, parts=parts)
    assert (turning(drawing.path) < 0) == ("clockwise" in case)


@pytest.mark.parametrize(
    ("plane", "axes", "words"), [("G18", (2, 0), "KI"), ("G19", (1, 2), "JK"), ("G17", (0, 1), "IJ")]
)
@pytest.mark.parametrize("motion", ["G2", "G3"])
def test_arcs_in_every_plane_of_space(read, plane, axes, words, motion):
    """G3 turns from the plane's first axis to its second: X to Y, Z to X, Y to Z."""
    drawing = read(f"G21 {plane}\nG0 X30 Y30 Z30\n{motion} {words[0]}-20 {words[1]}0", dimension=3)
    x = drawing.path(np.linspace(0, 1, 721))
    assert x.shape == (721, 3)
    center = np.full(3, 30.0)
    center[axes[0]] -= 20
    np.testing.assert_allclose(np.linalg.norm(x - center, axis=1), 20, atol=1e-12)
    quarter = x[180] - center
    assert quarter[axes[1]] == pytest.approx(20 if motion == "G3" else -20)
    assert drawing.path.length == pytest.approx(40 * np.pi, abs=1e-6)
    assert drawing.chord_error == 0


def test_a_helix_is_flattened_within_the_tolerance(read):
    drawing = read("G21\nG0 X75 Y50 Z0\nG3 X75 Y50 Z10 I-25 J0", tolerance=1e-3)
    assert 0 < drawing.chord_error <= 1e-3
    r = np.linspace(0, 1, 3001)
    x = drawing.path(r)
    phi = 2 * np.pi * r
    exact = np.stack([50 + 25 * np.cos(phi), 50 + 25 * np.sin(phi), 10 * r], axis=1)
    assert np.linalg.norm(x - exact, axis=1).max() <= 1e-3
    assert off_circle(drawing.path) <= drawing.chord_error
    assert drawing.segments == {"flattened": 1}
    flat = read("G21\nG0 X75 Y50 Z0\nG3 X75 Y50 Z10 I-25 J0", dimension=2)
    assert_circle(flat)


POCKET = "G21\nG0 Z5\nG0 X0 Y0\nG1 Z-1 F100\nG1 X10\nG0 Z5\nG0 X20 Y5\nG1 Z-1\nG1 X30 F300 S900\nG0 Z5\nG0 X0 Y0\n"


def test_rapid_moves_lift_the_tool_from_cut_to_cut(read):
    drawing = read(POCKET)
    assert len(drawing.subpaths) == 2
    assert drawing.gaps[0].bridged == "rapid"
    corners = [[0, 0, 5], [0, 0, -1], [10, 0, -1], [10, 0, 5], [20, 5, 5], [20, 5, -1], [30, 5, -1]]
    np.testing.assert_array_equal(drawing.path.points, corners)
    assert drawing.length == 32
    assert drawing.summary()["feeds"] == "F100 (line 4), F300 (line 9)"
    assert drawing.summary()["spindle"] == "S900 (line 9)"
    second = read(POCKET, subpath=1)
    np.testing.assert_array_equal(second.path.points, corners[-3:])


def test_in_the_plane_gaps_must_be_declared(read):
    drawing = read(POCKET, dimension=2)
    assert drawing.gaps[0].length == pytest.approx(np.hypot(10, 5))
    with pytest.raises(sm.InvalidInputError, match="1 gap between its 2 subpaths"):
        drawing.path  # noqa: B018
    joined = read(POCKET, dimension=2, gaps="line")
    np.testing.assert_array_equal(joined.path.points, [[0, 0], [10, 0], [20, 5], [30, 5]])
    assert any("Z was dropped" in note and "-1" in note for note in joined.notes)


def test_a_program_without_z_is_one_of_the_plane(read):
    assert read("G21\nG1 X5\nG1 Y5").path.dimension == 2
    assert read("G21\nG1 X5 Z0\nG1 Y5").path.dimension == 2
    assert read("G21\nG1 X5\nG1 Y5", dimension=3).path.dimension == 3


def test_units_and_scale(read):
    assert read("G20\nG1 X1").path.length == pytest.approx(25.4)
    assert read("G20\nG1 X1", arm_unit="m", scale=2).path.length == pytest.approx(0.0508)
    assert read("G1 X1", unit="inch").path.length == pytest.approx(25.4)
    assert read("G1 X1", unit="mm").unit == "mm, as asked for"
    changing = read("G21\nG1 X25.4\nG20\nG1 X2")
    assert changing.path.length == pytest.approx(50.8)
    assert "the unit changes within the program" in changing.notes


def test_nothing_is_ignored_silently(read):
    drawing = read(
        "G21 G17 G94\nT1 M6\nG54\n/G1 X1 F9\nG1 X2 E0.5\n$H\nG4 P2\nM117 hello there\nG187 P1\nG1 X3 M8\nM30\nG1 X99"
    )
    found = {entry.what: entry.lines for entry in drawing.ignored}
    assert found == {
        "G94": (1,),
        "T1": (2,),
        "M6": (2,),
        "G54": (3,),
        "/ (block delete), read as if switched off": (4,),
        "E": (5,),
        "$H": (6,),
        "G4": (7,),
        "P": (7, 9),
        "M117": (8,),
        "G187": (9,),
        "M8": (10,),
    }
    assert drawing.path.length == 3


def test_going_home_and_back(read):
    text = "G21\nG0 X0 Y0 Z5\nG1 Z0\nG1 X5\nG91 G28 Z0\nG90 G53 G0 X0 Y0\nG0 X10 Y0 Z5\nG1 Z0\nG1 X20\nG28\n"
    drawing = read(text)
    np.testing.assert_allclose(drawing.path.points[[0, -1]], [[0, 0, 5], [20, 0, 0]])
    assert {entry.what for entry in drawing.ignored} == {
        "G28 (to a place of the machine)",
        "G53 (to a place of the machine)",
    }


BAD = {
    "moves nowhere": "",
    "moves nowhere ": "%\n(nothing)\n",
    "makes no cutting move": "G21\nG0 X5\n",
    "is not a text file": b"\x00\x01\x02",
    "line 1: is not understood (got 'ÿØÿà')": b"\xff\xd8\xff\xe0",
    "unit: is stated nowhere; the file would say it by G20 or G21": "G1 X5",
    "line 2: is not understood (got 'Xnan')": "G21\nG1 Xnan",
    "line 2: is not understood (got 'Xinf Y1')": "G21\nG1 Xinf Y1",
    "line 2: exceeds 1e+09 in magnitude": f"G21\nG1 X{'9' * 400}",
    "line 2: writes a number with an exponent": "G21\nG1 X1E5",
    "line 2: is not understood (got 'X')": "G21\nG1 X",
    "line 2: is not understood (got '.5')": "G21\nG1 X1..5",
    "line 2: has parentheses that do not pair": "G21\nG1 X1 (to the left",
    "line 2: has parentheses that do not pair ": "G21\nG1 X1 (to (the) left)",
    "line 1: asks for both G20 and G21": "G20 G21\nG1 X5",
    "line 1: asks for both G90 and G91": "G21 G90 G91\nG1 X5",
    "line 1: asks for both G17 and G19": "G21 G17 G19\nG1 X5",
    "line 1: asks for both G90.1 and G91.1": "G21 G90.1 G91.1\nG1 X5",
    "line 1: asks for both G54 and G55": "G21 G54 G55\nG1 X5",
    "line 3: changes from G54.1 P1 to G54.1 P2": "G21 G54.1 P1\nG1 X5\nG54.1 P2\nG1 X6",
    "line 2: asks for a dwell (G4) and a move (G1) at once": "G21\nG4 G1 X5",
    "line 3: asks for G81 ": "G21\nG1 X1\nG81\nX5 Y5",
    "line 2: asks for G112": "G21\nG112\nG1 X5",
    "line 2: asks for G65": "G21\nG65 P9010\nG1 X5",
    "line 3: makes 3 turns in one arc": "G21\nG2 X10 I5\nX0 I-5 P3",
    "line 2: has the word F twice": "G21\nG1 X5 F1 F2",
    "line 2: is not understood (got 'X٥')": "G21\nG1 X٥",
    "line 3: has ends 0.001 apart that lie nearly on a line with its centre": "G21\nG0 X10 Y0\nG2 X10.001 Y0 I-10",
    "line 3: has ends 0.1": "G21\nG0 X10 Y0\nG2 X10.09 Y0.09 I-10",
    "gaps: is for the plane": "G21\nG0 Z5\nG1 Z0\nG1 X5",
    "lift: is for the plane": "G21\nG0 Z5\nG1 Z0\nG1 X5",
    "line 2: holds a variable or an expression": "G21\nG1 X#1",
    "line 2: holds a variable or an expression ": "G21\n#1=5",
    "line 2: has the word X twice": "G21\nG1 X1 X2",
    "line 2: asks for both G0 and G1": "G21\nG0 G1 X2",
    "line 2: moves before any G0, G1, G2 or G3": "G21\nX1",
    "line 4: moves before any G0, G1, G2 or G3": "G21\nG1 X1\nG80\nX2",
    "line 2: has I, J in a straight move": "G21\nG1 X5 I3 J4",
    "line 2: is an arc without centre or radius": "G21\nG2 X5 Y5",
    "line 2: gives both R and I": "G21\nG2 X5 Y5 R5 I5",
    "line 2: ends where it starts, and R does not say": "G21\nG2 R5",
    "line 2: has ends 10 apart, more than twice its radius 4.9": "G21\nG2 X10 R4.9",
    "line 2: has its start 5 and its end 6 from its centre": "G21\nG2 X11 Y0 I5 J0",
    "line 2: is an arc of radius zero": "G21\nG2 X11 Y0 I0 J0",
    "line 2: has K in an arc in the plane G17": "G21\nG2 X10 K5",
    "line 2: has J in an arc in the plane G18": "G21 G18\nG2 X10 J5",
    "line 2: gives one coordinate of an absolute centre": "G21 G90.1\nG2 X10 I5",
    "line 2: makes 3 turns in one arc": "G21\nG2 X0 Y0 I5 P3",
    "line 2: moves the axis A": "G21\nG1 X1 A90",
    "line 2: calls a subprogram (M98)": "G21\nM98 P1000",
    "line 2: asks for G81": "G21\nG81 X1 Y1 Z-5 R2",
    "line 2: asks for G92": "G21\nG92 X0",
    "line 2: asks for G41": "G21\nG41 D1",
    "line 2: asks for G5,": "G21\nG5 X1 Y1 I1 J1 P1",
    "line 3: changes from G54 to G55": "G21 G54\nG1 X5\nG55",
    "line 3: says its unit after the first move": "G90\nG1 X5\nG21",
    "line 3: cuts from where the machine's own place": "G21 G1 X5\nG28\nG1 X5 Y0",
    "line 3: cuts in the machine's own coordinates": "G21 G1 X5\nG1\nG53 X5",
}


@pytest.mark.parametrize("message", BAD)
def test_bad_programs_are_refused_by_file_and_line(read, tmp_path, message):
    name = message.split(":")[0]
    with pytest.raises(sm.InvalidInputError) as caught:
        read(BAD[message], **{"gaps": {"gaps": "line"}, "lift": {"lift": 5.0}}.get(name, {}))
    assert str(caught.value).startswith(f"{tmp_path / 'program.nc'}: {message.strip()}")
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


def test_a_unit_that_the_program_contradicts_is_an_error(read):
    with pytest.raises(sm.InvalidInputError, match="unit: is mm, and the file says inch by G20 in line 2"):
        read("G90\nG20\nG1 X1", unit="mm")
    with pytest.raises(sm.InvalidInputError, match="unit: is not known"):
        read("G1 X1", unit="m")
    with pytest.raises(sm.InvalidInputError, match="dimension: is neither 2 nor 3"):
        read("G1 X1", unit="mm", dimension=4)


def test_arcs_that_are_off_by_no_more_than_the_tolerance_are_put_right(read):
    text = "G21\nG0 X75 Y50\nG3 X50.0004 Y75.0003 I-25.0002 J0\nG1 X10\n"
    drawing = read(text, tolerance=1e-3)
    assert off_circle(drawing.subpaths[0].pieces[0].path) <= 1e-3
    np.testing.assert_allclose(drawing.subpaths[0].pieces[0].end, [50.0004, 75.0003], atol=1e-12)
    with pytest.raises(sm.InvalidInputError, match="line 3: has its start"):
        read(text, tolerance=1e-4)
    read("G21\nG2 X10.00001 R5")  # a half circle whose end was rounded


numbers = st.decimals(-1000, 1000, places=4).map(lambda value: format(value, "f"))


@given(st.lists(st.tuples(numbers, numbers), min_size=2, max_size=6, unique=True), st.booleans(), st.booleans())
def test_numbers_are_read_as_they_are_written(points, spaces, lower):
    gap = " " if spaces else ""
    text = "".join(f"G1{gap}X{x}{gap}Y{gap if y[0] != '-' else ''}{y}\n" for x, y in points)
    found = [[word.value for word in block.words] for block in blocks(text.lower() if lower else text)]
    assert found == [[1.0, float(x), float(y)] for x, y in points]


@given(st.lists(st.tuples(numbers, numbers), min_size=2, max_size=6))
def test_relative_and_absolute_programs_are_the_same(points):
    import os
    import tempfile

    at, absolute, relative = np.zeros(2), "G21 G90\n", "G21 G91\n"
    for x, y in points:
        to = np.array([float(x), float(y)])
        absolute += f"G1 X{x} Y{y}\n"
        relative += f"G1 X{to[0] - at[0]:.4f} Y{to[1] - at[1]:.4f}\n"
        at = to
    if not np.hypot(*np.diff(np.array(points, dtype=float), axis=0, prepend=0).T).sum() > 0:
        return
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for name, text in (("a.nc", absolute), ("b.nc", relative)):
            file = os.path.join(folder, name)
            with open(file, "w", encoding="utf-8") as out:
                out.write(text)
            found.append(read_gcode(file, arm_unit="mm").path(np.linspace(0, 1, 11)))
    np.testing.assert_allclose(found[0], found[1], atol=1e-7)


@given(st.binary(max_size=80) | st.text(alphabet="GXYZIJRMF0123456789.-+ ()\n;%N/#", max_size=80).map(str.encode))
def test_any_bytes_are_a_program_or_an_input_error(data):
    import os
    import tempfile

    handle, name = tempfile.mkstemp()
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        assert np.isfinite(read_gcode(name, "mm", dimension=3).path([0.0, 0.5, 1.0])).all()
    except sm.InvalidInputError as error:
        assert "\n" not in str(error)  # noqa: PT017
    finally:
        os.unlink(name)


def test_many_moves_are_read_in_bounded_time(read):
    x = np.linspace(0, 90, 200_000)
    text = "G21\n" + "".join(f"G1 X{a:.4f} Y{b:.4f}\n" for a, b in zip(x, np.sin(x), strict=True))
    before = time.process_time()
    drawing = read(text)
    assert drawing.path(0.5).shape == (2,)
    assert time.process_time() - before < 12


def test_many_arcs_are_flattened_and_too_many_moves_refused(read, monkeypatch):
    text = "G21\n" + "".join(f"G2 X{k + 1} I0.5\n" for k in range(2001))
    drawing = read(text, tolerance=1e-3)
    assert 0 < drawing.chord_error <= 1e-3
    assert drawing.segments == {"flattened": 2001}
    assert drawing.length == pytest.approx(2001 * np.pi / 2, rel=1e-2)
    assert any("were flattened" in note for note in drawing.notes)
    monkeypatch.setattr("selfmotion.exchange.reading.MOST_SEGMENTS", 100)
    with pytest.raises(sm.InvalidInputError, match="lines, each curve counted as 20"):
        read(text)


def test_names_may_have_spaces_and_comments_any_letters(read):
    assert read("G21 (Öffnung)\nG1 X5", name="öffnung 1 ключ.nc").path.length == 5
    assert read("G21 (Öffnung)\nG1 X5".encode("latin-1")).path.length == 5


def test_where_the_tool_is_taken_to_be_at_first_is_said(read):
    def said(text, **options):
        return [note for note in read(text, **options).notes if note.startswith("nothing says where")]

    assert said("G21\nG1 X5 Y5") == [
        "nothing says where the tool is when it first cuts: it was taken to be at 0 in X, Y"
    ]
    assert said("G21\nG0 X0\nG1 X5 Y5")[0].endswith("at 0 in Y")
    assert said("G21\nG0 X0 Y0\nG1 Z-1\nX5")[0].endswith("at 0 in Z")
    assert said("G21 G91\nG0 X1 Y1\nG1 X5")[0].endswith("at 0 in X, Y")
    assert said("G21\nG0 X0 Y0 Z5\nG1 Z0\nX5") == []
    assert said("G21\nG0 X0 Y0\nG1 Z-1\nX5", dimension=2) == []


def test_the_second_percent_sign_ends_the_program(read):
    drawing = read("%\nO1\nG21\nG1 X5\n%\nG1 X99\nwhatever is here\n")
    assert drawing.path.length == 5
    assert [str(entry) for entry in drawing.ignored] == ["% (end of the program) (line 5)"]
    assert read("G21\nG1 X5\n%\n").path.length == 5


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_end_as_any_system_ends_them(read, end):
    drawing = read(end.join(["G21", "/2 G1 X5 M7", "X8 M8", "\x1a"]))
    assert drawing.path.length == 8
    assert {entry.what: entry.lines for entry in drawing.ignored} == {
        "/ (block delete), read as if switched off": (2,),
        "M7": (2,),
        "M8": (3,),
    }


def test_lifts_are_for_programs_of_the_plane(read):
    text = "G21\nG0 X0 Y0 Z5\nG1 Z0\nX5\nG0 Z5\nX9\nG1 Z0\nX12\n"
    path = read(text, dimension=2, lift=3.0).path
    assert path.dimension == 3
    assert path.length == pytest.approx(5 + 3 + 4 + 3 + 3)


@pytest.mark.parametrize("words", ["G2 X40 Y10 R-30", "G3 X40 Y10 R-30"])
def test_an_arc_of_more_than_half_a_turn_by_radius(read, words):
    """Against the circle's own geometry: the centre on the far side, the length from the chord."""
    path = read(f"G21\nG0 X0 Y0\n{words}").path
    chord = np.hypot(40, 10)
    assert path.length == pytest.approx(30 * (2 * np.pi - 2 * np.arcsin(chord / 60)), abs=1e-6)
    x = path(np.linspace(0, 1, 201))
    across = np.array([-10, 40]) / chord
    center = np.array([20, 5]) + across * np.sqrt(900 - chord**2 / 4) * (1 if words[1] == "2" else -1)
    assert np.abs(np.hypot(*(x - center).T) - 30).max() <= 1e-12 * 30
