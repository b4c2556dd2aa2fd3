"""SVG: shapes against their formulas, pages and units, and every file that is refused."""

import sys
import time

import numpy as np
import pytest
from drawn import RADIUS, assert_circle, off_circle, svg, turning

import selfmotion as sm
from selfmotion.errors import MissingExtraError
from selfmotion.exchange import read_svg
from selfmotion.paths import Bezier


@pytest.fixture
def read(tmp_path):
    def make(body, page=None, name="drawing.svg", **options):
        file = tmp_path / name
        text = body if isinstance(body, bytes) else (svg(body) if page is None else svg(body, page)).encode()
        file.write_bytes(text)
        return read_svg(file, **{"arm_unit": "mm", **options})

    return make


CIRCLES = {
    "two arcs": ('<path d="M 75 50 A 25 25 0 0 1 25 50 A 25 25 0 0 1 75 50 Z"/>', 2),
    "a small and a large arc": ('<path d="M75 50A25 25 0 0 1 50 75 25 25 0 1 1 75 50z"/>', 2),
    "an arc grown to fit": ('<path d="M 75 50 A 1 1 0 0 0 25 50 a 25 25 0 0 0 50 0"/>', 2),
    "arcs grown from next to nothing": ('<path d="M75 50A1e-308 1e-308 0 0 1 25 50 1e-9 1e-9 0 0 1 75 50"/>', 2),
    "circle": ('<circle cx="50" cy="50" r="25"/>', 1),
    "ellipse": ('<ellipse cx="50" cy="50" rx="25" ry="25"/>', 1),
    "moved": ('<g transform="translate(50,50)"><circle r="25" transform="rotate(33)"/></g>', 1),
    "mirrored and scaled": ('<circle cx="-25" cy="25" r="12.5" transform="scale(-2 2)"/>', 1),
    "an ellipse squeezed": ('<ellipse cx="12.5" cy="50" rx="6.25" ry="25" transform="scale(4 1)"/>', 1),
    "squeezed askew": ('<ellipse rx="50" ry="25" transform="translate(50 50) rotate(20) scale(.5 1)"/>', 1),
    "used": ('<defs><circle id="c" r="25"/></defs><use xlink:href="#c" x="50" y="50"/>', 1),
    "a pixel is a user unit": ('<circle cx="50" cy="50" r="25px"/>', 1),
}


@pytest.mark.parametrize("case", CIRCLES)
def test_every_way_to_draw_a_circle(read, case):
    body, parts = CIRCLES[case]
    assert_circle(read(body), parts=parts)


def test_circles_run_as_svg_says_with_y_turned_up(read):
    """In SVG angles count from x to y, which points down there: clockwise as one sees it."""
    path = read('<circle cx="50" cy="50" r="25"/>').path
    np.testing.assert_allclose(path(0.0), [75, 50], atol=1e-12)
    assert turning(path) == pytest.approx(-np.pi * RADIUS**2, rel=1e-4)
    assert turning(read(CIRCLES["two arcs"][0]).path) < 0
    assert turning(read(CIRCLES["an arc grown to fit"][0]).path) > 0


def test_a_cubic_bezier_against_its_formula(read):
    drawing = read('<path d="M 10 20 C 30 90 60 -10 80 40"/>')
    r = np.linspace(0, 1, 101)[:, None]
    b = np.array([[10, 80], [30, 10], [60, 110], [80, 60]])  # 100 − y
    exact = (1 - r) ** 3 * b[0] + 3 * r * (1 - r) ** 2 * b[1] + 3 * r**2 * (1 - r) * b[2] + r**3 * b[3]
    assert isinstance(drawing.path, Bezier)
    np.testing.assert_allclose(drawing.path(r[:, 0]), exact, atol=1e-12)
    x = exact[:, 1]
    assert drawing.bounds[0, 1] <= x.min()
    assert drawing.bounds[1, 1] >= x.max()
    assert drawing.bounds[1, 1] == pytest.approx(x.max(), abs=0.05)


def test_quadratic_and_smooth_curves_and_all_letters(read):
    one = read('<path d="M10 10 Q 20 40 40 10 T 70 10 C 80 0 85 5 90 10 S 95 30 99 20 H 50 V 30 L 10 10"/>')
    two = read('<path d="m10 10 q 10 30 30 0 t 30 0 c 10 -10 15 -5 20 0 s 5 20 9 10 h -49 v 10 l -40 -20 z"/>')
    r = np.linspace(0, 1, 77)
    np.testing.assert_allclose(one.path(r), two.path(r), atol=1e-11)
    assert one.segments == {"bezier": 4, "line": 3}


@pytest.mark.parametrize(
    ("shape", "length", "kinds"),
    [
        ('<line x1="10" y1="20" x2="40" y2="60"/>', 50, {"line": 1}),
        ('<polyline points="0,0 30,0 30,40"/>', 70, {"line": 2}),
        ('<polygon points="0 0,30 0-30 40"/>', 30 + np.hypot(60, 40) + 50, {"line": 3}),
        ('<rect x="1" y="2" width="30" height="20"/>', 100, {"line": 4}),
        ('<rect x="1" y="2" width="30" height="20" rx="5"/>', 60 + 10 * np.pi, {"line": 4, "arc": 4}),
        ('<rect width="30" height="20" ry="90" rx="5"/>', None, {"line": 2, "ellipse": 4}),
        ('<path d="M0 0 30 0A0 5 0 0 1 30 40"/>', 70, {"line": 2}),
        ('<path d="M0 0 30 0A20 1e-308 0 0 1 30 40"/>', 70, {"line": 2}),
    ],
)
def test_basic_shapes(read, shape, length, kinds):
    drawing = read(shape)
    assert drawing.segments == kinds
    if length is not None:
        assert drawing.path.length == pytest.approx(length, abs=1e-9)
    assert drawing.path.breaks.size >= 0


def test_an_ellipse_under_an_affine_map_is_that_ellipse(read):
    drawing = read('<ellipse cx="3" cy="4" rx="10" ry="5" transform="matrix(2 .5 -.3 1.5 20 10)"/>')
    phi = np.linspace(0, 2 * np.pi, 200)
    page = np.stack([3 + 10 * np.cos(phi), 4 + 5 * np.sin(phi)])
    moved = np.array([[2, -0.3], [0.5, 1.5]]) @ page + np.array([[20], [10]])
    exact = np.stack([moved[0], 100 - moved[1]], axis=1)
    x = drawing.path(np.linspace(0, 1, 200))
    np.testing.assert_allclose(x, exact, atol=1e-11)
    np.testing.assert_allclose(drawing.bounds[:, 0], [exact[:, 0].min(), exact[:, 0].max()], atol=1e-2)


@pytest.mark.parametrize(
    ("page", "unit", "size"),
    [
        ('width="10cm" height="10cm" viewBox="0 0 100 100"', None, 0.05),
        ('width="4in" viewBox="0 0 100 100"', None, 4 * 0.0254 / 2),
        ('width="72pt" height="72pt" viewBox="0 0 50 50"', None, 0.0254),
        ('width="100mm" height="200mm" viewBox="0 0 100 100"', None, 0.05),
        ('width="100mm" height="200mm" viewBox="0 0 100 100" preserveAspectRatio="xMidYMid slice"', None, 0.1),
        ('viewBox="0 0 100 100"', "mm", 0.05),
        ('viewBox="0 0 100 100"', "inch", 50 * 0.0254),
        ('width="200" height="200"', "mm", 0.05),
        ("", "px", 50 * 0.0254 / 96),
        ('width="100%" height="100%"', "m", 50.0),
        ('width="200px" height="200px" viewBox="0 0 100 100"', "mm", 0.05),
    ],
)
def test_pages_and_units(read, page, unit, size):
    drawing = read('<line x1="10" y1="20" x2="60" y2="20"/>', page, unit=unit, arm_unit="m")
    assert drawing.path.length == pytest.approx(size, rel=1e-12)


def test_a_page_stretched_is_drawn_stretched(read):
    page = 'width="100mm" height="200mm" viewBox="0 0 100 100" preserveAspectRatio="none"'
    np.testing.assert_allclose(read('<line x2="10" y2="20"/>', page).path([0.0, 1.0]), [[0, 200], [10, 160]])


def test_the_origin_is_the_lower_left_corner_of_the_page(read):
    shape = '<line x1="5" y1="110" x2="25" y2="60"/>'
    page = 'width="100mm" height="100mm" viewBox="5 10 100 100"'
    np.testing.assert_allclose(read(shape, page).path([0.0, 1.0]), [[0, 0], [20, 50]], atol=1e-12)
    np.testing.assert_allclose(read(shape, "", unit="mm").path([0.0, 1.0]), [[5, -110], [25, -60]])
    np.testing.assert_allclose(read(shape, 'height="120"', unit="mm").path([0.0, 1.0]), [[5, 10], [25, 60]])


def test_subpaths_keep_their_order_and_what_meets_is_one(read):
    body = '<path d="M50 50 h10 M0 0 h10 M10 0 v10"/><path d="M10 10 h5"/><line x1="80" x2="90" y1="1" y2="1"/>'
    drawing = read(body)
    np.testing.assert_allclose([part.start for part in drawing.subpaths], [[50, 50], [0, 100], [80, 99]])
    assert [part.length for part in drawing.subpaths] == pytest.approx([10, 25, 10])
    assert [gap.after for gap in drawing.gaps] == [0, 1]
    assert drawing.gaps[0].length == pytest.approx(np.hypot(60, 50))


def test_what_is_not_drawn_is_reported_with_its_line(read):
    drawing = read(
        '<defs><path id="a" d="M0 0h1"/></defs>\n<text>R</text>\n<g style="display:none"><path d="M0 0h1"/></g>\n'
        '<image href="x.png"/><text>S</text><metadata/><style>path {stroke: red}</style>\n'
        '<path d="M0 0h9"/><path d=""/>'
    )
    assert drawing.segments == {"line": 1}
    found = {entry.what: (entry.count, entry.lines) for entry in drawing.ignored}
    assert found == {
        "<text>, not converted to paths": (2, (3, 5)),
        "<g> that is hidden": (1, (4,)),
        "<image>, a picture of pixels": (1, (5,)),
        "<style>, whose rules are not read": (1, (5,)),
    }
    assert "(lines 3, 5)" in "\n".join(drawing.lines())


BOMB = """<?xml version="1.0"?>
<!DOCTYPE lolz [<!ENTITY lol "lol"><!ENTITY lol2 "&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;&lol;">
<!ENTITY lol3 "&lol2;&lol2;&lol2;&lol2;&lol2;&lol2;&lol2;&lol2;&lol2;&lol2;">]>
<svg xmlns="http://www.w3.org/2000/svg"><text>&lol3;</text></svg>"""
OUTSIDE = """<!DOCTYPE svg [<!ENTITY outside SYSTEM "file:///etc/passwd">]>
<svg xmlns="http://www.w3.org/2000/svg"><text>&outside;</text></svg>"""
PUBLIC = """<?xml version="1.0" encoding="UTF-8"?>

<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">
<svg xmlns="http://www.w3.org/2000/svg"/>"""
BAD = {
    "line 2: declares a document type": BOMB.encode(),
    "line 1: declares a document type": OUTSIDE.encode(),
    "line 3: declares a document type": PUBLIC.encode(),
    "is packed, as files ending in .svgz are": b"\x1f\x8b\x08\x00\xff\xfe\x00",
    "line 1: is not XML: not well-formed": b"\x00\x01\x02",
    "line 1: is not XML: no element found": b"",
    "line 2: is not XML: no element found": svg('<path d="M0 0h1"/>').encode()[:-7],
    "line 2: is not XML: unclosed token": svg('<path d="M0 0h1"/>').encode()[:-9],
    "line 1: is not an SVG document": b"<html/>",
    "draws nothing that could be followed": svg("").encode(),
    "draws nothing that could be followed ": svg(
        '<text>R</text><path d="M 5 5"/><rect width="0" height="9"/>'
    ).encode(),
    "line 2, <path>: has path data that is not read": svg('<path d="M 0 0 L 10"/>').encode(),
    "line 2, <path>: has path data that is not read ": svg('<path d="M 0 0 L nan 10"/>').encode(),
    "line 2, <path>: has path data that is not read  ": svg('<path d="L 0 0 1 1"/>').encode(),
    "line 2, <path>: has path data that is not read   ": svg('<path d="M0 0 C 1 1 2 2"/>').encode(),
    "line 2, <path>: has coordinates beyond": svg('<path d="M 0 0 L 1e999 10"/>').encode(),
    "line 2, <path>: has an arc that ends where it starts": svg('<path d="M 0 0 A 5 5 0 0 1 0 0"/>').encode(),
    "line 2, <polyline>: has points that are not pairs": svg('<polyline points="0 0 1"/>').encode(),
    "line 2, <polyline>: has points that are not pairs ": svg('<polyline points="0 0 1 x"/>').encode(),
    "line 2, <polyline>: has coordinates beyond": svg('<polyline points="0 0 1 1e99"/>').encode(),
    "line 2, cx: is not a length (got 'inf')": svg('<circle cx="inf" r="1"/>').encode(),
    "line 2, r: is not a length (got '5%')": svg('<circle r="5%"/>').encode(),
    "line 2, <circle>: has a negative r": svg('<circle r="-5"/>').encode(),
    "line 2, <path>: has a transform that is not read": svg('<path transform="rotate(a)" d="M0 0h1"/>').encode(),
    "line 2, <path>: has a transform that is not read ": svg('<path transform="scale(1e999)" d="M0 0h1"/>').encode(),
    "line 2, <path>: is moved or shaped by its style": svg('<path style="transform: scale(2)" d="M0 0h1"/>').encode(),
    "line 2, width: is missing: it is a page within the page": svg(
        '<svg viewBox="0 0 9 9"><path d="M0 0h1"/></svg>'
    ).encode(),
    "line 2, height: is missing: it is a page within the page": svg(
        '<symbol id="s" viewBox="0 0 9 9"><path d="M0 0h1"/></symbol><use href="#s" width="5"/>'
    ).encode(),
    "line 2, <path>: has path data that is not read    ": svg('<path d="M0 0 a5 5 0 2 1 10 0"/>').encode(),
    "line 2, <path>: has a transform-origin": svg(
        '<path transform="rotate(9)" transform-origin="5 5" d="M0 0h1"/>'
    ).encode(),
    "line 2, <path>: is moved or shaped by its style ": svg(
        '<path transform="rotate(9)" style="transform-origin: 5px" d="M0 0h1"/>'
    ).encode(),
    "line 2, <rect>: is moved or shaped by its style": svg('<rect width="9" height="5" style="rx: 2"/>').encode(),
    "line 2, <style>: moves or shapes elements": svg(
        '<defs><style>.a {transform: scale(2)}</style></defs><path class="a" d="M0 0h1"/>'
    ).encode(),
    "line 1: states an encoding that is not read": b'<?xml version="1.0" encoding="big5"?><svg/>',
    "line 1: states an encoding that is not read ": b'<?xml version="1.0" encoding="klingon"?><svg/>',
    "line 1: is not XML: not well-formed  ": b'<svg xmlns="http://www.w3.org/2000/svg"><title>\xff</title></svg>',
    "line 2, <use>: refers to nothing in the file (got 'other.svg#a')": svg('<use href="other.svg#a"/>').encode(),
    "line 2, <use>: refers to itself": svg('<g id="a"><use href="#a"/></g>').encode(),
    "line 1, viewBox: is not four numbers": svg("", 'width="1mm" viewBox="0 0 a"').encode(),
    "line 1, viewBox: has no size": svg("", 'width="1mm" viewBox="0 0 0 5"').encode(),
    "line 1, viewBox: has no size ": svg("", 'width="1mm" viewBox="0 0 1e308 1e308"').encode(),
    "line 2, <path>: has a transform that is not read   ": svg('<path transform="rotate(1e308)" d="M0 0h1"/>').encode(),
    "line 2, <circle>: is enlarged beyond": svg(
        '<g transform="scale(1e9)"><circle r="1" transform="scale(1e9)"/></g>'
    ).encode(),
    "line 1, width: is not a length": svg("", 'width="1parsec" viewBox="0 0 1 1"').encode(),
    "line 2: nests more than 200 elements": svg("<g>" * 300 + "</g>" * 300).encode(),
    "unit: is stated nowhere": svg('<path d="M0 0h1"/>', 'width="100" height="100" viewBox="0 0 1 1"').encode(),
}


@pytest.mark.parametrize("message", BAD)
def test_bad_files_are_refused_by_file_and_line(read, tmp_path, message):
    with pytest.raises(sm.InvalidInputError) as caught:
        read(BAD[message])
    start = message.strip()
    assert str(caught.value).startswith(f"{tmp_path / 'drawing.svg'}: {start}")
    assert caught.value.remedy
    assert "\n" not in str(caught.value)


def test_uses_of_uses_are_bounded(read):
    levels = "".join(f'<g id="a{k}">{f"""<use href="#a{k - 1}"/>""" * 10}</g>' for k in range(1, 9))
    body = f'<defs><path id="a0" d="M0 0h1"/>{levels}</defs><use href="#a8"/>'
    before = time.process_time()
    with pytest.raises(sm.InvalidInputError, match="or too often to others"):
        read(body)
    assert time.process_time() - before < 60


def test_a_unit_that_the_file_contradicts_is_an_error(read):
    shape = '<path d="M0 0h1"/>'
    assert read(shape, unit="mm").unit == "mm by the size of its page with a viewBox"
    with pytest.raises(sm.InvalidInputError, match="unit: is inch, and the file says mm"):
        read(shape, unit="inch")
    with pytest.raises(sm.InvalidInputError, match="unit: is not known"):
        read(shape, unit="parsec")
    with pytest.raises(sm.InvalidInputError, match="arm_unit: is not known"):
        read(shape, arm_unit="px")


def test_names_may_have_spaces_and_any_letters(read):
    drawing = read('<path d="M0 0h10"/>', name="Schweißnaht 焊缝 №1.svg")
    assert drawing.file.endswith("Schweißnaht 焊缝 №1.svg")
    assert drawing.path.length == pytest.approx(10)


def test_many_points_are_read_in_bounded_time(read):
    x = np.linspace(0, 90, 200_000)
    points = " ".join(f"{a:.4f},{50 + np.sin(a):.4f}" for a in x)
    before = time.process_time()
    drawing = read(f'<path d="M {points}"/>')
    assert drawing.path(0.5).shape == (2,)
    assert len(drawing.lines()) < 20
    assert time.process_time() - before < 12


def test_too_much_is_refused(read, tmp_path, monkeypatch):
    monkeypatch.setattr("selfmotion.exchange.reading.MOST_SEGMENTS", 30)
    with pytest.raises(sm.InvalidInputError, match=r"has more than .* lines, each curve counted as 20"):
        read('<circle r="1"/><circle r="2"/>')
    monkeypatch.setattr("selfmotion.exchange.reading.LARGEST_FILE", 100)
    with pytest.raises(sm.InvalidInputError, match="is larger than 100 bytes"):
        read('<circle r="1"/>')


def test_without_the_package_the_extra_is_named(read, monkeypatch):
    monkeypatch.setitem(sys.modules, "svgpathtools", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'selfmotion\[io\]'"):
        read('<circle r="1"/>')


def test_pages_within_the_page_are_moved_and_scaled_as_svg_says(read):
    """Meet centres the shorter side, slice covers, none stretches; x and y place the page."""
    inner = '<svg x="10" y="20" width="40" height="20" viewBox="5 5 10 10" {}><path d="M5 5 L15 15"/></svg>'
    for aspect, ends in (
        ("", [[20, 80], [40, 60]]),
        ('preserveAspectRatio="xMinYMax"', [[10, 80], [30, 60]]),
        ('preserveAspectRatio="xMidYMin slice"', [[10, 80], [50, 40]]),
        ('preserveAspectRatio="none"', [[10, 80], [50, 60]]),
    ):
        np.testing.assert_allclose(read(inner.format(aspect)).path([0.0, 1.0]), ends, atol=1e-12)
    plain = '<svg x="10" y="20"><path d="M5 5 L15 15"/></svg>'
    np.testing.assert_allclose(read(plain).path([0.0, 1.0]), [[15, 75], [25, 65]], atol=1e-12)
    symbol = (
        '<symbol id="s" viewBox="0 0 10 10"><circle r="2" cx="5" cy="5"/></symbol>'
        '<use href="#s" x="40" y="30" width="20" height="20"/>'
    )
    assert off_circle(read(symbol).path, np.array([50.0, 60.0]), 4.0) <= 1e-12


def test_an_ellipse_with_one_radius_is_a_circle_and_one_without_is_not_drawn(read):
    drawing = read('<ellipse cx="50" cy="50" rx="25"/><ellipse cx="9" cy="9" rx="3" ry="0"/><circle r="0"/>')
    assert_circle(drawing)
    assert_circle(read('<ellipse cx="50" cy="50" rx="auto" ry="25"/>'))


def test_a_switch_shows_one_child_and_says_which_it_leaves_out(read):
    drawing = read(
        '<switch><foreignObject requiredExtensions="x"/><g systemLanguage="de"><path d="M0 0h5"/></g>'
        '<g><path d="M0 5h9"/></g><g><path d="M0 6h9"/></g></switch>'
    )
    assert drawing.path.length == pytest.approx(9)
    assert [str(entry) for entry in drawing.ignored] == [
        "<foreignObject> that a switch leaves out (line 2)",
        "<g> that a switch leaves out, 2 times (line 2)",
    ]


def test_the_first_of_two_elements_with_one_name_is_used(read):
    defs = '<defs><path id="a" d="M0 0h10"/><path id="a" d="M0 0h20"/></defs>'
    assert read(f'{defs}<use href="#a"/>').path.length == pytest.approx(10)


def test_what_is_cut_or_hidden_by_rules_is_said(read):
    drawing = read(
        '<defs><clipPath id="c"><path d="M0 0h1v1z"/></clipPath><style>.a {display: none}</style></defs>\n'
        '<path clip-path="url(#c)" d="M0 0h5"/>'
    )
    assert {entry.what for entry in drawing.ignored} == {
        "what cuts <path>: it is drawn whole",
        "<style>, whose rules are not read, though they hide something",
    }


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_the_encoding_is_what_the_file_states(read, encoding):
    name = encoding.removesuffix("-sig").upper()
    text = f'<?xml version="1.0" encoding="{name}"?>\n' + svg('<title>Öse</title><path d="M0 0h5"/>')
    assert read(text.encode(encoding)).path.length == pytest.approx(5)


def test_a_size_in_the_style_counts_as_one_in_attributes(read):
    page = 'style="fill:none; width:100mm;height: 100mm" viewBox="0 0 200 200"'
    assert read('<path d="M0 0h10"/>', page).path.length == pytest.approx(5)
    assert read('<path d="M0 0h10"/>', f'width="9" {page}').path.length == pytest.approx(5)


def test_a_unit_that_the_page_speaks_against_is_a_warning(read):
    page = 'width="100mm" height="100mm"'
    drawing = read('<path d="M0 0h10"/>', page, unit="mm")
    assert drawing.path.length == 10
    assert drawing.warnings[0].startswith("the page has a size in physical units but no viewBox")
    assert "warning: the page has a size" in "\n".join(drawing.lines())
    assert drawing.summary()["warnings"] == list(drawing.warnings)
    assert read('<path d="M0 0h10"/>', page, unit="px").warnings == ()
    beyond = read('<path d="M0 0h1000"/>')
    assert beyond.warnings == ("what is drawn extends over 10 times the page",)
    assert read('<path d="M0 0h150"/>').warnings == ()
