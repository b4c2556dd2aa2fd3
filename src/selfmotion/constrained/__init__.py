"""Arms with constraints beyond joint limits: each has margins of postures, and says of cells and boxes what is sure."""

from selfmotion.constrained.arm import (
    ConstrainedArm,
    constrained,
    constraints_of,
    keeps_constraints,
    unconstrained,
)
from selfmotion.constrained.constraint import BLOCKED, FREE, UNDECIDED, Constraint
from selfmotion.constrained.covers import why_empty
from selfmotion.constrained.singularity import SingularityMargin

__all__ = [
    "BLOCKED",
    "FREE",
    "UNDECIDED",
    "ConstrainedArm",
    "Constraint",
    "SingularityMargin",
    "constrained",
    "constraints_of",
    "keeps_constraints",
    "unconstrained",
    "why_empty",
]
