"""Triangles from STL and OBJ files."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from selfmotion._checks import LARGEST, is_file_name
from selfmotion._types import FloatArray, IntArray
from selfmotion.errors import InvalidInputError

LARGEST_FILE = 200_000_000
"""Size [bytes] from which a mesh is refused."""
_HEADER, _RECORD = 84, np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
_VERTEX = re.compile(rb"^\s*vertex\s+(\S+)\s+(\S+)\s+(\S+)\s*$", re.MULTILINE)
_RIGHT = "is it the right file?"


def load_triangles(file: str) -> tuple[FloatArray, IntArray]:
    """Read a mesh.

    Parameters
    ----------
    file : str
        By the end of its name ``.stl``, binary or text, or ``.obj``, of which faces and their points are read.

    Returns
    -------
    vertices : array, shape (k, 3)
    triangles : array of int, shape (m, 3)
        Which vertices; counter-clockwise seen from outside. Faces of more corners are cut into triangles.

    Raises
    ------
    InvalidInputError
        If the file cannot be read, or is no such mesh; the field is empty.
    """
    suffix = Path(file).suffix.lower()
    if suffix not in (".stl", ".obj"):
        raise InvalidInputError("", "is neither .stl nor .obj", "convert the mesh to one of these", file)
    data = _bytes(file)
    vertices, triangles = _from_stl(data) if suffix == ".stl" else _from_obj(data)
    if not len(triangles):
        raise InvalidInputError("", "has no triangles", _RIGHT)
    if not (np.abs(vertices) <= LARGEST).all():
        raise InvalidInputError("", "has a vertex that is not finite", "mend the file")
    return vertices, triangles


def _bytes(file: str) -> bytes:
    if not is_file_name(file):
        raise InvalidInputError("", "is no name of a file", "name one")
    try:
        with Path(file).open("rb") as stream:
            data = stream.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise InvalidInputError("", "does not exist", "check the name") from None
    except IsADirectoryError:
        raise InvalidInputError("", "is a folder", "name a file") from None
    except OSError as error:
        raise InvalidInputError("", f"cannot be read ({error.strerror or error})", "check the file") from None
    if len(data) > LARGEST_FILE:
        raise InvalidInputError("", f"is larger than {LARGEST_FILE // 10**6} MB", "simplify the mesh")
    return data


def _from_stl(data: bytes) -> tuple[FloatArray, IntArray]:
    """Return the corners of all facets, each on its own; binary files say how many there are."""
    count = int.from_bytes(data[_HEADER - 4 : _HEADER], "little")
    if len(data) >= _HEADER and len(data) == _HEADER + _RECORD.itemsize * count:
        corners = np.frombuffer(data, _RECORD, count, _HEADER)["corners"].reshape(-1, 3).astype(float)
    elif data.lstrip()[:5].lower() == b"solid":
        found = _VERTEX.findall(data)
        try:
            corners = np.array(found, dtype=bytes).astype(float).reshape(-1, 3)
        except ValueError:
            raise InvalidInputError("", "has a vertex that is not made of numbers", "mend the file") from None
        if len(corners) % 3 or len(found) != len(re.findall(rb"\bvertex\b", data)):
            raise InvalidInputError("", "has a facet without three vertices of three numbers", "mend the file")
    else:
        reason = "is no STL: its size is not what the number of its triangles asks for, and it is no text"
        raise InvalidInputError("", reason, _RIGHT)
    return corners, np.arange(len(corners)).reshape(-1, 3)


def _from_obj(data: bytes) -> tuple[FloatArray, IntArray]:
    vertices: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for row, line in enumerate(data.split(b"\n"), 1):
        key, *words = line.split(b"#", 1)[0].split() or [b""]
        try:
            if key == b"v":
                vertices.append([float(word) for word in words[:3]])
                if len(words) < 3:
                    raise ValueError
            elif key == b"f":
                face = [_index(word, len(vertices)) for word in words]
                if len(face) < 3:
                    raise ValueError
                triangles += [(face[0], face[k], face[k + 1]) for k in range(1, len(face) - 1)]
        except ValueError:
            what = "vertex without three numbers" if key == b"v" else "face without three of the vertices before it"
            raise InvalidInputError("", f"line {row}: has a {what}", "mend the file") from None
    return np.array(vertices).reshape(-1, 3), np.array(triangles, dtype=np.intp).reshape(-1, 3)


def _index(word: bytes, count: int) -> int:
    """Return which vertex a corner of a face names: counted from 1, or from the last one backwards."""
    number = int(word.split(b"/", 1)[0])
    index = number - 1 if number > 0 else count + number
    if number == 0 or not 0 <= index < count:
        raise ValueError
    return index
