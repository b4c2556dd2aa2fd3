"""The quadrature is exact where theory says so, and its error estimate is true where it is not."""

import mpmath
import numpy as np
import pytest

from selfmotion.quadrature import _GAUSS, _KRONROD, _NODES, integrate


def test_the_rule_integrates_polynomials_exactly():
    for degree in range(0, 24):
        exact = 2 / (degree + 1) if degree % 2 == 0 else 0.0
        assert _KRONROD @ _NODES**degree == pytest.approx(exact, abs=1e-15)
        if degree < 14:
            assert _GAUSS @ _NODES**degree == pytest.approx(exact, abs=1e-15)


CASES = [
    (lambda x: np.exp(x), "exp", mpmath.exp),
    (lambda x: np.sqrt(x), "square root at the end", mpmath.sqrt),
    (lambda x: np.abs(x - 0.3), "kink", lambda x: abs(x - mpmath.mpf("0.3"))),
    (lambda x: np.sqrt((x - 0.37) ** 2 + 1e-10), "near-kink", lambda x: mpmath.sqrt((x - 0.37) ** 2 + 1e-10)),
    (lambda x: np.cos(300 * x), "waves", lambda x: mpmath.cos(300 * x)),
    (lambda x: 1 / (1e-6 + (x - 0.5) ** 2), "peak", lambda x: 1 / (1e-6 + (x - 0.5) ** 2)),
]


@pytest.mark.parametrize(("function", "name", "reference"), CASES, ids=[case[1] for case in CASES])
def test_the_error_estimate_covers_the_true_error(function, name, reference):
    result = integrate(function, np.linspace(0, 1, 9))
    with mpmath.workdps(30):
        points = [0, 0.1, 0.3, 0.37, 0.5, 0.7, 1]
        if name == "waves":
            exact = float(mpmath.sin(300) / 300)
        elif name == "peak":
            exact = float(2000 * mpmath.atan(500))
        else:
            exact = float(mpmath.quad(reference, points))
    assert abs(result.value - exact) <= result.error
    assert result.error <= 1e-9 * max(1.0, abs(exact))


def test_what_cannot_be_integrated_has_an_infinite_error():
    assert integrate(lambda x: np.full_like(x, np.nan), np.array([0.0, 1.0])).error == np.inf


def test_jumps_at_panel_edges_cost_nothing():
    result = integrate(lambda x: np.where(x < 0.25, 1.0, 3.0), np.array([0.0, 0.25, 1.0]))
    assert result.value == pytest.approx(2.5, abs=1e-14)
    assert result.error < 1e-13


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_the_estimate_is_true_where_the_error_is_large(tolerance):
    """Loosely integrated square roots and kinks: the true error is far above rounding, and below the estimate."""
    for function, exact in ((np.sqrt, 2 / 3), (lambda x: np.abs(x - 0.3), 0.29)):
        result = integrate(function, np.array([0.0, 1.0]), tolerance)
        assert 1e-9 < abs(result.value - exact) <= result.error


@pytest.mark.parametrize("place", [0.5 + 1.2e-5, 0.5 + 1e-5, 0.5022123621862172, 0.5 - 1e-6, 1e-6, 1 - 1e-6])
def test_kinks_and_jumps_near_a_panel_s_ends_are_seen(place):
    """Beyond the outermost node K15 and G7 agree on the wrong answer."""
    edges = np.linspace(0, 1, 251)
    kink = integrate(lambda r: np.abs(r - place), edges)
    assert abs(kink.value - (place**2 + (1 - place) ** 2) / 2) <= kink.error
    jump = integrate(lambda r: (r > place) * 1.0, edges)
    assert abs(jump.value - (1 - place)) <= jump.error + 1e-16


def test_where_an_integrand_is_steep_and_noisy_panels_are_not_halved_for_ever():
    """The rates of a motion that starts at a singular posture: square roots, and rounding magnified by steepness."""
    asked = []

    def rates(x):
        asked.append(len(x))
        return (1.0 + 1e-16 * np.sin(1e15 * x) / (x + 1e-7)) / np.sqrt(x + 1e-6)

    result = integrate(rates, np.linspace(0.0, 1.0, 65))
    assert sum(asked) < 50_000
    assert abs(result.value - 2 * (np.sqrt(1 + 1e-6) - 1e-3)) < 1e-6
