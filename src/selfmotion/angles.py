"""Angles modulo a full turn."""

from __future__ import annotations

import numpy as np

from selfmotion._types import FloatArray

TAU = 2 * np.pi


def wrap(angle: FloatArray | float) -> FloatArray:
    """Return angles modulo 2π, inside [−π, π]."""
    return np.asarray(angle - TAU * np.rint(angle / TAU))


def nearest_turn(angle: FloatArray, reference: FloatArray) -> FloatArray:
    """Return `angle` moved by whole turns as near to `reference` as it gets."""
    return np.asarray(angle + TAU * np.rint((reference - angle) / TAU))
