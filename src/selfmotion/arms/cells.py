"""Cells: pieces of self-motions, each enclosed between two postures and a bound on how far it strays from their chord."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Cells:
    """m cells at one task point: every posture of cell k is ``(1 − s) a_k + s b_k + e`` with |e_i| ≤ dev_ki, 0 ≤ s ≤ 1.

    Attributes
    ----------
    a, b : array, shape (m, n)
        Joint angles at both ends [rad]; limited joints with their turns.
    dev : array, shape (m, n)
        [rad]
    pieces : array, shape (m, p)
        What the cover needs to split a cell; nobody else's business.
    origin : array of int, shape (m,)
        Of split cells, the row of the cell that each is a part of.
    """

    a: FloatArray
    b: FloatArray
    dev: FloatArray
    pieces: FloatArray
    origin: IntArray

    def __len__(self) -> int:
        return len(self.a)

    def __getitem__(self, rows: IntArray | BoolArray | slice) -> Cells:
        return Cells(self.a[rows], self.b[rows], self.dev[rows], self.pieces[rows], self.origin[rows])


class Cover(Protocol):
    """All that the certificate knows of an arm: its self-motion at any task point, in cells."""

    n: int
    wraps: BoolArray
    """Joints that are angles modulo 2π, shape (n,)."""

    def cells(self, r: float, spacing: float) -> Cells:
        """Return cells, no longer than `spacing`, that hold every feasible posture at r."""
        ...

    def split(self, r: float, cells: Cells, spacing: FloatArray) -> Cells:
        """Return cells no longer than `spacing` (m,) that hold every feasible posture of the given ones."""
        ...
