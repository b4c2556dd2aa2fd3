"""Which closed form solves a six-axis chain whose tool may roll, recognised from its Denavit–Hartenberg parameters."""

from __future__ import annotations

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import wrap
from selfmotion.arms._family_kernels import UR, WRIST
from selfmotion.arms.chain import Chain
from selfmotion.arms.closed_forms import ClosedForm, Family
from selfmotion.arms.hartenberg import SAME, Hartenberg, hartenberg, vanish

_ZERO = 1e-14  # of the reach: lengths that are rounding, and must not count


ROLL_FAMILIES = (
    Family(
        "spherical wrist", WRIST, "roll", (-1.0, 0.0, 1.0, -1.0, 1.0), (0.0, -0.5, 0.5, 0.0, 0.0, 0.0),
        tuple(f"{shoulder} {elbow} {wrist}" for shoulder in ("shoulder+", "shoulder-") for elbow in ("elbow+", "elbow-")
              for wrist in ("q5+", "q5-")),
    ),
    Family(
        "ur", UR, "roll", (1.0, 0.0, 0.0, 1.0, -1.0), (0.0,) * 6,
        tuple(f"{shoulder} {wrist} {elbow}" for shoulder in ("shoulder+", "shoulder-") for wrist in ("q5+", "q5-")
              for elbow in ("q3+", "q3-")),
    ),
)  # fmt: skip
"""The arms whose roll is solved in closed form, and enclosed rigorously."""


def roll_form_of(chain: Chain) -> ClosedForm | None:
    """Return how a chain of six revolute joints with a free roll is solved; None if no family knows it.

    Kernels turn the tool themselves: the geometry is the lengths, the rotation of tool⁻¹ row by row, and its position.
    """
    if chain.n != 6 or chain.prismatic.any():
        return None
    for family in ROLL_FAMILIES:
        found = hartenberg(chain, family.twists)
        if found is None:
            continue
        lengths = (_of_wrist if family.number == WRIST else _of_ur)(found)
        if lengths is None:
            continue
        lengths[np.abs(lengths) <= _ZERO * np.abs(lengths).sum()] = 0.0
        back = found.tool[:3, :3].T
        geometry = np.concatenate([lengths, back.ravel(), -back @ found.tool[:3, 3]])
        shift = wrap(found.shift - np.pi * np.array(family.zero))
        return ClosedForm(family, geometry, found.base, found.tool, shift)
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
