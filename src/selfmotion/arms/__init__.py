"""Arms: kinematics only; they know no path.

A new arm is one file and one line in `ARMS`.
"""

from __future__ import annotations

from selfmotion.arms.limits import JointBox, JointLimits
from selfmotion.arms.planar import PlanarArm
from selfmotion.arms.protocols import Breakpoints, Cause, FreeJoint, RedundantArm, SelfMotion
from selfmotion.arms.radii import Radii

ARMS: dict[str, type[RedundantArm]] = {arm.kind: arm for arm in (PlanarArm,)}
"""Every arm by the ``kind`` of a problem file."""

__all__ = [
    "ARMS",
    "Breakpoints",
    "Cause",
    "FreeJoint",
    "JointBox",
    "JointLimits",
    "PlanarArm",
    "Radii",
    "RedundantArm",
    "SelfMotion",
]
