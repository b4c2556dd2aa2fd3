"""Radii and the number of self-motion curves, the latter against curves that are put together piece by piece."""

import itertools

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.angles import wrap
from selfmotion.domain import feasible_arcs


def curves(arm, x):
    """Return the number of connected parts of the self-motion at `x`, joined where postures coincide."""
    self_motion = arm.self_motion()
    parts, ends = 0, []
    for branch, arcs in enumerate(feasible_arcs(self_motion, x[None])):
        found = arcs.interval_set(0)
        for low, high in found:
            if not found.is_full:  # without limits both ends of an interval are folds
                q, _ = arm.solve(x, np.array([[low], [high]]), branch)
                ends += [(parts, q[0]), (parts, q[1])]
            parts += 1
    leader = list(range(parts))
    same = 1e-6 * np.sqrt(arm.links.max() / arm.links.min())  # a fold is known to the square root of the rounding

    def find(k):
        while leader[k] != k:
            k = leader[k]
        return k

    for (a, qa), (b, qb) in itertools.combinations(ends, 2):
        if np.abs(wrap(qa - qb)).max() < same:
            leader[find(a)] = find(b)
    return len({find(k) for k in range(parts)})


def random_arm(rng):
    shape = rng.integers(5)
    links = [
        lambda: rng.uniform(0.2, 1, 3),
        lambda: np.full(3, rng.uniform(0.5, 2)),
        lambda: np.array([1.0, 1.0, rng.uniform(0.1, 3)])[rng.permutation(3)],
        lambda: 10 ** rng.uniform(-3, 3, 3),
        lambda: np.array([1.0, rng.uniform(0.1, 1), rng.choice([1.0, 1e-3, 50.0])]),
    ][shape]()
    if rng.random() < 0.3:
        return sm.PlanarArm([*links, rng.uniform(0.1, 1) * links.max()], direction=rng.uniform(-np.pi, np.pi))
    return sm.PlanarArm(links)


def test_number_of_curves_on_10000_random_arms():
    rng = np.random.default_rng(5)
    seen = set()
    for _ in range(10_000):
        arm = random_arm(rng)
        radii = arm.radii()
        marks = np.array([0.0, *radii.coregular[::-1], radii.outer, 1.1 * radii.outer])
        k = rng.integers(5)
        radius = marks[k] + rng.uniform(0.02, 0.98) * (marks[k + 1] - marks[k])
        if np.abs(radius - marks).min() < 1e-6 * radii.outer:  # such as an empty range between equal radii
            continue
        angle = rng.uniform(-np.pi, np.pi)
        x = radii.center + radius * np.array([np.cos(angle), np.sin(angle)])
        count = int(radii.self_motions(radius))
        seen.add((int(k), count))
        assert count == curves(arm, x), (arm, radius)
    assert seen == {(4, 0), (3, 1), (2, 2), (1, 1), (0, 2), (0, 0)}


def test_radii_of_the_seed_s_arm(seed_arm):
    radii = seed_arm.radii()
    assert radii.outer == 80
    assert radii.nearest == pytest.approx(56.5685424949238, rel=1e-15)
    assert radii.coregular == (40, 20, 20)
    assert radii.self_motions([81, 80, 79, 40, 39, 20, 19]).tolist() == [0, 1, 1, 1, 2, 1, 2]


def test_at_the_nearest_radius_the_third_link_turns_a_quarter_to_either_side(seed_arm):
    arm = sm.PlanarArm(seed_arm.links)
    radius = arm.radii().nearest
    ends = sm.angle_domain(arm, sm.Line([radius, 0], [radius + 1, 0]))(0.0).intervals
    np.testing.assert_allclose(ends, [[-np.pi / 2, np.pi / 2]], atol=1e-12)


def test_a_long_last_link_has_no_nearest_radius():
    assert np.isnan(sm.PlanarArm([1, 1, 3]).radii().nearest)
    assert sm.PlanarArm([1, 1, 2]).radii().nearest == 0
    assert sm.PlanarArm([1, 1, 3]).radii().self_motions([0.5, 0.99, 1.5]).tolist() == [0, 0, 1]


def test_more_redundancy_is_refused():
    with pytest.raises(sm.InvalidInputError, match="these radii need exactly one"):
        sm.PlanarArm([1, 1, 1, 1]).radii()
