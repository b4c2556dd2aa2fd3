"""Draw the three files that example 12 reads: the letter R, the outline of a bracket, a program that mills a pocket.

Run it to write them beside itself. They are written by hand, number by number, so that they say no more than they need.
"""

from pathlib import Path

LETTER = """\
<svg xmlns="http://www.w3.org/2000/svg" width="120mm" height="120mm" viewBox="0 0 120 120">
  <title>The letter R: two strokes, one of which runs round a bowl</title>
  <g fill="none" stroke="black" transform="translate(20 10)">
    <path d="M 10 90 V 10 H 40 A 20 20 0 0 1 40 50 H 10"/>
    <path d="M 40 50 C 55 55 58 75 70 90"/>
  </g>
</svg>
"""
POCKET = """\
%
(a pocket, 80 mm by 50 mm, corners of 10 mm, in two rings)
N10 G17 G21 G90
N20 M3 S12000
N30 G0 Z5
N40 G0 X10 Y0
N50 G1 Z-2 F200
N60 G1 X70 F600
N70 G3 X80 Y10 I0 J10
N80 G1 Y40
N90 G3 X70 Y50 R10
N100 G1 X10
N110 G3 X0 Y40 I0 J-10
N120 G1 Y10
N130 G3 X10 Y0 R10
N140 G1 X15 Y15 (step over)
N150 G1 X65
N160 G1 Y35
N170 G1 X15
N180 G1 Y15
N190 G0 Z5
N200 M5
N210 M30
%
"""


def bracket() -> str:
    """Return an angle bracket as DXF, in millimetres: an outline in pieces, as drawn in no order, and two holes."""
    entities = [
        _line((0, 0), (90, 0)),
        _line((0, 100), (0, 0)),  # drawn towards the first line
        _arc((90, 10), 10, -90, 0),
        _line((20, 100), (0, 100)),
        _line((100, 10), (100, 20)),
        _polyline([(100, 20, 0), (40, 20, -0.41421356237309503), (20, 40, 0), (20, 100, 0)]),
        _circle((10, 85), 4),
        _circle((80, 10), 4),
    ]
    header = _codes(0, "SECTION", 2, "HEADER", 9, "$ACADVER", 1, "AC1009", 9, "$INSUNITS", 70, 4, 0, "ENDSEC")
    body = _codes(0, "SECTION", 2, "ENTITIES") + "".join(entities) + _codes(0, "ENDSEC", 0, "EOF")
    return header + body


def _codes(*pairs: object) -> str:
    return "".join(f"{code}\n{value}\n" for code, value in zip(pairs[::2], pairs[1::2], strict=True))


def _line(start: tuple[float, float], end: tuple[float, float]) -> str:
    return _codes(0, "LINE", 8, "0", 10, start[0], 20, start[1], 11, end[0], 21, end[1])


def _arc(center: tuple[float, float], radius: float, start: float, end: float) -> str:
    return _codes(0, "ARC", 8, "0", 10, center[0], 20, center[1], 40, radius, 50, start, 51, end)


def _circle(center: tuple[float, float], radius: float) -> str:
    return _codes(0, "CIRCLE", 8, "0", 10, center[0], 20, center[1], 40, radius)


def _polyline(rows: list[tuple[float, float, float]]) -> str:
    vertices = [_codes(0, "VERTEX", 8, "0", 10, x, 20, y, 42, bulge) for x, y, bulge in rows]
    return _codes(0, "POLYLINE", 8, "0", 66, 1, 70, 0) + "".join(vertices) + _codes(0, "SEQEND", 8, "0")


FILES = {"letter.svg": LETTER, "bracket.dxf": bracket(), "pocket.nc": POCKET}

if __name__ == "__main__":
    for name, text in FILES.items():
        Path(__file__).with_name(name).write_text(text, encoding="utf-8")
