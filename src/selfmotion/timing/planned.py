"""The time law of a plan: its limits, checked, and the law that keeps them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import positive
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.plans import Plan
from selfmotion.timing.geometry import Geometry
from selfmotion.timing.law import Limits, fastest
from selfmotion.timing.trajectory import TimedTrajectory


def time_law(
    plan: Plan,
    max_acceleration: ArrayLike,
    max_velocity: ArrayLike | None = None,
    tool_speed: float | None = None,
    rate: float = 100.0,
) -> TimedTrajectory:
    """Time a plan: as fast as its joints can, or at constant speed of the tool wherever they can.

    Parameters
    ----------
    plan : Plan
    max_acceleration : float or array_like, shape (n,)
        Of every joint, or of each [rad/s²]; of a joint that slides [m/s²].
    max_velocity : float or array_like, shape (n,), optional
        Of every joint, or of each [rad/s; m/s]; those that the arm's URDF has hold too. Without either a joint's
        velocity is not limited, and that of a rail that the URDF does not have is not.
    tool_speed : float, optional
        Of the tool's position, in the path's unit of length per second. It is never exceeded, and kept wherever the
        joints allow it; :attr:`TimedTrajectory.slow` has where they do not.
    rate : float
        Samples per second.

    Returns
    -------
    TimedTrajectory
        From rest to rest. Joint angles are those of the plan at r(t). Limits hold between samples too, to 0.1 %.

    Raises
    ------
    InvalidInputError
        If a limit or the rate is not positive, there is another number of limits than joints, or the plan does not
        hold or has no finite cost.
    MissingExtraError
        If toppra is not installed: ``pip install 'selfmotion[time]'``.

    Notes
    -----
    Where the rate dq/dr of a joint jumps, at corners of the path, the arm stands still:
    :attr:`TimedTrajectory.stops`. The law is time-optimal, so that accelerations jump and jerk has no bound.
    """
    n = plan.problem.arm.n
    acceleration = _per_joint("max_acceleration", max_acceleration, n)
    velocity = np.full(n, np.inf) if max_velocity is None else _per_joint("max_velocity", max_velocity, n)
    chain = getattr(plan.problem.arm, "chain", None)
    if chain is not None:
        velocity = np.minimum(velocity, chain.velocity)
    speed = np.inf if tool_speed is None else positive("tool_speed", tool_speed)
    positive("rate", rate)
    if not np.isfinite(plan.cost):
        raise InvalidInputError("plan", "has no finite cost", "plan anew: some joint moves infinitely fast")
    geometry = Geometry(plan)
    if not plan.verification.holds:
        raise InvalidInputError("plan", f"does not hold: {plan.verification.failures[0]}", "plan anew")
    limits = Limits(velocity, acceleration, speed)
    return TimedTrajectory(plan, fastest(geometry, limits), limits, rate)


def _per_joint(field: str, value: ArrayLike, n: int) -> FloatArray:
    """Return a positive number per joint, given as such or as one for all."""
    try:
        given = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInputError(field, "is not made of numbers", f"give one number, or {n}", value) from None
    if given.shape not in ((), (1,), (n,)):
        count = given.shape[0] if given.ndim == 1 else f"shape {given.shape}"
        raise InvalidInputError(field, f"has {count} entries for {n} joints", f"give one number, or {n}", value)
    limits = np.broadcast_to(given, (n,)).copy()
    for j, limit in enumerate(limits):
        positive(field if given.ndim == 0 else f"{field}.{j}", float(limit))
    return limits
