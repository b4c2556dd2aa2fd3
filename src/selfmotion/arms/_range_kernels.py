"""Kernels that reckon with ranges, pairs of bounds rounded outwards, and with angles of joints in them."""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray
from selfmotion.arms._jet_kernels import (
    Range,
    down,
    range_angle,
    range_cosine_sine,
    range_product,
    range_quotient,
    range_square,
    range_sum,
    up,
)

TAU = 2 * np.pi
_WIDEST = 4.0  # box of a joint beyond which the turn of the middle is not looked for


@kernel
def wrap(angle: float) -> float:
    """Return the angle in [−π, π]."""
    return angle - TAU * np.rint(angle / TAU)


@kernel
def opposite(angle: float) -> float:
    """Return angle ± π in [−π, π]."""
    return angle - np.pi if angle > 0.0 else angle + np.pi


@kernel
def plus(x: Range, y: Range) -> Range:
    """Return the range of x + y."""
    return range_sum(x[0], x[1], y[0], y[1])


@kernel
def less(x: Range, y: Range) -> Range:
    """Return the range of x − y."""
    return range_sum(x[0], x[1], -y[1], -y[0])


@kernel
def product(x: Range, y: Range) -> Range:
    """Return the range of x y."""
    return range_product(x[0], x[1], y[0], y[1])


@kernel
def quotient(x: Range, y: Range) -> Range:
    """Return the range of x/y."""
    return range_quotient(x[0], x[1], y[0], y[1])


@kernel
def squared(x: Range) -> Range:
    """Return the range of x²."""
    return range_square(x[0], x[1])


@kernel
def root(x: Range) -> Range:
    """Return the range of √max(x, 0)."""
    return max(down(np.sqrt(max(x[0], 0.0))), 0.0), up(np.sqrt(max(x[1], 0.0)))


@kernel
def negative(x: Range) -> Range:
    """Return the range of −x."""
    return -x[1], -x[0]


@kernel
def within(x: Range, low: float, high: float) -> Range:
    """Return the range, known to lie in [low, high]."""
    return min(max(x[0], low), high), max(min(x[1], high), low)


@kernel
def common(x: Range, y: Range) -> Range:
    """Return the range that lies in both of two."""
    return max(x[0], y[0]), min(x[1], y[1])


@kernel
def around(x: Range, middle: Range, rate: Range, half: float) -> Range:
    """Return the part of a range that can be reached from the middle of an interval of u, `half` away."""
    room = up(up(max(abs(rate[0]), abs(rate[1]))) * half)
    return max(x[0], down(middle[0] - room)), min(x[1], up(middle[1] + room))


@kernel
def exactly(x: float) -> Range:
    """Return the range of a number."""
    return x, x


@kernel
def holds_zero(x: Range) -> bool:
    """Return whether zero is in the range."""
    return x[0] <= 0.0 <= x[1]


@kernel
def rotated(c: Range, s: Range, x: Range, y: Range) -> tuple[Range, Range]:
    """Return the ranges of (x, y) turned by the angle of (c, s)."""
    return less(product(c, x), product(s, y)), plus(product(s, x), product(c, y))


@kernel
def polar(x: Range, y: Range) -> tuple[Range, Range]:
    """Return the ranges of length and angle of (x, y)."""
    return root(plus(squared(x), squared(y))), range_angle(y[0], y[1], x[0], x[1])


@kernel
def swept(x: Range, y: Range, u0: float, u1: float) -> tuple[Range, Range]:
    """Return the ranges of (x, y) turned by all angles in [u0, u1]."""
    length, angle = polar(x, y)
    a, b, c, d = range_cosine_sine(down(u0 + angle[0]), up(u1 + angle[1]))
    return product(length, (a, b)), product(length, (c, d))


@kernel
def angle_of(y: Range, x: Range) -> Range:
    """Return the range of the angle of (x, y)."""
    return range_angle(y[0], y[1], x[0], x[1])


@kernel
def trigonometry(angle: Range) -> tuple[Range, Range]:
    """Return the ranges of cosine and sine."""
    a, b, c, d = range_cosine_sine(angle[0], angle[1])
    return (a, b), (c, d)


@kernel
def put(box: FloatArray, joint: int, x: Range) -> None:
    """Write a range."""
    box[joint, 0], box[joint, 1] = x[0], x[1]


@kernel
def get(box: FloatArray, joint: int) -> Range:
    """Read a range."""
    return box[joint, 0], box[joint, 1]


@kernel
def widened(x: FloatArray, pad: float) -> Range:
    """Return a range of the pose with room for rounding."""
    return x[0] - pad, x[1] + pad


@kernel
def narrowed(x: Range, middle: Range, rate: Range, half: float) -> Range:
    """Return the part of a joint's range that it can reach from the middle of an interval of u, `half` away."""
    if not (x[1] - x[0] < _WIDEST and middle[1] - middle[0] < 1.0):
        return x
    turns = np.rint((0.5 * (x[0] + x[1]) - 0.5 * (middle[0] + middle[1])) / TAU)
    room = up(up(max(abs(rate[0]), abs(rate[1]))) * half) + 1e-15 * abs(turns)
    return max(x[0], down(middle[0] + TAU * turns - room) - 1e-15), min(
        x[1], up(middle[1] + TAU * turns + room) + 1e-15
    )


@kernel
def meet(box: FloatArray, low: float, high: float) -> bool:
    """Narrow a range of angles to what it shares with [low, high] up to whole turns; return whether it does."""
    if box[1] - box[0] + high - low >= 6.28:  # they may share two pieces
        if high - low < box[1] - box[0]:
            box[0], box[1] = low, high
        return True
    turn = TAU * np.rint((box[0] + box[1] - low - high) / (2.0 * TAU))
    if turn != 0.0:
        low, high = down(low + turn) - 1e-15, up(high + turn) + 1e-15
    box[0], box[1] = max(box[0], low), min(box[1], high)
    return box[0] <= box[1]
