"""What a global planner proves, as users see it."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple

from selfmotion._types import FloatArray


class Level(NamedTuple):
    """One round of the proof.

    Attributes
    ----------
    slices, cells : int
        Task points at which postures were looked at, and cells that held them.
    bound, cost : float
        The lower bound proved so far, and the cost of the best motion known then.
    seconds : float
        Since the planner began.
    """

    slices: int
    cells: int
    bound: float
    cost: float
    seconds: float


class TubeSlice(NamedTuple):
    """What is left at one r: every motion cheaper than the best one has its posture there near one of these chords.

    Attributes
    ----------
    r : float
    a, b : array, shape (m, n)
        Ends of the chords [rad].
    """

    r: float
    a: FloatArray
    b: FloatArray


@dataclass(frozen=True)
class Certificate:
    """The proof of a lower bound, in figures.

    Attributes
    ----------
    bound : float
        No continuous motion that solves the problem costs less, if it is rigorous; else none that was seen.
    argument : str
        What proved it, in one sentence.
    levels : tuple of Level
    tube : tuple of TubeSlice
        Where a better motion could still be, if there is one.
    rigorous : bool
        Whether the arm's cover leaves nothing out. Without that the bound is an estimate.
    """

    bound: float
    argument: str
    levels: tuple[Level, ...]
    tube: tuple[TubeSlice, ...]
    rigorous: bool = True

    def summary(self) -> dict[str, Any]:
        """Return the proof as the command line's ``--json`` prints it."""
        return {
            "argument": self.argument,
            "levels": [
                level._asdict() | {"cost": level.cost if isfinite(level.cost) else None} for level in self.levels
            ],
            "tube": {"slices": len(self.tube), "cells": sum(len(part.a) for part in self.tube)},
        }
