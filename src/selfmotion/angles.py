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


def unwrap(q: FloatArray) -> None:
    """Make q (…, k, n) continuous along k in place, by whole turns; numpy's own takes ten times as long."""
    steps = np.diff(q, axis=-2)
    if steps.max(initial=0.0) > np.pi or steps.min(initial=0.0) < -np.pi:
        q[..., 1:, :] -= TAU * np.cumsum(np.rint(steps / TAU), axis=-2)


def unit(angle: FloatArray | float) -> FloatArray:
    """Return the unit vectors of directions (...), shape (..., 2)."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)
