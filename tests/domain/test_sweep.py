"""Sweeps of the self-motion at a point: on the task, inside the limits, ends in closed form, evenly spaced."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.angles import wrap


def random_case(rng):
    links = rng.uniform(0.2, 1, 3)
    fixed = rng.random() < 0.3
    n = 3 + fixed
    pairs = [None] * n
    for j in range(n):
        if rng.random() < 0.6:
            low = rng.uniform(-4, 2)
            pairs[j] = (low, low + rng.uniform(0.3, 8) if rng.random() < 0.8 else None)
    arm = sm.PlanarArm([*links, 0.3], pairs, direction=rng.uniform(-3, 3)) if fixed else sm.PlanarArm(links, pairs)
    center, inner, outer = arm.annulus
    radius, angle = rng.uniform(inner, outer), rng.uniform(-np.pi, np.pi)
    x = center + radius * np.array([np.cos(angle), np.sin(angle)])
    return arm, sm.angle_domain(arm, sm.Line(x, x + 1e-3)), x


def test_postures_reach_keep_limits_and_end_at_the_interval_s_ends():
    rng = np.random.default_rng(11)
    seen = 0
    for _ in range(1000):
        arm, domain, x = random_case(rng)
        for branch in (0, 1):
            intervals = domain(0.0, branch).intervals
            found = domain.sweep(0.0, branch, 7)
            parts = found.parts()
            assert len(parts) == len(intervals)
            for part, (low, high) in zip(parts, intervals, strict=True):
                seen += 1
                assert len(part.u) == (7 if high > low else 1)
                assert part.u[0] == low
                assert part.u[-1] == high
                assert (np.diff(part.u) >= 0).all()
            if len(found.u):
                assert arm.task_error(found.q, x).max() <= 1e-12 * arm.reach
                assert arm.margins(found.q).min() >= -1e-9
                assert np.abs(wrap(arm.u_of(found.q)[:, 0] - found.u)).max() < 1e-12
                assert arm.is_on_branch(found.q, branch, 1e-7).all()
    assert seen > 1000


def test_extreme_postures_without_limits_are_those_of_12_and_13_mended():
    """Independent of the code: Δ1 and Δ3 are angles of the triangle (l1 + l2, l3, R), by the cosine rule."""
    rng = np.random.default_rng(12)
    for _ in range(500):
        l1, l2, l3 = links = rng.uniform(0.2, 1, 3)
        arm = sm.PlanarArm(links)
        reach, ring = l1 + l2, arm.radii()
        inner = max(abs(reach - l3), ring.coregular[0])  # above ρ1 the ends of the interval are the stretched postures
        radius = inner + rng.uniform(0.05, 0.95) * (ring.outer - inner)
        psi = rng.uniform(-np.pi, np.pi)
        x = radius * np.array([np.cos(psi), np.sin(psi)])
        delta1 = np.arccos((radius**2 + reach**2 - l3**2) / (2 * radius * reach))
        delta3 = np.arccos((reach**2 + l3**2 - radius**2) / (2 * reach * l3))
        for branch in (0, 1):
            q = sm.angle_domain(arm, sm.Line(x, 1.001 * x)).sweep(0.0, branch, 2).q
            assert (q[:, 1] == 0.0).all()
            expected = [[psi + delta1, 0.0, -(np.pi - delta3)], [psi - delta1, 0.0, np.pi - delta3]]
            np.testing.assert_allclose(wrap(q - expected), 0.0, atol=1e-9)


def test_postures_are_equally_far_apart():
    domain = sm.angle_domain(sm.PlanarArm([30, 30, 20]), sm.Line([50, -10], [60, 0]))
    for branch in (0, 1):
        steps = np.linalg.norm(wrap(np.diff(domain.sweep(0.0, branch, 25).q, axis=0)), axis=1)
        assert steps.max() < 1.03 * steps.min()
    assert len(domain.sweep(0.0).u) == 25 * len(domain(0.0, 0).intervals)  # unless another number is asked for


def test_a_limit_that_ends_an_interval_is_met_exactly():
    arm = sm.PlanarArm([30, 30, 20], [None, (0.3, 1.2), None])
    q = sm.angle_domain(arm, sm.Line([50, -10], [60, 0])).sweep(0.0, "positive", 5).q
    ends = {float(value) for value in np.round(q[[0, 4], 1], 15)}
    assert ends <= {0.3, 1.2}


def test_a_full_circle_returns_to_its_start():
    found = sm.angle_domain(sm.PlanarArm([1, 1, 0.5]), sm.Line([1.0, 0.1], [1.0, 0.5])).sweep(0.5)
    np.testing.assert_allclose(wrap(found.q[0] - found.q[-1]), 0.0, atol=1e-12)
    np.testing.assert_array_equal(found.u[[0, -1]], [-np.pi, np.pi])


def test_parts_are_the_intervals_in_their_order():
    arm = sm.PlanarArm([30, 30, 20], [None, (0.3, 1.2), None])
    found = sm.angle_domain(arm, sm.Line([50, -10], [60, 0])).sweep(0.0, "positive", 5)
    parts = found.parts()
    assert [set(part.interval) for part in parts] == [{0}, {1}]
    for name in found._fields:
        np.testing.assert_array_equal(np.concatenate([getattr(part, name) for part in parts]), getattr(found, name))


def test_out_of_reach_there_is_nothing_to_sweep():
    found = sm.angle_domain(sm.PlanarArm([1, 1, 1]), sm.Line([4, 0], [5, 0])).sweep(0.0)
    assert found.q.shape == (0, 3)
    assert found.parts() == []


@pytest.mark.parametrize(("count", "branch"), [(1, 0), (2.5, 0), (5, "up"), (5, 2)])
def test_bad_arguments_are_named(count, branch):
    domain = sm.angle_domain(sm.PlanarArm([1, 1, 1]), sm.Line([1, 0], [2, 0]))
    with pytest.raises(sm.InvalidInputError, match=r"count|branch"):
        domain.sweep(0.0, branch, count)
