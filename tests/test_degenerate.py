"""Numbers at degenerate geometry, and laws that hold whatever the numbers: scales, rotations, orders, threads.

Tolerances are of doubles: what is scaled or turned agrees to rounding, amplified where a search stops at a tolerance.
"""

import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import selfmotion as sm
from oracle import Arms
from selfmotion.domain import angle_domain

POINTS = np.array([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]], float)
LINKS = np.array([30.0, 30.0, 20.0])
R = np.linspace(0.0, 1.0, 41)
CLEAR = 1e-6  # of a constraint, and in u: where the domain must agree with the oracle

PLANNERS = {
    "sinusoid": lambda turn=0.0: sm.Sinusoid(
        [0.3 + turn], amplitude=[0.4], optimizer=sm.PSO(population=8, iterations=4, bounds=(0, 2), seed=1)
    ),
    "refine": lambda turn=0.0: sm.Refine(starts=2, tolerance=1e-4, time_limit=20),
    "global": lambda turn=0.0: sm.Global(gap=1e-2, time_limit=20),
}


def rotated(points, turn):
    c, s = np.cos(turn), np.sin(turn)
    return points @ np.array([[c, s], [-s, c]])


def problem(scale=1.0, turn=0.0):
    arm = sm.PlanarArm(LINKS * scale, [None, (0, np.pi), None])
    return sm.Problem(arm, sm.Bezier(rotated(POINTS, turn) * scale), samples=200)


@pytest.fixture(scope="module")
def plans():
    return {name: sm.plan(problem(), planner()) for name, planner in PLANNERS.items()}


def apart(plan, other, turn=0.0):
    """Largest difference of u, which is an absolute direction in the plane."""
    off = plan.u(R) - other.u(R) - turn
    return np.abs(np.mod(off + np.pi, 2 * np.pi) - np.pi).max()


@pytest.mark.parametrize("scale", [1e-9, 2.0**-20, 0.3, 1e3, 1e9])
@pytest.mark.parametrize("name", PLANNERS)
def test_a_scaled_problem_has_the_same_plan(name, scale, plans):
    plan, base = sm.plan(problem(scale), PLANNERS[name]()), plans[name]
    assert plan.cost == pytest.approx(base.cost, rel=1e-12)
    assert apart(plan, base) <= 1e-8
    assert plan.verification.holds
    assert plan.verification.max_tracking_error <= 1e-13 * LINKS.sum() * scale
    if base.lower_bound is not None:
        assert plan.lower_bound == pytest.approx(base.lower_bound, rel=1e-4)
        assert plan.lower_bound <= base.cost


@settings(max_examples=4)
@given(turn=st.floats(-3.1, 3.1))
@pytest.mark.parametrize("name", PLANNERS)
def test_a_turned_problem_has_the_turned_plan(name, turn, plans):
    plan, base = sm.plan(problem(turn=turn), PLANNERS[name](turn)), plans[name]
    exact = name == "sinusoid"  # the others stop at a tolerance, on collocation points the same, postures not
    assert plan.cost == pytest.approx(base.cost, rel=1e-12 if exact else 1e-8)
    assert apart(plan, base, turn) <= (1e-12 if exact else 1e-4)
    assert plan.verification.holds
    if base.lower_bound is not None:
        assert plan.lower_bound <= base.cost * (1 + 1e-12)
        assert base.lower_bound <= plan.cost * (1 + 1e-12)


def test_a_path_run_backwards_costs_the_same(plans):
    arm = sm.PlanarArm(LINKS, [None, (0, np.pi), None])
    back = sm.plan(sm.Problem(arm, sm.Bezier(POINTS[::-1]), samples=200), PLANNERS["global"]())
    base = plans["global"]
    assert back.cost == pytest.approx(base.cost, rel=1e-8)
    assert max(back.lower_bound, base.lower_bound) <= min(back.cost, base.cost) * (1 + 1e-12)


# Degenerate geometry

EQUAL = st.sampled_from([[1.0, 1.0, 1.0], [1.0, 1.0, 0.5], [2.0, 1.0, 1.0], [1.0, 2.0, 1.0], [1.0, 1.0, 2.0]])
ENDS = st.sampled_from([0.0, 0.5, -0.5, np.pi / 2, -np.pi / 2, np.pi, -np.pi])
LIMITS = st.one_of(
    st.none(),
    st.tuples(ENDS, st.sampled_from([1e-9, 1e-3, 1.0, np.pi, 2 * np.pi - 1e-9])).map(lambda p: (p[0], p[0] + p[1])),
)
ARMS = st.builds(sm.PlanarArm, EQUAL, st.tuples(LIMITS, LIMITS, LIMITS))


def paths(draw, arm):
    """A path through an awkward place of an arm: its base, a radius where feasibility changes, a cusp."""
    l1, l2, l3 = arm.links
    awkward = [0.0, l3, abs(l1 - l2), l1 + l2, *(abs(a * l1 + b * l2 + l3) for a in (1, -1) for b in (1, -1))]
    radius = draw(st.sampled_from(awkward))
    angle = draw(st.sampled_from([0.0, 1.0, np.pi / 2, np.pi]))
    across = np.array([np.cos(angle), np.sin(angle)])
    along = np.array([-across[1], across[0]])
    at, size = radius * across, draw(st.sampled_from([1e-9, 1e-3, 1.0])) * arm.links.sum()
    kind = draw(st.sampled_from(["through", "touching", "circle", "cusp", "repeated", "uneven"]))
    if kind == "through":
        return sm.Line(at - 0.3 * size * across, at + 0.4 * size * across)
    if kind == "touching":
        return sm.Line(at - 0.3 * size * along, at + 0.4 * size * along)
    if kind == "circle":
        return sm.Circle([0, 0], max(radius, 0.1))
    if kind == "cusp":
        return sm.Bezier([at, at + size * across, at + size * along, at + 0.5 * size * across])
    if kind == "repeated":
        return sm.Bezier([at, at, at, at + size * along, at + size * along])
    return sm.Waypoints(at + size * np.outer([0.0, 1e-9, 2e-9, 0.5, 0.5 + 1e-7, 1.0], along))


@st.composite
def cases(draw):
    arm = draw(ARMS)
    return arm, paths(draw, arm), draw(st.sampled_from([0.0, 0.25, 3 / 7, 0.5, 1.0]))


@settings(max_examples=400)
@given(cases(), st.integers(0, 2**32))
def test_the_domain_agrees_with_another_inverse_kinematics(case, seed):
    arm, path, r = case
    domain, x = angle_domain(arm, path), path(r)
    u = np.random.default_rng(seed).uniform(-np.pi, np.pi, 200)
    for branch, sign in ((0, 1), (1, -1)):
        margin = Arms([arm], [sign]).margin(np.array([complex(*x)]), u[None])[0]
        inside = domain(r, branch).contains(u)
        clear = np.abs(margin) > CLEAR
        assert (inside == (margin > 0))[clear].all()
        q, ok = arm.solve(x, u[:, None], branch)
        assert ok[margin > CLEAR].all()
        assert np.abs(arm.forward(q[ok]) - x).max(initial=0.0) <= 1e-13 * arm.reach


@settings(max_examples=10)
@given(cases())
def test_a_plan_on_degenerate_geometry_holds_or_says_why_not(case):
    arm, path, _ = case
    try:
        asked = sm.Problem(arm, path, samples=50)
        plan = sm.plan(asked, sm.Global(gap=0.5, time_limit=0.3))
    except sm.InfeasibleError as error:
        explained = bool(error.blocked or error.needs or error.proof)
    except sm.SelfMotionError as error:
        explained = bool(error.remedy)
    else:
        explained = plan.verification.holds
        assert plan.lower_bound <= plan.cost * (1 + 1e-12)
        assert np.abs(arm.forward(plan(R)) - path(R)).max() <= 1e-9 * arm.reach
    assert explained


# Orders, threads and processes


BATCHED = {
    "3R": lambda: sm.PlanarArm([1.0, 1.0, 1.0], [None, (0, np.pi), None]),
    "5R": lambda: sm.PlanarArm([1.0, 0.7, 0.5, 0.4, 0.3]),
    "panda": lambda: sm.named_arm("panda"),
    "ur10e": lambda: sm.named_arm("ur10e"),
}


@pytest.mark.parametrize("name", BATCHED)
def test_rows_of_a_batch_are_what_they_are_alone_in_any_order(name):
    arm, rng = BATCHED[name](), np.random.default_rng(3)
    q = rng.uniform(-1.0, 1.0, (64, arm.n))
    x, order = arm.forward(q), rng.permutation(64)
    u = arm.u_of(q)
    for branch in range(min(2, len(arm.branches))):
        together, ok = arm.solve(x, u, branch)
        shuffled, ok_shuffled = arm.solve(x[order], u[order], branch)
        assert shuffled.tobytes() == together[order].tobytes()
        assert (ok_shuffled == ok[order]).all()
        alone = np.concatenate([arm.solve(x[k : k + 1], u[k : k + 1], branch)[0] for k in range(64)])
        assert alone.tobytes() == together.tobytes()
    for method in (arm.forward, arm.jacobian, arm.u_of):
        assert method(q[order]).tobytes() == method(q)[order].tobytes()


PRINTED = """
import numpy as np, selfmotion as sm
import sys; sys.path[:0] = {path!r}
from test_degenerate import PLANNERS, R, problem
print([sm.plan(problem(), PLANNERS[name]())(R).tobytes().hex() for name in PLANNERS])
"""


def test_threads_and_processes_give_the_same_bits(plans):
    expected = {name: plan(R).tobytes() for name, plan in plans.items()}
    names = list(PLANNERS) * 2
    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(lambda name: sm.plan(problem(), PLANNERS[name]())(R).tobytes(), names))
    assert together == [expected[name] for name in names]
    code = PRINTED.format(path=[p for p in sys.path if p])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == str([bits.hex() for bits in expected.values()])
