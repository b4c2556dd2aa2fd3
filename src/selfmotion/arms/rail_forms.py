"""Which closed form solves a six-axis arm on a rail: that of the six axes, the base being where the rail takes it."""

from __future__ import annotations

import numpy as np

from selfmotion.arms._family_kernels import UR, UR_RAIL, WRIST, WRIST_RAIL
from selfmotion.arms.chain import Chain
from selfmotion.arms.closed_forms import ClosedForm
from selfmotion.arms.roll_forms import ROLL_FAMILIES, roll_form_of

_ON_RAIL = {WRIST: WRIST_RAIL, UR: UR_RAIL}

RAIL_FAMILIES = tuple(
    family._replace(
        name=f"{family.name} on a rail", number=_ON_RAIL[family.number], parameter="rail", zero=(0.0, *family.zero)
    )
    for family in ROLL_FAMILIES
)
"""The arms on a rail that are solved in closed form, and enclosed rigorously; twists are those of the six axes."""


def rail_form_of(chain: Chain) -> ClosedForm | None:
    """Return how a chain of a rail and six revolute joints is solved; None if no family knows it.

    The geometry is that of the six axes, and after it the direction of the rail in their base.
    """
    if not is_on_rail(chain):
        return None
    six = roll_form_of(without_rail(chain))
    if six is None:
        return None
    family = next(family for family in RAIL_FAMILIES if family.number == _ON_RAIL[six.family.number])
    along = six.base[:3, :3].T @ chain.offsets[0][:3, 2]
    return ClosedForm(family, np.append(six.geometry, along), six.base, six.tool, np.append(0.0, six.shift))


def is_on_rail(chain: Chain) -> bool:
    """Return whether a chain's first joint slides, and six others turn."""
    return chain.n == 7 and bool(chain.prismatic[0]) and not chain.prismatic[1:].any()


def without_rail(chain: Chain) -> Chain:
    """Return a chain with its first joint, which slides, held at zero, whether its limits allow that or not."""
    offsets = np.concatenate([chain.offsets[:1] @ chain.offsets[1:2], chain.offsets[2:]])
    limits = chain.limits.as_list()[1:]
    return Chain(chain.names[1:], offsets, limits, chain.prismatic[1:], chain.velocity[1:], chain.base, chain.tip)
