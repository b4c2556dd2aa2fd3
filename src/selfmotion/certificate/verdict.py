"""What a proof says to its reader, in one line."""

from __future__ import annotations

import math
from decimal import ROUND_CEILING, Decimal

from selfmotion.errors import InvalidInputError

_CONTRADICTION = 1e-9  # relative; a bound above the cost by less is rounding
_LEAST = 1e-12  # relative; nobody knows a cost better
_DIGITS = 2  # of the percentage
_SHOWN, _MOST_SHOWN = 5, 12  # digits of costs


def verdict(cost: float, cost_error: float, bound: float, reference: float | None = None, rigorous: bool = True) -> str:
    """Return what is proved of a motion, such as ``5.2775 → 4.8894, proved within 0.0085 % of the best possible``.

    Parameters
    ----------
    cost, cost_error : float
        Of the best motion known, and the error that its cost may have.
    bound : float
        What every motion costs at least.
    reference : float, optional
        The cost of another motion, to begin with.
    rigorous : bool
        Whether the bound is proved, not estimated.

    Returns
    -------
    str
        One line. Where nothing is proved it says so.

    Raises
    ------
    InvalidInputError
        If the bound is above the cost.
    """
    gap = proved_within(cost, cost_error, bound)
    digits = _SHOWN
    if math.isfinite(gap):
        digits = min(max(_SHOWN, math.ceil(-math.log10(gap))), _MOST_SHOWN)
    shown = f"{cost:#.{digits}g}" if reference is None else f"{reference:#.{_SHOWN}g} → {cost:#.{digits}g}"
    if not math.isfinite(gap):
        return f"{shown}, how far from the best possible is unknown"
    return f"{shown}, {'proved' if rigorous else 'estimated to be'} within {percent(gap)} of the best possible"


def proved_within(cost: float, cost_error: float, bound: float) -> float:
    """Return by which part of the best possible cost a motion costs more than that, at most.

    Parameters
    ----------
    cost, cost_error, bound : float
        As for :func:`verdict`.

    Returns
    -------
    float
        (cost + cost_error − bound)/bound, rounded up; infinite where nothing is proved.

    Raises
    ------
    InvalidInputError
        If the bound is above the cost.
    """
    most = cost + cost_error
    if not (math.isfinite(most) and math.isfinite(bound) and bound > 0.0):
        return math.inf
    if bound > most * (1.0 + _CONTRADICTION):
        raise InvalidInputError("bound", f"is above the cost, {cost:.9g}: one of them is wrong", value=bound)
    return max((most - bound) / bound * (1.0 + 1e-15) + 1e-15, _LEAST)


def percent(part: float) -> str:
    """Return a part as a percentage of two digits that is never too small, such as ``0.0085 %``.

    Parameters
    ----------
    part : float
        1 is all of it.

    Returns
    -------
    str
    """
    value = Decimal(part) * 100
    rounded = value.quantize(Decimal(1).scaleb(value.adjusted() - _DIGITS + 1), ROUND_CEILING).normalize()
    return f"{rounded:f} %"
