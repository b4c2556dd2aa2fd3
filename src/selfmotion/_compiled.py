"""How kernels are compiled: once, so that the second call is fast, and either strictly or for speed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar, cast

from numba import config, njit, typeof, types

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


class Handed:
    """A kernel that is handed other kernels, and compiled once whichever they are.

    Handed as compiled code usually is, each of them would be compiled into it anew, and arms that are never used along
    with those that are.

    Parameters
    ----------
    function : callable
        Its first arguments are kernels.
    signatures : sequence of numba signatures
        Those kernels', in their order.
    """

    def __init__(self, function: Callable[..., Any], signatures: Sequence[Any]) -> None:
        self._python, self._signatures = function, tuple(signatures)
        self._compiled: dict[Any, Callable[..., Any]] = {}

    def __call__(self, *args: Any) -> Any:
        """Run it."""
        if config.DISABLE_JIT:  # type: ignore[attr-defined]
            return self._python(*args)
        count = len(self._signatures)
        rest = tuple(typeof(arg) for arg in args[count:])  # type: ignore[no-untyped-call]
        if rest not in self._compiled:
            signature = (*(types.FunctionType(s) for s in self._signatures), *rest)
            compiled = njit(signature, cache=True, nogil=True, error_model="numpy", fastmath=False)
            self._compiled[rest] = compiled(self._python)
        return self._compiled[rest](*args)
