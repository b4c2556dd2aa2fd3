"""The sinusoid (22), as a function of r and of time."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.profiles import SinusoidProfile


def test_it_is_equation_22_for_every_curve_at_once():
    profile = SinusoidProfile([0.3, -1.0], [0.4, 0.2])
    a, r = np.array([[0.5, 2.0], [3.0, 0.0]]), np.linspace(0, 1, 7)
    u = profile(a, r)
    assert u.shape == (2, 7, 2)
    np.testing.assert_allclose(u[0, :, 0], 0.3 + 0.4 * np.sin(np.pi * r))
    np.testing.assert_allclose(u[1, :, 1], -1.0)
    np.testing.assert_array_equal(profile(a[0], r), u[0])
    assert profile.parameter_names == ("f1", "f2")


def test_its_derivative():
    profile, r, h = SinusoidProfile([0.3], [0.4]), np.linspace(0.1, 0.9, 9), 1e-6
    slope = (profile([2.5], r + h) - profile([2.5], r - h)) / (2 * h)
    np.testing.assert_allclose(profile([2.5], r, 1), slope, atol=1e-8)


def test_as_a_function_of_time():
    profile, total = SinusoidProfile([0.3], [0.4]), 8.0
    t = np.linspace(0, total, 11)
    np.testing.assert_allclose(profile.at_time([1.5], t, total), profile([1.5], t / total))
    h = 1e-6
    inner = t[1:-1]
    slope = (profile.at_time([1.5], inner + h, total) - profile.at_time([1.5], inner - h, total)) / (2 * h)
    np.testing.assert_allclose(profile.at_time([1.5], inner, total, 1), slope, atol=1e-8)


@pytest.mark.parametrize(
    "call",
    [
        lambda p: p.at_time([1.0], [0.0], 0.0),
        lambda p: p.at_time([1.0], [0.0], -1.0),
        lambda p: p.at_time([1.0], [2.0], 1.0),
        lambda p: SinusoidProfile([0.1], [0.0]),
        lambda p: SinusoidProfile([0.1], [0.2, 0.3]),
    ],
)
def test_bad_input_is_refused(call):
    with pytest.raises(sm.InvalidInputError):
        call(SinusoidProfile([0.3], [0.4]))
