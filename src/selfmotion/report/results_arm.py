"""What the report says of arms."""

from __future__ import annotations

from typing import Any

from selfmotion.arms import JointLimits, PlanarArm


def arm_facts(arm: PlanarArm) -> dict[str, Any]:
    """Return what the report says of an arm."""
    return {
        "links": ", ".join(f"{length:g}" for length in arm.links),
        "joints": arm.n,
        "reach": arm.reach,
        "limits": limits_text(arm.limits),
    }


def limits_text(limits: JointLimits) -> str:
    """Return the limits of the joints that have some, as inequalities."""
    bounds = enumerate(zip(limits.lower, limits.upper, strict=True))
    return ", ".join(f"{low:.4g} ≤ θ{joint + 1} ≤ {high:.4g}" for joint, (low, high) in bounds if limits.limited[joint])
