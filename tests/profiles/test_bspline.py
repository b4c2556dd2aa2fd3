"""Clamped cubic B-splines: against de Boor's recursion, and the laws of the basis."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.profiles import BSplineProfile

R = np.linspace(0, 1, 101)
COUNTS = (4, 5, 8, 13)


def recursion(knots, i, degree, r):
    """B_i by the recursion of Cox and de Boor, written out; the last interval is closed."""
    if degree == 0:
        last = knots[i + 1] == 1.0 and knots[i] < 1.0
        return ((knots[i] <= r) & ((r < knots[i + 1]) | (last & (r == 1.0)))).astype(float)
    total = np.zeros_like(r)
    for k, rising in ((i, True), (i + 1, False)):
        width = knots[k + degree] - knots[k]
        if width > 0:
            ramp = (r - knots[k]) / width
            total += (ramp if rising else 1 - ramp) * recursion(knots, k, degree - 1, r)
    return total


@pytest.mark.parametrize("count", COUNTS)
def test_the_functions_are_those_of_the_recursion(count):
    profile = BSplineProfile(1, count)
    expected = np.column_stack([recursion(profile.knots, i, 3, R) for i in range(count)])
    np.testing.assert_allclose(profile.functions(R, 0), expected, atol=1e-14)


@pytest.mark.parametrize("count", COUNTS)
def test_they_are_not_negative_and_sum_to_one(count):
    profile = BSplineProfile(1, count)
    functions = profile.functions(R, 0)
    assert (functions >= 0).all()
    np.testing.assert_allclose(functions.sum(axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(profile.functions(R, 1).sum(axis=1), 0.0, atol=1e-12)


def test_a_population_is_its_formula_and_the_components_do_not_mix():
    profile = BSplineProfile(2, 6, offset=[0.3, -1.0])
    assert profile.parameter_names == tuple(f"c{i}_{j}" for j in (1, 2) for i in range(2, 7))
    a = np.random.default_rng(0).normal(size=(4, 10))
    u = profile(a, R)
    assert u.shape == (4, 101, 2)
    functions = np.column_stack([recursion(profile.knots, i, 3, R) for i in range(6)])
    for curve, row in zip(u, a, strict=True):
        both = np.column_stack([[0.3, *row[:5]], [-1.0, *row[5:]]])
        np.testing.assert_allclose(curve, functions @ both, atol=1e-13)


def test_its_derivative():
    profile, h, r = BSplineProfile(1, 7, offset=[0.3]), 1e-6, np.linspace(0.011, 0.983, 57)
    a = np.random.default_rng(1).normal(size=6)
    slope = (profile(a, r + h) - profile(a, r - h)) / (2 * h)
    np.testing.assert_allclose(profile(a, r, 1), slope, atol=1e-7)


def test_asking_elsewhere_and_back_changes_nothing():
    profile, a = BSplineProfile(1, 6), np.arange(6.0)
    once, slope = profile(a, R), profile(a, R, 1)
    moving = R.copy()
    profile(a, moving)
    moving *= 0.5  # the caller's own array
    np.testing.assert_allclose(profile(a, moving)[::2], once[: len(R) // 2 + 1], atol=1e-1)
    np.testing.assert_array_equal(profile(a, moving), BSplineProfile(1, 6)(a, moving))
    np.testing.assert_array_equal(profile(a, R), once)
    np.testing.assert_array_equal(profile(a, R, 1), slope)


def test_start_and_end_are_exact_and_the_curve_stays_in_the_range_of_its_coefficients():
    a = np.random.default_rng(2).normal(size=(200, 6))
    free, started, both = BSplineProfile(1, 6), BSplineProfile(1, 7, [0.3]), BSplineProfile(1, 8, [0.3], [1.7])
    np.testing.assert_array_equal(free(a, [0.0, 1.0])[..., 0], a[:, [0, -1]])
    assert free.start is None
    assert (started(a, [0.0]) == 0.3).all()
    assert (both(a, [0.0, 1.0])[..., 0] == [0.3, 1.7]).all()
    u = free(a, R)[..., 0]
    assert (u.max(axis=1) <= a.max(axis=1) + 1e-14).all()
    assert (u.min(axis=1) >= a.min(axis=1) - 1e-14).all()
    # Variation diminishing: a level is crossed no more often than the coefficients cross it.
    assert ((np.diff(u > 0.1, axis=1)).sum(axis=1) <= (np.diff(a > 0.1, axis=1)).sum(axis=1)).all()


def test_every_cubic_is_a_member():
    profile = BSplineProfile(1, 9)
    for power in range(4):
        found = np.linalg.lstsq(profile.functions(R, 0), R**power, rcond=None)[0]
        np.testing.assert_allclose(profile(found, R)[:, 0], R**power, atol=1e-13)


def test_a_planted_member_is_found():
    profile = BSplineProfile(1, 5, offset=[0.3])
    planted = np.array([0.5, -0.3, 0.2, 0.6])
    goal = profile(planted, R)
    optimizer = sm.PSO(30, 250, profile.box(np.array([1.0])), seed=3)
    result = optimizer.minimize(lambda a: ((profile(a, R) - goal) ** 2).mean(axis=(1, 2)), 4)
    np.testing.assert_allclose(result.x, planted, atol=1e-6)


def test_the_box_lies_around_the_offset_or_around_zero():
    span = np.array([0.5, 1.0])
    box = BSplineProfile(2, 4, [0.3, -1.0]).box(span)
    np.testing.assert_allclose(box, [[-0.2, 0.8]] * 3 + [[-2.0, 0.0]] * 3)
    np.testing.assert_allclose(BSplineProfile(2, 4).box(span), [[-0.5, 0.5]] * 4 + [[-1.0, 1.0]] * 4)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: BSplineProfile(1, 3), "coefficients"),
        (lambda: BSplineProfile(0, 4), "n_u"),
        (lambda: BSplineProfile(1, 4, [0.3, 0.3]), "offset"),
        (lambda: BSplineProfile(1, 4, None, [0.3, 0.3]), "end"),
        (lambda: BSplineProfile(1, 4)([0.1], R), "a"),
    ],
)
def test_bad_input_is_refused(make, field):
    with pytest.raises(sm.InvalidInputError) as caught:
        make()
    assert caught.value.field == field
    assert caught.value.remedy
