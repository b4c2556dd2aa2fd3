"""Task-space paths x(r), r ∈ [0, 1], with derivatives; they know no arm.

A new path is one file with a :class:`Path` subclass and one line in `PATHS`: the problem file, its
schema, the tests and the docs' tables pick it up from there.
"""

from __future__ import annotations

from selfmotion.paths.base import Path
from selfmotion.paths.bezier import Bezier
from selfmotion.paths.clothoid import Clothoid
from selfmotion.paths.ellipse import Arc, Circle, Ellipse
from selfmotion.paths.line import Line
from selfmotion.paths.lissajous import Lissajous
from selfmotion.paths.placed import Frame, Placed
from selfmotion.paths.pose import PosePath, PoseWaypoints, angular_velocity, rotation_matrix
from selfmotion.paths.rose import Rose
from selfmotion.paths.transforms import ArcLength, Concatenation, Relative, Reversed, Section, Transformed
from selfmotion.paths.waypoints import Waypoints

PATHS: dict[str, type[Path]] = {
    path.kind: path
    for path in (
        Bezier,
        Clothoid,
        Line,
        Arc,
        Circle,
        Ellipse,
        Lissajous,
        Rose,
        Waypoints,
        Reversed,
        ArcLength,
        Concatenation,
        Transformed,
        Placed,
        PosePath,
        PoseWaypoints,
    )
}
"""Every path by the ``kind`` of a problem file."""

__all__ = [
    "PATHS",
    "Arc",
    "ArcLength",
    "Bezier",
    "Circle",
    "Clothoid",
    "Concatenation",
    "Ellipse",
    "Frame",
    "Line",
    "Lissajous",
    "Path",
    "Placed",
    "PosePath",
    "PoseWaypoints",
    "Relative",
    "Reversed",
    "Rose",
    "Section",
    "Transformed",
    "Waypoints",
    "angular_velocity",
    "rotation_matrix",
]
