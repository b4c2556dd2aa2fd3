"""How kernels are compiled: once, so that the second call is fast, and either strictly or for speed."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., object])


def kernel(function: F) -> F:
    """Compile `function` for plain arrays and floats: IEEE arithmetic as written, no fused or reordered operations.

    What carries a proof, or must give the same bits as other code, is compiled so.
    """
    return cast(F, njit(cache=True, nogil=True, error_model="numpy", fastmath=False)(function))


def fast_kernel(function: F) -> F:
    """Compile `function` so that loops over plain arrays run in SIMD registers.

    Sums may be reordered and products fused. NaN and infinity keep their meaning: a candidate that leaves the arm's
    reach must not turn into a number.
    """
    return cast(
        F, njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz", "arcp"})(function)
    )


def elementary(function: F) -> F:
    """Compile a function of single numbers that cancels on purpose, to be inlined into fast kernels.

    Products may be fused, sums not reordered: that would undo the cancellation.
    """
    return cast(F, njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract", "nsz"})(function))
