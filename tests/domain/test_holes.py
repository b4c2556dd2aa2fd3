"""What obstacles take of the angle domain: found wherever dense sampling finds it, and named by what is in the way."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.domain import AngleDomain, SampledDomain
from selfmotion.scene import CircleObstacle, PolygonObstacle

PATH = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
ARM = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None], thickness=1)
DENSE = np.linspace(-np.pi, np.pi, 6001)


def between(seed):
    rng = np.random.default_rng(seed)
    discs = [CircleObstacle(rng.uniform([0, -40], [70, 50]), rng.uniform(0.5, 6)) for _ in range(3)]
    corners = rng.uniform([20, 20], [40, 40]) + np.array([[0, 0], [15, 2], [10, 6], [3, 20]])
    return sm.Problem(ARM, PATH, obstacles=[*discs, PolygonObstacle(corners, name="clamp")], clearance=0.3)


@pytest.mark.parametrize("seed", range(4))
def test_intervals_end_where_dense_sampling_says(seed):
    problem = between(seed)
    domain = AngleDomain(problem.arm.self_motion(), PATH)
    for r in np.linspace(0, 1, 13):
        for branch in (0, 1):
            q, ok = problem.arm.solve(PATH(r)[None, None], DENSE[None, :, None], branch)
            q, ok = q.reshape(-1, 3), ok.ravel()
            limits = problem.arm.margins(q).min(axis=-1)
            kept = problem.scene.margins(q).min(axis=1)
            holds = ok & (limits >= 0) & (kept >= 0)
            found = domain(float(r), branch)
            clear = found.distance_to_ends(DENSE) > 1e-9 if len(found.intervals) else np.ones(len(DENSE), bool)
            # At the ends of what limits allow rounding decides.
            clear &= (np.abs(limits) > 1e-9) | ~ok
            assert (found.contains(DENSE) == holds)[clear].all(), (r, branch)


@pytest.mark.parametrize("seed", range(4))
def test_a_hole_is_where_limits_allow_and_its_obstacle_does_not(seed):
    problem = between(seed)
    domain = AngleDomain(problem.arm.self_motion(), PATH)
    sampled = SampledDomain(domain, [0], 40)
    for hole in sampled.holes(0):
        for strip in hole.strips:
            if not strip.causes[0]:
                continue
            for r, low, high in zip(strip.r, strip.low, strip.high, strict=True):
                if high - low < 1e-6:
                    continue
                for u in np.linspace(low, high, 5)[1:-1]:
                    assert domain.unconstrained(r, 0).contains(u)
                    assert not domain(r, 0).contains(u)
        r, u = hole.at
        q = problem.arm.solve(PATH(r)[None], [[u]], 0)[0]
        assert problem.scene.cause(int(problem.scene.margins(q)[0].argmin())) == hole.cause
        assert hole.cause.endswith(hole.by)


def test_the_least_of_margins_is_that_of_all_of_them():
    problem = between(0)
    q = np.random.default_rng(1).uniform(-3, 3, (4000, 3))
    margins = problem.scene.margins(q)
    least, which = problem.scene.least_margins(q)
    assert np.array_equal(least, margins.min(axis=1))
    assert np.array_equal(margins[np.arange(len(q)), which], least)


def test_without_obstacles_nothing_is_taken():
    domain = sm.angle_domain(ARM, PATH)
    assert domain.unconstrained is domain
    assert SampledDomain(domain, [0], 20).holes(0) == []
