"""Clamped cubic B-splines: curves of local shape, with a start and an end that may be fixed or free."""

from __future__ import annotations

from typing import Any

import numpy as np

from selfmotion._checks import angles, integer, read_only
from selfmotion._types import FloatArray, Vector
from selfmotion.profiles.linear import LinearProfile

_DEGREE = 3
FEWEST_COEFFICIENTS, MOST_COEFFICIENTS = _DEGREE + 1, 500


class BSplineProfile(LinearProfile):
    """The curves ``u_j(r) = Σ_i c_ji B_i(r)``, i = 1…m, with cubic B-splines B_i on uniform clamped knots.

    Parameters
    ----------
    n_u : int
        Number of components of u.
    coefficients : int
        Number m of coefficients of a component, the fixed ones too; at least 4. The curve has m − 3 cubic pieces.
    offset : array_like, shape (n_u,), optional
        The redundancy vector at r = 0 [rad], which is c_1; by default it is free.
    end : array_like, shape (n_u,), optional
        The redundancy vector at r = 1 [rad], which is c_m; by default it is free.

    Raises
    ------
    InvalidInputError
        If offset or end have another length than n_u, or a number is out of its range.

    Notes
    -----
    The B_i are not negative and sum to 1 (C. de Boor, *A Practical Guide to Splines*, 1978, chapter IX): a curve never
    leaves the range of its coefficients, and swings across a level no more often than they do.
    """

    kind = "bspline"

    def __init__(self, n_u: int, coefficients: int, offset: Vector | None = None, end: Vector | None = None) -> None:
        n_u = integer("n_u", n_u, 1, 1000)
        self.count = integer("coefficients", coefficients, FEWEST_COEFFICIENTS, MOST_COEFFICIENTS)
        self.offset = None if offset is None else read_only(angles("offset", offset, n_u))
        self._end = None if end is None else read_only(angles("end", end, n_u))
        ends = {0: self.offset, self.count - 1: self._end}
        fixed = {k: value for k, value in ends.items() if value is not None}
        super().__init__(tuple(f"c{i + 1}" for i in range(self.count)), fixed, n_u)
        inner = np.linspace(0.0, 1.0, self.count - _DEGREE + 1)
        self.knots = read_only(np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)]))

    @property
    def start(self) -> FloatArray | None:
        """The offset, where every curve starts if it is fixed."""
        return self.offset

    @property
    def end(self) -> FloatArray | None:
        """The redundancy vector at r = 1 if it is fixed."""
        return self._end

    def settings(self) -> dict[str, Any]:
        """Return the number of coefficients, offset and end."""
        ends = {"offset": self.offset, "end": self._end}
        return {"coefficients": self.count, **{k: v.tolist() for k, v in ends.items() if v is not None}}

    def cycles(self, a: FloatArray) -> float:
        """Return the most oscillations that m coefficients can make."""
        return (self.count - 1) / 2

    def functions(self, r: FloatArray, order: int) -> FloatArray:
        """Return the B_i or their derivatives, shape (k, m)."""
        from scipy.interpolate import BSpline

        return np.asarray(BSpline(self.knots, np.eye(self.count), _DEGREE)(r, nu=order))

    def box(self, span: FloatArray) -> FloatArray:
        """Return offset ± span for every free coefficient; ±span without an offset.

        Parameters
        ----------
        span : array, shape (n_u,)
            Half-widths [rad].

        Returns
        -------
        array, shape (d, 2)
        """
        centre = np.zeros(self.n_u) if self.offset is None else self.offset
        rows = np.stack([centre - span, centre + span], axis=-1)
        return np.repeat(rows, len(self.free), axis=0)
