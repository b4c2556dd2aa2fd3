"""Waypoint files: one point or pose per row, as CSV from controllers and CAM programs, as JSON or as a NumPy array."""

from __future__ import annotations

import os
import re
from typing import Literal, NamedTuple

import numpy as np

from selfmotion._checks import LARGEST, choice
from selfmotion._types import FileName, FloatArray, Placement
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.file_path import PathFromFile, about_file
from selfmotion.exchange.files import read_bytes, read_text
from selfmotion.exchange.reading import Options, about, settled_unit
from selfmotion.exchange.waypoint_table import (
    array_table,
    in_metres,
    json_table,
    wanted_columns,
)
from selfmotion.paths import Path, Placed, PoseWaypoints, Waypoints
from selfmotion.paths.base import POSE, SPACE
from selfmotion.units import UNITS

_LINE_END = re.compile(r"\r\n?|\n")
_COUNTS = ("r", "t", "index")
_REMEDY = "start with x,y,z,qx,qy,qz,qw (or x,y,z or x,y), in any order"


def load_waypoints(file: str | os.PathLike[str], unit: Literal["m", "mm", "cm", "inch"] | None = None) -> FloatArray:
    """Read a table of points or poses.

    Parameters
    ----------
    file : path-like
        By the end of its name:

        - ``.json``: ``[[x, y], …]`` or ``[[x, y, z], …]``; ``[{"x": …, "y": …}, …]``; or ``{"points": [[…], …]}`` with
          ``"columns"``, their names, and ``"unit"`` if wanted.
        - ``.npy``: an array of shape (k, 2) or (k, 3), or one with named fields.
        - anything else is CSV in UTF-8. The first row names the columns, separated by commas, semicolons or tabs. What
          follows a ``#`` is a comment. The first column may be ``r``, ``t`` or ``index``; it is not read.

        Columns and fields, in any order, are ``x,y,z,qx,qy,qz,qw`` for poses, ``x,y,z`` or ``x,y`` for points. Any
        other is an error.
    unit : {"m", "mm", "cm", "inch"}, optional
        Of the positions; by default what the file says, else m.

    Returns
    -------
    array, shape (k, 2), (k, 3) or (k, 7)
        Positions [m]; of poses then the unit quaternion in the order w, x, y, z.

    Raises
    ------
    InvalidInputError
        Naming file, line and column: if a column is missing or not known, a value is no finite number, a quaternion is
        not of unit norm, the file states another unit, or there are fewer than two rows.
    """
    return read_table(file, unit).rows


class Table(NamedTuple):
    """What a file of waypoints holds.

    Attributes
    ----------
    rows : array, shape (k, 2), (k, 3) or (k, 7)
        As :func:`load_waypoints` returns them.
    unit : str
        Of the file's positions.
    words : str
        The same, and who says it.
    """

    rows: FloatArray
    unit: str
    words: str


def read_table(file: str | os.PathLike[str], unit: str | None = None) -> Table:
    """Read a table of points or poses as :func:`load_waypoints`, and say which unit it is in."""
    if unit is not None:
        choice("unit", unit, UNITS)
    suffix = os.path.splitext(os.fspath(file))[1].lower()
    with about(file):
        stated = None
        if suffix == ".json":
            table, stated = json_table(read_text(file))
            if stated is not None:
                choice("unit", stated, UNITS)
        named, words = ("m", "m, as nothing else is said")
        if stated is not None or unit is not None:
            named, words = settled_unit(unit, stated, "its unit")
        if suffix == ".npy":
            return Table(in_metres(array_table(read_bytes(file)), UNITS[named], "row {}".format), named, words)
        if suffix == ".json":
            return Table(in_metres(table, UNITS[named], "row {}".format), named, words)
        return Table(_parsed(read_text(file), UNITS[named]), named, words)


def _parsed(text: str, scale: float) -> FloatArray:
    if "\0" in text:
        raise InvalidInputError("", "is not a text file", "is it the right file?")
    stripped = ((k, line.split("#", 1)[0].strip(" \f\v")) for k, line in enumerate(_LINE_END.split(text), 1))
    lines = [(k, line) for k, line in stripped if line.strip(" \t,;")]
    if not lines:
        raise InvalidInputError("", "is empty", _REMEDY)
    (number, header), *rows = lines
    separator = next((mark for mark in ("\t", ";", ",") if mark in header), ",")
    names = [name.strip().strip('"').lower() for name in header.split(separator)]
    counted = names[:1] if names[0] in _COUNTS else []
    before = f"{_REMEDY}; before them one of {', '.join(_COUNTS)}"
    wanted = wanted_columns(names, f"line {number}", _REMEDY, counted, f"drop them: {before}")
    if len(rows) < 2:
        raise InvalidInputError("", f"has {len(rows)} rows below its header", "give at least two")
    columns = [names.index(name) for name in wanted]
    table = np.empty((len(rows), len(wanted)))
    for at, (number, line) in enumerate(rows):
        cells = line.split(separator)
        if len(cells) != len(names):
            reason = f"has {len(cells)} columns, and the header has {len(names)}"
            raise InvalidInputError(f"line {number}", reason, "give one number per column", line)
        table[at] = [_number(cells[c], number, name) for c, name in zip(columns, wanted, strict=True)]
    return in_metres(table, scale, lambda row: f"line {rows[row][0]}")


def _number(text: str, line: int, column: str) -> float:
    try:
        # What Python takes for a number beyond what tables hold: 1_000, and digits of other scripts.
        value = float(text) if text.isascii() and "_" not in text else np.nan
    except ValueError:
        value = np.nan
        if len(text) > 2 and text.strip()[:1] == text.strip()[-1:] == '"':
            return _number(text.strip()[1:-1], line, column)
    if not np.isfinite(value) or abs(value) > LARGEST:
        reason = "is not a finite number" if text.strip() else "is empty"
        remedy = "write decimals with a point, 0.5, and nothing between thousands" if "," in text else "correct it"
        raise InvalidInputError(f"line {line}, column {column}", reason, remedy, text.strip())
    return value


class FilePath(PathFromFile):
    """The points or poses of a CSV, JSON or NumPy file, joined.

    Parameters
    ----------
    file : str
        See :func:`load_waypoints`.
    interpolation : {"linear", "spline"}
        As of ``waypoints`` and ``pose_waypoints``.
    unit : {"m", "mm", "cm", "inch"}, optional
        Of the file's positions; by default what the file says, else m.
    parameter : {"uniform", "length"}
        How poses share r; points share it by their distances.
    frame, tool : mapping, optional
        As of ``placed``.
    arm_unit : {"m", "mm", "cm", "inch"}
        Of the arm's lengths, and so of the path.
    scale : float
        A further factor.

    Raises
    ------
    InvalidInputError
        Naming file and line.
    """

    kind = "file"

    def __init__(
        self,
        file: FileName,
        interpolation: Literal["linear", "spline"] = "linear",
        unit: Literal["m", "mm", "cm", "inch"] | None = None,
        parameter: Literal["uniform", "length"] = "uniform",
        frame: Placement = None,
        tool: Placement = None,
        arm_unit: Literal["m", "mm", "cm", "inch"] = "m",
        scale: float = 1.0,
    ) -> None:
        factor = Options(arm_unit, scale).factor(1.0)
        choice("unit", unit or "m", UNITS)
        choice("parameter", parameter, ("uniform", "length"))
        choice("interpolation", interpolation, ("linear", "spline"))
        name = os.fspath(file)

        def joined() -> Path:
            table = load_waypoints(file, unit)
            table[:, : SPACE if table.shape[1] == POSE else None] *= factor
            if table.shape[1] == POSE:
                return PoseWaypoints(table, interpolation, parameter)
            return Waypoints(table, interpolation)

        path = about_file(name, joined)
        super().__init__(name, path if frame is None and tool is None else Placed(path, frame, tool))
