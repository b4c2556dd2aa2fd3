"""What every profile family is: curves u(r; a) that are chosen by their coefficients a."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import positive
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError


@dataclass(frozen=True, eq=False)
class ProfileCurve:
    """One curve of a family, a callable of (r, order).

    Attributes
    ----------
    profile : Profile
    a : array, shape (m,)
        Its coefficients.
    """

    profile: Profile
    a: FloatArray

    def __call__(self, r: FloatArray, order: int) -> FloatArray:
        """Return u or du/dr, shape (k, n_u)."""
        return self.profile(self.a, r, order)


class Profile(ABC):
    """A family of curves u(r; a) of the redundancy vector."""

    kind: ClassVar[str]

    @property
    @abstractmethod
    def n_u(self) -> int:
        """Number of components of u."""

    @property
    @abstractmethod
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the coefficients a, which an optimizer chooses."""

    @property
    def start(self) -> FloatArray | None:
        """The redundancy vector at r = 0 if all curves share it, shape (n_u,)."""
        return None

    @property
    def end(self) -> FloatArray | None:
        """The redundancy vector at r = 1 if all curves share it, shape (n_u,)."""
        return None

    @abstractmethod
    def settings(self) -> dict[str, Any]:
        """Return what fixes the family, for a result's record."""

    @abstractmethod
    def cycles(self, a: FloatArray) -> float:
        """Return how many oscillations the fastest component of the curve makes."""

    @abstractmethod
    def _evaluate(self, a: FloatArray, r: FloatArray, order: int) -> FloatArray:
        """Return u or du/dr for coefficients (..., m) at r (k,), as shape (..., k, n_u)."""

    def __call__(self, a: ArrayLike, r: ArrayLike, order: int = 0) -> FloatArray:
        """Evaluate curves of the family.

        Parameters
        ----------
        a : array_like, shape (..., len(parameter_names))
            Coefficients, a row per curve.
        r : array_like, shape (k,)
            Path parameter.
        order : {0, 1}
            0 for u [rad], 1 for du/dr.

        Returns
        -------
        array, shape (..., k, n_u)

        Raises
        ------
        InvalidInputError
            If the number of coefficients or the order does not fit.
        """
        coefficients = np.asarray(a, dtype=float)
        if coefficients.ndim < 1 or coefficients.shape[-1] != len(self.parameter_names):
            raise InvalidInputError("a", f"has shape {coefficients.shape}", f"give (..., {len(self.parameter_names)})")
        if order not in (0, 1):
            raise InvalidInputError("order", "must be 0 or 1", "higher derivatives are not offered", order)
        return self._evaluate(coefficients, np.asarray(r, dtype=float), order)

    def at_time(self, a: ArrayLike, t: ArrayLike, total_time: float, order: int = 0) -> FloatArray:
        """Evaluate curves as functions of time, equations (20) and (21): ``u(t) = u(r)∘r(t)``, ``r = t/T``.

        Parameters
        ----------
        a : array_like, shape (..., len(parameter_names))
        t : array_like, shape (k,)
            Times in [0, T].
        total_time : float
            The travelling time T, positive, in the unit of `t`.
        order : {0, 1}
            0 for u [rad], 1 for du/dt.

        Returns
        -------
        array, shape (..., k, n_u)

        Raises
        ------
        InvalidInputError
            If T is not positive or a time is outside [0, T].
        """
        total = positive("total_time", total_time)
        times = np.asarray(t, dtype=float)
        if not ((times >= 0) & (times <= total)).all():
            raise InvalidInputError("t", "leaves [0, total_time]", "give times of the motion", t)
        return self(a, times / total, order) / total**order
