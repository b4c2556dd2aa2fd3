"""How kernels are compiled: once, so that the second call is fast, and either strictly or for speed.

What is compiled is kept in files for the next process. Where those cannot be written or read (a read-only or full disk,
files torn by what ended their writer), code is compiled anew each time, and nothing else changes.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, TypeVar, cast

from numba import config, njit, typeof, types
from numba.core.caching import FunctionCache

F = TypeVar("F", bound=Callable[..., object])
_TORN = (EOFError, pickle.UnpicklingError, ValueError, AttributeError, ImportError, IndexError)


class _Cache(FunctionCache):
    """numba's files of compiled code, without which everything works too."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except OSError:
            return None
        except _TORN:
            with suppress(OSError):
                self.flush()  # type: ignore[no-untyped-call]
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        with suppress(OSError, *_TORN):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


def _compiling(function: Callable[..., Any], **options: Any) -> Any:
    """Return what compiles `function` when it is called, keeping the code in files if there is a place for them."""
    dispatcher = njit(nogil=True, error_model="numpy", **options)(function)
    if not config.DISABLE_JIT:  # type: ignore[attr-defined]
        with suppress(RuntimeError):  # no place is writable
            dispatcher._cache = _Cache(function)  # type: ignore[no-untyped-call]
    return dispatcher


def kernel(function: F) -> F:
    """Compile `function` for plain arrays and floats: IEEE arithmetic as written, no fused or reordered operations.

    What carries a proof, or must give the same bits as other code, is compiled so.
    """
    return cast(F, _compiling(function, fastmath=False))


def fast_kernel(function: F) -> F:
    """Compile `function` so that loops over plain arrays run in SIMD registers.

    Sums may be reordered and products fused. NaN and infinity keep their meaning: a candidate that leaves the arm's
    reach must not turn into a number.
    """
    return cast(F, _compiling(function, fastmath={"reassoc", "contract", "nsz", "arcp"}))


def elementary(function: F) -> F:
    """Compile a function of single numbers that cancels on purpose, to be inlined into fast kernels.

    Products may be fused, sums not reordered: that would undo the cancellation.
    """
    return cast(F, _compiling(function, fastmath={"contract", "nsz"}))


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
            compiled = _compiling(self._python, fastmath=False)
            compiled.compile(signature)
            compiled.disable_compile()
            self._compiled[rest] = compiled
        return self._compiled[rest](*args)
