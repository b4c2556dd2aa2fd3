"""Any file with a path in it, by the end of its name."""

from __future__ import annotations

import os
from typing import Any, Literal, Unpack

import numpy as np

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.drawing import Drawing, drawing
from selfmotion.exchange.dxf_file import read_dxf
from selfmotion.exchange.gcode_file import read_gcode
from selfmotion.exchange.pieces import Piece, line
from selfmotion.exchange.reading import Options, Reading, spelled_out
from selfmotion.exchange.svg_file import read_svg
from selfmotion.exchange.waypoint_file import read_table
from selfmotion.paths import PoseWaypoints
from selfmotion.paths.base import PLANE, POSE, SPACE
from selfmotion.units import UNITS

_GCODE = (".nc", ".ngc", ".gcode", ".gc", ".cnc", ".tap", ".g", ".eia", ".mpf")
_TABLES = (".csv", ".json", ".npy")
ENDINGS = (".svg", ".dxf", *_GCODE, *_TABLES)
"""What names may end in."""


@spelled_out
def read_drawing(
    file: str | os.PathLike[str],
    unit: Any = None,
    *,
    dimension: Literal[2, 3] | None = None,
    **options: Unpack[Reading],
) -> Drawing:
    """Read a drawing, a program or a table of waypoints, whichever the end of its name says.

    Parameters
    ----------
    file : path-like
        ``.svg``, ``.dxf``, G-code (``.nc``, ``.ngc``, ``.gcode``, ``.tap`` and the like), ``.csv``, ``.json`` or
        ``.npy``.
    unit : str, optional
        As of the reader: :func:`read_svg`, :func:`read_dxf`, :func:`read_gcode`, :func:`load_waypoints`.
    dimension : {2, 3}, optional
        Of G-code: 2 drops Z.
    **options
        `arm_unit`, `scale`, `tolerance`, `gaps`, `lift` and `subpath`: see :class:`~.reading.Options`.
        A table is one run without gaps; `lift` puts points of the plane into space.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        If the name has another end, or as the reader does.
    """
    suffix = os.path.splitext(os.fspath(file))[1].lower()
    if suffix in _GCODE:
        return read_gcode(file, unit, dimension=dimension, **options)
    readers: dict[str, Any] = {".svg": read_svg, ".dxf": read_dxf, **dict.fromkeys(_TABLES, _read_table)}
    if suffix not in readers:
        reason, remedy = "has a name whose end says no format", f"rename it to end in one of {', '.join(ENDINGS)}"
        raise InvalidInputError("", reason, remedy, source=os.fspath(file))
    if dimension is not None:
        raise InvalidInputError("dimension", "is for G-code", "leave it out", dimension, os.fspath(file))
    found: Drawing = readers[suffix](file, unit, **options)
    return found


def _read_table(file: str | os.PathLike[str], unit: Any = None, **options: Unpack[Reading]) -> Drawing:
    chosen, source = Options(**options), os.fspath(file)
    rows, named, words = read_table(file, unit)
    points = rows[:, : PLANE if rows.shape[1] == PLANE else SPACE] * chosen.factor(1.0)
    poses = PoseWaypoints(np.hstack([points, rows[:, SPACE:]])) if rows.shape[1] == POSE else None
    if points.shape[1] == SPACE and chosen.lift is not None:
        raise InvalidInputError("lift", "is for a path of the plane", "leave it out", chosen.lift, source)
    # Poses may turn in one place.
    lines = line(points) if poses is None else Piece("line", points)
    form = os.path.splitext(source)[1][1:].upper()
    notes = [] if poses is None else ["every row has an orientation"]
    strokes = [] if lines is None else [[lines]]
    return drawing(source, form, words, UNITS[named], strokes, chosen, close=False, poses=poses, notes=notes)
