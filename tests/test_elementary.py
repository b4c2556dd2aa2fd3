"""Sine, cosine and arctangent against mpmath, in units of the last place."""

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import config

from selfmotion._compiled import fast_kernel
from selfmotion._elementary_kernels import arctan2, sincos, sine, wrapped

mpmath.mp.prec = 200
RNG = np.random.default_rng(0)


@fast_kernel
def fill_sincos(x, sines, cosines):
    """As objectives use it: in a loop that runs in vector registers, sums free to be reordered."""
    for i in range(len(x)):
        sines[i], cosines[i] = sincos(x[i])


@fast_kernel
def fill_sine(x, found):
    for i in range(len(x)):
        found[i] = sine(x[i])


@fast_kernel
def fill_arctan2(y, x, angle):
    for i in range(len(x)):
        angle[i] = arctan2(y[i], x[i])


def ulps(found, exact):
    """Return how many units of the last place apart they are at worst."""
    return max(
        abs(float((mpmath.mpf(float(a)) - b) / mpmath.mpf(float(np.spacing(abs(float(b)))))))
        for a, b in zip(found, exact, strict=True)
    )


@pytest.mark.parametrize(
    "x",
    [
        RNG.uniform(-4.0, 4.0, 2000),
        RNG.uniform(-1e3, 1e3, 1000),
        RNG.uniform(-1e6, 1e6, 1000),
        0.5 * np.pi * np.arange(-400, 400) + RNG.choice([0.0, 1e-9, 1e-15], 800),
        10.0 ** RNG.uniform(-300.0, 0.0, 300),
    ],
    ids=["small", "turns", "far", "near multiples of π/2", "tiny"],
)
def test_sine_and_cosine_are_right_to_a_unit_of_the_last_place(x):
    sines, cosine = np.empty_like(x), np.empty_like(x)
    fill_sincos(x, sines, cosine)
    assert ulps(sines, [mpmath.sin(mpmath.mpf(float(v))) for v in x]) < 1.0
    alone = np.empty_like(x)
    fill_sine(x, alone)
    assert ulps(alone, [mpmath.sin(mpmath.mpf(float(v))) for v in x]) < (2.5 if config.DISABLE_JIT else 1.75)
    assert ulps(cosine, [mpmath.cos(mpmath.mpf(float(v))) for v in x]) < 1.0


@pytest.mark.parametrize("spread", [0.0, 0.5, 3.0, 100.0])
def test_the_arctangent_is_right_to_a_unit_of_the_last_place_or_so(spread):
    y, x = (RNG.choice([-1.0, 1.0], 1500) * 10.0 ** RNG.uniform(-spread, spread, 1500) for _ in range(2))
    y[:300] = x[:300] * np.tan(np.pi / 8) * (1.0 + RNG.uniform(-1e-15, 1e-15, 300))  # where the reduction changes
    angle = np.empty_like(y)
    fill_arctan2(y, x, angle)
    exact = [mpmath.atan2(mpmath.mpf(float(b)), mpmath.mpf(float(a))) for b, a in zip(y, x, strict=True)]
    assert ulps(angle, exact) < (1.8 if config.DISABLE_JIT else 1.25)  # what the division loses needs fused products


def test_the_arctangent_on_the_axes_and_at_zero():
    y, x = np.array([0.0, 0.0, 1.0, -1.0, 0.0]), np.array([1.0, -1.0, 0.0, 0.0, 0.0])
    angle = np.empty_like(y)
    fill_arctan2(y, x, angle)
    np.testing.assert_array_equal(angle, [0.0, np.pi, 0.5 * np.pi, -0.5 * np.pi, 0.0])


def test_nan_stays_nan():
    sines, cosine, alone, angle = np.empty((4, 9))
    x = np.ones(9)
    x[4] = np.nan
    fill_sincos(x, sines, cosine)
    fill_sine(x, alone)
    fill_arctan2(x, np.ones(9), angle)
    for found in (sines, cosine, alone, angle):
        assert list(np.flatnonzero(np.isnan(found))) == [4]


@given(st.floats(-1e5, 1e5))
def test_wrapping_leaves_a_whole_number_of_turns(angle):
    rest = wrapped(angle)
    assert abs(rest) <= np.pi * (1 + 1e-15)
    turns = (angle - rest) / (2 * np.pi)
    assert abs(turns - round(turns)) < 1e-10
