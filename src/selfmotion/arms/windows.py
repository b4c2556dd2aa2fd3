"""Whole turns: the angles of a posture that joint limits allow."""

from __future__ import annotations

from itertools import product

import numpy as np

from selfmotion._types import BoolArray, FloatArray, IntArray


def turned_postures(
    q: FloatArray, wraps: BoolArray, windows: FloatArray, first: IntArray, period: FloatArray
) -> list[tuple[float, ...]]:
    """Return a posture (n,) in every combination of whole turns with which its joints are in their windows.

    Joint j may lie in ``windows[first[j]:first[j + 1]]``, shape (m, 2); one that `wraps` stays as it stands.
    A turn is its `period` (n,).
    """
    options = []
    for j, angle in enumerate(q):
        turns = [0.0] if wraps[j] else [
            float(k) for low, high in windows[first[j] : first[j + 1]]
            for k in range(int(np.ceil((low - angle) / period[j])), int(np.floor((high - angle) / period[j])) + 1)
        ]  # fmt: skip
        options.append([float(angle) + float(period[j]) * k for k in turns])
    return list(product(*options))
