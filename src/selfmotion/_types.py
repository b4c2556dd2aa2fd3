"""Array types shared by every signature.

The ``Annotated`` aliases are read twice: by people, and by :mod:`selfmotion.exchange.schema`, which
derives the problem file's schema from the constructors' signatures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
IntArray = NDArray[np.intp]

Vector = Annotated[ArrayLike, "vector"]
"""Numbers, shape (k,)."""
Point = Annotated[ArrayLike, "point"]
"""One point of the plane, shape (2,)."""
Points = Annotated[ArrayLike, "points"]
"""Points of the plane, shape (k, 2)."""
Position = Annotated[ArrayLike, "position"]
"""One point of the plane or of space, shape (2,) or (3,)."""
SpacePoint = Annotated[ArrayLike, "space_point"]
"""Three numbers: a point of space, a direction, the sizes of a box; shape (3,)."""
Positions = Annotated[ArrayLike, "positions"]
"""Points of the plane or of space, shape (k, 2) or (k, 3)."""
Direction = Annotated[ArrayLike, "direction"]
"""A vector of space, not zero, shape (3,)."""
Rotation = Annotated[ArrayLike, "rotation"]
"""A unit quaternion (w, x, y, z), shape (4,), or a rotation matrix, shape (3, 3)."""
Rotations = Annotated[ArrayLike, "rotations"]
"""Unit quaternions (w, x, y, z), shape (k, 4)."""
Poses = Annotated[ArrayLike, "poses"]
"""Poses (x, y, z, quaternion w, x, y, z), shape (k, 7)."""
Placement = Annotated[Any, "frame"]
"""A rigid motion: ``translation`` and one of ``quaternion``, ``matrix``, ``rpy``, ``normal`` with ``x_axis``."""
ToolFrame = Annotated[Any, "tool"]
"""The tool's frame in that of the arm's tip: ``translation`` and one of ``quaternion``, ``matrix``, ``rpy``."""
Rail = Annotated[Any, "rail"]
"""What an arm's base slides on: its ``axis`` in the base's frame, and ``limits`` in metres."""
FollowRule = Annotated[Any, "follow"]
"""How a tool follows a tangent: ``axis`` and ``up``."""
FileName = Annotated[str, "file"]
"""Name of a file; in a problem file, relative to that."""
Limits = Annotated[Sequence[Any] | None, "limits"]
"""Per joint ``None`` or ``(lower, upper)`` in radians; either end may be ``None``."""
ArmPlace = Annotated[Any, "placement"]
"""Where a planar arm stands: ``base``, its plane, ``unit``, ``frame`` and ``joints``."""
Box = Annotated[ArrayLike, "box"]
"""``(lower, upper)`` for every variable, or one such pair per variable."""
