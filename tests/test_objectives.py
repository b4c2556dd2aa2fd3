"""Objectives: integrals with true error bounds, chord sums below them, and known values."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion import _objective_kernels as kernels
from selfmotion.angles import wrap
from selfmotion.motion import Motion
from selfmotion.objectives import OBJECTIVES, joint_weights
from selfmotion.profiles import SinusoidProfile

PROFILE = SinusoidProfile([0.3], [0.4])


def seed_motion(arm, path, f):
    return Motion(arm, path, lambda r, order: PROFILE(np.array([f]), r, order), 0, 4000)


def gauss_legendre(motion, objective, nodes):
    from scipy.special import roots_legendre

    x, w = roots_legendre(nodes)
    return w @ objective.chord(motion.rates((x + 1) / 2), np.ones(nodes), np.ones(3)) / 2


@pytest.mark.parametrize("f", [0.5385, 3.0, 15.0])
def test_the_integral_and_its_error_bound(seed_arm, seed_path, f):
    """Against Gauss–Legendre on ever more panels, a rule that shares no node with ours."""
    motion, travel = seed_motion(seed_arm, seed_path, f), OBJECTIVES["joint_travel"]()
    ours = travel.integral(motion.rates, seed_path.grid(64), np.ones(3))
    x, w = np.polynomial.legendre.leggauss(40)
    sums = []
    for panels in (2000, 5000):
        edges = np.linspace(0, 1, panels + 1)
        r = (edges[:-1, None] + np.diff(edges)[:, None] * (x + 1) / 2).ravel()
        values = travel.chord(motion.rates(r), np.ones(len(r)), np.ones(3)).reshape(panels, -1)
        sums.append(float((values @ w).sum() / 2 / panels))
    settled = abs(sums[1] - sums[0])
    assert settled < 1e-9
    assert abs(ours.value - sums[1]) <= ours.error + settled
    assert ours.error <= 1e-8


def test_at_the_best_f_within_1e8_of_4000_nodes(seed_arm, seed_path):
    motion, travel = seed_motion(seed_arm, seed_path, 0.5385), OBJECTIVES["joint_travel"]()
    ours = travel.integral(motion.rates, seed_path.grid(64), np.ones(3))
    assert ours.value == pytest.approx(gauss_legendre(motion, travel, 4000), abs=1e-8)


@pytest.mark.parametrize("kind", OBJECTIVES)
def test_chord_sums_rise_to_the_integral(seed_arm, seed_path, kind):
    motion, objective = seed_motion(seed_arm, seed_path, 1.7), OBJECTIVES[kind]()
    integral = objective.integral(motion.rates, seed_path.grid(64), np.ones(3))
    last = 0.0
    for samples in (11, 101, 1001, 10_001):
        r = np.linspace(0, 1, samples)
        chord = objective.sampled(motion(r), r, np.ones(3))
        assert last <= chord + 1e-12
        assert chord <= integral.value + integral.error
        last = chord
    assert last == pytest.approx(integral.value, abs=1e-5)


def test_known_values_on_straight_joint_lines():
    r, weights = np.linspace(0, 1, 5), np.array([1.0, 2.0, 0.5])
    q = np.outer(r, [3.0, -4.0, 0.0])
    assert OBJECTIVES["joint_travel"]().sampled(q, r, weights) == pytest.approx(10**0.5 + 2 * 17**0.5 + 0.5)
    assert OBJECTIVES["l1"]().sampled(q, r, weights) == pytest.approx(3 + 8)
    assert OBJECTIVES["l2"]().sampled(q, r, weights) == pytest.approx((9 + 64) ** 0.5)
    assert OBJECTIVES["joint_travel"]().sampled(0 * q, r, np.ones(3)) == pytest.approx(3.0)  # the floor: n


@pytest.mark.parametrize("kind", OBJECTIVES)
def test_every_objective_is_convex_and_homogeneous(kind):
    rng, chord = np.random.default_rng(0), OBJECTIVES[kind].chord
    a, b = rng.normal(size=(2, 500, 3))
    ha, hb = rng.random((2, 500))
    weights = rng.random(3)
    both = chord(a, ha, weights) + chord(b, hb, weights)
    assert (chord(a + b, ha + hb, weights) <= both + 1e-12).all()
    np.testing.assert_allclose(chord(2.5 * a, 2.5 * ha, weights), 2.5 * chord(a, ha, weights))


def numeric(function, at, step):
    """Derivatives by central differences of a function of rates (k, n), joint by joint."""
    sides = [[function(at + sign * step * one) for sign in (1, -1)] for one in np.eye(at.shape[1])]
    return np.stack([(above - below) / (2 * step) for above, below in sides], axis=-1)


@pytest.mark.parametrize("kind", OBJECTIVES)
def test_smoothed_densities_have_the_derivatives_that_they_say(kind):
    """Against differences: gradient from values, the Hessian from gradients; a majorant lies above the Hessian."""
    rng, smoothed, weights = np.random.default_rng(4), OBJECTIVES[kind].smoothed, np.array([0.3, 1.0, 2.5])
    rates = rng.normal(size=(40, 3))
    at = smoothed(rates, weights, 0.2)
    np.testing.assert_allclose(at.gradient, numeric(lambda x: smoothed(x, weights, 0.2).value, rates, 1e-5), atol=1e-8)
    hessian = numeric(lambda x: smoothed(x, weights, 0.2).gradient, rates, 1e-5)
    np.testing.assert_allclose(at.diagonal, np.einsum("kii->ki", hessian), atol=1e-8)
    v = rng.normal(size=(40, 3))
    np.testing.assert_allclose(at.times(v), np.einsum("kij,kj->ki", hessian, v), atol=1e-7)
    above = np.einsum("ki,ij->kij", at.majorant, np.eye(3)) - hessian
    assert (np.linalg.eigvalsh(above) > -1e-8).all()
    # Near the kink it is the Hessian, and so no more than is needed.
    flat = smoothed(np.zeros((1, 3)), weights, 0.2)
    np.testing.assert_allclose(flat.majorant, flat.diagonal)


@pytest.mark.parametrize("kind", OBJECTIVES)
def test_smoothing_adds_at_most_its_width(kind):
    objective, weights = OBJECTIVES[kind], np.array([0.3, 1.0, 2.5])
    rates = np.vstack([np.zeros(3), np.random.default_rng(5).normal(size=(40, 3))])
    added = objective.smoothed(rates, weights, 0.2).value - objective.chord(rates, np.ones(41), weights)
    most = {"joint_travel": 0.0, "l1": 0.2 * weights.sum(), "l2": 0.2}[kind]
    assert (added >= -1e-12).all()
    assert (added <= most + 1e-12).all()
    assert added[0] == pytest.approx(most)
    assert objective.has_kinks == (most > 0)


@pytest.mark.parametrize("kind", OBJECTIVES)
def test_compiled_sums_and_densities_are_those_of_numpy(kind):
    """On a sheet with rows of others, whose samples beyond k are not looked at; steps are the shorter way round."""
    rng, objective, number = np.random.default_rng(6), OBJECTIVES[kind], kernels.KINDS[kind]
    for n, k in ((1, 1), (3, 7), (4, 20)):
        weights, runs = rng.random(n), rng.random(k)
        sheet = 1e3 * rng.normal(size=(n + 3, k + 3))
        sheet[2 : n + 2] = rng.uniform(-np.pi, np.pi, (n, k + 3))
        steps = wrap(np.diff(sheet[2 : n + 2, : k + 1].T, axis=0))
        wanted = objective.chord(steps, runs, weights)
        found = kernels.chord_sum(number, runs, weights, k, sheet.copy(), 2, n + 2)
        assert found == pytest.approx(wanted.sum(), rel=1e-13)
        filled = sheet.copy()
        kernels.densities(number, weights, k, filled, 2, 0)
        density = objective.chord(sheet[2 : n + 2, 1 : k + 1].T, np.ones(k), weights)
        np.testing.assert_allclose(filled[0, :k], density, rtol=1e-13)
        filled[0, :k] = sheet[0, :k]
        np.testing.assert_array_equal(filled, sheet)


def test_weights_may_be_left_out_and_some_may_be_zero():
    np.testing.assert_array_equal(joint_weights(None, 3), np.ones(3))
    np.testing.assert_array_equal(joint_weights([0, 0.5, 0], 3), [0.0, 0.5, 0.0])


@pytest.mark.parametrize("bad", [[1, 1], [1, -1, 1], [0, 0, 0], [1, np.nan, 1], "abc"])
def test_bad_weights_are_refused(bad):
    with pytest.raises(sm.InvalidInputError):
        joint_weights(bad, 3)


def test_l1_of_random_motions_against_the_sum_between_turning_points():
    """l1 is Σ|Δθ| over the pieces on which a joint is monotone: a fine grid, its turns refined, and no quadrature."""
    rng = np.random.default_rng(3)
    checked = 0
    while checked < 25:
        arm = sm.PlanarArm(rng.uniform(0.8, 1.2, 3))
        start, end = rng.uniform(-0.5, 0.5, (2, 2))
        path = sm.Line(start + np.array([1.6, 0.0]), end + np.array([1.6, 0.5]))
        profile, f = SinusoidProfile([rng.uniform(-0.3, 0.3)], [0.2]), np.array([rng.uniform(0, 4)])
        motion = Motion(arm, path, lambda r, order, p=profile, f=f: p(f, r, order), 0, 4000)
        r = np.linspace(0, 1, 40_001)
        if arm.reach_margin(path(r), motion.u(r)).min() < 0.05:
            continue
        exact = 0.0
        for joint in range(3):
            rates = motion.rates(r)[:, joint]
            turns = np.flatnonzero(np.sign(rates[1:]) * np.sign(rates[:-1]) < 0)
            low, high = r[turns].copy(), r[turns + 1].copy()
            for _ in range(50):
                middle = (low + high) / 2
                same = np.sign(motion.rates(middle)[:, joint]) == np.sign(rates[turns])
                low, high = np.where(same, middle, low), np.where(same, high, middle)
            exact += np.abs(np.diff(motion(np.concatenate([[0.0], low, [1.0]]))[:, joint])).sum()
        ours = OBJECTIVES["l1"]().integral(motion.rates, path.grid(250), np.ones(3))
        assert abs(ours.value - exact) <= ours.error + 1e-12
        assert ours.error < 1e-8
        checked += 1
