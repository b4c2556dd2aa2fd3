"""The circles that the tool crosses when the self-motion of a planar arm changes its structure.

With one redundant degree a posture on which two constraints bind at once has one joint left to turn, so its tool lies
on a circle; and where the two solutions of one constraint fall together, the arm is stretched or folded around it and
the tool lies on a circle too. These finitely many circles cut the plane into regions inside which the self-motion, its
intervals and what bounds them, keep their structure. The co-regular radii of Burdick (1989) are those of the folds.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import unit
from selfmotion.arms.protocols import Cause

if TYPE_CHECKING:
    from selfmotion.arms.planar import PlanarArm


class EventCircle(NamedTuple):
    """Tool positions at which the self-motion changes its structure.

    Attributes
    ----------
    center : array, shape (2,)
    radius : float
        Zero or more.
    causes : tuple of Cause
        The constraint whose two solutions fall together there, or the two that bind at once.
    singular : bool
        Whether one joint is free there: w = 0, the first two links folded onto the base.
    """

    center: FloatArray
    radius: float
    causes: tuple[Cause, ...]
    singular: bool = False


def constraints(arm: PlanarArm) -> list[Cause]:
    """Return every constraint that can bound the feasible self-motion: joint limits, then the folds θ2 = 0 and π.

    A joint limited on one side only never binds: from a turn further inside it is free.

    Parameters
    ----------
    arm : PlanarArm

    Returns
    -------
    list of Cause
    """
    lower, upper = arm.limits.lower, arm.limits.upper
    both = np.flatnonzero(np.isfinite(lower) & np.isfinite(upper))
    limits = [
        Cause(f"{bound} limit", int(j), float(values[j]))
        for j in both
        for bound, values in (("lower", lower), ("upper", upper))
    ]
    return [*limits, Cause("fold", 1, 0.0), Cause("fold", 1, np.pi)]


def event_circles(arm: PlanarArm) -> list[EventCircle]:
    """Return the circles at which the self-motion of an arm with one redundant degree changes its structure.

    Parameters
    ----------
    arm : PlanarArm
        With ``n_u == 1``.

    Returns
    -------
    list of EventCircle
        At least the four of the folds, radii ``|l3 ± (l1 + l2)|`` and ``|l3 ± |l1 − l2||``.
    """
    causes = constraints(arm)
    offset = arm.annulus[0]
    equal = arm.links[0] == arm.links[1]
    found = [
        EventCircle(offset + center, radius, (cause,), bool(equal and cause.kind == "fold" and cause.value))
        for cause in causes
        for center, radius in _touch(arm, cause)
    ]
    for first, second in combinations(causes, 2):
        if first.joint != second.joint:
            center, radius = _meet(arm, *sorted((first, second), key=lambda cause: cause.joint))
            found.append(EventCircle(offset + center, radius, (first, second)))
    return found


def _touch(arm: PlanarArm, cause: Cause) -> list[tuple[FloatArray, float]]:
    """Return where the two postures with one joint fixed fall together."""
    l1, l2, l3 = arm.links[:3]
    center = np.zeros(2)
    if cause.joint == 0:
        center, swing, distance = l1 * unit(cause.value), l3, l2
    elif cause.joint == 1:
        swing, distance = l3, _rigid(l1, l2, cause.value)
    elif cause.joint == 2:
        swing, distance = _rigid(l2, l3, cause.value), l1
    else:  # the direction of link 3 is known: what is left is a two-link arm
        center, swing, distance = l3 * unit(_direction(arm, cause)), l1, l2
    return [(center, float(abs(swing - distance))), (center, float(swing + distance))]


def _meet(arm: PlanarArm, first: Cause, second: Cause) -> tuple[FloatArray, float]:
    """Return where the tool may be with two joints fixed, the one nearer to the base first."""
    l1, l2, l3 = arm.links[:3]
    if second.joint == 3:
        u = _direction(arm, second)
        if first.joint == 0:
            return l3 * unit(u) + l1 * unit(first.value), float(l2)
        if first.joint == 1:
            return l3 * unit(u), _rigid(l1, l2, first.value)
        return l3 * unit(u) + l2 * unit(u - first.value), float(l1)
    if (first.joint, second.joint) == (0, 1):
        return l1 * unit(first.value) + l2 * unit(first.value + second.value), float(l3)
    if (first.joint, second.joint) == (0, 2):
        return l1 * unit(first.value), _rigid(l2, l3, second.value)
    chain = np.array([l1, 0.0]) + l2 * unit(first.value) + l3 * unit(first.value + second.value)
    return np.zeros(2), float(np.hypot(*chain))


def _rigid(a: float, b: float, angle: float) -> float:
    """Return the distance between the ends of two links with a fixed angle between them."""
    return float(np.hypot(a + b * np.cos(angle), b * np.sin(angle)))


def _direction(arm: PlanarArm, cause: Cause) -> float:
    assert arm.direction is not None
    return arm.direction - cause.value
