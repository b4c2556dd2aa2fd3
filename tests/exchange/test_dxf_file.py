"""DXF: entities against their formulas, chains, units, and every file that is refused."""

import json
import logging
import sys
import time

import ezdxf
import numpy as np
import pytest
from drawn import assert_circle, off_circle, turning

import selfmotion as sm
from selfmotion.errors import MissingExtraError
from selfmotion.exchange import read_dxf
from selfmotion.exchange.chaining import chained
from selfmotion.exchange.pieces import line


@pytest.fixture
def read(tmp_path):
    def make(draw, units=4, version="R2010", name="drawing.dxf", **options):
        file = tmp_path / name
        if callable(draw):
            document = ezdxf.new(version)
            document.header["$INSUNITS"] = units
            draw(document.modelspace())
            document.saveas(file)
        else:
            file.write_bytes(draw)
        return read_dxf(file, **{"arm_unit": "mm", **options})

    return make


MIRRORED = {"extrusion": (0, 0, -1)}


def block(space, **scales):
    inner = space.doc.blocks.new("inner")
    inner.add_circle((0, 0), 5)
    space.add_blockref("inner", (50, 50), dxfattribs={"rotation": 40, "xscale": 5, "yscale": 5, **scales})


def rational(space):
    """A circle as nine rational control points."""
    s = np.sqrt(0.5)
    corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    spline = space.add_rational_spline(
        [(50 + 25 * x, 50 + 25 * y) for x, y in corners],
        weights=[1, s] * 4 + [1],
        degree=2,
        knots=[0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4],
    )
    return spline


CIRCLES = {
    "circle": (lambda space: space.add_circle((50, 50), 25), 1),
    "circle seen from below": (lambda space: space.add_circle((-50, 50), 25, dxfattribs=MIRRORED), 1),
    "arcs": (lambda space: [space.add_arc((50, 50), 25, a, b) for a, b in ((0, 200), (200, 360))], 2),
    "arcs in no order": (
        lambda space: [space.add_arc((50, 50), 25, a, b) for a, b in ((10, 100), (250, 10), (100, 250))],
        3,
    ),
    "bulges": (lambda space: space.add_lwpolyline([(75, 50, 1), (25, 50, 1)], "xyb", close=True), 2),
    "large bulge": (
        lambda space: space.add_lwpolyline(
            [(75, 50, -np.tan(3 * np.pi / 8)), (50, 75, -np.tan(np.pi / 8))], "xyb", close=True
        ),
        2,
    ),
    "bulges seen from below": (
        lambda space: space.add_lwpolyline([(-75, 50, 1), (-25, 50, 1)], "xyb", close=True, dxfattribs=MIRRORED),
        2,
    ),
    "old polyline": (lambda space: space.add_polyline2d([(75, 50, 1), (25, 50, 1)], "xyb", close=True), 2),
    "ellipse": (lambda space: space.add_ellipse((50, 50), (0, 25), 1.0), 1),
    "block": (block, 1),
    "block mirrored": (lambda space: block(space, xscale=-5), 1),
}


@pytest.mark.parametrize("case", CIRCLES)
def test_every_way_to_draw_a_circle(read, case):
    draw, parts = CIRCLES[case]
    assert_circle(read(draw), parts=parts, tolerance=1e-9 if "block" in case else 1e-12)


def test_senses_of_rotation(read):
    assert turning(read(CIRCLES["circle"][0]).path) > 0
    assert turning(read(CIRCLES["large bulge"][0]).path) < 0
    assert turning(read(CIRCLES["bulges seen from below"][0]).path) < 0


def test_a_rational_spline_is_flattened_within_the_tolerance(read):
    drawing = read(rational, tolerance=1e-3)
    assert drawing.segments == {"flattened": 1}
    assert 0 < drawing.chord_error <= 1e-3
    assert off_circle(drawing.path) <= drawing.chord_error * (1 + 1e-6)
    assert drawing.path.is_closed
    # A chord as far off the arc is shorter by 8/3 of the square of its sagitta over the chord.
    assert drawing.path.length == pytest.approx(50 * np.pi, rel=1e-3)
    finer = read(rational, tolerance=1e-6)
    assert off_circle(finer.path) <= 1e-6
    assert finer.path.length == pytest.approx(50 * np.pi, abs=1e-4)


def de_boor(t, control, degree, knots):
    """Return a B-spline by the recursion of its basis (Cox, de Boor), in numbers only."""
    basis = [(knots[i] <= t) & (t < knots[i + 1]) for i in range(len(knots) - 1)]
    basis = [b.astype(float) for b in basis]
    for d in range(1, degree + 1):
        following = []
        for i in range(len(basis) - 1):
            value = np.zeros_like(t)
            if knots[i + d] > knots[i]:
                value += (t - knots[i]) / (knots[i + d] - knots[i]) * basis[i]
            if knots[i + d + 1] > knots[i + 1]:
                value += (knots[i + d + 1] - t) / (knots[i + d + 1] - knots[i + 1]) * basis[i + 1]
            following.append(value)
        basis = following
    return np.stack(basis, axis=1) @ control


@pytest.mark.parametrize("knots", [[0, 0, 0, 0, 1, 2.5, 4, 4, 4, 4], [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]])
def test_a_spline_against_its_recursion(read, knots):
    control = np.array([(0, 0), (30, 40), (60, -10), (80, 50), (100, 20), (90, 80)], dtype=float)

    def draw(space):
        spline = space.add_spline(degree=3)
        spline.control_points = [(*point, 0) for point in control]
        spline.knots = knots

    drawing = read(draw, tolerance=1e-4)
    clamped = knots[3] == 0
    assert drawing.segments == ({"bezier": 3} if clamped else {"flattened": 1})
    assert drawing.chord_error <= 1e-4
    t = np.linspace(knots[3], knots[6], 4001)[:-1]
    exact = de_boor(t, control, 3, np.array(knots, dtype=float))
    if clamped:  # each span of knots is one Bezier curve
        for piece, (a, b) in zip(drawing.subpaths[0].pieces, ((0, 1), (1, 2.5), (2.5, 4)), strict=True):
            r = np.linspace(0, 1, 50)[:-1]
            x = de_boor(a + (b - a) * r, control, 3, np.array(knots, dtype=float))
            np.testing.assert_allclose(piece.path(r), x, atol=1e-12)
        assert drawing.path.length == pytest.approx(np.hypot(*np.diff(exact, axis=0).T).sum(), rel=1e-3)
        return
    x = drawing.path(np.linspace(0, 1, 20001))
    worst = max(np.hypot(*(x - point).T).min() for point in exact[::40])
    assert worst <= 1e-4 + np.hypot(*np.diff(x, axis=0).T).max()


def test_an_elliptic_arc(read):
    drawing = read(lambda space: space.add_ellipse((1, 2), (30, 10), 0.5, 0.3, 2.0))
    t = 0.3 + 1.7 * np.linspace(0, 1, 50)[:, None]
    exact = np.array([1, 2]) + np.cos(t) * [30, 10] + 0.5 * np.sin(t) * [-10, 30]
    np.testing.assert_allclose(drawing.path(np.linspace(0, 1, 50)), exact, atol=1e-12)
    assert drawing.segments == {"ellipse": 1}


def outline(space):
    """A slot whose pieces are drawn in no order and in either direction, then a hole."""
    space.add_line((10, 0), (0, 0))
    space.add_line((0, 10), (10, 10))
    space.add_arc((0, 5), 5, 90, 270)
    space.add_arc((10, 5), 5, -90, 90)
    space.add_circle((5, 5), 1)


def test_chains_run_as_their_first_entity_and_keep_the_order_of_the_file(read):
    drawing = read(outline)
    assert [part.closed for part in drawing.subpaths] == [True, True]
    first, hole = drawing.subpaths
    np.testing.assert_allclose(first.start, [10, 0], atol=1e-12)
    assert [piece.kind for piece in first.pieces] == ["line", "arc", "line", "arc"]
    assert first.length == pytest.approx(20 + 10 * np.pi)
    assert turning(first.path) < 0
    assert hole.length == pytest.approx(2 * np.pi)
    assert drawing.gaps[0].length == pytest.approx(np.hypot(4, 5))


@pytest.mark.parametrize("gap", [1e-5, 0.05])
def test_ends_within_the_tolerance_are_joined_and_that_is_said(read, gap):
    def draw(space):
        space.add_line((0, 0), (10, gap))
        space.add_line((10, 0), (20, 0))
        space.add_arc((20, 5 + gap), 5, -90, 90)
        space.add_arc((20, 15), 5, -90, 90)

    drawing = read(draw, tolerance=0.1)
    assert len(drawing.subpaths) == 1
    assert len(drawing.joints) == 3
    assert max(drawing.joints) == pytest.approx(gap)
    assert f"3 joints closed, the widest {gap:.2g}" in drawing.lines()[3]
    assert drawing.path.length == pytest.approx(20 + 10 * np.pi, abs=4 * gap)
    x = drawing.path(drawing.path.grid(1000))
    assert np.hypot(*np.diff(x, axis=0).T).max() < 0.2
    apart = read(draw, tolerance=gap / 2)
    assert len(apart.subpaths) == 4


def test_a_drawing_nearly_closed_is_closed(read):
    def draw(space):
        space.add_lwpolyline([(0, 0), (10, 0), (10, 10), (0.01, 0.02)])

    assert read(draw, tolerance=0.1).path.is_closed
    assert not read(draw, tolerance=0.001).path.is_closed
    assert read(lambda space: space.add_arc((0, 0), 5, 0.1, 360), tolerance=0.1).path.is_closed


def test_forks_are_said_and_the_file_s_order_kept(read):
    def draw(space):
        space.add_line((0, 0), (10, 0))
        space.add_line((10, 0), (20, 5))
        space.add_line((10, 0), (20, -5))

    drawing = read(draw)
    np.testing.assert_allclose(drawing.subpaths[0].end, [20, 5])
    assert any("more than two ends meet at 1 points, the first (10, 0)" in note for note in drawing.notes)


def test_chaining_any_order_gives_back_the_whole_polyline():
    rng = np.random.default_rng(5)
    corners = np.cumsum(rng.normal(size=(40, 2)), axis=0)
    for _ in range(20):
        strokes = []
        for k in rng.permutation(39):
            ends = corners[k : k + 2] if rng.random() < 0.5 else corners[k : k + 2][::-1]
            strokes.append([line(np.array(ends))])
        chains, forks = chained(strokes, 1e-9)
        assert len(chains) == 1
        assert not forks
        found = np.vstack([chains[0][0].start, *(piece.end for piece in chains[0])])
        assert (found == corners).all() or (found == corners[::-1]).all()
    assert chained([], 1.0) == ([], [])


def test_lines_shorter_than_the_tolerance_are_chained_too():
    """Fine curves are drawn as many short lines; each goes on with the nearest, not with the first that is near."""
    corners = np.stack([np.arange(400) * 0.05, np.sin(np.arange(400) * 0.05)], axis=1)
    order = np.random.default_rng(2).permutation(399)
    chains, forks = chained([[line(corners[k : k + 2])] for k in order], 0.1)
    assert len(chains) == 1
    assert forks == []
    assert sum(piece.length for piece in chains[0]) == pytest.approx(np.hypot(*np.diff(corners, axis=0).T).sum())


def test_many_strokes_from_one_point_are_chained_in_bounded_time():
    angles = np.linspace(0, 6, 20_000)
    star = [[line(np.array([[0.0, 0.0], [10 * np.cos(a), 10 * np.sin(a)]]))] for a in angles]
    before = time.process_time()
    chains, forks = chained(star, 1e-4)
    assert len(chains) == 10_000
    assert len(forks) == 1
    assert time.process_time() - before < 20


@pytest.mark.parametrize(
    ("code", "metres"), [(1, 0.0254), (2, 0.3048), (4, 1e-3), (5, 1e-2), (6, 1.0), (14, 0.1), (10, 0.9144)]
)
def test_units_of_the_file(read, code, metres):
    drawing = read(lambda space: space.add_line((0, 0), (3, 4)), units=code, arm_unit="m")
    assert drawing.path.length == pytest.approx(5 * metres, rel=1e-12)


def test_units_asked_for(read):
    def draw(space):
        space.add_line((0, 0), (3, 4))

    assert read(draw, units=0, unit="inch", arm_unit="m").path.length == pytest.approx(0.127)
    assert read(draw, units=4, unit="mm").path.length == pytest.approx(5)
    with pytest.raises(sm.InvalidInputError, match=r"unit: is inch, and the file says mm by \$INSUNITS"):
        read(draw, units=4, unit="inch")
    with pytest.raises(sm.InvalidInputError, match=r"unit: is stated nowhere; the file would say it by \$INSUNITS"):
        read(draw, units=0)


def test_what_is_no_path_is_reported(read):
    def draw(space):
        space.doc.layers.add("hidden").off()
        space.add_text("bracket")
        space.add_point((1, 1))
        space.add_point((2, 1))
        space.add_circle((0, 0), 1, dxfattribs={"layer": "hidden"})
        space.add_line((0, 0), (5, 0))

    drawing = read(draw)
    assert {entry.what: entry.count for entry in drawing.ignored} == {"TEXT": 1, "POINT": 2, "CIRCLE that is hidden": 1}
    assert drawing.path.length == 5


@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_versions_and_binary_files(read, tmp_path, version):
    assert read(lambda space: space.add_line((0, 0), (5, 0)), version=version, unit="mm", units=4).path.length == 5
    document = ezdxf.new(version)
    document.header["$INSUNITS"] = 4
    document.modelspace().add_line((0, 0), (5, 0))
    document.saveas(tmp_path / "binary.dxf", fmt="bin")
    unit = "mm" if version == "R12" else None  # which knows no $INSUNITS
    assert read_dxf(tmp_path / "binary.dxf", unit, arm_unit="mm").path.length == 5


def text_of(draw):
    import io

    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    draw(document.modelspace())
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def a_line(space):
    space.add_line((1.25, 2.5), (3.75, 4.5))


BAD = {
    "is empty": lambda: b"  \n",
    "is not a DXF file": lambda: b"\x89PNG\x00\x01",
    "is not a DXF file ": lambda: b"x,y\n1,2\n",
    "is not a DXF file  ": lambda: b"AC1032\x00\x00\x00",
    "does not end with EOF: a part of it is missing": lambda: text_of(a_line)[:-400].encode(),
    "is not a DXF file that can be read": lambda: b"0\nSECTION\n2\nHEADER\nnumber\n5\n0\nEOF\n",
    "draws nothing that could be followed": lambda: text_of(lambda _: None).encode(),
    "LINE of handle": lambda: text_of(a_line).replace("\n3.75\n", "\nnan\n").encode(),
    "LINE of handle ": lambda: text_of(a_line).replace("\n3.75\n", "\n1e300\n").encode(),
    "is not a DXF file that can be read ": lambda: text_of(a_line).replace("\n3.75\n", "\nleft\n").encode(),
    "LINE of handle  ": lambda: text_of(lambda space: space.add_line((0, 0, 0), (5, 0, 9))).encode(),
    "CIRCLE of handle": lambda: text_of(
        lambda space: space.add_circle((0, 0), 5, dxfattribs={"extrusion": (1, 0, 0)})
    ).encode(),
    "SPLINE of handle": lambda: text_of(lambda space: space.add_spline(degree=3)).encode(),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_files_are_refused_by_file_and_handle(read, tmp_path, message):
    with pytest.raises(sm.InvalidInputError) as caught:
        read(BAD[message]())
    assert str(caught.value).startswith(f"{tmp_path / 'drawing.dxf'}: {message.strip()}")
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("part", [0.2, 0.5, 0.8, 0.95])
def test_a_file_cut_off_anywhere_is_refused(read, part):
    text = text_of(outline)
    with pytest.raises(sm.InvalidInputError):
        read(text[: int(part * len(text))].encode())


def test_many_points_in_bounded_time_and_too_many_refused(read, monkeypatch):
    text = text_of(lambda space: space.add_lwpolyline([(1, 2), (3, 4)], "xy"))
    start = text.index(" 10\n", text.index("\nENTITIES\n"))
    stop = text.index("  0\n", start)
    rows = "".join(f" 10\n{x:.4f}\n 20\n{np.sin(x):.4f}\n" for x in np.linspace(0, 90, 200_000))
    before = time.process_time()
    drawing = read((text[:start] + rows + text[stop:]).encode())
    assert drawing.path(0.5).shape == (2,)
    assert drawing.segments["line"] > 160_000
    assert time.process_time() - before < 24
    monkeypatch.setattr("selfmotion.exchange.reading.MOST_SEGMENTS", 30)
    with pytest.raises(sm.InvalidInputError, match="lines, each curve counted as 20"):
        read(outline)


def test_blocks_in_blocks_are_bounded(read, monkeypatch):
    monkeypatch.setattr("selfmotion.exchange.reading.MOST_SEGMENTS", 2000)

    def draw(space):
        blocks = space.doc.blocks
        blocks.new("b0").add_line((0, 0), (1, 0))
        for k in range(1, 9):
            inner = blocks.new(f"b{k}")
            for m in range(10):
                inner.add_blockref(f"b{k - 1}", (m * 10.0**k, 0))
        space.add_blockref("b8", (0, 0))

    before = time.process_time()
    with pytest.raises(sm.InvalidInputError, match="lines, each curve counted as 20"):
        read(draw)
    assert time.process_time() - before < 60


def test_names_may_have_spaces_and_any_letters(read):
    drawing = read(lambda space: space.add_line((0, 0), (5, 0)), name="кронштейн 支架 ö.dxf")
    assert drawing.path.length == 5


def test_without_the_package_the_extra_is_named(tmp_path, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "ezdxf"]:
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(MissingExtraError, match=r"pip install 'selfmotion\[io\]'"):
        read_dxf(tmp_path / "any.dxf")


HEADLESS = b"0\nSECTION\n2\nENTITIES\n0\nLINE\n8\n0\n10\n0\n20\n0\n11\n5\n21\n0\n0\nENDSEC\n0\nEOF\n"


def test_a_file_without_header_says_no_unit(read):
    """Its reader has metres as a default, which is none of the file's words."""
    with pytest.raises(sm.InvalidInputError, match="unit: is stated nowhere"):
        read(HEADLESS)
    assert read(HEADLESS, unit="mm").path.length == 5


def test_units_that_contradict_each_other_or_the_size_are_warnings(read):
    def draw(space):
        space.add_line((0, 0), (300, 0))

    assert read(draw, units=4).warnings == ()
    (found,) = read(draw, units=1).warnings
    assert found == "the file contradicts itself: its unit is inch by $INSUNITS, and metric by $MEASUREMENT"
    (found,) = read(draw, units=6).warnings
    assert found == (
        "it extends over 300 m, its numbers being in m by $INSUNITS; "
        "it would extend over 0.3 m if they were in mm or 3 m if they were in cm"
    )
    assert "extends over 3e-05 m" in read(lambda space: space.add_line((0, 0), (0.03, 0))).warnings[0]


def nested(space):
    space.doc.blocks.new("a").add_blockref("a", (1, 1))
    space.add_blockref("a", (0, 0))


def askew(space):
    inner = space.doc.blocks.new("a")
    inner.add_blockref("a", (1, 1), dxfattribs={"xscale": 2, "rotation": 30})
    space.add_blockref("a", (0, 0), dxfattribs={"yscale": 3, "rotation": 10})


def empty_bomb(space):
    space.doc.blocks.new("b0")
    for k in range(1, 9):
        inner = space.doc.blocks.new(f"b{k}")
        for _ in range(10):
            inner.add_blockref(f"b{k - 1}", (0, 0))
    space.add_blockref("b8", (0, 0))


def spline(weights=None, knots=None, points=((0, 0), (5, 5), (10, 0))):
    return lambda space: space.add_open_spline(points, 2, knots).__setattr__("weights", weights or [])


WRONG = {
    "INSERT of handle .*: inserts itself": nested,
    "INSERT of handle .*: inserts itself ?": askew,
    "INSERT of handle .*: inserts itself, or too many others": empty_bomb,
    "INSERT of handle .*: inserts the block 'none', which is not in": lambda space: space.add_blockref("none", (0, 0)),
    "CIRCLE of handle .*: has a negative radius": lambda space: space.add_circle((0, 0), -5),
    "SPLINE of handle .*: has weights that are not positive": spline([1, -3, 1]),
    "SPLINE of handle .*: has weights that are not positiv": spline([0, 0, 0]),
    "SPLINE of handle .*: has knots that do not ascend": spline(knots=[0] * 6),
    "SPLINE of handle .*: has knots that do not ascen": spline(
        knots=[0, 0, 0, 0.7, 0.3, 1, 1, 1], points=[(0, 0), (5, 5), (10, 0), (15, 3), (20, 0)]
    ),
    "SPLINE of handle .*: comes apart at a knot": spline(
        knots=[0, 0, 0, 1, 1, 1, 2, 2, 2], points=[(0, 0), (1, 1), (2, 0), (3, 1), (4, 0), (5, 1)]
    ),
}


@pytest.mark.parametrize("message", WRONG)
def test_entities_that_contradict_themselves_are_refused_by_handle(read, message):
    with pytest.raises(sm.InvalidInputError, match=message) as caught:
        read(WRONG[message])
    assert caught.value.remedy
    assert "handle ?" not in str(caught.value)


def test_inserts_are_hidden_as_layers_say(read):
    """Frozen layers hide all of an insert; those that are off only what is on the layer of the insert."""

    def draw(space):
        space.doc.layers.add("off").off()
        space.doc.layers.add("frozen").freeze()
        inner = space.doc.blocks.new("inner")
        inner.add_line((0, 0), (10, 0))
        inner.add_line((0, 5), (7, 5), dxfattribs={"layer": "seen"})
        for k, attributes in enumerate(({"layer": "off"}, {"layer": "frozen"}, {"invisible": 1})):
            space.add_blockref("inner", (0, 20 * k), dxfattribs=attributes)

    drawing = read(draw)
    assert drawing.path.length == 7
    assert {entry.what: entry.count for entry in drawing.ignored} == {
        "LINE that is hidden": 1,
        "INSERT that is hidden": 2,
    }


def test_annotations_are_none_of_the_workpiece(read):
    def draw(space):
        space.add_linear_dim(base=(0, 2), p1=(0, 0), p2=(3, 0)).render()
        space.add_leader([(0, 0), (5, 5)])
        space.add_mline([(0, 0), (5, 5)])
        space.add_line((0, 9), (4, 9))

    drawing = read(draw)
    assert drawing.path.length == 4
    assert {entry.what for entry in drawing.ignored} == {
        "DIMENSION, an annotation",
        "LEADER, an annotation",
        "MLINE, to be exploded in the drawing program",
    }


def test_a_spline_whose_weights_are_all_the_same_is_exact(read):
    plain, weighted = (read(spline(weights)) for weights in (None, [2.5, 2.5, 2.5]))
    assert weighted.segments == plain.segments == {"bezier": 1}
    assert weighted.chord_error == 0
    np.testing.assert_array_equal(weighted.path([0.0, 0.3, 1.0]), plain.path([0.0, 0.3, 1.0]))


def test_any_flipped_byte_or_line_is_a_drawing_or_an_input_error(read, tmp_path, monkeypatch):
    """Text and binary; no traceback, whatever the parser makes of it."""
    # What the parser logs has bytes in it that are no text, which reports of tests cannot be sent with.
    monkeypatch.setattr(logging.getLogger("ezdxf"), "propagate", False)
    document = ezdxf.new()
    document.header["$INSUNITS"] = 4
    outline(document.modelspace())
    block(document.modelspace())
    document.saveas(tmp_path / "good.dxf", fmt="bin")
    binary = (tmp_path / "good.dxf").read_bytes()
    lines = text_of(lambda space: (outline(space), block(space))).split("\n")
    rng = np.random.default_rng(5)
    refused = 0
    for k in range(60):
        broken, spoilt = bytearray(binary), list(lines)
        broken[rng.integers(len(broken))] = rng.integers(256)
        spoilt[rng.integers(len(spoilt))] = ("", "x", "-1", "1e309", "nan", "0", "9" * 25)[k % 7]
        for data in (bytes(broken), "\n".join(spoilt).encode(), binary[: int(len(binary) * k / 60)]):
            try:
                drawing = read(data, gaps="line")
                assert np.isfinite(drawing.path([0.0, 0.5, 1.0])).all()
                json.dumps(drawing.summary())
            except sm.InvalidInputError as error:
                refused += 1
                assert "\n" not in str(error)  # noqa: PT017
    assert 60 < refused < 180
