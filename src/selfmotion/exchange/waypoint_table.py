"""Tables of points or poses from JSON and NumPy files, and what is checked of every table."""

from __future__ import annotations

import io
import json
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

import numpy as np

from selfmotion._checks import LARGEST
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError, shorten
from selfmotion.paths.base import PLANE, POSE, SPACE
from selfmotion.rotations import TOLERANCE

POSITION = ("x", "y", "z")
# The order inside the library; a file's columns go by their names.
QUATERNION = ("qw", "qx", "qy", "qz")
_POINTS_REMEDY = "write [[x, y], …], [[x, y, z], …], or {columns: [x, y, z, qx, qy, qz, qw], points: [[…], …]}"


def wanted_columns(
    names: Sequence[str], where: str, remedy: str, skipped: Sequence[str] = (), unknown_remedy: str = ""
) -> list[str]:
    """Return the columns to read, in the library's order, checked against those that there are.

    Parameters
    ----------
    names : sequence of str
    where, remedy : str
        For messages.
    skipped : sequence of str
        Columns that may be there and are not read.
    unknown_remedy : str
        What to do about other columns, if it is not `remedy`.
    """
    if not any(name in names for name in POSITION):
        raise InvalidInputError(where, "names no columns x, y, z", remedy, names)
    repeated = [name for name in names if names.count(name) > 1]
    if repeated:
        raise InvalidInputError(where, f"names the column {repeated[0]} twice", "drop one of them", names)
    unknown = [name for name in names if name not in (*POSITION, *QUATERNION, *skipped)]
    if unknown:
        listed = ", ".join(repr(name) for name in unknown)
        raise InvalidInputError(where, f"names columns that are not known: {listed}", unknown_remedy or remedy, names)
    turned = any(name in names for name in QUATERNION)
    wanted = [*POSITION, *QUATERNION] if turned else [*POSITION] if "z" in names else ["x", "y"]
    missing = [name for name in wanted if name not in names]
    if missing:
        raise InvalidInputError(where, f"lacks the columns {', '.join(missing)}", remedy, names)
    return wanted


def in_metres(table: FloatArray, scale: float, where: Callable[[int], str]) -> FloatArray:
    """Return a table with its positions multiplied by `scale` and its quaternions of unit norm.

    Parameters
    ----------
    table : array, shape (k, 2), (k, 3) or (k, 7)
    scale : float
    where : callable
        Row to the field to name for it.
    """
    if len(table) < 2:
        raise InvalidInputError("", f"has {len(table)} rows", "give at least two")
    wrong = np.flatnonzero(~(np.abs(table) <= LARGEST).all(axis=1))
    if len(wrong):
        raise InvalidInputError(where(int(wrong[0])), "holds no finite numbers", "correct it", table[wrong[0]].tolist())
    table[:, : SPACE if table.shape[1] > PLANE else PLANE] *= scale
    if table.shape[1] == POSE:
        norms = np.linalg.norm(table[:, SPACE:], axis=1)
        wrong = np.flatnonzero(np.abs(norms - 1.0) > TOLERANCE)
        if len(wrong):
            reason = f"holds no unit quaternion: its norm is {norms[wrong[0]]:.9g}"
            remedy = "divide it by its norm, with seven digits or more"
            raise InvalidInputError(where(int(wrong[0])), reason, remedy, table[wrong[0], SPACE:].tolist())
        table[:, SPACE:] /= norms[:, None]
    return table


def json_table(text: str) -> tuple[FloatArray, str | None]:
    """Return the table in JSON text, and the unit that it states.

    Raises
    ------
    InvalidInputError
        Naming line or row.
    """
    try:
        data = json.loads(text, parse_constant=_no_number, object_pairs_hook=_unique)
    except json.JSONDecodeError as error:
        where = f"line {error.lineno}, column {error.colno}"
        raise InvalidInputError(where, f"is not JSON ({error.msg.lower()})", "is it a whole file?") from None
    except InvalidInputError:
        raise
    except (RecursionError, ValueError) as error:
        reason = "is nested too deeply" if isinstance(error, RecursionError) else "holds a number of too many digits"
        raise InvalidInputError("", reason, _POINTS_REMEDY) from None
    unit, names = None, None
    if isinstance(data, dict):
        unknown = [key for key in data if key not in ("unit", "columns", "points")]
        if unknown or "points" not in data:
            reason = f"has the unknown field {shorten(unknown[0])}" if unknown else "has no points"
            raise InvalidInputError("", reason, _POINTS_REMEDY)
        unit, names, data = data.get("unit"), data.get("columns"), data["points"]
        if names is not None and not (isinstance(names, list) and all(isinstance(name, str) for name in names)):
            raise InvalidInputError("columns", "is not a list of names", _POINTS_REMEDY, names)
    if not isinstance(data, list) or not data:
        raise InvalidInputError("", "holds no list of points", _POINTS_REMEDY)
    if names is None and isinstance(data[0], dict):
        names = list(data[0])
        for k, row in enumerate(data):
            if not isinstance(row, dict) or set(row) != set(names):
                raise InvalidInputError(f"row {k}", "has other names than row 0", "give every row the same", row)
        data = [[row[name] for name in names] for row in data]
    if names is None:
        first = data[0]
        count = len(first) if isinstance(first, list) else 0
        if count not in (PLANE, SPACE):
            reason = "does not say which number is which" if count == POSE else "is neither [x, y] nor [x, y, z]"
            raise InvalidInputError("row 0", reason, _POINTS_REMEDY, first)
        names = list(POSITION[:count])
    return _named(_numbers(data, len(names)), names, "columns", _POINTS_REMEDY), unit


def _numbers(rows: list[Any], count: int) -> FloatArray:
    table = np.empty((len(rows), count))
    for k, row in enumerate(rows):
        if not isinstance(row, list) or len(row) != count:
            raise InvalidInputError(f"row {k}", f"does not have {count} numbers", "give every row as many", row)
        for value in row:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise InvalidInputError(f"row {k}", "holds what is no number", "give finite numbers", value)
        try:
            table[k] = row
        except OverflowError:
            raise InvalidInputError(f"row {k}", "holds no finite numbers", "correct it", row) from None
    return table


def _named(table: FloatArray, names: Sequence[str], where: str, remedy: str) -> FloatArray:
    """Return the wanted columns of a table, none left over."""
    wanted = wanted_columns(names, where, remedy)
    return table[:, [names.index(name) for name in wanted]]


def _unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object of JSON, refused if it names something twice."""
    found = dict(pairs)
    if len(found) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidInputError("", f"names {shorten(twice)} twice", "leave one of them")
    return found


def _no_number(text: str) -> NoReturn:
    raise InvalidInputError("", f"holds {text}, which is no number", "give finite numbers")


def array_table(data: bytes) -> FloatArray:
    """Return the table in the bytes of a NumPy file.

    Raises
    ------
    InvalidInputError
        If it is none, is cut short, holds objects, or does not say which column is which.
    """
    remedy = "save an array of shape (k, 2) or (k, 3), or one with the fields x, y, z, qx, qy, qz, qw"
    if not data.startswith(b"\x93NUMPY"):
        raise InvalidInputError("", "is not a NumPy file (.npy)", remedy)
    shape, kind = _header(data)
    if kind.hasobject:
        raise InvalidInputError("", "holds Python objects, which are not read", remedy)
    names = kind.names
    kinds = [kind[name].base for name in names] if names else [kind]
    if any(one.kind not in "iuf" for one in kinds) or any(kind[name].shape for name in names or ()):
        raise InvalidInputError("", f"holds {kind}, not numbers", remedy)
    if not names and not (len(shape) == 2 and shape[1] in (PLANE, SPACE)):
        wrong = "does not say which number is which" if shape[-1:] == (POSE,) else "is no table of points"
        raise InvalidInputError("", f"{wrong}: its shape is {shape}", remedy)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = np.load(io.BytesIO(data), allow_pickle=False)
    except (ValueError, OSError, EOFError, MemoryError) as error:
        raise InvalidInputError("", f"cannot be read ({shorten(str(error))})", "is it a whole file?") from None
    if not names:
        return np.array(found, dtype=float)
    table = np.stack([np.asarray(found[name], dtype=float).ravel() for name in names], axis=1)
    return _named(table, [name.lower() for name in names], "fields", remedy)


def _header(data: bytes) -> tuple[tuple[int, ...], np.dtype[Any]]:
    """Return shape and type of a NumPy file, checked against how many bytes there are."""
    stream = io.BytesIO(data)
    try:
        version = np.lib.format.read_magic(stream)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of headers that old versions wrote
            shape, _, kind = read(stream)
    except Exception as error:  # whatever a broken header makes of its parser
        raise InvalidInputError("", f"has a header that is not read ({shorten(str(error))})", "save it again") from None
    if kind.names and len(shape) != 1:
        raise InvalidInputError("", f"is no table of points: its shape is {shape}", "save fields of shape (k,)")
    size = int(np.prod([float(extent) for extent in shape])) * kind.itemsize
    if not kind.hasobject and len(data) - stream.tell() < size:
        reason = f"holds {len(data) - stream.tell()} bytes of numbers, and its header says {size}"
        raise InvalidInputError("", reason, "is it a whole file?")
    return shape, kind
