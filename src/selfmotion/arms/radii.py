"""The radii at which the self-motion of a planar arm with one redundant degree changes its shape."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray, IntArray

if TYPE_CHECKING:
    from selfmotion.arms.planar import PlanarArm


@dataclass(frozen=True)
class Radii:
    """Characteristic distances of the task point from `center`, in the arm's unit of length.

    Attributes
    ----------
    center : array, shape (2,)
        The base; with a fixed direction of the last link the base moved by that link.
    outer : float
        ``R_max = l1 + l2 + l3``, equation (9): beyond it nothing is reached.
    nearest : float
        ``R*_min = √((l1 + l2)² − l3²)``, equation (10), where the seed's nearest maximum reachable workspace begins:
        there the third link can turn by just a quarter turn to either side of the line from `center` to the point.
        NaN if l3 > l1 + l2, when there is no such radius.
    coregular : tuple of float
        ``ρ1 ≥ ρ2 ≥ ρ3``, the values ``|l1 + l2 − l3|``, ``|l1 − l2 + l3|``, ``|−l1 + l2 + l3|`` in descending order. On
        these circles, and only there, closed curves of the self-motion split, merge or vanish (Burdick's co-regular
        surfaces): some posture has all its links on one line.
    closes : bool
        Whether the three links can form a triangle, so that the tool reaches `center`.
    """

    center: FloatArray
    outer: float
    nearest: float
    coregular: tuple[float, float, float]
    closes: bool

    def self_motions(self, radius: ArrayLike) -> IntArray:
        """Return how many closed curves the self-motion of the arm without joint limits has.

        Parameters
        ----------
        radius : array_like
            Distances R ≥ 0 of task points from `center`.

        Returns
        -------
        array of int, the shape of `radius`
            0 beyond R_max; then from outside in 1, 2 below ρ1, 1 below ρ2; below ρ3 it is 2 if the links can form
            a triangle, else 0. Exactly at R_max, and at a co-regular radius, where curves touch, all is connected: 1.
        """
        distance = np.asarray(radius, dtype=float)
        rho1, rho2, rho3 = self.coregular
        inside = [distance > self.outer, distance >= rho1, distance >= rho2, distance >= rho3]
        count = np.select(inside, [0, 1, 2, 1], 2 if self.closes else 0)
        touching = np.isin(distance, [self.outer, rho1, rho2, rho3])
        return np.where(touching, 1, count)


def radii_of(arm: PlanarArm) -> Radii:
    """Return the characteristic radii of an arm whose first three links carry its one redundant degree."""
    l1, l2, l3 = (float(length) for length in arm.links[:3])
    square = (l1 + l2 - l3) * (l1 + l2 + l3)
    rho = sorted((abs(l1 + l2 - l3), abs(l1 - l2 + l3), abs(-l1 + l2 + l3)), reverse=True)
    return Radii(
        center=arm.annulus[0],
        outer=l1 + l2 + l3,
        nearest=float(np.sqrt(square)) if square >= 0 else float("nan"),
        coregular=(rho[0], rho[1], rho[2]),
        closes=2 * max(l1, l2, l3) <= l1 + l2 + l3,
    )
