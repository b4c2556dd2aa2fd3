"""A curve u(r) moved by hand: a B-spline all of whose coefficients are free, on one branch."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from selfmotion._checks import branch_index, finite_array
from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.arms.protocols import RedundantArm, u_period
from selfmotion.errors import InvalidInputError
from selfmotion.profiles import BSplineProfile, ProfileCurve
from selfmotion.studio.place import Place, Tell
from selfmotion.studio.problems import problem_of
from selfmotion.studio.wire import unpacked

FEWEST, MOST = 8, 200
"""Coefficients of a component."""
_COUNTS = (8, 10, 12, 16, 20, 24, 32, 40, 48, 64, 80, 96, 128, 160, 200)
_NEAR = 5e-3  # how near a curve shall follow its samples [rad]
_GAP = 1 / 200  # between samples, beyond which they are taken to be joined by a line
_FURTHEST = 1e3  # [rad], as everywhere


class Hand(NamedTuple):
    """A curve made by hand.

    Attributes
    ----------
    curve : ProfileCurve
        Of the family ``bspline`` with all coefficients free.
    branch : int
    """

    curve: ProfileCurve
    branch: int

    @property
    def cycles(self) -> float:
        """How many oscillations it can make at most."""
        return self.curve.profile.cycles(self.curve.a)


def hand_of(arm: RedundantArm, data: Any) -> Hand:
    """Return the curve that ``{branch, coefficients}`` describes.

    Raises
    ------
    InvalidInputError
        If it does not fit the arm.
    """
    if not isinstance(data, dict):
        raise InvalidInputError("hand", "is not a mapping", "give branch and coefficients")
    branch = branch_of(arm, data.get("branch"), "hand.branch")
    rows = finite_array("hand.coefficients", unpacked("hand.coefficients", data.get("coefficients")), 2)
    if len(rows) != arm.n_u or not FEWEST <= rows.shape[1] <= MOST:
        reason = f"has shape {rows.shape}"
        raise InvalidInputError("hand.coefficients", reason, f"give {arm.n_u} rows of {FEWEST} to {MOST} numbers")
    if np.abs(rows).max() > _FURTHEST:
        raise InvalidInputError("hand.coefficients", "exceeds 1000 rad", "give angles in radians")
    return Hand(ProfileCurve(BSplineProfile(arm.n_u, rows.shape[1]), rows.ravel()), branch)


def hand_object(arm: RedundantArm, branch: int, coefficients: FloatArray) -> dict[str, Any]:
    """Return a curve by hand as plain data; coefficients (n_u, m)."""
    return {"branch": arm.branches[branch], "coefficients": coefficients.tolist()}


def branch_of(arm: RedundantArm, value: Any, field: str) -> int:
    """Return the index of a branch given by its name or index; what is wrong is said of `field`."""
    try:
        return branch_index(arm.branches, value)
    except InvalidInputError as error:
        raise InvalidInputError(field, error.reason, error.remedy, error.value) from None


def fit(payload: dict[str, Any], tell: Tell, place: Place) -> dict[str, Any]:
    """Return the coefficients whose curve follows samples ``r``, ``u`` on a ``branch``, and how far off it is.

    Of several counts of coefficients the smallest is taken that is within 5e-3 rad of all samples, else the nearest.
    """
    arm = problem_of(payload.get("problem"), place.folder).problem.arm
    branch = branch_of(arm, payload.get("branch"), "branch")
    r = finite_array("r", unpacked("r", payload.get("r")), 1)
    u = finite_array("u", unpacked("u", payload.get("u")), 2, arm.n_u)
    if len(r) != len(u) or len(r) < 2:
        raise InvalidInputError("u", f"has {len(u)} rows for {len(r)} places", "give one for each r, two or more")
    if r.min() < 0.0 or r.max() > 1.0:
        raise InvalidInputError("r", "leaves [0, 1]", "give path parameters")
    r, first = np.unique(r, return_index=True)
    u = u[first]
    if u_period(arm) == TAU:
        u = np.unwrap(u, axis=0)
    coefficients, off = fitted(r, u)
    return {"hand": hand_object(arm, branch, coefficients), "off": off}


def fitted(r: FloatArray, u: FloatArray) -> tuple[FloatArray, float]:
    """Return coefficients (n_u, m) of a B-spline that follows samples u (k, n_u) at r (k,), and how far off it is.

    It begins and ends exactly where they do: a start that a problem gives is kept.
    """
    even = np.linspace(0.0, 1.0, 4 * MOST + 1)
    after = np.clip(np.searchsorted(r, even), 1, len(r) - 1) if len(r) > 1 else np.zeros(len(even), int)
    wide = (r[after] - r[after - 1] > _GAP) | (even < r[0]) | (even > r[-1])
    places = np.union1d(r, even[wide])
    values = np.stack([np.interp(places, r, column) for column in u.T], axis=-1)
    best: tuple[FloatArray, float] | None = None
    for count in _COUNTS:
        profile = BSplineProfile(u.shape[1], count)
        functions, ends = profile.functions(places, 0), values[[0, -1]]
        inner = np.linalg.lstsq(functions[:, 1:-1], values - functions[:, [0, -1]] @ ends, rcond=None)[0]
        found = np.vstack([ends[:1], inner, ends[1:]])
        off = float(np.abs(profile.functions(r, 0) @ found - u).max())
        if best is None or off < best[1]:
            best = found.T, off
        if off <= _NEAR:
            break
    assert best is not None
    return best
