"""One decorator for the numba kernels, so that their compiler flags are said once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numba

_F = TypeVar("_F", bound=Callable[..., Any])

# No nnan/ninf: a NaN that a kernel meets must come out as NaN.
_FASTMATH = {"reassoc", "contract", "nsz", "arcp"}


def kernel(function: _F) -> _F:
    """Compile `function` for speed: cached on disk, free of the GIL, NaN keeps its meaning."""
    compiled: _F = numba.njit(cache=True, nogil=True, error_model="numpy", fastmath=_FASTMATH)(function)
    return compiled
