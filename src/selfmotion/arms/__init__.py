"""Arms: kinematics only; they know no path.

A new sort of arm is one file and one line in `ARMS`, a new spatial arm one data file and one line in `CATALOGUE`.
"""

from __future__ import annotations

from collections.abc import Callable

from selfmotion.arms.catalogue import CATALOGUE, how_solved, how_solved_file, named_arm, urdf_arm
from selfmotion.arms.limits import JointBox, JointLimits
from selfmotion.arms.placement import ArmPlacement
from selfmotion.arms.planar import PlanarArm
from selfmotion.arms.protocols import Breakpoints, Cause, FreeJoint, RedundantArm, SelfMotion
from selfmotion.arms.radii import Radii

ARMS: dict[str, Callable[..., RedundantArm]] = {PlanarArm.kind: PlanarArm, "named": named_arm, "urdf": urdf_arm}
"""Every sort of arm by the ``kind`` of a problem file: a class, or a function that makes one."""

__all__ = [
    "ARMS",
    "CATALOGUE",
    "ArmPlacement",
    "Breakpoints",
    "Cause",
    "FreeJoint",
    "JointBox",
    "JointLimits",
    "PlanarArm",
    "Radii",
    "RedundantArm",
    "SelfMotion",
    "how_solved",
    "how_solved_file",
    "named_arm",
    "urdf_arm",
]
