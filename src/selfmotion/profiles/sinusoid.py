"""The sinusoid of the seed's paper, equation (22)."""

from __future__ import annotations

from typing import Any

import numpy as np

from selfmotion._checks import angles, read_only
from selfmotion._types import FloatArray, Vector
from selfmotion.errors import InvalidInputError
from selfmotion.profiles.base import Profile


class SinusoidProfile(Profile):
    """The curves ``u_j(r) = offset_j + amplitude_j sin(2π f_j r)``, (22), chosen by their frequencies f.

    Parameters
    ----------
    offset : array_like, shape (n_u,)
        The redundancy vector at r = 0, θ_gi [rad].
    amplitude : array_like, shape (n_u,)
        A [rad].

    Raises
    ------
    InvalidInputError
        If the two differ in length, or all amplitudes are zero.
    """

    kind = "sinusoid"

    def __init__(self, offset: Vector, amplitude: Vector) -> None:
        self.offset = read_only(angles("offset", offset))
        self.amplitude = read_only(angles("amplitude", amplitude, len(self.offset)))
        if not self.amplitude.any():
            raise InvalidInputError(
                "amplitude", "is zero: no frequency changes the curve", "give at least one amplitude", amplitude
            )

    @property
    def n_u(self) -> int:
        """Number of components of u."""
        return len(self.offset)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """``("f",)``, or ``("f1", "f2", …)`` for several components."""
        return ("f",) if self.n_u == 1 else tuple(f"f{j + 1}" for j in range(self.n_u))

    @property
    def start(self) -> FloatArray:
        """The offset, where every sinusoid starts."""
        return self.offset

    def settings(self) -> dict[str, Any]:
        """Return offset and amplitude."""
        return {"offset": self.offset.tolist(), "amplitude": self.amplitude.tolist()}

    def cycles(self, a: FloatArray) -> float:
        """Return the largest frequency."""
        return float(np.abs(a).max())

    def _evaluate(self, a: FloatArray, r: FloatArray, order: int) -> FloatArray:
        rate = 2 * np.pi * a[..., None, :]
        phase = rate * r[:, None]
        if order == 0:
            return self.offset + self.amplitude * np.sin(phase)
        return self.amplitude * rate * np.cos(phase)
