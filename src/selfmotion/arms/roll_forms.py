"""Which closed form solves a six-axis chain whose tool may roll, recognised from its Denavit–Hartenberg parameters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms.chain import Chain
from selfmotion.arms.hartenberg import SAME, Hartenberg, hartenberg, vanish

WRIST, UR = 2, 3
_ZERO = 1e-14  # of the reach: lengths that are rounding, and must not count


class RollFamily(NamedTuple):
    """What a family's arms have in common.

    Attributes
    ----------
    name : str
    number : int
        Of its kernels.
    twists : tuple of float
        The sines of the turns about x from each joint to the next.
    zero : tuple of float
        What its closed form counts joints from, in parts of π.
    branches : tuple of str
    """

    name: str
    number: int
    twists: tuple[float, ...]
    zero: tuple[float, ...]
    branches: tuple[str, ...]
    parameter: str = "roll"


ROLL_FAMILIES = (
    RollFamily(
        "spherical wrist", WRIST, (-1.0, 0.0, 1.0, -1.0, 1.0), (0.0, -0.5, 0.5, 0.0, 0.0, 0.0),
        tuple(f"{shoulder} {elbow} {wrist}" for shoulder in ("shoulder+", "shoulder-") for elbow in ("elbow+", "elbow-")
              for wrist in ("q5+", "q5-")),
    ),
    RollFamily(
        "ur", UR, (1.0, 0.0, 0.0, 1.0, -1.0), (0.0,) * 6,
        tuple(f"{shoulder} {wrist} {elbow}" for shoulder in ("shoulder+", "shoulder-") for wrist in ("q5+", "q5-")
              for elbow in ("q3+", "q3-")),
    ),
)  # fmt: skip
"""The arms whose roll is solved in closed form, and enclosed rigorously."""


class RollForm(NamedTuple):
    """A chain as its family sees it: ``T(q) = base · T_family(q + shift) · tool``.

    Attributes
    ----------
    family : str
    number : int
        Of the family's kernels.
    geometry : array
        The lengths that the kernels want, without the tool.
    base, tool : array, shape (4, 4)
    shift : array, shape (6,)
        [rad]
    """

    family: str
    number: int
    geometry: FloatArray
    base: FloatArray
    tool: FloatArray
    shift: FloatArray

    @property
    def with_tool(self) -> FloatArray:
        """The geometry for kernels: the lengths, the rotation of tool⁻¹ row by row, and its position."""
        back = self.tool[:3, :3].T
        return np.concatenate([self.geometry, back.ravel(), -back @ self.tool[:3, 3]])


def roll_form_of(chain: Chain) -> RollForm | None:
    """Return how a chain of six revolute joints with a free roll is solved; None if no family knows it."""
    if chain.n != 6 or chain.prismatic.any():
        return None
    for family in ROLL_FAMILIES:
        found = hartenberg(chain, family.twists)
        if found is None:
            continue
        geometry = (_of_wrist if family.number == WRIST else _of_ur)(found)
        if geometry is None:
            continue
        geometry[np.abs(geometry) <= _ZERO * np.abs(geometry).sum()] = 0.0
        shift = wrap(found.shift - np.pi * np.array(family.zero))
        return RollForm(family.name, family.number, geometry, found.base, found.tool, shift)
    return None


def _of_wrist(found: Hartenberg) -> FloatArray | None:
    d, a = found.d, found.a
    if vanish(d[4], a[3], a[4]) and a[1] > SAME and np.hypot(a[2], d[3]) > SAME:
        return np.array([a[0], a[2], d[2], a[1], d[3]])
    return None


def _of_ur(found: Hartenberg) -> FloatArray | None:
    d, a = found.d, found.a
    if vanish(a[0], a[3], a[4]) and min(a[1], a[2], abs(d[3])) > SAME:
        return np.array([a[1], a[2], d[3], d[4]])
    return None
