"""Paths moved rigidly in space: from a workpiece's frame to the base, and from the tool that was meant to another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np

from selfmotion._checks import finite_array, read_only
from selfmotion._types import FloatArray, Placement
from selfmotion.errors import InvalidInputError
from selfmotion.paths.base import PLANE, POSE, SPACE, Path
from selfmotion.rotations import conjugate, from_matrix, from_rotation_matrix, from_rpy, product, pure, unit_quaternions

_ORIENTATIONS = ("quaternion", "matrix", "rpy", "normal")
_FIELDS = ("translation", *_ORIENTATIONS, "x_axis")


@dataclass(frozen=True)
class Frame:
    """A rigid motion of space: ``x ↦ R x + translation``; or the frame that it moves the base's onto.

    Attributes
    ----------
    translation : array, shape (3,)
    quaternion : array, shape (4,)
        Of R, in the order w, x, y, z.
    """

    translation: FloatArray
    quaternion: FloatArray

    @classmethod
    def of(cls, field: str, value: Any) -> Frame:
        """Return the frame that a mapping describes, the one that stands still if it is None.

        Parameters
        ----------
        field : str
            For messages.
        value : Frame, mapping or None
            ``translation`` (default 0) and at most one of ``quaternion`` (w, x, y, z), ``matrix`` (3, 3), ``rpy``
            (roll, pitch, yaw about the fixed x, then y, then z axis [rad]) and ``normal`` (the z-axis; with ``x_axis``,
            of which the part across the normal is meant).

        Raises
        ------
        InvalidInputError
            Naming the field inside.
        """
        if isinstance(value, Frame):
            return value
        given = {} if value is None else value
        remedy = f"write {{translation: […], rpy: […]}}; the fields are {', '.join(_FIELDS)}"
        if not isinstance(given, Mapping):
            raise InvalidInputError(field, "is not a mapping", remedy, value)
        given = {key: entry for key, entry in given.items() if entry is not None}
        for key in given:
            if key not in _FIELDS:
                near = get_close_matches(str(key), _FIELDS, 1)
                hint = f"did you mean {near[0]!r}? " if near else ""
                raise InvalidInputError(f"{field}.{key}", "is not a known field", hint + remedy)
        ways = [way for way in _ORIENTATIONS if way in given]
        if len(ways) > 1:
            raise InvalidInputError(field, f"says its rotation by {' and '.join(ways)}", "leave one of them")
        if "x_axis" in given and "normal" not in given:
            raise InvalidInputError(f"{field}.x_axis", "stands without a normal", "add the normal")
        shift = finite_array(f"{field}.translation", given.get("translation", [0.0, 0.0, 0.0]), 1, SPACE)
        return cls(read_only(shift), read_only(_quaternion(field, ways[0] if ways else "", given)))


def _quaternion(field: str, way: str, given: Mapping[str, Any]) -> FloatArray:
    """Return the rotation of a frame that is given in one of the ways."""
    if way == "quaternion":
        return unit_quaternions(f"{field}.quaternion", given[way], 1)
    if way == "matrix":
        return from_rotation_matrix(f"{field}.matrix", given[way])
    if way == "rpy":
        return from_rpy(f"{field}.rpy", given[way])
    if way == "normal":
        z = direction(f"{field}.normal", given[way])
        if "x_axis" not in given:
            raise InvalidInputError(f"{field}.x_axis", "is missing", "say where the x-axis of the plane points")
        x = direction(f"{field}.x_axis", given["x_axis"])
        across = x - (x @ z) * z
        if np.linalg.norm(across) <= 1e-6:
            raise InvalidInputError(f"{field}.x_axis", "is along the normal", "give a direction of the plane")
        x = across / np.linalg.norm(across)
        return from_matrix(np.stack([x, np.cross(z, x), z], axis=1))
    return np.array([1.0, 0.0, 0.0, 0.0])


def direction(field: str, value: Any) -> FloatArray:
    """Return `value`, a vector (3,) that is not zero, as a unit vector."""
    vector = finite_array(field, value, 1, SPACE)
    size = float(np.linalg.norm(vector))
    if not size > 0:
        raise InvalidInputError(field, "is zero and has no direction", "give a direction", value)
    return vector / size


class Placed(Path):
    """A path moved rigidly in space; a plane curve is put into the x-y plane of the frame.

    Parameters
    ----------
    path : Path
        A plane curve, a space curve or a path of poses.
    frame : mapping or Frame, optional
        The frame that the path is given in, as seen from the base: ``translation`` [m] and one of ``quaternion``
        (w, x, y, z), ``matrix``, ``rpy`` [rad], ``normal`` with ``x_axis``.
    tool : mapping or Frame, optional
        For poses: the frame that is to be moved, as seen from the one whose poses are given.

    Raises
    ------
    InvalidInputError
        If a frame is none, or a tool is given for a path without orientation.

    Notes
    -----
    ``frame · X(r) · tool`` for poses X. Planar shapes come into space by it: a circle about `translation` with the axis
    `normal`, whose angles count from `x_axis`.
    """

    kind = "placed"

    def __init__(self, path: Path, frame: Placement = None, tool: Placement = None) -> None:
        self.path = path
        self.frame = Frame.of("frame", frame)
        self.tool = Frame.of("tool", tool)
        self.dimension = max(path.dimension, SPACE)
        self.highest_order = path.highest_order
        if tool is not None and path.dimension != POSE:
            raise InvalidInputError("tool", "needs a path of poses", "leave it out, or give orientations by kind pose")

    @property
    def breaks(self) -> FloatArray:
        """Those of the original path."""
        return self.path.breaks

    @property
    def waypoints(self) -> FloatArray:
        """Those of the original path."""
        return self.path.waypoints

    def _evaluate(self, r: FloatArray, order: int) -> FloatArray:
        given = self.path(r, order)
        if self.path.dimension == PLANE:
            given = np.pad(given, ((0, 0), (0, 1)))
        position = given[:, :SPACE]
        if self.path.dimension == POSE and self.tool.translation.any():
            position = position + self._offset(r, order)
        turned = product(product(self.frame.quaternion, pure(position)), conjugate(self.frame.quaternion))[:, 1:]
        if order == 0:
            turned = turned + self.frame.translation
        if self.dimension != POSE:
            return turned
        return np.hstack([turned, product(product(self.frame.quaternion, given[:, SPACE:]), self.tool.quaternion)])

    def _offset(self, r: FloatArray, order: int) -> FloatArray:
        """Return the turned tool offset q ⊗ (0, p) ⊗ q*, or its derivatives by the product rule."""
        q = [self.path(r, k)[:, SPACE:] for k in range(order + 1)]
        offset = pure(self.tool.translation)
        terms = [
            factor * product(product(q[k], offset), conjugate(q[order - k]))
            for k, factor in enumerate(([1], [1, 1], [1, 2, 1])[order])
        ]
        return np.asarray(sum(terms))[:, 1:]

    def _fastest(self, low: float, high: float) -> float:
        speed, arm = self.path.fastest(low, high), float(np.linalg.norm(self.tool.translation))
        return speed + arm * self.path.turning(low, high) if arm else speed

    def _bending(self, low: float, high: float) -> float:
        if self.tool.translation.any():
            raise self._unbounded("second derivative", "_bending")
        return self.path.bending(low, high)

    def _turning(self, low: float, high: float) -> float:
        return self.path.turning(low, high)
