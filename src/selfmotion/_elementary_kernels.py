"""Sine, cosine and arctangent without branches, so that loops over them run in SIMD registers.

Compilers have no vector form of libm's functions at hand, and a call per number is what an objective spends its time
on. Here a number of either sign is reduced, put through one polynomial and selected from, without a jump. The errors
are of libm's class: tests/test_elementary.py measures them in units of the last place against mpmath.

The reduction modulo π/2 subtracts three parts of it, the first two of 33 bits (Cody, Waite 1980): exact while the
quotient has at most 20 bits, |x| < 10⁶. What rounding takes from a reduced number is carried along in a second one. The
polynomials of sine and cosine together are those of S. L. Moshier's Cephes library (|x| ≤ π/4). That of the sine alone
interpolates (sin z / z − 1)/z² at the Chebyshev nodes of z² ≤ (π/2)², to 4e-17 of sin z, that of the arctangent
(arctan t / t − 1)/t² at those of t² ≤ tan² π/8, to 6e-18 of t.
"""

from __future__ import annotations

import math

import numpy as np

from selfmotion._compiled import elementary

_TWO_OVER_PI, _OVER_PI = 2.0 / math.pi, 1.0 / math.pi
# π/2 in three parts of 33 + 33 + 53 bits.
_PART1, _PART2, _PART3 = 1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21
_TAN_EIGHTH = 0.41421356237309503  # tan π/8
_HALF_PI, _QUARTER_PI, _QUARTER_PI_TAIL = 1.5707963267948966, 0.7853981633974483, 3.061616997868383e-17
_HALF_PI_TAIL = 6.123233995736766e-17
_TAU, _OVER_TAU = 2.0 * math.pi, 1.0 / (2.0 * math.pi)


@elementary
def _reduced(x: float, quotient: float) -> tuple[float, float]:
    """Return x less so many times π/2, and what rounding took from it."""
    first, second = x - quotient * _PART1, quotient * _PART2
    near = first - second
    tail = ((first - near) - second) - quotient * _PART3
    z = near + tail
    return z, tail - (z - near)


@elementary
def sine(x: float) -> float:
    """Return sin x alone, |x| < 10⁶, to 1.7 units of the last place.

    Reduced modulo π one polynomial does, a longer one. Meant for phases 2πf r, whose own rounding counts for more.
    """
    quotient = np.rint(x * _OVER_PI)
    z, lost = _reduced(x, 2.0 * quotient)
    zz = z * z
    s = 2.73144475909634e-15
    s = s * zz - 7.643970296165793e-13
    s = s * zz + 1.6058977312444268e-10
    s = s * zz - 2.5052107616995878e-08
    s = s * zz + 2.755731921916323e-06
    s = s * zz - 1.9841269841254974e-04
    s = s * zz + 8.333333333333316e-03
    s = s * zz - 1.6666666666666666e-01
    value = z + (lost * (1.0 - 0.5 * zz) + z * (zz * s))
    return -value if quotient - 2.0 * np.floor(0.5 * quotient) == 1.0 else value


@elementary
def sincos(x: float) -> tuple[float, float]:
    """Return sin x and cos x, |x| < 10⁶."""
    quotient = np.rint(x * _TWO_OVER_PI)
    z, lost = _reduced(x, quotient)
    zz = z * z
    s = 1.58962301576546568060e-10
    s = s * zz - 2.50507477628578072866e-8
    s = s * zz + 2.75573136213857245213e-6
    s = s * zz - 1.98412698295895385996e-4
    s = s * zz + 8.33333333332211858878e-3
    s = s * zz - 1.66666666666666307295e-1
    s = z + (lost + z * (zz * s))
    c = -1.13585365213876817300e-11
    c = c * zz + 2.08757008419747316778e-9
    c = c * zz - 2.75573141792967388112e-7
    c = c * zz + 2.48015872888517045348e-5
    c = c * zz - 1.38888888888730564116e-3
    c = c * zz + 4.16666666666665929218e-2
    half = 0.5 * zz
    most = 1.0 - half
    c = most + (((1.0 - most) - half) + (zz * (zz * c) - z * lost))
    quadrant = quotient - 4.0 * np.floor(0.25 * quotient)
    odd = (quadrant == 1.0) | (quadrant == 3.0)
    sine = c if odd else s
    cosine = s if odd else c
    sine = -sine if quadrant >= 2.0 else sine
    cosine = -cosine if (quadrant == 1.0) | (quadrant == 2.0) else cosine
    return sine, cosine


@elementary
def arctan2(y: float, x: float) -> float:
    """Return the angle of (x, y) in [−π, π], 0 for (0, 0)."""
    ax, ay = abs(x), abs(y)
    steep = ay > ax
    large = ay if steep else ax
    small = ax if steep else ay
    # arctan(s/l) = π/4 + arctan((s − l)/(s + l)): a factor instead of cases, which would be branches.
    middle = 1.0 if small > _TAN_EIGHTH * large else 0.0
    above, below = small - middle * large, large + middle * small
    above_lost, below_lost = small - (above + middle * large), middle * small - (below - large)
    inverse = 1.0 / (1.0 if below == 0.0 else below)
    t = above * inverse
    lost = ((above - t * below) + (above_lost - t * below_lost)) * inverse
    z = t * t
    # Coefficients in groups side by side: one chain of products would keep the processor waiting.
    z2 = z * z
    z4 = z2 * z2
    p = -9.0909045781210850e-02 + 7.6921831907606510e-02 * z
    p = p + z2 * (-6.6645114464602200e-02 + 5.8581489047951240e-02 * z)
    high = -5.0854496960392584e-02 + 3.9231657085083686e-02 * z - 1.9176885636589053e-02 * z2
    low = -3.3333333333333330e-01 + 1.9999999999995520e-01 * z
    low = low + z2 * (-1.4285714284666542e-01 + 1.1111111015256292e-01 * z)
    p = low + z4 * (p + z4 * high)
    rest = lost + t * (z * p)
    angle = middle * _QUARTER_PI + (t + (rest + middle * _QUARTER_PI_TAIL))
    angle = _HALF_PI - (angle - _HALF_PI_TAIL) if steep else angle
    angle = math.pi - (angle - 2.0 * _HALF_PI_TAIL) if x < 0.0 else angle
    return -angle if y < 0.0 else angle


@elementary
def wrapped(angle: float) -> float:
    """Return `angle` less the nearest whole number of turns, in [−π, π] up to rounding."""
    return angle - _TAU * np.rint(angle * _OVER_TAU)
