"""Families that are linear in their coefficients: a curve is a sum of fixed functions of r."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.profiles.base import Profile


class LinearProfile(Profile):
    """The curves ``u_j(r) = Σ_k c_jk φ_k(r)``, some columns k of whose coefficients are fixed.

    A family says what its functions φ_k are; the free coefficients are the a that an optimizer chooses, component by
    component. A population of curves is then one matrix product.

    Parameters
    ----------
    names : tuple of str, length m
        Names of the functions' coefficients.
    fixed : mapping of int to array, shape (n_u,)
        Columns whose coefficients are given.
    n_u : int

    Attributes
    ----------
    free : array of int
        Columns whose coefficients are chosen.
    """

    def __init__(self, names: tuple[str, ...], fixed: Mapping[int, FloatArray], n_u: int) -> None:
        self._n_u = n_u
        self.free = np.array([k for k in range(len(names)) if k not in fixed], dtype=np.intp)
        self._coefficients = np.zeros((n_u, len(names)))
        for k, column in fixed.items():
            self._coefficients[:, k] = column
        chosen = [names[k] for k in self.free]
        self._names = tuple(chosen if n_u == 1 else [f"{name}_{j + 1}" for j in range(n_u) for name in chosen])
        self._known: dict[int, tuple[FloatArray, FloatArray]] = {}

    @property
    def n_u(self) -> int:
        """Number of components of u."""
        return self._n_u

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the free coefficients, as ``("a1", "a2")``; with components ``("a1_1", "a2_1", "a1_2", …)``."""
        return self._names

    @abstractmethod
    def functions(self, r: FloatArray, order: int) -> FloatArray:
        """Return φ or dφ/dr at r (k,), a column per function, shape (k, m)."""

    @abstractmethod
    def box(self, span: FloatArray) -> FloatArray:
        """Return lower and upper bounds of the free coefficients for half-widths `span` (n_u,), shape (d, 2)."""

    def coefficients(self, a: FloatArray) -> FloatArray:
        """Return all c, the fixed ones too, for free ones a (..., d), as shape (..., n_u, m)."""
        every = np.broadcast_to(self._coefficients, (*a.shape[:-1], *self._coefficients.shape)).copy()
        every[..., self.free] = a.reshape(*a.shape[:-1], self._n_u, len(self.free))
        return every

    def _evaluate(self, a: FloatArray, r: FloatArray, order: int) -> FloatArray:
        # An optimizer asks for the same r thousands of times: the functions are evaluated there once.
        at, functions = self._known.get(order, (None, None))
        if at is None or functions is None or not np.array_equal(at, r):
            at, functions = r.copy(), self.functions(r, order).T
            self._known[order] = at, functions
        return np.ascontiguousarray(np.swapaxes(self.coefficients(a) @ functions, -1, -2))
