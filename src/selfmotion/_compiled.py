"""How kernels are compiled: once, so that the second call is fast, and either strictly or for speed.

What a kernel computes, to the last bit, depends on its arguments alone and not on what else a process has compiled.
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
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.typed_passes import AnnotateTypes

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


class _SelfContained(JITCodeLibrary):
    """Machine code that calls copies of its own of other kernels, never what is loaded already by the same name.

    numba compiles copies of what a kernel calls into it, each optimised in its place, and for a call the loader takes
    the copy that was loaded first: how reordered sums round would depend on what a process had compiled or run before.
    """

    def _finalize_final_module(self) -> None:
        self._shared_module = self._final_module.clone()  # what others compile in, exported as numba does
        for function in self._shared_module.functions:
            if not function.is_declaration and function.linkage.name == "external":
                function.linkage = "linkonce_odr"
        for function in self._final_module.functions:
            if function.linkage.name == "linkonce_odr":
                function.linkage = "internal"
        super()._finalize_final_module()  # type: ignore[no-untyped-call]


@register_pass(mutates_CFG=False, analysis_only=False)  # type: ignore[no-untyped-call]
class _SelfContainedPass(LoweringPass):
    """What numba fills with machine code is self-contained."""

    _name = "self_contained"

    def __init__(self) -> None:
        LoweringPass.__init__(self)  # type: ignore[no-untyped-call]

    def run_pass(self, state: Any) -> bool:
        """Begin the code of a function."""
        codegen, name = state.targetctx.codegen(), state.func_id.func_qualname
        state.library = _SelfContained(codegen, name)  # type: ignore[no-untyped-call]
        state.library.enable_object_caching()
        return False


class _Compiler(Compiler):
    """numba's compiler, with self-contained machine code."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes, ours before those that write machine code."""
        pipelines: list[Any] = super().define_pipelines()  # type: ignore[no-untyped-call]
        for pipeline in pipelines:
            pipeline.add_pass_after(_SelfContainedPass, AnnotateTypes)
            pipeline.finalize()
        return pipelines


def _compiling(function: Callable[..., Any], **options: Any) -> Any:
    """Return what compiles `function` when it is called, keeping the code in files if there is a place for them."""
    dispatcher = njit(nogil=True, error_model="numpy", pipeline_class=_Compiler, **options)(function)
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
