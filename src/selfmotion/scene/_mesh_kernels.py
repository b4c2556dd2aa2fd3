"""Kernel that tells whether points are inside of a closed mesh."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray


@kernel
def winding(corners: FloatArray, point: FloatArray) -> float:
    """Return how often triangles (m, 3, 3) wind around a point: the sum of the solid angles that they are seen at.

    Of a closed mesh it is a whole number, 0 outside; the angle of one triangle is by Van Oosterom and Strackee (1983).
    """
    total = 0.0
    for k in range(len(corners)):
        ax, ay, az = corners[k, 0, 0] - point[0], corners[k, 0, 1] - point[1], corners[k, 0, 2] - point[2]
        bx, by, bz = corners[k, 1, 0] - point[0], corners[k, 1, 1] - point[1], corners[k, 1, 2] - point[2]
        cx, cy, cz = corners[k, 2, 0] - point[0], corners[k, 2, 1] - point[1], corners[k, 2, 2] - point[2]
        a = np.sqrt(ax * ax + ay * ay + az * az)
        b = np.sqrt(bx * bx + by * by + bz * bz)
        c = np.sqrt(cx * cx + cy * cy + cz * cz)
        volume = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
        ab, bc, ca = ax * bx + ay * by + az * bz, bx * cx + by * cy + bz * cz, cx * ax + cy * ay + cz * az
        total += np.arctan2(volume, a * b * c + ab * c + bc * a + ca * b)
    return total / (2.0 * np.pi)
