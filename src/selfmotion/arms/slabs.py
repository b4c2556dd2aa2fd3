"""Covers of slabs: all postures along a part of a path in boxes of joint angles, which a motion must pass through."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Protocol

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Boxes:
    """m boxes of joint angles in a slab, a part of the path.

    Attributes
    ----------
    low, high : array, shape (m, n)
        Ends of the boxes [rad]: of limited joints as they stand, their turns counted, and not beyond their limits; of
        free ones modulo 2π, at most 2π apart.
    clean : array of bool, shape (m,)
        Whether all postures that the box was made for are inside all limits.
    pieces : array, shape (m, p)
        What the cover needs to split a box; nobody else's business.
    origin : array of int, shape (m,)
        Of split boxes, the row of the box that each is a part of.
    places : array, shape (m, n + 1, 5)
        Of planar arms, where the base and the ends of the links are in the postures that the box was made for: within
        `rest` of the line from (x, y) − (Δx, Δy) to (x, y) + (Δx, Δy), as (x, y, Δx, Δy, rest). Narrower than the box
        tells, since joints do not move independently. Of others (m, 0, 5).
    """

    low: FloatArray
    high: FloatArray
    clean: BoolArray
    pieces: FloatArray
    origin: IntArray
    places: FloatArray

    def __len__(self) -> int:
        return len(self.low)

    def __getitem__(self, rows: IntArray | BoolArray | slice) -> Boxes:
        return Boxes(*(getattr(self, each.name)[rows] for each in fields(self)))

    def contain(self, q: FloatArray, wraps: BoolArray, tolerance: float = 0.0) -> BoolArray:
        """Return which boxes hold a posture, shape (m,).

        Parameters
        ----------
        q : array, shape (n,)
            Joint angles, those of limited joints as they stand [rad].
        wraps : array of bool, shape (n,)
            Joints that are angles modulo 2π.
        tolerance : float
            How far outside still counts [rad].
        """
        away = q - 0.5 * (self.low + self.high)
        away -= np.where(wraps, 2 * np.pi * np.rint(away / (2 * np.pi)), 0.0)
        return np.asarray((np.abs(away) <= 0.5 * (self.high - self.low) + tolerance).all(axis=-1))


class SlabCover(Protocol):
    """All that a proof of infeasibility knows of an arm and its path: boxes that hold its postures."""

    n: int
    wraps: BoolArray
    """Joints that are angles modulo 2π, shape (n,)."""
    one_sided: BoolArray
    """Those of them that do have a limit, on one side, shape (n,)."""
    slabs: int
    """Into how many slabs the whole path is cut to begin with."""

    def boxes(self, low: float, high: float, size: float) -> Boxes:
        """Return boxes that hold every feasible posture at every r in [low, high].

        Radii exceed `size` [rad] only where the slab is too thick for less.
        """
        ...

    def split(self, low: float, high: float, boxes: Boxes, size: FloatArray) -> Boxes:
        """Return boxes of radii `size`, shape (m,), that hold every posture of `boxes` at every r in [low, high].

        The slab is a part of the one that `boxes` were made for.
        """
        ...
