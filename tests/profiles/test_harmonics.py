"""A line plus a sine series: what its curves are, which curves it has, and that its ends are exact."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.profiles import HarmonicsProfile, SinusoidProfile

R = np.linspace(0, 1, 101)


def test_it_is_its_formula_for_every_curve_at_once():
    profile = HarmonicsProfile([0.3, -1.0], 2)
    assert profile.parameter_names == ("travel_1", "a1_1", "a2_1", "travel_2", "a1_2", "a2_2")
    a = np.random.default_rng(0).normal(size=(4, 6))
    u = profile(a, R)
    assert u.shape == (4, 101, 2)
    for curve, (t1, p, q, t2, x, y) in zip(u, a, strict=True):
        first = 0.3 + t1 * R + p * np.sin(np.pi * R) + q * np.sin(2 * np.pi * R)
        second = -1.0 + t2 * R + x * np.sin(np.pi * R) + y * np.sin(2 * np.pi * R)
        np.testing.assert_allclose(curve, np.column_stack([first, second]), atol=1e-14)


@pytest.mark.parametrize("end", [None, [2.0, 0.1]])
def test_its_derivative_is_that_of_a_complex_step(end):
    """The same curve in complex numbers: Im u(r + ih)/h has no rounding of a difference in it."""
    profile = HarmonicsProfile([0.3, -1.0], 4, end)
    a = np.random.default_rng(1).normal(size=len(profile.parameter_names))
    c = profile.coefficients(a)
    z = R + 1e-30j
    functions = np.stack([np.ones_like(z), z, *(np.sin(np.pi * k * z) for k in range(1, 5))])
    np.testing.assert_allclose(profile(a, R, 1), (c @ functions).imag.T / 1e-30, atol=1e-12)


def test_start_and_end_are_exact():
    a = np.random.default_rng(2).normal(size=(50, 7))
    free, kept = HarmonicsProfile([0.3], 6), HarmonicsProfile([0.3], 7, [1.7])
    assert (free(a, [0.0]) == 0.3).all()
    assert (kept(a, [0.0]) == 0.3).all()
    np.testing.assert_allclose(free(a, [1.0])[:, 0, 0], 0.3 + a[:, 0], atol=1e-14)
    np.testing.assert_allclose(kept(a, [1.0]), 1.7, atol=1e-13)
    assert free.end is None
    assert kept.end == [1.7]


@pytest.mark.parametrize("f", [0.5, 1.0, 2.5])
def test_the_sinusoid_of_half_a_whole_frequency_is_a_member(f):
    profile, sinusoid = HarmonicsProfile([0.3], 5), SinusoidProfile([0.3], [0.4])
    a = np.zeros(6)
    a[int(2 * f)] = 0.4
    for order in (0, 1):
        np.testing.assert_allclose(profile(a, R, order), sinusoid([f], R, order), atol=1e-13)


def test_the_sines_of_a_smooth_curve_fall_off_with_the_third_power():
    """u = eʳ is curved at both ends: coefficients as k⁻³ leave a root mean square as m^−5/2, 5.7 per doubling."""
    r, errors = np.linspace(0, 1, 2001), []
    for m in (8, 16, 32):
        functions = HarmonicsProfile([1.0], m).functions(r, 0)[:, 1:]
        found = np.linalg.lstsq(functions, np.exp(r) - 1, rcond=None)[0]
        errors.append(np.sqrt(np.mean((functions @ found - np.exp(r) + 1) ** 2)))
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 2**2.5, rtol=0.15)


def test_a_planted_member_is_found():
    profile = HarmonicsProfile([0.3], 3)
    planted = np.array([0.5, -0.3, 0.2, 0.1])
    goal = profile(planted, R)
    optimizer = sm.PSO(30, 150, profile.box(np.array([1.0])), seed=3)
    result = optimizer.minimize(lambda a: ((profile(a, R) - goal) ** 2).mean(axis=(1, 2)), 4)
    np.testing.assert_allclose(result.x, planted, atol=1e-6)


def test_no_sine_of_the_box_is_faster_than_the_first():
    profile = HarmonicsProfile([0.3, 0.1], 4)
    box = profile.box(np.array([0.6, 1.2]))
    np.testing.assert_allclose(box[:, 1], [0.6, 0.6, 0.3, 0.2, 0.15, 1.2, 1.2, 0.6, 0.4, 0.3])
    np.testing.assert_array_equal(box[:, 0], -box[:, 1])


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: HarmonicsProfile([0.3], 0), "harmonics"),
        (lambda: HarmonicsProfile([0.3], 1.5), "harmonics"),
        (lambda: HarmonicsProfile([], 2), "offset"),
        (lambda: HarmonicsProfile([0.3], 2, [0.1, 0.2]), "end"),
        (lambda: HarmonicsProfile([0.3], 2)([0.1, 0.2], R), "a"),
        (lambda: HarmonicsProfile([0.3], 1)([0.1, 0.2], R, 2), "order"),
    ],
)
def test_bad_input_is_refused(make, field):
    with pytest.raises(sm.InvalidInputError) as caught:
        make()
    assert caught.value.field == field
    assert caught.value.remedy
