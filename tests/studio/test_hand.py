"""Curves moved by hand: they follow their samples, and cost what the library says."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.errors import InvalidInputError
from selfmotion.motion import Motion
from selfmotion.plans import Plan
from selfmotion.profiles import ProfileCurve, SinusoidProfile
from selfmotion.studio.cases import CASES
from selfmotion.studio.hand import fit, fitted, hand_of
from selfmotion.studio.motions import curve_object
from selfmotion.studio.place import Place
from selfmotion.studio.problems import problem_of

SEED = CASES[0].problem


def ask(r, u, problem=SEED, branch="positive"):
    return fit({"problem": problem, "r": r, "u": u, "branch": branch}, lambda *_: None, Place())


@pytest.mark.parametrize("frequency", [0.7, 2.0, 4.3, 11.0])
def test_a_curve_through_a_sinusoid_follows_it_and_costs_the_same(frequency):
    problem = problem_of(SEED, None).problem
    r = np.linspace(0, 1, 1000)
    profile = SinusoidProfile([0.3], [0.1])
    u = profile([frequency], r)
    found = ask(r.tolist(), u.tolist())
    hand = hand_of(problem.arm, found["hand"])
    assert found["off"] <= 5e-3
    np.testing.assert_allclose(hand.curve(r, 0), u, atol=found["off"] * (1 + 1e-9))
    assert np.abs(hand.curve(r, 0) - u).max() == pytest.approx(found["off"], rel=1e-6)
    motion = Motion(problem.arm, problem.path, ProfileCurve(profile, np.array([frequency])), 0, 2000)
    told = curve_object(problem, hand, "hand")
    exact = Plan(problem, motion, "sinusoid", {}).cost
    assert told["cost"] == pytest.approx(exact, rel=2e-2)
    own = Plan(problem, Motion(problem.arm, problem.path, hand.curve, 0, 2000), "hand", {})
    assert told["cost"] == pytest.approx(own.cost, abs=own.cost_error + 1e-10)
    assert told["cost_sampled"] == own.cost_sampled


def test_a_curve_begins_and_ends_exactly_where_its_samples_do():
    r = np.linspace(0.0, 1.0, 200)
    u = np.column_stack([np.sin(9 * r), np.sqrt(r + 0.01)])
    coefficients, off = fitted(r, u)
    assert off > 1e-6  # it is not the samples that are a spline
    assert coefficients[:, 0].tolist() == u[0].tolist()
    assert coefficients[:, -1].tolist() == u[-1].tolist()


def test_the_fewest_coefficients_that_are_near_enough_are_taken():
    r = np.linspace(0, 1, 500)
    few, many = (np.asarray(ask(r.tolist(), u[:, None].tolist())["hand"]["coefficients"]) for u in
                 (0.3 + 0.2 * r, 0.3 + 0.3 * np.sin(2 * np.pi * 6 * r)))  # fmt: skip
    assert few.shape[1] == 8
    assert 8 < many.shape[1] < 200
    profile_off = fitted(r, (0.3 + 0.3 * np.sin(2 * np.pi * 6 * r))[:, None])[1]
    assert profile_off <= 5e-3


def test_what_no_curve_follows_is_said_to_be_off():
    r = np.linspace(0, 1, 400)
    coefficients, off = fitted(r, np.where(r < 0.5, 0.0, 1.0)[:, None])
    assert off > 0.2
    assert np.isfinite(coefficients).all()


def test_samples_that_wrap_become_one_curve_beyond_a_half_turn():
    r = np.linspace(0, 1, 300)
    u = 2.5 + 2.0 * r
    found = ask(r.tolist(), (np.mod(u + np.pi, 2 * np.pi) - np.pi)[:, None].tolist())
    hand = hand_of(problem_of(SEED, None).problem.arm, found["hand"])
    np.testing.assert_allclose(hand.curve(r, 0)[:, 0], u, atol=5e-3)


def test_few_samples_are_joined_by_lines_without_swinging():
    found = ask([0.1, 0.5, 0.9], [[0.2], [0.8], [0.1]])
    hand = hand_of(problem_of(SEED, None).problem.arm, found["hand"])
    u = hand.curve(np.linspace(0, 1, 500), 0)
    assert u.min() > 0.05
    assert u.max() < 0.85


def test_components_are_fitted_each_on_its_own():
    problem = next(case.problem for case in CASES if case.name == "circle-4r")
    r = np.linspace(0, 1, 200)
    u = np.stack([np.sin(r), np.cos(3 * r)], axis=1)
    found = ask(r.tolist(), u.tolist(), problem, "negative")
    hand = hand_of(problem_of(problem, None).problem.arm, found["hand"])
    assert hand.branch == 1
    np.testing.assert_allclose(hand.curve(r, 0), u, atol=5e-3)
    np.testing.assert_allclose(hand.curve(r, 1), np.stack([np.cos(r), -3 * np.sin(3 * r)], axis=1), atol=0.2)


@pytest.mark.parametrize(
    ("hand", "field"),
    [
        ({"branch": "positive", "coefficients": [[0.0] * 7]}, "hand.coefficients"),
        ({"branch": "positive", "coefficients": [[0.0] * 201]}, "hand.coefficients"),
        ({"branch": "positive", "coefficients": [[0.0] * 8] * 2}, "hand.coefficients"),
        ({"branch": "positive", "coefficients": [[2e3] * 8]}, "hand.coefficients"),
        ({"branch": "positive", "coefficients": [[float("nan")] * 8]}, "hand.coefficients"),
        ({"branch": "positive"}, "hand.coefficients"),
        ({"branch": "up", "coefficients": [[0.0] * 8]}, "hand.branch"),
        ({"coefficients": [[0.0] * 8]}, "hand.branch"),
        ([], "hand"),
    ],
)
def test_what_is_no_curve_of_this_arm_is_refused(hand, field):
    with pytest.raises(InvalidInputError) as found:
        hand_of(sm.PlanarArm([30, 30, 20]), hand)
    assert found.value.field == field


@pytest.mark.parametrize(
    ("r", "u", "field"),
    [
        ([0.0, 1.0], [[0.0]], "u"), ([0.0, 1.5], [[0.0], [0.0]], "r"), ([0.0], [[0.0]], "u"),
        ([0.0, 1.0], [[0.0, 1.0], [0.0, 1.0]], "u"), ([], [], "u"),
    ],
)  # fmt: skip
def test_samples_that_do_not_fit_are_refused(r, u, field):
    with pytest.raises(InvalidInputError) as found:
        ask(r, u)
    assert found.value.field == field
