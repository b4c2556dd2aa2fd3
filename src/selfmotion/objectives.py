"""What a motion costs: joint travel (1a), and plain travel in the l1 and l2 sense.

Each objective is a density c(θ', 1) that is integrated, and the same convex function c(Δθ, Δr) of a chord,
``c(h θ', h) = h c(θ', 1)``. An arc costs at least its chord, so the chord sum over samples never exceeds the integral.

A new objective is one class and one line in `OBJECTIVES`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.quadrature import Integral, integrate


class Smoothed(NamedTuple):
    """A smooth density c(θ') at k rates of n joints, and its derivatives.

    Attributes
    ----------
    value : array, shape (k,)
    gradient : array, shape (k, n)
    diagonal : array, shape (k, n)
        Diagonal of the Hessian.
    times : callable
        The Hessian times vectors (k, n).
    majorant : array, shape (k, n)
        Diagonal of a matrix above the Hessian that does not vanish away from kinks.
    """

    value: FloatArray
    gradient: FloatArray
    diagonal: FloatArray
    times: Callable[[FloatArray], FloatArray]
    majorant: FloatArray


class Objective(ABC):
    """A cost of joint motions that is convex and positively homogeneous in (Δθ, Δr).

    Attributes
    ----------
    has_kinks : bool
        Whether the density is not smooth somewhere.
    """

    kind: ClassVar[str]
    has_kinks: ClassVar[bool]

    @staticmethod
    @abstractmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return the cost of a straight piece.

        Parameters
        ----------
        dq : array, shape (..., n)
            Joint changes [rad].
        dr : array_like, shape (...)
            Change of the path parameter.
        weights : array, shape (n,)

        Returns
        -------
        array, shape (...)
        """

    @staticmethod
    @abstractmethod
    def smoothed(rates: FloatArray, weights: FloatArray, width: float) -> Smoothed:
        """Return the density ``c(θ', 1)`` and its derivatives, kinks rounded off.

        Parameters
        ----------
        rates : array, shape (k, n)
            θ' [rad].
        weights : array, shape (n,)
        width : float
            Rates below which a kink is rounded, weighted ones for l2. The density grows by at most this, times the
            weights' sum for l1. Without effect on a density without kinks.

        Returns
        -------
        Smoothed
        """

    def sampled(self, q: FloatArray, r: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the chord sum of sampled motions: (1a) as the seed computes it.

        Parameters
        ----------
        q : array, shape (..., k, n)
            Continuous joint angles at the samples [rad].
        r : array, shape (k,)
        weights : array, shape (n,)

        Returns
        -------
        array, shape (...)
        """
        return np.asarray(self.chord(np.diff(q, axis=-2), np.diff(r), weights).sum(axis=-1))

    def integral(self, rates: Callable[[FloatArray], FloatArray], edges: FloatArray, weights: FloatArray) -> Integral:
        """Return the cost of a motion and an estimate of its error.

        Parameters
        ----------
        rates : callable
            Maps r of shape (k,) to θ'(r) of shape (k, n).
        edges : array, shape (p + 1,)
            Panel ends to start from, including every break of the path.
        weights : array, shape (n,)

        Returns
        -------
        Integral
            ``error`` is the estimate of :mod:`selfmotion.quadrature`.
        """
        return integrate(lambda r: self.chord(rates(r), np.ones(len(r)), weights), edges)


class JointTravel(Objective):
    """The seed's joint angle travelling distance, (1a): ``Σ_i w_i ∫ √(1 + θ_i'²) dr``.

    Its floor is ``Σ w_i``, reached when nothing moves.
    """

    kind = "joint_travel"
    has_kinks = False

    @staticmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return ``Σ w_i √(Δr² + Δθ_i²)``."""
        step = np.asarray(dr, dtype=float)[..., None]
        length = dq * dq
        length += step * step
        return np.asarray(np.sqrt(length, out=length) @ weights)

    @staticmethod
    def smoothed(rates: FloatArray, weights: FloatArray, width: float) -> Smoothed:
        """Return ``Σ w_i √(1 + θ_i'²)``, which has no kinks."""
        return _rounded_modulus(rates, weights, 1.0)


class L1Travel(Objective):
    """Plain joint travel, ``Σ_i w_i ∫ |θ_i'| dr``: independent of how fast the path is run."""

    kind = "l1"
    has_kinks = True

    @staticmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return ``Σ w_i |Δθ_i|``."""
        return np.asarray(np.abs(dq) @ weights)

    @staticmethod
    def smoothed(rates: FloatArray, weights: FloatArray, width: float) -> Smoothed:
        """Return ``Σ w_i √(width² + θ_i'²)``."""
        return _rounded_modulus(rates, weights, width)


class L2Travel(Objective):
    """Length of the joint path, ``∫ ‖w∘θ'‖ dr``: each joint's travel counts w_i times."""

    kind = "l2"
    has_kinks = True

    @staticmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return ``√Σ (w_i Δθ_i)²``."""
        return np.asarray(np.sqrt((dq * dq) @ (weights * weights)))

    @staticmethod
    def smoothed(rates: FloatArray, weights: FloatArray, width: float) -> Smoothed:
        """Return ``√(width² + Σ (w_i θ_i')²)``."""
        squares = weights * weights
        value = np.sqrt(width * width + (rates * rates) @ squares)[:, None]
        gradient = squares * rates / value

        def times(v: FloatArray) -> FloatArray:
            return np.asarray((squares * v - gradient * (gradient * v).sum(axis=1, keepdims=True)) / value)

        return Smoothed(value[:, 0], gradient, (squares - gradient * gradient) / value, times, squares / value)


def _rounded_modulus(rates: FloatArray, weights: FloatArray, width: float) -> Smoothed:
    """Return ``Σ w_i √(width² + θ_i'²)`` with its derivatives."""
    length = np.sqrt(width * width + rates * rates)
    diagonal = weights * (width / length) ** 2 / length
    return Smoothed(
        length @ weights, weights * rates / length, diagonal, lambda v: np.asarray(diagonal * v), weights / length
    )


OBJECTIVES: dict[str, type[Objective]] = {objective.kind: objective for objective in (JointTravel, L1Travel, L2Travel)}
"""Every objective by its name in a problem file."""


def joint_weights(weights: ArrayLike | None, n: int) -> FloatArray:
    """Return `weights` as an array of n numbers ≥ 0, not all zero; all 1 if None.

    Parameters
    ----------
    weights : array_like, shape (n,), or None
    n : int
        Number of joints.

    Returns
    -------
    array, shape (n,)

    Raises
    ------
    InvalidInputError
        If there are not n, one is negative, or all are zero.
    """
    if weights is None:
        return np.ones(n)
    array = finite_array("weights", weights, 1, n)
    if (array < 0).any() or not array.any():
        raise InvalidInputError("weights", "must be ≥ 0 and not all zero", "give one weight per joint", weights)
    return array
