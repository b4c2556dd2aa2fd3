"""Waypoint files: CSV with one point or pose per row, as controllers and CAM programs write them."""

from __future__ import annotations

import os
from typing import Literal

import numpy as np

from selfmotion._checks import LARGEST, choice
from selfmotion._types import FileName, FloatArray, Placement
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import read_text
from selfmotion.paths import Path, Placed, PoseWaypoints, Waypoints
from selfmotion.paths.base import POSE, SPACE
from selfmotion.rotations import TOLERANCE

UNITS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
"""Metres in one unit of a file's positions."""
_POSITION = ("x", "y", "z")
# The order inside the library; a file's columns go by their names.
_QUATERNION = ("qw", "qx", "qy", "qz")
_COUNTS = ("r", "t", "index")
_REMEDY = "start with x,y,z,qx,qy,qz,qw (or x,y,z or x,y), in any order"


def load_waypoints(file: str | os.PathLike[str], unit: Literal["m", "mm", "cm", "inch"] = "m") -> FloatArray:
    """Read a table of points or poses.

    Parameters
    ----------
    file : path-like
        UTF-8 text. The first row names the columns, in any order: ``x,y,z,qx,qy,qz,qw`` for poses, ``x,y,z`` or ``x,y``
        for points. Columns are separated by commas, semicolons or tabs. What follows a ``#`` is a comment. The first
        column may be ``r``, ``t`` or ``index``; it is not read. Any other column is an error.
    unit : {"m", "mm", "cm", "inch"}
        Of the positions.

    Returns
    -------
    array, shape (k, 2), (k, 3) or (k, 7)
        Positions [m]; of poses then the unit quaternion in the order w, x, y, z.

    Raises
    ------
    InvalidInputError
        Naming file, line and column: if a column is missing or not known, a value is no finite number, a quaternion is
        not of unit norm, or there are fewer than two rows.
    """
    scale = UNITS[choice("unit", unit, UNITS)]
    source = os.fspath(file)
    try:
        return _parsed(read_text(file), scale)
    except InvalidInputError as error:
        raise error if error.source else error.inside(source=source) from None


def _parsed(text: str, scale: float) -> FloatArray:
    if "\0" in text:
        raise InvalidInputError("", "is not a text file", "is it the right file?")
    stripped = ((k, line.split("#", 1)[0].strip(" \r\f\v")) for k, line in enumerate(text.split("\n"), 1))
    lines = [(k, line) for k, line in stripped if line.strip(" \t,;")]
    if not lines:
        raise InvalidInputError("", "is empty", _REMEDY)
    (number, header), *rows = lines
    separator = next((mark for mark in ("\t", ";", ",") if mark in header), ",")
    names = [name.strip().strip('"').lower() for name in header.split(separator)]
    wanted = _wanted(names, f"line {number}")
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
    table[:, : SPACE if len(wanted) > 2 else 2] *= scale
    if len(wanted) == POSE:
        norms = np.linalg.norm(table[:, SPACE:], axis=1)
        wrong = np.flatnonzero(np.abs(norms - 1.0) > TOLERANCE)
        if len(wrong):
            reason = f"holds no unit quaternion: its norm is {norms[wrong[0]]:.9g}"
            remedy = "divide it by its norm, with seven digits or more"
            raise InvalidInputError(f"line {rows[wrong[0]][0]}", reason, remedy, table[wrong[0], SPACE:].tolist())
        table[:, SPACE:] /= norms[:, None]
    return table


def _wanted(names: list[str], where: str) -> list[str]:
    """Return the columns to read, in the library's order, checked against the header."""
    if not any(name in names for name in _POSITION):
        raise InvalidInputError(where, "names no columns x, y, z", _REMEDY, names)
    repeated = [name for name in names if names.count(name) > 1]
    if repeated:
        raise InvalidInputError(where, f"names the column {repeated[0]} twice", "drop one of them", names)
    counted = names[1:] if names[0] in _COUNTS else names
    unknown = [name for name in counted if name not in (*_POSITION, *_QUATERNION)]
    if unknown:
        listed = ", ".join(repr(name) for name in unknown)
        remedy = f"drop them: {_REMEDY}; before them one of {', '.join(_COUNTS)}"
        raise InvalidInputError(where, f"names columns that are not known: {listed}", remedy, names)
    turned = any(name in names for name in _QUATERNION)
    wanted = [*_POSITION, *_QUATERNION] if turned else [*_POSITION] if "z" in names else ["x", "y"]
    missing = [name for name in wanted if name not in names]
    if missing:
        raise InvalidInputError(where, f"lacks the columns {', '.join(missing)}", _REMEDY, names)
    return wanted


def _number(text: str, line: int, column: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value) or abs(value) > LARGEST:
        reason = "is not a finite number" if text.strip() else "is empty"
        raise InvalidInputError(f"line {line}, column {column}", reason, "correct it", text.strip())
    return value


class FilePath(Path):
    """The points or poses of a CSV file, joined.

    Parameters
    ----------
    file : str
        See :func:`load_waypoints`.
    interpolation : {"linear", "spline"}
        As of ``waypoints`` and ``pose_waypoints``.
    unit : {"m", "mm", "cm", "inch"}
        Of the file's positions; the path is in metres.
    parameter : {"uniform", "length"}
        How poses share r; points share it by their distances.
    frame, tool : mapping, optional
        As of ``placed``.

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
        unit: Literal["m", "mm", "cm", "inch"] = "m",
        parameter: Literal["uniform", "length"] = "uniform",
        frame: Placement = None,
        tool: Placement = None,
    ) -> None:
        self.file = os.fspath(file)
        for name, value, options in (
            ("unit", unit, UNITS),
            ("parameter", parameter, ("uniform", "length")),
            ("interpolation", interpolation, ("linear", "spline")),
        ):
            choice(name, value, options)
        path: Path
        try:
            table = load_waypoints(file, unit)
            if table.shape[1] == POSE:
                path = PoseWaypoints(table, interpolation, parameter)
            else:
                path = Waypoints(table, interpolation)
        except InvalidInputError as error:
            # The source of what is wrong further out is the problem file.
            where = ", ".join(part for part in (self.file, error.field) if part)
            raise InvalidInputError("file", f"{where}: {error.reason}", error.remedy, error.value) from None
        self.path = path if frame is None and tool is None else Placed(path, frame, tool)
        self.dimension, self.highest_order = self.path.dimension, self.path.highest_order

    def __repr__(self) -> str:
        return f"FilePath({self.file!r}, {self.path!r})"

    @property
    def breaks(self) -> FloatArray:
        """The inner rows."""
        return self.path.breaks

    @property
    def waypoints(self) -> FloatArray:
        """Path parameters of all rows."""
        return self.path.waypoints

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        return self.path(r, order)

    def _fastest(self, low: float, high: float) -> float:
        return self.path.fastest(low, high)

    def _bending(self, low: float, high: float) -> float:
        return self.path.bending(low, high)

    def _turning(self, low: float, high: float) -> float:
        return self.path.turning(low, high)
