"""Where a planar arm stands in space, and what it is called there; planners never ask."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import choice, finite_array, read_only
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import from_matrix, from_rotation_matrix, from_rpy, matrix, unit_quaternions
from selfmotion.units import UNITS, point_text, unlikely_arm

PLANES = ("xy", "xz", "yx", "yz", "zx", "zy")
"""Where the x- and the y-axis of the arm's plane point: ``xz`` is upright, its y-axis up."""

_WAYS = ("plane", "quaternion", "matrix", "rpy", "x_axis")
_FIELDS = ("base", *_WAYS, "y_axis", "unit", "frame", "joints")
_REMEDY = f"write {{base: [0, 0, 400], plane: xz, unit: mm}}; the fields are {', '.join(_FIELDS)}"
_ROUNDED = 1e-15  # norms that are one but for rounding
_FAR = 50.0  # reaches that no base is likely to be away
_PARALLEL = 1e-6  # sine of the angle between two axes that say no plane


@dataclass(frozen=True, eq=False)
class ArmPlacement:
    """A planar arm in space: ``x ↦ unit·(base + R (x, 0))``.

    Attributes
    ----------
    base : array, shape (3,)
        Of the arm's first joint, in `frame` [unit].
    quaternion : array, shape (4,)
        Of R, in the order w, x, y, z; its first two columns are the axes of the arm's plane.
    unit : str
        Of the arm's links and of `base`: ``m``, ``mm``, ``cm`` or ``inch``.
    frame : str
        Name of the frame that the base stands in.
    joints : tuple of str, or None
        Names of the joints, if they have any of their own.
    """

    base: FloatArray
    quaternion: FloatArray
    unit: str = "m"
    frame: str = "world"
    joints: tuple[str, ...] | None = None

    @classmethod
    def of(cls, field: str, value: Any, n: int) -> ArmPlacement | None:
        """Return the placement of an arm of n joints that a mapping describes, None for None.

        Parameters
        ----------
        field : str
            For messages.
        value : ArmPlacement, mapping or None
            ``base`` (default 0), ``unit`` (default m), ``frame`` (default world), ``joints``, and at most one of
            ``plane`` (two of x, y, z; default xy), ``quaternion`` (w, x, y, z), ``matrix`` (3, 3), ``rpy`` (roll,
            pitch, yaw about the fixed x, then y, then z axis [rad]) and ``x_axis`` with ``y_axis``, of which the part
            across the x-axis is meant.
        n : int

        Raises
        ------
        InvalidInputError
            Naming the field inside.
        """
        if value is None:
            return None
        if isinstance(value, ArmPlacement):
            value = value.as_mapping()
        if not isinstance(value, Mapping):
            raise InvalidInputError(field, "is not a mapping", _REMEDY, value)
        given = {key: entry for key, entry in value.items() if entry is not None}
        for key in given:
            if key not in _FIELDS:
                near = get_close_matches(str(key), _FIELDS, 1)
                hint = f"did you mean {near[0]!r}? " if near else ""
                raise InvalidInputError(f"{field}.{key}", "is not a known field", hint + _REMEDY)
        ways = [way for way in _WAYS if way in given]
        if len(ways) > 1:
            raise InvalidInputError(field, f"says its plane by {' and '.join(ways)}", "leave one of them")
        if ("x_axis" in given) != ("y_axis" in given):
            raise InvalidInputError(field, "has one axis of the plane only", "give x_axis and y_axis")
        base = finite_array(f"{field}.base", given.get("base", [0.0, 0.0, 0.0]), 1, 3)
        turn = _quaternion(field, ways[0] if ways else "plane", {"plane": "xy", **given})
        unit = choice(f"{field}.unit", given.get("unit", "m"), UNITS)
        frame = _name(f"{field}.frame", given.get("frame", "world"))
        return cls(read_only(base), read_only(turn), unit, frame, _names(f"{field}.joints", given.get("joints"), n))

    def as_mapping(self) -> dict[str, Any]:
        """Return it as plain data, from which :meth:`of` makes it again."""
        names = None if self.joints is None else list(self.joints)
        turn = {"base": self.base.tolist(), "quaternion": self.quaternion.tolist()}
        return {**turn, "unit": self.unit, "frame": self.frame, "joints": names}

    @property
    def pose(self) -> FloatArray:
        """The frame of the arm's plane in `frame` [m], shape (4, 4)."""
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = matrix(self.quaternion), self.metres * self.base
        return pose

    @property
    def metres(self) -> float:
        """In one of the arm's units of length."""
        return UNITS[self.unit]

    def doubts(self, reach: float) -> list[str]:
        """Return what is to be said if the size of the arm in space, or the place of its base, is an unlikely one.

        Parameters
        ----------
        reach : float
            In the arm's unit.
        """
        metres = self.metres * reach
        doubts = [f"in space {size}" for size in [unlikely_arm(metres, self.unit)] if size is not None]
        away = float(np.linalg.norm(self.base)) / reach
        if away > _FAR or 0 < away < 1 / _FAR**1.5:
            times = f"{away:.0f} times its reach" if away > 1 else f"a {1 / away:.0f}th of its reach"
            doubts.append(
                f"in space the arm's base is at {point_text(self.pose[:3, 3])} m, {times} of {metres:.3g} m from the "
                f"origin: placement.base is in {self.unit} (placement.unit), as the links are"
            )
        return doubts

    def to_space(self, x: ArrayLike) -> FloatArray:
        """Return points of the arm's plane in space.

        Parameters
        ----------
        x : array_like, shape (..., 2)
            In the arm's unit.

        Returns
        -------
        array, shape (..., 3)
            In `frame` [m].
        """
        return self.metres * (self.base + np.asarray(x, dtype=float) @ self.pose[:3, :2].T)


def _quaternion(field: str, way: str, given: Mapping[str, Any]) -> FloatArray:
    """Return the rotation that is said in one of the ways."""
    if way == "plane":
        plane = choice(f"{field}.plane", given[way], PLANES)
        x, y = (np.eye(3)["xyz".index(letter)] for letter in plane)
        return from_matrix(np.stack([x, y, np.cross(x, y)], axis=1))
    if way == "x_axis":
        x, y = (finite_array(f"{field}.{axis}", given[axis], 1, 3) for axis in ("x_axis", "y_axis"))
        for axis, vector in (("x_axis", x), ("y_axis", y)):
            if not vector.any():
                raise InvalidInputError(f"{field}.{axis}", "is zero and has no direction", "give a direction")
        x, y = x / np.linalg.norm(x), y / np.linalg.norm(y)
        across = y - (y @ x) * x
        if np.linalg.norm(across) <= _PARALLEL:
            raise InvalidInputError(f"{field}.y_axis", "is along the x_axis", "give another direction of the plane")
        y = across / np.linalg.norm(across)
        return from_matrix(np.stack([x, y, np.cross(x, y)], axis=1))
    if way == "quaternion":
        unit = unit_quaternions(f"{field}.quaternion", given[way], 1)
        as_given = finite_array(f"{field}.quaternion", given[way], 1)
        return as_given if np.abs(unit - as_given).max() < _ROUNDED else unit  # a stored one comes back bit by bit
    read = from_rotation_matrix if way == "matrix" else from_rpy
    return read(f"{field}.{way}", given[way])


def _name(field: str, value: Any) -> str:
    if not isinstance(value, str) or not value or not value.isprintable():
        raise InvalidInputError(field, "is not a name", "give a text", value)
    return value


def _names(field: str, value: Any, n: int) -> tuple[str, ...] | None:
    """Return n different names."""
    if value is None:
        return None
    names = tuple(value) if isinstance(value, list | tuple) else ()
    if len(names) != n:
        raise InvalidInputError(field, f"are not {n} names", "give one per joint, from the base to the tool", value)
    names = tuple(_name(f"{field}.{j}", name) for j, name in enumerate(names))
    for j, name in enumerate(names):
        if name in names[:j]:
            raise InvalidInputError(f"{field}.{j}", "occurs twice", "give every joint its own name", name)
    return names
