"""Derivatives against differences, and what the ends fix."""

import numpy as np
import pytest
from cases import ENDS, random_arm, random_collocation

from selfmotion.objectives import OBJECTIVES
from selfmotion.refinement.linear import BandedLinear, DenseLinear

STEP = 1e-5


def central(function, c, d, step=STEP):
    """Fourth-order central difference of `function` along d."""
    one = np.asarray(function(c + step * d)) - np.asarray(function(c - step * d))
    two = np.asarray(function(c + 2 * step * d)) - np.asarray(function(c - 2 * step * d))
    return (8 * one - two) / (12 * step)


def relative(found, wanted):
    return np.abs(found - wanted).max() / max(np.abs(wanted).max(), 1e-3)


@pytest.mark.parametrize("objective", OBJECTIVES)
@pytest.mark.parametrize("ends", ENDS)
def test_the_gradient_and_the_hessian_are_those_of_the_cost(objective, ends):
    for seed in range(8):
        rng = np.random.default_rng(seed)
        problem, c = random_collocation(rng, ends, objective)
        d = rng.normal(size=c.shape)
        density = problem.density(c)
        slope = float((problem.gradient(density) * d).sum())
        assert slope == pytest.approx(float(central(problem.cost, c, d)), rel=1e-6, abs=1e-8)
        bent = central(lambda at: problem.gradient(problem.density(at)), c, d)  # noqa: B023
        assert relative(problem.curvature(density, d), bent) < 1e-6


@pytest.mark.parametrize("ends", ENDS)
def test_the_task_and_its_multipliers_have_their_derivatives(ends):
    for seed in range(8):
        rng = np.random.default_rng(100 + seed)
        problem, c = random_collocation(rng, ends)
        d = rng.normal(size=c.shape)
        linear = _linear(problem, c)
        moved = central(lambda at: -problem.lack(problem.postures(at)), c, d)  # noqa: B023
        assert relative(linear.task(d), moved) < 1e-6
        y = rng.normal(size=moved.shape)
        assert float((linear.transposed(y) * d).sum()) == pytest.approx(float((y * linear.task(d)).sum()), rel=1e-10)


def test_the_jacobian_changes_as_its_rate_says():
    for seed in range(40):
        rng = np.random.default_rng(seed)
        arm = random_arm(rng)
        q, dq, y = (rng.normal(size=(3, arm.n)) for _ in range(3))
        rate = central(arm.jacobian, q, dq)
        assert relative(arm.jacobian_rate(q, dq), rate) < 1e-8
        # Second derivatives commute: the rate along a, applied to b, is the rate along b, applied to a.
        ab = np.einsum("ktn,kn->kt", arm.jacobian_rate(q, dq), y)
        ba = np.einsum("ktn,kn->kt", arm.jacobian_rate(q, y), dq)
        assert ab == pytest.approx(ba, abs=1e-12 * arm.reach)


@pytest.mark.parametrize("ends", ENDS)
def test_the_tangent_keeps_the_task_to_first_order_and_the_gradient_along_it_is_the_reduced_one(ends):
    for seed in range(4):
        rng = np.random.default_rng(200 + seed)
        problem, c = random_collocation(rng, ends)
        linear = _linear(problem, c)
        d = linear.tangent(rng.normal(size=c.shape))
        assert np.abs(linear.task(d)).max() < 1e-9 * problem.arm.reach * np.abs(d).max()
        assert linear.product(d, d) == pytest.approx(float((d * np.einsum("iab,ib->ia", linear.matrices, d)).sum()))


@pytest.mark.parametrize("ends", ENDS)
def test_the_ends_are_what_they_are_said_to_be(ends):
    problem, c = random_collocation(np.random.default_rng(7), ends)
    full = problem.coefficients(c)
    first, last = problem.space.spline(full)(np.array([0.0, 1.0]))
    if problem.ends.start is not None:
        assert first == pytest.approx(problem.ends.start, abs=1e-14)
    if problem.ends.end is not None:
        assert last == pytest.approx(problem.ends.end, abs=1e-14)
    if problem.ends.closure is not None:
        assert last - first == pytest.approx(problem.ends.closure, abs=1e-13)
    assert problem.unknowns(full) == pytest.approx(c)
    assert problem.postures(c) == pytest.approx(problem.space.spline(full)(problem.points), abs=1e-12)
    assert problem.rates(c) == pytest.approx(problem.space.spline(full)(problem.space.nodes, 1), abs=1e-10)


@pytest.mark.parametrize("ends", ENDS)
def test_the_stiffness_is_the_hessian_of_separable_costs(ends):
    problem, c = random_collocation(np.random.default_rng(3), ends)
    density = problem.density(c)
    matrices = problem.stiffness(density.diagonal, 0.0)
    d = np.random.default_rng(4).normal(size=c.shape)
    assert np.einsum("iab,ib->ia", matrices, d) == pytest.approx(problem.curvature(density, d), abs=1e-10)


def _linear(problem, c):
    matrices = problem.stiffness(np.ones((len(problem.space.nodes), problem.arm.n)), 1.0)
    return DenseLinear(problem, problem.postures(c), matrices)


@pytest.mark.parametrize("ends", [ends for ends in ENDS if ends != "cyclic"])
def test_both_ways_to_a_step_agree(ends):
    rng = np.random.default_rng(9)
    problem, c = random_collocation(rng, ends)
    matrices = problem.stiffness(np.ones((len(problem.space.nodes), problem.arm.n)), 1.0)
    q = problem.postures(c)
    dense, banded = (kind(problem, q, matrices) for kind in (DenseLinear, BandedLinear))
    slope, lack = rng.normal(size=c.shape), rng.normal(size=(len(problem.points), 2))
    assert banded.tangent(slope) == pytest.approx(dense.tangent(slope), abs=1e-8)
    assert banded.towards(lack) == pytest.approx(dense.towards(lack), abs=1e-7)
    assert banded.multipliers(slope) == pytest.approx(dense.multipliers(slope), abs=1e-6)
    assert banded.task(banded.towards(lack)) == pytest.approx(lack, abs=1e-8)
