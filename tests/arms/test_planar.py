"""Planar arms: FK∘IK is the identity, on folds and co-regular radii too; derivatives are those of the IK."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.arms import RedundantArm, SelfMotion


def unit(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def random_targets(rng, links, count):
    """Targets that the arm reaches for random u: inside, on both folds and on the co-regular radii."""
    l1, l2 = links[:2]
    u = rng.uniform(-np.pi, np.pi, (count, len(links) - 2))
    special = rng.integers(0, 6, count)
    u[special == 4] = np.pi * rng.integers(-1, 2, (int((special == 4).sum()), len(links) - 2))  # aligned links
    d = rng.uniform(abs(l1 - l2), l1 + l2, count)
    d = np.where(special == 1, l1 + l2, np.where(special == 2, abs(l1 - l2), d))
    near_fold = (l1 + l2) * (1 - 10.0 ** rng.uniform(-16, -6, count))
    d = np.where(special == 3, np.maximum(near_fold, abs(l1 - l2)), d)
    phi = np.where(special == 4, 0.0, rng.uniform(-np.pi, np.pi, count))
    x = d[:, None] * unit(phi) + np.stack([np.cos(u) @ links[2:], np.sin(u) @ links[2:]], axis=-1)
    return x, u


@pytest.mark.parametrize("n", range(3, 13))
def test_forward_of_inverse_is_the_identity(n):
    """10 arms × 10,000 targets for each n: one million in all, to 1e-12 of the reach."""
    rng = np.random.default_rng(n)
    for trial in range(10):
        links = rng.uniform(0.1, 3.0, n) if trial < 8 else np.ones(n) * rng.uniform(0.1, 3)
        if trial == 7:
            links[0] *= 1e-3
        arm = sm.PlanarArm(links)
        x, u = random_targets(rng, links, 10_000)
        branch = trial % 2
        q, ok = arm.solve(x, u, branch)
        assert ok.all()
        assert np.abs(arm.forward(q) - x).max() <= 1e-12 * arm.reach
        assert (np.abs(q) <= np.pi + 1e-15).all()
        sign = 1 - 2 * branch
        assert (sign * np.sin(q[:, 1]) >= -1e-15).all()
        turned = arm.u_of(q) - u
        np.testing.assert_allclose(np.sin(turned / 2), 0.0, atol=1e-14 * n)


@pytest.mark.parametrize("signs", [(1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)])
def test_co_regular_radii(signs):
    """All links on one line: the postures in which components of the self-motion meet."""
    rng = np.random.default_rng(5)
    for _ in range(200):
        links = rng.uniform(0.2, 2, 3)
        arm = sm.PlanarArm(links)
        psi = rng.uniform(-np.pi, np.pi)
        x = np.dot(signs, links) * unit(psi)
        u = psi if signs[2] > 0 else psi + np.pi
        for branch in (0, 1):
            q, ok = arm.solve(x, [u], branch)
            assert ok
            np.testing.assert_allclose(arm.forward(q), x, atol=1e-12 * arm.reach)


def test_every_corner_of_reach_is_reached():
    arm = sm.PlanarArm([3, 2, 1])
    for radius, u in ((6.0, 0.0), (4.0, np.pi), (2.0, 0.0)):
        q, ok = arm.solve([radius, 0.0], [u])
        assert ok
        np.testing.assert_allclose(arm.forward(q), [radius, 0], atol=1e-14)
    assert not arm.solve([6.0 + 1e-9, 0.0], [0.0])[1]
    assert arm.reach_margin([6.5, 0.0], [0.0]) == pytest.approx(-0.5)


def test_seed_formulas_with_the_misprints_mended():
    """(2)–(7) written out, l3 in (2) and c2, s2 in (5)(6)."""
    rng = np.random.default_rng(1)
    l1, l2, l3 = 30.0, 30.0, 20.0
    arm = sm.PlanarArm([l1, l2, l3])
    u = rng.uniform(-1, 1, 500)
    x = np.column_stack([rng.uniform(40, 60, 500), rng.uniform(-20, 20, 500)])
    w = x - l3 * unit(u)
    c2 = ((w**2).sum(1) - l1**2 - l2**2) / (2 * l1 * l2)
    keep = np.abs(c2) < 0.999
    for branch, sign in ((0, 1), (1, -1)):
        s2 = sign * np.sqrt(np.where(keep, 1 - c2**2, 0))
        delta = (w**2).sum(1)
        s1 = ((l1 + l2 * c2) * w[:, 1] - l2 * s2 * w[:, 0]) / delta
        c1 = ((l1 + l2 * c2) * w[:, 0] + l2 * s2 * w[:, 1]) / delta
        theta1, theta2 = np.arctan2(s1, c1), np.arctan2(s2, c2)
        expected = np.column_stack([theta1, theta2, u - theta2 - theta1])[keep]
        q = arm.solve(x, u[:, None], branch)[0][keep]
        np.testing.assert_allclose(np.sin((q - expected) / 2), 0, atol=1e-12)


@pytest.mark.parametrize(("links", "direction"), [([3, 2, 1], None), ([1, 1, 1, 1, 1], None), ([7, 7, 4, 1.5], -1.0)])
def test_derivatives_against_finite_differences(links, direction):
    rng = np.random.default_rng(2)
    arm = sm.PlanarArm(links, direction=direction)
    u = rng.uniform(-1, 1, (300, arm.n_u))
    full = u if direction is None else np.column_stack([u, np.full(300, direction)])
    d = rng.uniform(0.3, 0.9, 300) * (links[0] + links[1])
    x = d[:, None] * unit(rng.uniform(-3, 3, 300))
    x = x + np.stack([np.cos(full) @ np.array(links[2:]), np.sin(full) @ np.array(links[2:])], axis=-1)
    h = 1e-5
    for branch in (0, 1):
        dq_du, dq_dx = arm.derivative(x, u, branch)
        for j in range(arm.n_u):
            step = h * np.eye(arm.n_u)[j]
            change = arm.solve(x, u + step, branch)[0] - arm.solve(x, u - step, branch)[0]
            np.testing.assert_allclose(dq_du[..., j], 2 * np.arcsin(np.sin(change / 2)) / (2 * h), atol=2e-7)
        for j in range(2):
            step = h * np.eye(2)[j]
            change = arm.solve(x + step, u, branch)[0] - arm.solve(x - step, u, branch)[0]
            np.testing.assert_allclose(dq_dx[..., j], 2 * np.arcsin(np.sin(change / 2)) / (2 * h), atol=2e-7)


def test_jacobian_against_finite_differences_and_rates():
    rng = np.random.default_rng(3)
    for direction in (None, 0.3):
        arm = sm.PlanarArm([2, 1.5, 1, 0.5], direction=direction)
        q = rng.uniform(-2, 2, (50, 4))
        jacobian = arm.jacobian(q)
        for j in range(4):
            step = 1e-6 * np.eye(4)[j]
            slope = (arm.forward(q + step) - arm.forward(q - step)) / 2e-6
            np.testing.assert_allclose(jacobian[:, :2, j], slope, atol=1e-8)
        assert jacobian.shape == (50, 2 if direction is None else 3, 4)
    still = sm.PlanarArm([2, 1.5, 1, 0.5])
    x, u = still.forward(q), still.u_of(q)
    rates = still.rates(x, np.zeros(2), u, np.ones(2), 0)
    held = np.einsum("kij,kj->ki", still.jacobian(still.solve(x, u, 0)[0]), rates)
    np.testing.assert_allclose(held, 0, atol=1e-9)  # self-motion holds the tool still


def test_manipulability_is_zero_exactly_where_the_arm_is_stretched():
    arm = sm.PlanarArm([2, 1, 1])
    assert arm.manipulability([0.3, 0, 0]) == pytest.approx(0, abs=1e-7)
    assert arm.manipulability([0.3, 1, 1]) > 0.5
    q = np.array([0.3, 1.0, -0.7])
    singular_values = np.linalg.svd(arm.jacobian(q), compute_uv=False)
    assert arm.manipulability(q) == pytest.approx(np.prod(singular_values))


def test_fixed_direction_turns_a_4r_into_a_3r():
    arm = sm.PlanarArm([7, 7, 4, 1.5], direction=-np.pi / 3)
    short = sm.PlanarArm([7, 7, 4])
    x = np.array([9.0, 3.0])
    q, ok = arm.solve(x, [0.4], "negative")
    assert ok
    np.testing.assert_allclose(q[:3], short.solve(x - 1.5 * unit(-np.pi / 3), [0.4], 1)[0])
    assert np.cos(q.sum() + np.pi / 3) == pytest.approx(1.0)
    center, inner, outer = arm.annulus
    np.testing.assert_allclose(center, 1.5 * unit(-np.pi / 3))
    assert (inner, outer) == (0.0, 18.0)


def test_annulus_is_what_random_postures_reach():
    rng = np.random.default_rng(4)
    for links in ([3, 1, 0.5], [1, 5, 1, 0.5], [1, 1, 1]):
        arm = sm.PlanarArm(links)
        distance = np.linalg.norm(arm.forward(rng.uniform(-np.pi, np.pi, (200_000, len(links)))), axis=1)
        _, inner, outer = arm.annulus
        assert distance.min() >= inner - 1e-12
        assert distance.max() <= outer + 1e-12
        assert distance.min() <= inner + 0.1
        assert distance.max() >= outer - 0.1


def test_protocols_are_met():
    assert isinstance(sm.PlanarArm([1, 1, 1]), RedundantArm)
    assert isinstance(sm.PlanarArm([1, 1, 1]).self_motion(), SelfMotion)
    line = sm.PlanarArm([1, 1, 1, 1]).line([0.1, 0.2], [1.0, 0.5])
    assert not line.periodic
    q, ok = line.solve(line.pose([[2.0, 0.5]]), [[0.0, 0.3]], 0)
    assert q.shape == (1, 2, 4)
    np.testing.assert_allclose(line.arm.forward(q[ok]), [2.0, 0.5] * np.ones((ok.sum(), 1)), atol=1e-14)
    with pytest.raises(sm.InvalidInputError):
        sm.PlanarArm([1, 1, 1, 1]).self_motion()


@given(
    low=st.floats(-8, 8),
    span=st.one_of(st.just(0.0), st.floats(0, 9)),
    angles=st.lists(st.floats(-20, 20), min_size=1, max_size=5),
)
def test_excess_is_the_distance_to_the_limits_modulo_turns(low, span, angles):
    limits = sm.PlanarArm([1, 1, 1], [(low, low + span), None, None]).limits
    for angle in angles:
        nearest = min(
            max(low - (angle + 2 * np.pi * k), (angle + 2 * np.pi * k) - low - span, 0.0) for k in range(-8, 9)
        )
        assert limits.excess([angle, 99.0, 99.0])[0] == pytest.approx(nearest, abs=1e-12)
        assert limits.excess([angle, 99.0, 99.0])[1] == 0


@given(low=st.floats(-12, 6), span=st.floats(0, 9), start=st.floats(-3, 3), travel=st.floats(-8, 8))
def test_lifting_finds_the_turns_that_fit_if_any_do(low, span, start, travel):
    arm = sm.PlanarArm([1, 1, 1], [(low, low + span), None, None])
    true = np.linspace(start, start + travel, 60)
    wrapped = np.stack([np.angle(np.exp(1j * true)), np.zeros(60), np.zeros(60)], axis=-1)
    lifted = arm.limits.lift(wrapped[None])
    np.testing.assert_allclose(np.diff(lifted.q[0, :, 0]), np.diff(true), atol=1e-12)
    possible = [
        max(low - (min(true) + 2 * np.pi * k), 0.0) + max(max(true) + 2 * np.pi * k - low - span, 0.0)
        for k in range(-6, 7)
    ]
    assert lifted.excess[0, 0] == pytest.approx(min(possible), abs=1e-9)
    assert lifted.excess[0, 1] == 0


def test_half_open_limits_and_a_given_start():
    limits = sm.PlanarArm([1, 1, 1], [(3.5, None), (None, -4.0), None]).limits
    q = np.zeros((1, 5, 3))
    lifted = limits.lift(q.copy())
    assert (lifted.q[0, :, 0] == 2 * np.pi).all()
    assert (lifted.q[0, :, 1] == -2 * np.pi).all()
    assert not lifted.excess.any()
    assert limits.as_list() == [[3.5, None], [None, -4.0], None]
    started = limits.lift(q.copy(), start=[4 * np.pi, -2 * np.pi, 2 * np.pi])
    np.testing.assert_allclose(started.q[0, 0], [4 * np.pi, -2 * np.pi, 2 * np.pi])


BAD = {
    "two links": lambda: sm.PlanarArm([1, 1]),
    "zero link": lambda: sm.PlanarArm([1, 0, 1]),
    "negative link": lambda: sm.PlanarArm([1, -1, 1]),
    "NaN link": lambda: sm.PlanarArm([1, np.nan, 1]),
    "huge link": lambda: sm.PlanarArm([1, 1e200, 1]),
    "text": lambda: sm.PlanarArm("abc"),
    "booleans": lambda: sm.PlanarArm([True, True, True]),
    "lost link": lambda: sm.PlanarArm([1, 1e-17, 1]),
    "reversed limits": lambda: sm.PlanarArm([1, 1, 1], [(1, -1), None, None]),
    "number of limits": lambda: sm.PlanarArm([1, 1, 1], [None]),
    "limit of one number": lambda: sm.PlanarArm([1, 1, 1], [(1,), None, None]),
    "NaN limit": lambda: sm.PlanarArm([1, 1, 1], [(np.nan, 1), None, None]),
    "limits as text": lambda: sm.PlanarArm([1, 1, 1], "abc"),
    "direction of a 3R": lambda: sm.PlanarArm([1, 1, 1], direction=0.0),
    "branch": lambda: sm.PlanarArm([1, 1, 1]).solve([1, 0], [0.0], "left"),
    "branch index": lambda: sm.PlanarArm([1, 1, 1]).solve([1, 0], [0.0], 2),
    "u too long": lambda: sm.PlanarArm([1, 1, 1]).solve([1, 0], [0.0, 1.0]),
    "q too short": lambda: sm.PlanarArm([1, 1, 1]).forward([1, 0]),
    "x too long": lambda: sm.PlanarArm([1, 1, 1]).solve([1, 0, 0], [0.0]),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_arms_are_refused_by_field(case):
    with pytest.raises(sm.InvalidInputError) as caught:
        BAD[case]()
    assert caught.value.field
