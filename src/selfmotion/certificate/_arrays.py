"""Cells and the values on them as plain arrays, which kernels are handed together."""

from __future__ import annotations

from typing import NamedTuple

from selfmotion._types import FloatArray, IntArray


class Arcs(NamedTuple):
    """m cells: posture ``(1 − s) a + s b + ½ s (1 − s) bow + e``, |e| ≤ rest, within dev of the chord; all (m, n)."""

    a: FloatArray
    b: FloatArray
    bow: FloatArray
    dev: FloatArray
    rest: FloatArray


class Values(NamedTuple):
    """A value function on m cells: proposed values at both ends, how they sag between, slopes, and what is not proved.

    The cost of every motion that arrives at posture ``(1 − s) a + s b + ½ s (1 − s) bow + e`` of cell k is at least
    ``(1 − s) v[k, 0] + s v[k, 1] − ½ sag[k] s (1 − s) + g[k]·e − lost[k]``.
    """

    v: FloatArray
    sag: FloatArray
    g: FloatArray
    lost: FloatArray

    def of(self, rows: IntArray | slice) -> Values:
        """Return the values on some of the cells."""
        return Values(self.v[rows], self.sag[rows], self.g[rows], self.lost[rows])


class Boxes(NamedTuple):
    """Boxes around cells, or around some of them together: middle ± room, both (k, n).

    No value that is proposed in a box is less than `lowest`, and none that is proved less than −`deepest`, both (k,).
    """

    middle: FloatArray
    room: FloatArray
    lowest: FloatArray
    deepest: FloatArray
