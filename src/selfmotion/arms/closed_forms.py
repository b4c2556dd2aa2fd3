"""Which closed form solves a chain: recognised from its Denavit–Hartenberg parameters, whatever frames a file chose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms._family_kernels import PANDA, SRS
from selfmotion.arms.chain import Chain
from selfmotion.arms.hartenberg import SAME, hartenberg, vanish


class Family(NamedTuple):
    """What a family's arms have in common.

    Attributes
    ----------
    name : str
    number : int
        Of its kernels.
    parameter : str
        What u is.
    twists : tuple of float
        The signs of the quarter turns about x from each joint to the next.
    zero : tuple of float
        What its closed form counts joints from, in parts of π.
    branches : tuple of str
    """

    name: str
    number: int
    parameter: str
    twists: tuple[float, ...]
    zero: tuple[float, ...]
    branches: tuple[str, ...]


FAMILIES = (
    Family(
        "panda", PANDA, "q7", (-1.0, 1.0, 1.0, -1.0, 1.0, 1.0), (0.0,) * 7,
        tuple(f"{elbow} {wrist} {shoulder}" for elbow in ("q4-", "q4+") for wrist in ("q5in", "q5out")
              for shoulder in ("q2+", "q2-")),
    ),
    Family(
        "srs", SRS, "arm angle", (1.0,) * 6, (1.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0),
        tuple(f"{elbow} {wrist} {shoulder}" for elbow in ("q4+", "q4-") for wrist in ("q6+", "q6-")
              for shoulder in ("q2+", "q2-")),
    ),
)  # fmt: skip
"""The arms that are solved in closed form, and enclosed rigorously."""


class ClosedForm(NamedTuple):
    """A chain as its family sees it: ``T(q) = base · T_family(q + shift) · tool``.

    Attributes
    ----------
    family : Family
    geometry : array
        The lengths that the family's kernels want.
    base, tool : array, shape (4, 4)
    shift : array, shape (n,)
        [rad]
    """

    family: Family
    geometry: FloatArray
    base: FloatArray
    tool: FloatArray
    shift: FloatArray


def closed_form_of(chain: Chain) -> ClosedForm | None:
    """Return how a chain of seven revolute joints is solved in closed form; None if no family knows it."""
    if chain.n != 7 or chain.prismatic.any():
        return None
    for family in FAMILIES:
        found = hartenberg(chain, family.twists)
        if found is None:
            continue
        d, a = found.d, found.a
        if family.number == PANDA and vanish(d[1], d[3], d[5], a[0], a[1], a[4]) and min(abs(d[2]), abs(d[4])) > SAME:
            geometry = np.array([0.0, d[2], a[2], d[4], a[3], a[5]])
            if d[2] > 0 and d[4] > 0 and a[5] > SAME:
                return ClosedForm(family, geometry, found.base, found.tool, found.shift)
        if family.number == SRS and vanish(d[1], d[3], d[5], *a[:6]) and min(d[2], d[4]) > SAME:
            shift = wrap(found.shift - np.pi * np.array(family.zero))
            geometry = np.array([0.0, d[2], d[4], 0.0, 0.0, 1.0])
            return ClosedForm(family, geometry, found.base, found.tool, shift)
    return None


def shortfall(form: ClosedForm, rotation: FloatArray, position: FloatArray) -> FloatArray:
    """Return how far shoulder and wrist are too far apart, or too near, for all u, at poses (k, 3, 3) and (k, 3).

    Those of the family's last frame in its base. The wrist of a Panda is on a circle of radius a7 about axis 7.
    """
    if form.family.number == PANDA:
        _, d3, a4, d5, a5, a7 = form.geometry
        seen = -np.einsum("kji,kj->ki", rotation, position)
        across = np.hypot(seen[:, 0], seen[:, 1])
        nearest, farthest = np.hypot(across - a7, seen[:, 2]), np.hypot(across + a7, seen[:, 2])
        upper, fore = np.hypot(a4, d3), np.hypot(a5, d5)
    else:
        upper, fore = form.geometry[1:3]
        nearest = farthest = np.linalg.norm(position, axis=-1)
    return np.maximum(nearest - (upper + fore), abs(upper - fore) - farthest)
