"""Cells: pieces of self-motions, each between two postures and within bounds of their chord and of a parabola."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray

_NOT_GIVEN = np.empty(0)


@dataclass(frozen=True)
class Cells:
    """m cells at one task point: every posture of cell k is ``(1 − s) a_k + s b_k + e`` with |e_i| ≤ dev_ki, 0 ≤ s ≤ 1.

    For the same s it is ``(1 − s) a_k + s b_k + ½ s (1 − s) bow_k + f`` with |f_i| ≤ rest_ki.

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
    bow, rest : array, shape (m, n)
        [rad]; zero and dev if not given. The smaller `rest` is, the longer cells serve a proof.
    """

    a: FloatArray
    b: FloatArray
    dev: FloatArray
    pieces: FloatArray
    origin: IntArray
    bow: FloatArray = field(default_factory=lambda: _NOT_GIVEN)
    rest: FloatArray = field(default_factory=lambda: _NOT_GIVEN)

    def __post_init__(self) -> None:
        if self.rest is _NOT_GIVEN:
            object.__setattr__(self, "bow", np.zeros_like(self.dev))
            object.__setattr__(self, "rest", self.dev)

    def __len__(self) -> int:
        return len(self.a)

    def __getitem__(self, rows: IntArray | BoolArray | slice) -> Cells:
        return Cells(
            self.a[rows], self.b[rows], self.dev[rows], self.pieces[rows], self.origin[rows], self.bow[rows],
            self.rest[rows],
        )  # fmt: skip


class Cover(Protocol):
    """All that a lower bound knows of an arm: its self-motion at any task point, in cells."""

    n: int
    wraps: BoolArray
    """Joints that are angles modulo 2π, shape (n,)."""

    def cells(self, x: FloatArray, spacing: float) -> Cells:
        """Return cells that hold every feasible posture at a task point.

        Parameters
        ----------
        x : array, shape (2,)
            The task point.
        spacing : float
            About how long cells may be, joint by joint [rad].
        """
        ...

    def split(self, x: FloatArray, cells: Cells, spacing: FloatArray) -> Cells:
        """Return cells of about `spacing` (m,) that hold every feasible posture of the given ones at x."""
        ...

    def points(self, q: FloatArray, turned: bool) -> Cells:
        """Return cells that are postures q (m, n) alone; if `turned`, in every turn that the limits allow."""
        ...
