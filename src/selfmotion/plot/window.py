"""The turn of u that a picture shows: where it is cut open, and what of the angle domain lies in it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.angles import TAU, wrap
from selfmotion.arms import Cause
from selfmotion.domain.fibre import End
from selfmotion.domain.strips import Strip

_BINS = 720


class Window(NamedTuple):
    """The turn of u that is shown.

    Attributes
    ----------
    center : float
        Middle of the window [rad]; its seam is half a turn away.
    """

    center: float

    @classmethod
    def around(cls, shown: Sequence[Strip]) -> Window:
        """Return the window whose seam lies in the middle of where the strips reach least."""
        middles = (np.arange(_BINS) + 0.5) / _BINS * TAU - np.pi
        cover = np.zeros(_BINS)
        for strip in shown:
            inside = np.mod(middles[:, None] - strip.low, TAU) <= strip.high - strip.low
            cover += inside[:, 1:] @ np.diff(strip.r)
        lowest = cover <= cover.min() + 1e-9
        if lowest.all():
            return cls(0.0)
        # The middle of the longest run of least cover, on the circle.
        ends = np.flatnonzero(np.diff(np.concatenate([[0], lowest, lowest, [0]]).astype(int)))
        longest = int(np.argmax(ends[1::2] - ends[::2]))
        return cls(float(wrap(middles[(ends[2 * longest] + ends[2 * longest + 1]) // 2 % _BINS] + np.pi)))

    def wrapped(self, u: FloatArray) -> FloatArray:
        """Return each direction in the window."""
        return wrap(u - self.center) + self.center

    def near(self, u: FloatArray) -> FloatArray:
        """Return directions `u` moved by whole turns into the window, as one continuous curve."""
        lifted = np.unwrap(u)
        return np.asarray(lifted - TAU * np.rint((np.mean(lifted) - self.center) / TAU))

    def copies(self, strip: Strip) -> list[tuple[FloatArray, FloatArray]]:
        """Return the strip's (low, high) cut at the seam: more than one pair where it crosses that."""
        if strip.is_circle:
            return [(np.full(len(strip.r), self.center - np.pi), np.full(len(strip.r), self.center + np.pi))]
        bottom, top = self.center - np.pi, self.center + np.pi
        first, last = np.ceil((bottom - strip.high.max()) / TAU), np.floor((top - strip.low.min()) / TAU)
        return [
            (np.clip(strip.low + turn, bottom, top), np.clip(strip.high + turn, bottom, top))
            for turn in TAU * np.arange(first, last + 1)
        ]

    def boundary(self, shown: Sequence[Strip]) -> list[tuple[tuple[Cause, ...], FloatArray, FloatArray]]:
        """Return what bounds the strips as curves (causes, r, u), NaN where one is interrupted; the seam is none."""
        parts: dict[End, dict[float, tuple[FloatArray, FloatArray]]] = {}
        causes = {}
        for strip in shown:
            for end, why, u in zip(strip.ends, strip.causes, (strip.low, strip.high), strict=True):
                if end:  # the end of two strips, where it is one, is drawn once
                    parts.setdefault(end, {})[float(strip.r[0])] = strip.r, self.wrapped(u)
                    causes[end] = why
        return [(causes[end], *self._cut(*_joined(list(mine.values())))) for end, mine in parts.items()]

    def _cut(self, r: FloatArray, u: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return a curve that leaps from one side of the window to the other as one that leaves and comes back."""
        step = np.diff(u)
        leaps = np.flatnonzero(np.abs(step) > np.pi)
        side = -np.sign(step[leaps])
        seam = self.center + side * np.pi
        part = (seam - u[leaps]) / (step[leaps] + side * TAU)
        at, nothing = r[leaps] + part * np.diff(r)[leaps], np.full(len(leaps), np.nan)
        place = np.repeat(leaps + 1, 3)
        return (
            np.insert(r, place, np.column_stack([at, nothing, at]).ravel()),
            np.insert(u, place, np.column_stack([seam, nothing, seam - side * TAU]).ravel()),
        )


def _joined(parts: list[tuple[FloatArray, FloatArray]]) -> tuple[FloatArray, FloatArray]:
    """Return curves (r, u) as one, with NaN where the next does not begin at the end of the last."""
    rows: list[tuple[FloatArray, FloatArray]] = []
    for r, u in parts:
        if rows and rows[-1][0][-1] != r[0]:
            rows.append((np.array([np.nan]), np.array([np.nan])))
        rows.append((r, u))
    r, u = (np.concatenate(row) for row in zip(*rows, strict=True))
    return r, u
