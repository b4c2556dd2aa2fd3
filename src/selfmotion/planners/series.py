"""Planners whose profiles are sums of given functions: harmonics and B-splines, for any number of redundant degrees."""

from __future__ import annotations

from abc import abstractmethod

from selfmotion._checks import angles, integer
from selfmotion._types import FloatArray, Vector
from selfmotion.angles import wrap
from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import Optimizer
from selfmotion.planners.base import refuse_own_bounds
from selfmotion.planners.candidates import Ranking
from selfmotion.planners.parametric import Parametric
from selfmotion.problem import Problem
from selfmotion.profiles import BSplineProfile, HarmonicsProfile, LinearProfile, Profile
from selfmotion.profiles.bspline import FEWEST_COEFFICIENTS, MOST_COEFFICIENTS
from selfmotion.profiles.harmonics import MOST_HARMONICS


class Series(Parametric):
    """Chooses the coefficients of a linear family in a box of half-width `span`.

    Parameters
    ----------
    offset : array_like, shape (n_u,), or None
    span : array_like, shape (n_u,)
        Positive [rad].
    optimizer : Optimizer
        Without bounds of its own.
    ranking : {"integral", "samples"}
    """

    vectors = ("offset", "span")

    def __init__(self, offset: Vector | None, span: Vector, optimizer: Optimizer, ranking: Ranking) -> None:
        super().__init__(optimizer, ranking)
        refuse_own_bounds(optimizer, self.kind, "span")
        self.span = angles("span", span)
        if not (self.span > 0).all():
            raise InvalidInputError("span", "must be greater than zero", "give half-widths in radians", span)
        self.offset = None if offset is None else angles("offset", offset)

    @abstractmethod
    def profile_for(self, problem: Problem) -> LinearProfile:
        """Return the profile family to search for this problem."""

    def optimizer_for(self, profile: Profile) -> Optimizer:
        """Return the optimizer with the family's box as its bounds."""
        assert isinstance(profile, LinearProfile)
        return self.optimizer.with_bounds(profile.box(self.span))

    def _ends(self, problem: Problem) -> tuple[FloatArray | None, FloatArray | None]:
        """Return u(0) and u(1) as far as they are given, the second within π of the first."""
        given = None if problem.start is None else problem.start.u
        start = given if self.offset is None else self.offset
        end = None if problem.end is None else problem.end.u
        return start, end if start is None or end is None else start + wrap(end - start)


class Harmonics(Series):
    """A straight line plus a sine series, ``u_j(r) = offset_j + travel_j r + Σ_k a_jk sin(π k r)``.

    Parameters
    ----------
    offset : array_like, shape (n_u,), optional
        The redundancy vector at r = 0 [rad]; by default that of the problem's start.
    span : array_like, shape (n_u,)
        Half-widths of the box [rad]: ``travel_j`` is searched in ±span_j, ``a_jk`` in ±span_j / k.
    harmonics : int
        Number of sines, from 1 to 200.
    optimizer : Optimizer
        Searches travel and a; its ``bounds`` must be left out, for `span` sets them.
    ranking : {"integral", "samples"}
        What candidates are ranked by, the integral or the chord sum over the problem's samples.

    Raises
    ------
    InvalidInputError
        If a number is out of its range, or the optimizer has bounds of its own.

    Notes
    -----
    A problem's ``end: {u: …}`` is kept: it fixes the travel, to the turn of the end that is nearest to the offset.
    """

    kind = "harmonics"
    slower = "lower planner.harmonics"

    def __init__(
        self,
        offset: Vector | None = None,
        *,
        span: Vector,
        harmonics: int = 5,
        optimizer: Optimizer,
        ranking: Ranking = "integral",
    ) -> None:
        super().__init__(offset, span, optimizer, ranking)
        self.harmonics = integer("harmonics", harmonics, 1, MOST_HARMONICS)

    def profile_for(self, problem: Problem) -> HarmonicsProfile:
        """Return the curves that start at the offset and end where the problem says, if it does."""
        start, end = self._ends(problem)
        if start is None:
            raise InvalidInputError("planner.offset", "is missing", "give it, or a start")
        return HarmonicsProfile(start, self.harmonics, end)


class BSpline(Series):
    """Clamped cubic B-splines, ``u_j(r) = Σ_i c_ji B_i(r)``, whose start may be free.

    Parameters
    ----------
    offset : array_like, shape (n_u,), optional
        The redundancy vector at r = 0 [rad]; by default that of the problem's start. Without either the start is free.
    span : array_like, shape (n_u,)
        Half-widths of the box [rad]: every ``c_ji`` is searched in offset_j ± span_j, in ±span_j if the start is free.
    coefficients : int
        Number of coefficients of a component, from 4 to 500; those fixed by a given start or end count.
    optimizer : Optimizer
        Searches the coefficients; its ``bounds`` must be left out, for `span` sets them.
    ranking : {"integral", "samples"}
        What candidates are ranked by, the integral or the chord sum over the problem's samples.

    Raises
    ------
    InvalidInputError
        If a number is out of its range, or the optimizer has bounds of its own.

    Notes
    -----
    A problem's ``end: {u: …}`` is kept: it fixes the last coefficient, to the turn of the end that is nearest to the
    offset.
    """

    kind = "bspline"
    slower = "lower planner.coefficients"

    def __init__(
        self,
        offset: Vector | None = None,
        *,
        span: Vector,
        coefficients: int = 8,
        optimizer: Optimizer,
        ranking: Ranking = "integral",
    ) -> None:
        super().__init__(offset, span, optimizer, ranking)
        self.coefficients = integer("coefficients", coefficients, FEWEST_COEFFICIENTS, MOST_COEFFICIENTS)

    def profile_for(self, problem: Problem) -> BSplineProfile:
        """Return the splines with the start and the end that are given."""
        return BSplineProfile(problem.arm.n_u, self.coefficients, *self._ends(problem))
