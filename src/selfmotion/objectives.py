"""What a motion costs: joint travel (1a), and plain travel in the l1 and l2 sense.

Each objective is a density c(θ', 1) that is integrated, and the same convex function c(Δθ, Δr) of a chord,
``c(h θ', h) = h c(θ', 1)``. An arc costs at least its chord, so the chord sum over samples never exceeds the integral.

A new objective is one class and one line in `OBJECTIVES`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.quadrature import Integral, integrate


class Objective(ABC):
    """A cost of joint motions that is convex and positively homogeneous in (Δθ, Δr)."""

    kind: ClassVar[str]

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

    @staticmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return ``Σ w_i √(Δr² + Δθ_i²)``."""
        step = np.asarray(dr, dtype=float)[..., None]
        length = dq * dq
        length += step * step
        return np.asarray(np.sqrt(length, out=length) @ weights)


class L1Travel(Objective):
    """Plain joint travel, ``Σ_i w_i ∫ |θ_i'| dr``: independent of how fast the path is run."""

    kind = "l1"

    @staticmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return ``Σ w_i |Δθ_i|``."""
        return np.asarray(np.abs(dq) @ weights)


class L2Travel(Objective):
    """Length of the joint path, ``∫ ‖w∘θ'‖ dr``: each joint's travel counts w_i times."""

    kind = "l2"

    @staticmethod
    def chord(dq: FloatArray, dr: ArrayLike, weights: FloatArray) -> FloatArray:
        """Return ``√Σ (w_i Δθ_i)²``."""
        return np.asarray(np.sqrt((dq * dq) @ (weights * weights)))


OBJECTIVES: dict[str, type[Objective]] = {objective.kind: objective for objective in (JointTravel, L1Travel, L2Travel)}
"""Every objective by its name in a problem file."""


def joint_weights(weights: ArrayLike | None, n: int) -> FloatArray:
    """Return `weights` as an array of n numbers ≥ 0, not all zero; all 1 if None."""
    if weights is None:
        return np.ones(n)
    array = finite_array("weights", weights, 1, n)
    if (array < 0).any() or not array.any():
        raise InvalidInputError("weights", "must be ≥ 0 and not all zero", "give one weight per joint", weights)
    return array
