"""Interval arithmetic with first derivatives, on plain floats: what proves where a function of u lies, and how steep.

A *jet* (low, high, dlow, dhigh) says of a function of the redundancy parameter u: over the whole interval of u its
value lies in [low, high] and its derivative, wherever it has one, in [dlow, dhigh]. A derivative of which nothing is
known is [−∞, ∞]. Several functions may be held by one jet (a family over poses); then it holds for each of them.

Rounding: every elementary operation moves its bounds outwards by 4e-16 of their size (two roundings, and the error
below one unit in the last place of square root, sine, cosine and arctangent) and by 1e-300 for what underflows.
Infinite bounds stand for "unbounded", never for a value: 0·∞ = 0. With numbers in, no NaN comes out.
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel

Jet = tuple[float, float, float, float]
Range = tuple[float, float]

RELATIVE, TINY = 4e-16, 1e-300
LARGEST = 1.7e308
_PI = 3.1415926535897936  # rounded up
_FARTHEST = 1e5  # beyond, the place in the period is not worth knowing


@kernel
def down(x: float) -> float:
    """Return a bound below every number that rounding may have made x of."""
    x = min(x, LARGEST)
    return x - (RELATIVE * abs(x) + TINY)


@kernel
def up(x: float) -> float:
    """Return a bound above every number that rounding may have made x of."""
    x = max(x, -LARGEST)
    return x + (RELATIVE * abs(x) + TINY)


@kernel
def times(a: float, b: float) -> float:
    """Return a b, with 0·∞ = 0."""
    product = a * b
    return 0.0 if np.isnan(product) else product


@kernel
def range_sum(a: float, b: float, c: float, d: float) -> Range:
    """Return the range of x + y for x in [a, b] and y in [c, d]."""
    return down(a + c), up(b + d)


@kernel
def range_product(a: float, b: float, c: float, d: float) -> Range:
    """Return the range of x y for x in [a, b] and y in [c, d]."""
    ac, ad, bc, bd = times(a, c), times(a, d), times(b, c), times(b, d)
    return down(min(ac, ad, bc, bd)), up(max(ac, ad, bc, bd))


@kernel
def range_square(a: float, b: float) -> Range:
    """Return the range of x² for x in [a, b]."""
    one, two = a * a, b * b
    least = 0.0 if a <= 0.0 <= b else down(min(one, two))
    return max(least, 0.0), up(max(one, two))


@kernel
def range_inverse(a: float, b: float) -> Range:
    """Return the range of 1/x for x in [a, b], unbounded where that holds zero."""
    if a <= 0.0 <= b:
        return -np.inf, np.inf
    return down(1.0 / b), up(1.0 / a)


@kernel
def range_quotient(a: float, b: float, c: float, d: float) -> Range:
    """Return the range of x/y for x in [a, b] and y in [c, d], unbounded where the latter holds zero."""
    if c <= 0.0 <= d:
        return -np.inf, np.inf
    if c > 0.0:
        return down(a / (d if a >= 0.0 else c)), up(b / (c if b >= 0.0 else d))
    return down(b / (d if b >= 0.0 else c)), up(a / (c if a >= 0.0 else d))


@kernel
def extremes(low: float, high: float, phase: float) -> tuple[bool, bool]:
    """Return whether cos(x − π phase) may reach −1, and 1, within [low, high]."""
    if not (abs(low) < _FARTHEST and abs(high) < _FARTHEST):
        return True, True
    first, last = np.floor(low / np.pi - phase), np.floor(high / np.pi - phase)
    if last - first >= 2.0:
        return True, True
    if last == first:
        return False, False
    even = last == 2.0 * np.floor(0.5 * last)
    return not even, even


@kernel
def range_cosine_sine(low: float, high: float) -> tuple[float, float, float, float]:
    """Return the ranges of cosine and sine, (least, most, least, most), over [low, high].

    An end of the interval so near to an extreme that rounding hides on which side it is, is itself within 1e-21 of it.
    """
    if not (abs(low) < _FARTHEST and abs(high) < _FARTHEST):
        return -1.0, 1.0, -1.0, 1.0
    one, two = np.cos(low), np.cos(high)
    bottom, top = extremes(low, high, 0.0)
    cosine_low = -1.0 if bottom else max(down(min(one, two)), -1.0)
    cosine_high = 1.0 if top else min(up(max(one, two)), 1.0)
    one, two = np.sin(low), np.sin(high)
    bottom, top = extremes(low, high, 0.5)
    sine_low = -1.0 if bottom else max(down(min(one, two)), -1.0)
    sine_high = 1.0 if top else min(up(max(one, two)), 1.0)
    return cosine_low, cosine_high, sine_low, sine_high


@kernel
def range_angle(y_low: float, y_high: float, x_low: float, x_high: float) -> Range:
    """Return the range of the angle of (x, y) over a box; it may reach beyond π, and is [−π, π] around the origin."""
    if x_low > 0.0:
        low = np.arctan2(y_low, x_low if y_low < 0.0 else x_high)
        high = np.arctan2(y_high, x_high if y_high < 0.0 else x_low)
    elif y_low > 0.0:
        low = np.arctan2(y_low if x_high > 0.0 else y_high, x_high)
        high = np.arctan2(y_low if x_low < 0.0 else y_high, x_low)
    elif y_high < 0.0:
        low = np.arctan2(y_high if x_low < 0.0 else y_low, x_low)
        high = np.arctan2(y_high if x_high > 0.0 else y_low, x_high)
    elif x_high < 0.0:  # across the cut
        low = np.pi - np.arctan2(y_high, -x_high)
        high = np.pi + np.arctan2(-y_low, -x_high)
    else:
        return -_PI, _PI
    return down(low), up(high)


@kernel
def constant(value: float) -> Jet:
    """Return the jet of a number."""
    return value, value, 0.0, 0.0


@kernel
def held(low: float, high: float) -> Jet:
    """Return the jet of what lies in [low, high] and does not depend on u."""
    return low, high, 0.0, 0.0


@kernel
def unknown(low: float, high: float) -> Jet:
    """Return the jet of what lies in [low, high] and depends on u in an unknown way."""
    return low, high, -np.inf, np.inf


@kernel
def variable(u0: float, u1: float) -> Jet:
    """Return the jet of u itself over [u0, u1]."""
    return u0, u1, 1.0, 1.0


@kernel
def minus(f: Jet) -> Jet:
    """Return the jet of −f."""
    return -f[1], -f[0], -f[3], -f[2]


@kernel
def add(f: Jet, g: Jet) -> Jet:
    """Return the jet of f + g."""
    low, high = range_sum(f[0], f[1], g[0], g[1])
    dlow, dhigh = range_sum(f[2], f[3], g[2], g[3])
    return low, high, dlow, dhigh


@kernel
def sub(f: Jet, g: Jet) -> Jet:
    """Return the jet of f − g."""
    low, high = range_sum(f[0], f[1], -g[1], -g[0])
    dlow, dhigh = range_sum(f[2], f[3], -g[3], -g[2])
    return low, high, dlow, dhigh


@kernel
def scale(c: float, f: Jet) -> Jet:
    """Return the jet of c f."""
    if c < 0.0:
        c, f = -c, minus(f)
    return down(times(c, f[0])), up(times(c, f[1])), down(times(c, f[2])), up(times(c, f[3]))


@kernel
def mul(f: Jet, g: Jet) -> Jet:
    """Return the jet of f g."""
    low, high = range_product(f[0], f[1], g[0], g[1])
    a, b = range_product(f[2], f[3], g[0], g[1])
    c, d = range_product(f[0], f[1], g[2], g[3])
    dlow, dhigh = range_sum(a, b, c, d)
    return low, high, dlow, dhigh


@kernel
def square(f: Jet) -> Jet:
    """Return the jet of f²."""
    low, high = range_square(f[0], f[1])
    dlow, dhigh = range_product(f[0], f[1], f[2], f[3])
    return low, high, down(2.0 * dlow), up(2.0 * dhigh)


@kernel
def sqrt(f: Jet) -> Jet:
    """Return the jet of √max(f, 0), of unknown derivative where f may reach zero."""
    low, high = max(down(np.sqrt(max(f[0], 0.0))), 0.0), up(np.sqrt(max(f[1], 0.0)))
    if f[0] <= 0.0 or low <= 0.0:
        return low, high, -np.inf, np.inf
    dlow, dhigh = range_quotient(f[2], f[3], low, high)
    return low, high, down(0.5 * dlow), up(0.5 * dhigh)


@kernel
def div(f: Jet, g: Jet) -> Jet:
    """Return the jet of f/g, unbounded where g may reach zero."""
    if g[0] <= 0.0 <= g[1]:
        return -np.inf, np.inf, -np.inf, np.inf
    low, high = range_quotient(f[0], f[1], g[0], g[1])
    a, b = range_product(low, high, g[2], g[3])  # (f/g)' = (f' − (f/g) g')/g
    a, b = range_sum(f[2], f[3], -b, -a)
    dlow, dhigh = range_quotient(a, b, g[0], g[1])
    return low, high, dlow, dhigh


@kernel
def cos_sin(f: Jet) -> tuple[Jet, Jet]:
    """Return the jets of cos f and of sin f."""
    cosine_low, cosine_high, sine_low, sine_high = range_cosine_sine(f[0], f[1])
    a, b = range_product(sine_low, sine_high, f[2], f[3])
    c, d = range_product(cosine_low, cosine_high, f[2], f[3])
    return (cosine_low, cosine_high, -b, -a), (sine_low, sine_high, c, d)


@kernel
def cos(f: Jet) -> Jet:
    """Return the jet of cos f."""
    return cos_sin(f)[0]


@kernel
def sin(f: Jet) -> Jet:
    """Return the jet of sin f."""
    return cos_sin(f)[1]


@kernel
def atan2(y: Jet, x: Jet) -> Jet:
    """Return the jet of the angle of (x, y): one continuous choice of it over the box, which may reach beyond π.

    Where the box holds the origin nothing is known of the angle, and the value is [−π, π].
    """
    low, high = range_angle(y[0], y[1], x[0], x[1])
    if x[0] <= 0.0 <= x[1] and y[0] <= 0.0 <= y[1]:
        return low, high, -np.inf, np.inf
    a, b = range_product(x[0], x[1], y[2], y[3])
    c, d = range_product(y[0], y[1], x[2], x[3])
    a, b = range_sum(a, b, -d, -c)  # x y' − y x'
    c, d = range_square(x[0], x[1])
    e, f = range_square(y[0], y[1])
    c, d = range_sum(c, d, e, f)  # x² + y²
    dlow, dhigh = range_quotient(a, b, c, d)
    return low, high, dlow, dhigh


@kernel
def intersect(f: Jet, g: Jet) -> Jet:
    """Return the jet of what both f and g hold: empty, with low > high, if nothing is."""
    return max(f[0], g[0]), min(f[1], g[1]), max(f[2], g[2]), min(f[3], g[3])


@kernel
def hull(f: Jet, g: Jet) -> Jet:
    """Return the jet that holds whatever f or g holds."""
    return min(f[0], g[0]), max(f[1], g[1]), min(f[2], g[2]), max(f[3], g[3])
