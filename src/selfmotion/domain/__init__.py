"""Where arm and path meet: the feasible self-motion at a task point and along a path."""

from __future__ import annotations

from selfmotion.arms import PlanarArm
from selfmotion.domain.angle_domain import AngleDomain, blocked_stretches
from selfmotion.domain.feasible import FeasibleArcs, feasible_arcs
from selfmotion.paths import Path


def angle_domain(arm: PlanarArm, path: Path) -> AngleDomain:
    """Return the angle domain of an arm with one redundant degree along a path.

    Parameters
    ----------
    arm : PlanarArm
    path : Path

    Returns
    -------
    AngleDomain
        Call it with ``(r, branch)`` for an :class:`~selfmotion.intervals.IntervalSet`.

    Raises
    ------
    InvalidInputError
        If the arm has another degree of redundancy.
    """
    return AngleDomain(arm.self_motion(), path)


__all__ = ["AngleDomain", "FeasibleArcs", "angle_domain", "blocked_stretches", "feasible_arcs"]
