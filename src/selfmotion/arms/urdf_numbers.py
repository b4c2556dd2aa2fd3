"""Numbers and poses as URDF writes them."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np

from selfmotion._checks import angles, finite_array, number
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError

_COUNTS = {1: "one number", 3: "three numbers"}


def written_pose(field: str, element: ElementTree.Element) -> FloatArray:
    """Return what the ``<origin>`` inside an element says, ``Trans(xyz) Rz(yaw) Ry(pitch) Rx(roll)``, shape (4, 4)."""
    origin = element.find("origin")
    pose = np.eye(4)
    if origin is None:
        return pose
    pose[:3, 3] = finite_array(f"{field}.xyz", written_numbers(f"{field}.xyz", origin, "xyz", 3, "0 0 0"), 1, 3)
    turn = angles(f"{field}.rpy", written_numbers(f"{field}.rpy", origin, "rpy", 3, "0 0 0"), 3)
    (c1, c2, c3), (s1, s2, s3) = np.cos(turn), np.sin(turn)
    about_x = np.array([[1, 0, 0], [0, c1, -s1], [0, s1, c1]])
    about_y = np.array([[c2, 0, s2], [0, 1, 0], [-s2, 0, c2]])
    about_z = np.array([[c3, -s3, 0], [s3, c3, 0], [0, 0, 1]])
    pose[:3, :3] = about_z @ about_y @ about_x
    return pose


def written_numbers(field: str, element: ElementTree.Element, name: str, count: int, default: str = "") -> list[float]:
    """Return the numbers of an attribute, one or three."""
    text = element.get(name, default)
    words = text.split()
    if len(words) != count:
        raise InvalidInputError(field, f"needs {_COUNTS[count]} and has {len(words)}", "put spaces between them", text)
    return [written_number(field, word) for word in words]


def written_number(field: str, text: str) -> float:
    """Return a written number, which must be finite."""
    # Python would take 1_000, and digits of other scripts.
    if "_" in text or not text.isascii():
        raise InvalidInputError(field, "is not a number", "write it like -1.5 or 2e-3", text)
    try:
        value = float(text)
    except ValueError:
        remedy = "expand the xacro template first" if "${" in text else "write it like -1.5 or 2e-3"
        raise InvalidInputError(field, "is not a number", remedy, text) from None
    return number(field, value)
