"""Which closed form solves a chain: recognised from its Denavit–Hartenberg parameters, whatever frames a file chose."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms._family_kernels import PANDA, SRS
from selfmotion.arms.chain import Chain

_SAME = 1e-9  # of lengths [m] and angles [rad]
_QUARTER = 0.5 * np.pi


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


class _Hartenberg(NamedTuple):
    """``T = base · Π Rz(q_j + shift_j) Tz(d_j) Tx(a_j) Rx(±π/2) · tool``, without d of the first and a of the last."""

    base: FloatArray
    shift: FloatArray
    d: FloatArray
    a: FloatArray
    tool: FloatArray


def closed_form_of(chain: Chain) -> ClosedForm | None:
    """Return how a chain of seven revolute joints is solved in closed form; None if no family knows it."""
    if chain.n != 7 or chain.prismatic.any():
        return None
    for family in FAMILIES:
        found = _hartenberg(chain, family.twists)
        if found is None:
            continue
        d, a = found.d, found.a
        if family.number == PANDA and _vanish(d[1], d[3], d[5], a[0], a[1], a[4]) and min(abs(d[2]), abs(d[4])) > _SAME:
            geometry = np.array([0.0, d[2], a[2], d[4], a[3], a[5]])
            if d[2] > 0 and d[4] > 0 and a[5] > _SAME:
                return ClosedForm(family, geometry, found.base, found.tool, found.shift)
        if family.number == SRS and _vanish(d[1], d[3], d[5], *a[:6]) and min(d[2], d[4]) > _SAME:
            shift = wrap(found.shift - np.pi * np.array(family.zero))
            geometry = np.array([0.0, d[2], d[4], 0.0, 0.0, 1.0])
            return ClosedForm(family, geometry, found.base, found.tool, shift)
    return None


def _vanish(*lengths: float) -> bool:
    return max(abs(length) for length in lengths) <= _SAME


def _hartenberg(chain: Chain, twists: tuple[float, ...]) -> _Hartenberg | None:
    """Return the parameters of a chain whose neighbouring joints are perpendicular; None if they are not."""
    n = chain.n
    base = chain.offsets[0].copy()
    shift, d, a = np.zeros(n), np.zeros(n), np.zeros(n)
    for j, sign in enumerate(twists):
        rotation, t = chain.offsets[j + 1][:3, :3], chain.offsets[j + 1][:3, 3]
        if abs(rotation[2, 2]) > _SAME:
            return None
        # Rz(μ) Rx(±π/2) Rz(ν): its last column is where the next joint's axis points.
        axis = rotation[:, 2]
        mu = np.arctan2(sign * axis[0], -sign * axis[1])
        nu = np.arctan2(sign * rotation[2, 0], sign * rotation[2, 1])
        along = np.array([np.cos(mu), np.sin(mu), 0.0])
        a[j] = t @ along
        d[j] += t[2]
        d[j + 1] += t @ axis
        shift[j] += mu
        shift[j + 1] += nu
    base[:3, 3] += base[:3, :3] @ np.array([0.0, 0.0, d[0]])
    tool = chain.offsets[n].copy()
    turn = np.eye(4)
    c, s = np.cos(-shift[n - 1]), np.sin(-shift[n - 1])
    # What the last joint is turned by to begin with belongs to the tool.
    turn[:2, :2] = [[c, -s], [s, c]]
    tool = np.linalg.inv(turn) @ tool
    tool[2, 3] += d[n - 1]
    shift[n - 1] = 0.0
    d[0] = d[n - 1] = 0.0
    return _Hartenberg(base, wrap(shift), d, a, tool)
