"""Long arrays in blocks: what stays in the processor's cache is fast, and memory does not grow with the whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", bound=np.generic)


def in_blocks(function: Callable[[NDArray[Any]], NDArray[T]], rows: NDArray[Any], size: int) -> NDArray[T]:
    """Return a row-wise function of an array, computed `size` rows at a time.

    Parameters
    ----------
    function : callable
        Maps an array, shape (b, …), to one of as many rows.
    rows : array, shape (k, …)
    size : int
        Rows of a block.
    """
    if len(rows) <= size:
        return function(rows)
    return np.concatenate([function(rows[k : k + size]) for k in range(0, len(rows), size)])
