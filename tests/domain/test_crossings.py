"""Zeros of functions along a path, against functions whose zeros are planted."""

import numpy as np
import pytest

from selfmotion.domain.crossings import crossings


def found(functions, edges=(0.0, 1.0)):
    """Zeros of each function, by its number."""
    got = crossings(lambda r: np.stack([f(r) for f in functions], axis=-1), np.array(edges))
    assert (np.diff(got.r) >= 0).all()
    return [got.r[got.function == k] for k in range(len(functions))]


def product(roots, scale=1.0):
    return lambda r: scale * np.prod(r[..., None] - np.asarray(roots), axis=-1)


def test_zeros_of_several_functions_are_told_apart():
    roots = [[0.1, 0.5, 0.9], [0.3], [], [0.5, 0.7]]
    for got, wanted in zip(found([product(some) for some in roots]), roots, strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-15)


@pytest.mark.parametrize("waves", [3, 40, 400])
def test_none_of_many_zeros_is_missed(waves):
    (got,) = found([lambda r: np.sin(waves * np.pi * (r + 0.3 / waves))])
    np.testing.assert_allclose(got, (np.arange(1, waves + 1) - 0.3) / waves, atol=3e-15)


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6])
def test_neighbours_are_found_as_well_as_they_can_be(apart):
    """To about rounding by their distance, as the docstring says; all else is exact."""
    roots = [0.2, 0.4 - apart / 2, 0.4 + apart / 2, 0.8]
    (got,) = found([product(roots)])
    np.testing.assert_allclose(got[[0, 3]], [0.2, 0.8], atol=1e-15)
    np.testing.assert_allclose(got[[1, 2]], roots[1:3], atol=3e-16 / apart + 1e-15)


def test_a_touch_is_no_crossing_and_an_inflection_is_one():
    touch, inflection = found([lambda r: (r - 0.4) ** 2, lambda r: (r - 0.6) ** 3 + 0.1 * (r - 0.6)])
    assert len(touch) == 0
    np.testing.assert_allclose(inflection, [0.6], atol=1e-15)


def test_what_vanishes_all_along_crosses_nothing():
    still, other = found([lambda r: 0.0 * r, lambda r: r - 0.25])
    assert len(still) == 0
    np.testing.assert_array_equal(other, [0.25])


def test_corners_of_the_path_are_edges():
    """|r − 1/3| − 1/6 and a tooth: smooth between the edges only; also a zero at an edge."""
    valley = lambda r: np.abs(r - 1 / 3) - 1 / 6  # noqa: E731
    tooth = lambda r: 1 / 3 - np.abs(r - 2 / 3) - 0.3 * r  # noqa: E731
    across = lambda r: r - 2 / 3 + np.maximum(r - 2 / 3, 0.0)  # noqa: E731, zero at its corner
    got = found([valley, tooth, across], [0.0, 1 / 3, 2 / 3, 1.0])
    np.testing.assert_allclose(got[0], [1 / 6, 1 / 2], atol=1e-15)
    np.testing.assert_allclose(got[1], [1 / 2.1, 1 / 1.3], atol=1e-15)
    np.testing.assert_allclose(got[2], [2 / 3], atol=1e-15)


def test_random_polynomials_have_the_zeros_that_were_planted():
    rng = np.random.default_rng(2)
    for _ in range(60):
        roots = np.sort(rng.uniform(-0.5, 1.5, int(rng.integers(1, 9))))
        if np.diff(roots).min(initial=1.0) < 0.02 or np.abs(roots - [[0.0], [1.0]]).min() < 1e-3:
            continue
        away = rng.uniform(0.2, 3.0)
        (got,) = found([lambda r, roots=roots, away=away: product(roots)(r) * np.exp(away * r) / (1 + (3 * r) ** 2)])
        np.testing.assert_allclose(got, roots[(roots > 0) & (roots < 1)], atol=1e-11)
