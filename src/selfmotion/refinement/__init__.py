"""Shortest motions near a given one, in joint space, at any degree of redundancy.

``min ∫ c(s'(r)) dr`` over the coefficients of a joint-space spline s, with the task kept at collocation points and the
joint limits at every coefficient. In joint space neither a fold nor a limit is special: motions cross the one and
ride the other. What is left between the collocation points is closed exactly, see :mod:`selfmotion.refinement.closing`.
"""

from __future__ import annotations

from selfmotion.refinement.closing import ClosedSpline
from selfmotion.refinement.collocation import Collocation
from selfmotion.refinement.newton import Minimum, minimise
from selfmotion.refinement.optima import Optima, Optimum
from selfmotion.refinement.spline import Ends, SplineSpace
from selfmotion.refinement.starts import Start, random_starts, start_from

__all__ = [
    "ClosedSpline",
    "Collocation",
    "Ends",
    "Minimum",
    "Optima",
    "Optimum",
    "SplineSpace",
    "Start",
    "minimise",
    "random_starts",
    "start_from",
]
