"""A spline that nearly keeps the task, closed: the tool on the path, limits never broken, rates as differences say."""

import numpy as np
import pytest
from cases import random_arm, random_path
from hypothesis import given
from hypothesis import strategies as st

import selfmotion as sm
from selfmotion.refinement import ClosedSpline, SplineSpace
from selfmotion.refinement.follow import followed, on_task


def closed(seed, noise, on_limits=False):
    """A motion led along a random path, as a spline on few knots, disturbed, with some joints laid on their limits."""
    for k in range(50):
        rng = np.random.default_rng([seed, k])
        arm = random_arm(rng)
        path, box = random_path(rng, arm), arm.boxes()[0]
        lower = np.where(np.isfinite(box.lower), box.lower, -1.5)
        upper = np.maximum(np.where(np.isfinite(box.upper), box.upper, 1.5), lower + 0.2)
        q, ok = on_task(arm, path(0.0), box, rng.uniform(lower, upper, (20, arm.n)))
        r = np.linspace(0.0, 1.0, 201)
        motions, reached = followed(arm, path, box, q[ok], np.zeros_like(q[ok]), r)
        if not (reached == 1.0).any():
            continue
        motion = motions[np.argmax(reached == 1.0)]
        space = SplineSpace.with_spans(24, np.empty(0))
        at = space.collocation
        c = space.interpolating(np.stack([np.interp(at, r, joint) for joint in motion.T], axis=-1))
        c += noise * rng.normal(size=c.shape)
        c = np.clip(c, box.lower[:, None], box.upper[:, None])
        if on_limits:
            near = np.abs(c - box.lower[:, None]) < 0.02
            c = np.where(near, box.lower[:, None], c)
        return arm, path, box, ClosedSpline(arm, path, space, c, box)
    raise AssertionError("no random motion could be led along its path")


@given(st.integers(0, 10_000), st.sampled_from([0.0, 1e-4, 3e-3]), st.booleans())
def test_the_tool_is_on_the_path_and_no_limit_broken(seed, noise, on_limits):
    arm, path, box, motion = closed(seed, noise, on_limits)
    r = np.linspace(0.0, 1.0, 997)
    q = motion(r)
    assert min((q - box.lower).min(), (box.upper - q).min()) >= -1e-12
    if motion.correction(r).max() < 0.02:
        assert arm.task_error(q, path(r)).max() <= 1e-12 * arm.reach


def test_rates_are_the_derivative():
    for seed in range(30):
        arm, _, _, motion = closed(seed, 1e-3, on_limits=seed % 2 == 0)
        r = np.random.default_rng(seed).uniform(0.01, 0.99, 50)
        step = 1e-6
        differences = (motion(r + step) - motion(r - step)) / (2 * step)
        knots = motion.space.edges
        away = np.abs(r[:, None] - knots).min(axis=1) > 2 * step
        scale = np.abs(differences).max()
        assert motion.rates(r)[away] == pytest.approx(differences[away], abs=1e-5 * scale)
        assert motion(r).shape == (50, arm.n)


def test_a_joint_that_rides_its_limit_stays_there_to_the_last_bit():
    arm = sm.PlanarArm([1.0, 1.0, 1.0, 1.0], [None, (0.4, 2.0), None, None])
    path = sm.Line((2.0, -1.0), (2.0, 1.0))
    space = SplineSpace.with_spans(10, np.empty(0))
    box = arm.boxes()[0]
    r = np.linspace(0, 1, 201)
    q, ok = on_task(arm, path(0.0), box, np.array([[-0.9, 0.8, 0.4, 0.3]]))
    assert ok.all()
    motion = followed(arm, path, box, q, 0 * q, r)[0][0]
    c = space.interpolating(np.stack([np.interp(space.collocation, r, joint) for joint in motion.T], axis=-1))
    c[1] = 0.4
    riding = ClosedSpline(arm, path, space, c, box)
    q = riding(r)
    assert np.abs(q[:, 1] - 0.4).max() < 1e-15
    assert arm.task_error(q, path(r)).max() < 1e-13
    assert np.abs(riding.rates(r)[:, 1]).max() < 1e-12


def test_u_is_continuous_and_belongs_to_the_joints():
    arm, _, _, motion = closed(5, 0.0)
    r = np.linspace(0, 1, 2001)
    u = motion.u(r)
    assert np.abs(np.diff(u, axis=0)).max() < 0.5
    assert np.abs(np.sin(u - arm.u_of(motion(r)))).max() < 1e-12
