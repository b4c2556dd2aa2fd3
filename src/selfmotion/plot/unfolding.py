"""A chart of the whole angle domain: both elbows unfolded along the self-motion, glued where they meet at folds."""

from __future__ import annotations

from functools import cached_property
from typing import Literal, NamedTuple

import numpy as np

from selfmotion._types import FloatArray, IntArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause
from selfmotion.domain import AngleDomain
from selfmotion.domain.strips import Strip, strips
from selfmotion.plot.window import Window

_GRID = 2001
_SHIFT = 1.08 * TAU  # from one elbow to the other where they cannot be glued [rad]
_JUMP = 1.0  # a curve that moves farther from one place to the next has jumped [rad]
_TICKS = {-np.pi: "−π", -np.pi / 2: "−π/2", 0.0: "0", np.pi / 2: "π/2", np.pi: "π"}


class Part(NamedTuple):
    """A part of the domain in the chart.

    Attributes
    ----------
    r, low, high : array, shape (k,)
    edges : tuple of array, shape (k,)
        `low` and `high` where the domain ends there, NaN where it goes on in the chart or beyond its seam.
    """

    r: FloatArray
    low: FloatArray
    high: FloatArray
    edges: tuple[FloatArray, FloatArray]


class _Folds(NamedTuple):
    """The two folds of a kind between which a self-motion goes to and fro, along the whole path.

    Attributes
    ----------
    cause : Cause
    r : array, shape (k,)
    middle : array, shape (k,)
        Direction in the middle between them, continuous [rad].
    """

    cause: Cause
    r: FloatArray
    middle: FloatArray


class Unfolding:
    """Ordinates for postures of both elbows.

    Parameters
    ----------
    domain : AngleDomain
        Of an arm with two branches.

    Attributes
    ----------
    used : tuple of int
        The branches with something feasible.
    kind : {"one", "around", "apart"}
        Of one elbow the ordinate is u. Two elbows that meet at folds on both sides of a middle m, along the whole path,
        are unfolded: u = m + a sin s, where a is the distance of the folds, with s from −π/2 to π/2 on the positive
        elbow and beyond on the negative one; s = π and s = −π are the same posture. Otherwise the negative elbow is put
        above the positive one.
    """

    def __init__(self, domain: AngleDomain) -> None:
        self._domain = domain = domain.unconstrained
        self._strips = {branch: strips(domain.structure, branch) for branch in range(len(domain.self_motion.branches))}
        self.used = tuple(branch for branch, shown in self._strips.items() if shown)
        both = len(self.used) == 2
        self.kind: Literal["one", "around", "apart"] = "one" if not both else "around" if self._folds else "apart"

    @cached_property
    def _folds(self) -> _Folds | None:
        r = np.linspace(0.0, 1.0, _GRID)
        for value in (0.0, np.pi):
            cause = Cause("fold", 1, value)
            middle, half = self._between(r, cause)
            if np.isfinite(half).all() and half.min() > 0.0:
                return _Folds(cause, r, np.unwrap(middle))
        return None

    @cached_property
    def _window(self) -> Window:
        return Window.around([strip for shown in self._strips.values() for strip in shown])

    def _between(self, r: FloatArray, cause: Cause) -> tuple[FloatArray, FloatArray]:
        """Return the middle between both folds of a kind and how far they are from it, NaN where they are not."""
        motion = self._domain.self_motion
        found = motion.breakpoints(motion.pose(self._domain.path(r)))
        columns = [k for k, one in enumerate(found.causes) if one == cause]
        markers = [k for k, one in enumerate(found.causes) if one.kind == "marker"]
        if len(columns) != 2 or not markers:
            return np.zeros(len(r)), np.full(len(r), np.nan)
        middle = found.u[:, markers[0]] + (np.pi if cause.value else 0.0)
        return middle, np.abs(wrap(found.u[:, columns[0]] - middle))

    def _frame(self, r: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the middle, continuous along the path, and the distance of the folds."""
        assert self._folds is not None
        middle, half = self._between(r, self._folds.cause)
        near = np.interp(r, self._folds.r, self._folds.middle)
        return middle + TAU * np.rint((near - middle) / TAU), half

    def ordinate(self, r: FloatArray, u: FloatArray, branch: IntArray) -> FloatArray:
        """Return the ordinates of postures, all of shape (k,)."""
        if self._folds is None:
            return self._window.wrapped(u) + self._above * (branch == 1)
        middle, half = self._frame(r)
        v = wrap(u - middle)
        if self.kind == "one":
            return np.asarray(middle + v)
        s = _angle(v, half)
        return np.where(branch == 1, np.copysign(np.pi, v) - s, s)

    @property
    def _above(self) -> float:
        return _SHIFT if self.kind == "apart" else 0.0

    def curve(self, r: FloatArray, u: FloatArray, branch: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return a dense motion as a curve (r, y), interrupted where the chart is cut."""
        y = self.ordinate(r, u, branch)
        place: list[int] = []
        rows: list[float] = []
        values: list[float] = []
        for k in np.flatnonzero(np.abs(np.diff(y)) > _JUMP).tolist():
            around = self.kind == "around" and abs(y[k + 1] - y[k]) > np.pi
            at, side = 0.5 * (r[k] + r[k + 1]), np.copysign(np.pi, y[k])
            place += [k + 1] * (3 if around else 1)
            rows += [at, np.nan, at] if around else [np.nan]
            values += [side, np.nan, -side] if around else [np.nan]
        return np.insert(r, place, rows), np.insert(y, place, values)

    def cut(self, ends: FloatArray) -> FloatArray:
        """Return short intervals between ordinates (k, 2), more than k where the chart cuts one."""
        torn = np.abs(ends[:, 1] - ends[:, 0]) > _JUMP
        pieces = [ends[~torn]]
        for one in ends[torn]:
            around = self.kind == "around" and abs(one[1] - one[0]) > np.pi
            pieces.append(np.array([[y, np.copysign(np.pi, y) if around else y] for y in one]))
        return np.vstack(pieces)

    def ticks(self) -> tuple[list[float], list[str]]:
        """Return ordinates and their names, nothing where they are plain values of u."""
        if self.kind == "around":
            return list(_TICKS), list(_TICKS.values())
        if self.kind == "one":
            return [], []
        bottom = self._window.center - np.pi
        u = [t for t in range(int(np.ceil(bottom)), int(np.floor(bottom + TAU)) + 1) if t % 2 == 0]
        return [t + shift for shift in (0.0, self._above) for t in u], [f"{t}".replace("-", "−") for t in u] * 2

    def names(self) -> dict[float, str]:
        """Return where in the chart the elbows are, nothing for a single one."""
        if self.kind == "around":
            return {-0.75 * np.pi: "negative", 0.0: "positive elbow", 0.75 * np.pi: "negative"}
        if self.kind == "one":
            return {}
        return {self._window.center: "positive elbow", self._window.center + self._above: "negative elbow"}

    def parts(self) -> list[Part]:
        """Return the domain in the chart, without constraints beyond joint limits."""
        return [
            part for branch, shown in self._strips.items() for strip in shown for part in self.placed(strip, branch)
        ]

    def placed(self, strip: Strip, branch: int) -> list[Part]:
        """Return a strip of a branch in the chart."""
        put = {"one": self._plain if self._folds else self._shifted, "around": self._around, "apart": self._shifted}
        return put[self.kind](strip, branch)

    def _shifted(self, strip: Strip, branch: int) -> list[Part]:
        shift, (bottom, top) = self._above * (branch == 1), self._window.center + np.array([-np.pi, np.pi])
        parts = []
        for low, high in self._window.copies(strip):
            edges = [np.where((y > bottom) & (y < top), y + shift, np.nan) for y in (low, high)]
            parts.append(Part(strip.r, low + shift, high + shift, (edges[0], edges[1])))
        return parts

    def _plain(self, strip: Strip, _: int) -> list[Part]:
        low, high, moved = self._placed(strip)[:3]
        return [Part(strip.r, low + moved, high + moved, (low + moved, high + moved))]

    def _around(self, strip: Strip, branch: int) -> list[Part]:
        low, high, _, half = self._placed(strip)
        assert self._folds is not None
        low_edge, high_edge = (
            np.where(self._folds.cause in causes, np.nan, v)
            for causes, v in zip(strip.causes, (low, high), strict=True)
        )
        if branch == 0:
            edges = _angle(low_edge, half), _angle(high_edge, half)
            return [Part(strip.r, _angle(low, half), _angle(high, half), edges)]
        parts = []
        for side in (1.0, -1.0):
            least, most = (low.clip(0), high.clip(0)) if side > 0 else (low.clip(None, 0), high.clip(None, 0))
            if (most > least).any():
                lower, upper = (side * np.pi - _angle(v, half) for v in (most, least))
                one, other = (
                    side * np.pi - _angle(np.where(side * v > 0, v, np.nan), half) for v in (high_edge, low_edge)
                )
                parts.append(Part(strip.r, lower, upper, (one, other)))
        return parts

    def _placed(self, strip: Strip) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the ends of a strip from the middle between the folds, that middle, and the distance of the folds."""
        middle, half = self._frame(strip.r)
        inside = 0.5 * (strip.low + strip.high) - middle
        turn = TAU * np.rint(inside[len(inside) // 2] / TAU)
        return strip.low - turn - middle, strip.high - turn - middle, middle, half


def _angle(v: FloatArray, half: FloatArray) -> FloatArray:
    return np.asarray(np.arcsin(np.clip(v / half, -1.0, 1.0)))
