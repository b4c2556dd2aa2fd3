"""How kernels are compiled: strictly, so that they may carry proofs, and once, so that the second call is fast."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., object])


def kernel(function: F) -> F:
    """Compile `function` for plain arrays and floats: IEEE arithmetic as written, no fused or reordered operations."""
    return cast(F, njit(cache=True, nogil=True, error_model="numpy", fastmath=False)(function))
