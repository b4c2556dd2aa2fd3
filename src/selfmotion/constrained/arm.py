"""An arm with constraints beyond its joint limits: obstacles, itself, singular postures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import BoolArray, FloatArray
from selfmotion.arms import RedundantArm, SelfMotion
from selfmotion.constrained.constraint import Constraint
from selfmotion.constrained.covers import ConstrainedCover, ConstrainedSlabs
from selfmotion.constrained.self_motion import ConstrainedSelfMotion

if TYPE_CHECKING:
    from selfmotion.paths import Path

# What the arm can do only because nothing but joint limits forbids postures.
_NOT_ITS_OWN = frozenset({"cover_with_an_end_open"})


class ConstrainedArm:
    """An arm whose postures must keep constraints; in everything else it is the arm without them.

    Parameters
    ----------
    arm : RedundantArm
        Without constraints.
    constraints : sequence of Constraint
        One or more.

    Attributes
    ----------
    bare : RedundantArm
        The arm without constraints.
    constraints : tuple of Constraint
    has_structure : bool
        False: obstacles end intervals of the self-motion where no closed form tells.
    """

    has_structure = False

    def __init__(self, arm: RedundantArm, constraints: Sequence[Constraint]) -> None:
        self.bare, self.constraints = arm, tuple(constraints)

    def __getattr__(self, name: str) -> Any:
        """Return what the arm without constraints has."""
        if name in _NOT_ITS_OWN or name.startswith("__") or name == "bare":
            raise AttributeError(name)
        return getattr(self.bare, name)

    def __repr__(self) -> str:
        return f"ConstrainedArm({self.bare!r}, {self.constraints!r})"

    def least(self, q: ArrayLike) -> FloatArray:
        """Return the least margin of each constraint, in its own unit.

        Parameters
        ----------
        q : array_like, shape (..., n)
            [rad; m of joints that slide].

        Returns
        -------
        array, shape (..., c)
        """
        postures = np.asarray(q, dtype=float)
        flat = postures.reshape(-1, postures.shape[-1])
        found = [constraint.least_margins(flat)[0] for constraint in self.constraints]
        return np.stack(found, axis=-1).reshape(*postures.shape[:-1], len(found))

    def relaxed(self, slack: ArrayLike, upper: ArrayLike | None = None) -> ConstrainedArm:
        """Return the same arm with joint limits that give by `slack`, upper ones by `upper` if it is given [rad]."""
        return ConstrainedArm(self.bare.relaxed(slack, upper), self.constraints)

    def cover(self, elbow: str = "any") -> ConstrainedCover:
        """Return the cells of the self-motion that are not surely blocked."""
        return ConstrainedCover(self.bare.cover(elbow), self.constraints)

    def slabs(self, path: Path, elbow: str = "any") -> ConstrainedSlabs:
        """Return boxes of the postures along parts of a path that are not surely blocked."""
        return ConstrainedSlabs(self.bare.slabs(path, elbow), self.constraints)

    def self_motion(self) -> SelfMotion:
        """Return the self-motion, for one redundant degree; else raise InvalidInputError."""
        return ConstrainedSelfMotion(self.bare.self_motion(), self.constraints)


def constrained(arm: RedundantArm, constraints: Sequence[Constraint]) -> RedundantArm:
    """Return an arm under constraints; the arm itself if there are none.

    Parameters
    ----------
    arm : RedundantArm
    constraints : sequence of Constraint

    Returns
    -------
    RedundantArm
        A :class:`ConstrainedArm`, which is one by what it hands on.
    """
    return cast("RedundantArm", ConstrainedArm(arm, constraints)) if constraints else arm


def constraints_of(arm: RedundantArm) -> tuple[Constraint, ...]:
    """Return an arm's constraints beyond its joint limits; none of most arms."""
    return arm.constraints if isinstance(arm, ConstrainedArm) else ()


def keeps_constraints(arm: RedundantArm, q: FloatArray) -> BoolArray:
    """Return which postures (k, n) keep an arm's constraints beyond its joint limits, up to rounding; shape (k,)."""
    kept = np.ones(len(q), bool)
    for constraint in constraints_of(arm):
        kept &= constraint.least_margins(q)[0] >= -constraint.tolerance
    return kept


def unconstrained(arm: RedundantArm) -> RedundantArm:
    """Return an arm without its constraints beyond joint limits."""
    return arm.bare if isinstance(arm, ConstrainedArm) else arm
