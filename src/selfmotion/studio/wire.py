"""Arrays as JSON: their little-endian bytes in base64, with their shape."""

from __future__ import annotations

import base64
import math
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError

Precision = Literal["f4", "f8"]


def packed(array: ArrayLike, precision: Precision = "f8") -> dict[str, Any]:
    """Return an array as ``{"f4" or "f8": base64, "shape": […]}``; NaN and infinity are kept.

    Parameters
    ----------
    array : array_like
    precision : {"f4", "f8"}
        Four or eight bytes per number.
    """
    values = np.ascontiguousarray(array, dtype=f"<{precision}")
    return {precision: base64.b64encode(values.tobytes()).decode(), "shape": list(np.shape(array))}


def unpacked(field: str, value: Any) -> FloatArray:
    """Return the array that :func:`packed` made, or that nested lists of numbers are.

    Raises
    ------
    InvalidInputError
        Naming the field, if it is neither.
    """
    try:
        if isinstance(value, list | tuple):
            return np.array(value, dtype=float)
        (precision,) = set(value) - {"shape"}
        if precision not in ("f4", "f8"):
            raise ValueError
        flat = np.frombuffer(base64.b64decode(value[precision], validate=True), dtype=f"<{precision}")
        return flat.reshape(value["shape"]).astype(float)
    except (TypeError, ValueError, KeyError):
        raise InvalidInputError(field, "is no array", "give nested lists of numbers, or a packed array") from None


def finite(value: float | None) -> float | None:
    """Return a number that JSON knows: None for what is not finite."""
    return None if value is None or not math.isfinite(value) else float(value)
