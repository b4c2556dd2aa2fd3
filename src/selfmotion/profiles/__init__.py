"""Profile families u(r; a): they only choose coefficients; evaluation downstream is shared.

A new family is one file and one line here, and one line in :mod:`selfmotion.planners` that makes it a planner.
"""

from __future__ import annotations

from selfmotion.profiles.base import Profile, ProfileCurve
from selfmotion.profiles.bspline import BSplineProfile
from selfmotion.profiles.harmonics import HarmonicsProfile
from selfmotion.profiles.linear import LinearProfile
from selfmotion.profiles.sinusoid import SinusoidProfile

PROFILES: dict[str, type[Profile]] = {
    profile.kind: profile for profile in (SinusoidProfile, HarmonicsProfile, BSplineProfile)
}
"""Every profile family by its kind."""

__all__ = [
    "PROFILES",
    "BSplineProfile",
    "HarmonicsProfile",
    "LinearProfile",
    "Profile",
    "ProfileCurve",
    "SinusoidProfile",
]
