"""A straight line plus a sine series: the Fourier form of any smooth curve with a given start."""

from __future__ import annotations

from typing import Any

import numpy as np

from selfmotion._checks import angles, integer, read_only
from selfmotion._types import FloatArray, Vector
from selfmotion.errors import InvalidInputError
from selfmotion.profiles.linear import LinearProfile

MOST_HARMONICS = 200


class HarmonicsProfile(LinearProfile):
    """The curves ``u_j(r) = offset_j + travel_j r + Σ_k a_jk sin(π k r)``, k = 1…m, chosen by travel and amplitudes a.

    Parameters
    ----------
    offset : array_like, shape (n_u,)
        The redundancy vector at r = 0 [rad].
    harmonics : int
        Number m of sines; the fastest makes m/2 oscillations.
    end : array_like, shape (n_u,), optional
        The redundancy vector at r = 1 [rad]; it fixes ``travel = end − offset``.

    Raises
    ------
    InvalidInputError
        If offset and end differ in length, or `harmonics` is not a whole number from 1 to 200.

    Notes
    -----
    The base frequency 1/2 and the straight line leave the end free: a series of period 1 would come back to the start.
    What remains when the line is taken off is zero at both ends, so the sines of a smooth curve fall off as k⁻³;
    M. L. Nagurka, V. Yen, *Fourier-based optimal control of nonlinear dynamic systems* (1990) add such a polynomial
    for the same reason. The sinusoid (22) with frequency f = k/2 is a member.
    """

    kind = "harmonics"

    def __init__(self, offset: Vector, harmonics: int, end: Vector | None = None) -> None:
        self.offset = read_only(angles("offset", offset))
        if not len(self.offset):
            raise InvalidInputError("offset", "is empty", "give one number per redundant degree")
        self._end = None if end is None else read_only(angles("end", end, len(self.offset)))
        self.harmonics = integer("harmonics", harmonics, 1, MOST_HARMONICS)
        fixed = {0: self.offset} if self._end is None else {0: self.offset, 1: self._end - self.offset}
        names = ("offset", "travel", *(f"a{k}" for k in range(1, self.harmonics + 1)))
        super().__init__(names, fixed, len(self.offset))

    @property
    def start(self) -> FloatArray:
        """The offset, where every curve starts."""
        return self.offset

    @property
    def end(self) -> FloatArray | None:
        """The redundancy vector at r = 1 if it is fixed."""
        return self._end

    def settings(self) -> dict[str, Any]:
        """Return offset, number of harmonics and end."""
        end = {} if self._end is None else {"end": self._end.tolist()}
        return {"offset": self.offset.tolist(), "harmonics": self.harmonics, **end}

    def cycles(self, a: FloatArray) -> float:
        """Return the oscillations of the fastest sine, whatever its amplitude."""
        return self.harmonics / 2

    def functions(self, r: FloatArray, order: int) -> FloatArray:
        """Return 1, r and sin(π k r), or their derivatives, shape (k, 2 + m)."""
        rate = np.pi * np.arange(1, self.harmonics + 1)
        phase = r[:, None] * rate
        one, zero = np.ones((len(r), 1)), np.zeros((len(r), 1))
        if order == 0:
            return np.hstack([one, r[:, None], np.sin(phase)])
        return np.hstack([zero, one, rate * np.cos(phase)])

    def box(self, span: FloatArray) -> FloatArray:
        """Return ±span for the travel and ±span/k for the k-th amplitude, which keeps every sine's rate inside ±π span.

        Parameters
        ----------
        span : array, shape (n_u,)
            Half-widths [rad].

        Returns
        -------
        array, shape (d, 2)
        """
        widths = 1.0 / np.arange(1, self.harmonics + 1)
        if self._end is None:
            widths = np.append(1.0, widths)
        half = np.outer(span, widths).ravel()
        return np.stack([-half, half], axis=-1)
