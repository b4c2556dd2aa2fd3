"""Any file with a path in it, by the end of its name."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.drawing import Drawing, Options, drawing
from selfmotion.exchange.dxf_file import read_dxf
from selfmotion.exchange.files import UNITS
from selfmotion.exchange.gcode_file import read_gcode
from selfmotion.exchange.pieces import line
from selfmotion.exchange.svg_file import read_svg
from selfmotion.exchange.waypoint_file import load_waypoints
from selfmotion.paths import PoseWaypoints
from selfmotion.paths.base import PLANE, POSE, SPACE

_GCODE = (".nc", ".ngc", ".gcode", ".gc", ".cnc", ".tap", ".g", ".eia", ".mpf")
_TABLES = (".csv", ".json", ".npy")
ENDINGS = (".svg", ".dxf", *_GCODE, *_TABLES)
"""What names may end in."""


def read_drawing(file: str | os.PathLike[str], unit: str | None = None, **options: Any) -> Drawing:
    """Read a drawing, a program or a table of waypoints, whichever the end of its name says.

    Parameters
    ----------
    file : path-like
        ``.svg``, ``.dxf``, G-code (``.nc``, ``.ngc``, ``.gcode``, ``.tap`` and the like), ``.csv``, ``.json`` or
        ``.npy``.
    unit : str, optional
        As of the reader.
    **options
        Those of the reader: see :func:`read_svg`, :func:`read_dxf`, :func:`read_gcode`; of tables `arm_unit`, `scale`
        and `tolerance`, the last of which they do not need.

    Returns
    -------
    Drawing

    Raises
    ------
    InvalidInputError
        If the name has another end, or as the reader does.
    """
    suffix = os.path.splitext(os.fspath(file))[1].lower()
    readers: dict[str, Any] = {".svg": read_svg, ".dxf": read_dxf, **dict.fromkeys(_GCODE, read_gcode)}
    readers |= dict.fromkeys(_TABLES, _read_table)
    if suffix not in readers:
        reason, remedy = "has a name whose end says no format", f"rename it to end in one of {', '.join(ENDINGS)}"
        raise InvalidInputError("", reason, remedy, source=os.fspath(file))
    return readers[suffix](file, unit, **options)


def _read_table(
    file: str | os.PathLike[str],
    unit: Any = None,
    *,
    arm_unit: str = "m",
    scale: float = 1.0,
    tolerance: float | None = None,
) -> Drawing:
    options, source = Options(arm_unit, scale, tolerance), os.fspath(file)
    table = load_waypoints(file, unit)
    points = table[:, : PLANE if table.shape[1] == PLANE else SPACE] * options.factor(1.0)
    poses = PoseWaypoints(np.hstack([points, table[:, SPACE:]])) if table.shape[1] == POSE else None
    lines = line(points)
    form = os.path.splitext(source)[1][1:].upper()
    words = f"{unit}, as asked for" if unit in UNITS else "m, or what the file says"
    notes = [] if poses is None else ["every row has an orientation"]
    return drawing(source, form, words, [] if lines is None else [[lines]], options, poses=poses, notes=notes)
