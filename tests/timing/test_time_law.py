"""Time laws: limits hold between grid points, the motion is the plan's, and nothing faster is known."""

import sys
from itertools import pairwise

import numpy as np
import pytest
from attack_laws import EXCEEDED, KEPT, LONGER, attack, between, exceeded, failed, slot, toppra_s_own

import selfmotion as sm
from selfmotion.motion import Motion

pytest.importorskip("toppra")


@pytest.fixture(scope="module")
def plan():
    """The shortest of the motions of a three-link arm on a smooth curve that is known to this test."""
    arm = sm.PlanarArm([0.5, 0.4, 0.3])
    problem = sm.Problem(arm, sm.Bezier([[0.7, -0.3], [0.9, 0.2], [0.4, 0.5], [0.2, 0.7]]), samples=200)
    return sm.plan(problem, sm.Refine(starts=2, time_limit=10))


@pytest.fixture(scope="module")
def cornered():
    """A motion around a corner of its path."""
    arm = sm.PlanarArm([0.5, 0.4, 0.3])
    problem = sm.Problem(arm, sm.Waypoints([[0.7, -0.3], [0.8, 0.1], [0.5, 0.2]]), samples=200)
    return sm.plan(problem, sm.Refine(starts=2, time_limit=10))


@pytest.mark.parametrize("seed", range(18))
def test_limits_hold_between_grid_points_and_no_law_of_toppra_is_shorter(seed):
    """Six sorts of plans, in the plane and in space; `python tests/timing/attack_laws.py` takes five hundred."""
    row = attack(seed)
    assert max(row["worst"]) <= EXCEEDED
    assert max(row["worst"]) > 0.95  # something is at its limit
    assert not failed(row), row


@pytest.mark.parametrize("seed", range(3))
def test_round_slots_where_curvature_jumps_the_law_is_as_fast_as_it_can_be(seed):
    rng = np.random.default_rng(seed)
    arm = sm.PlanarArm([0.5, 0.4, 0.3], [None, (0.0, np.pi), None])
    path = slot(np.array([0.5, 0.3]), 0.15, rng.uniform(0.02, 0.1))
    plan = sm.plan(sm.Problem(arm, path, samples=200), sm.Global(gap=3e-2))
    timed = sm.time_law(plan, rng.uniform(2, 10, 3), 2.0)
    assert max(exceeded(timed)) <= EXCEEDED
    kept = [timed.duration / own for own, taken in toppra_s_own(timed) if own is not None and taken < KEPT]
    assert kept
    assert max(kept) <= LONGER


def test_the_motion_is_the_plan_s_and_goes_from_rest_to_rest(plan):
    timed = sm.time_law(plan, 5.0, 1.0, tool_speed=0.3)
    t = between(timed.law)
    r = timed.law(t).r
    assert np.array_equal(timed.states(t)[0], plan(r))
    assert (np.diff(r) >= 0.0).all()
    assert timed.r[[0, -1]].tolist() == [0.0, 1.0]
    assert not timed.dq[[0, -1]].any()
    assert (np.diff(timed.t) > 0.0).all()


def test_velocities_and_accelerations_are_the_derivatives_of_the_angles(plan):
    timed = sm.time_law(plan, 5.0, 1.0)
    h = 1e-5
    t = np.linspace(0.02, 0.98, 300) * timed.duration
    inside = (np.abs(t[:, None] - timed.law.t).min(axis=1)) > 2 * h  # accelerations jump at the law's knots
    t = t[inside]
    _, dq, ddq = timed.states(t)
    assert (timed(t + h) - timed(t - h)) / (2 * h) == pytest.approx(dq, abs=1e-6)
    assert (timed.states(t + h)[1] - timed.states(t - h)[1]) / (2 * h) == pytest.approx(ddq, abs=1e-3)
    assert timed(0.5).shape == (3,)


def test_a_joint_that_turns_evenly_takes_the_time_of_a_trapezoid():
    """The shortest motion on a circle about the base turns joint 1 only: its law is known in closed form."""
    arm = sm.PlanarArm([0.5, 0.4, 0.3])
    path = sm.Arc([0.0, 0.0], 0.8, 0.0, 1.5)
    u = 0.7

    class Turning:
        """u(r) turns as the tool does."""

        def __call__(self, r, order):
            return (u + 1.5 * r if order == 0 else np.full(len(r), 1.5))[:, None]

    plan = sm.Plan(sm.Problem(arm, path), Motion(arm, path, Turning(), 0, 100), "turning", {})
    timed = sm.time_law(plan, [2.0, 2.0, 2.0], 1.0)
    assert timed.duration == pytest.approx(1.5 / 1.0 + 1.0 / 2.0, rel=2e-3)
    assert timed.largest[0][0] == pytest.approx(1.0, abs=1e-3)
    even = sm.time_law(plan, 2.0, 1.0, tool_speed=0.4)
    assert even.duration == pytest.approx(1.2 / 0.4 + 0.5 / 2.0, rel=2e-3)


def test_at_constant_speed_of_the_tool_it_says_where_and_why_it_is_slower(plan):
    timed = sm.time_law(plan, 20.0, 3.0, tool_speed=0.2)
    moved = timed.law(np.linspace(0, timed.duration, 2000))
    speed = np.linalg.norm(plan.problem.path(moved.r, 1), axis=1) * moved.speed
    assert [(part.why, part.rest) for part in timed.slow] == [("acceleration", True)] * 2
    outside = (moved.r > timed.slow[0].r[1]) & (moved.r < timed.slow[1].r[0])
    assert outside.mean() > 0.9
    assert speed[outside] == pytest.approx(0.2, rel=2e-3)
    joint = int(np.argmax(np.abs(plan.rates(0.5)))) + 1
    limits = np.full(3, 3.0)
    limits[joint - 1] = 0.5 * np.abs(timed.states(0.5 * timed.duration)[1])[joint - 1]
    slower = sm.time_law(plan, 20.0, limits, tool_speed=0.2)
    assert ("velocity", joint) in {(part.why, part.joint) for part in slower.slow}
    assert slower.duration > timed.duration
    assert str(slower.slow[0]).endswith(f"of joint{slower.slow[0].joint}")
    assert sm.time_law(plan, 20.0, 3.0).slow == ()


def test_slow_stretches_meet_where_one_limit_takes_over_from_another(plan):
    reached = np.abs(sm.time_law(plan, 20.0, 3.0, tool_speed=0.2).dq).max(axis=0)
    met = 0
    for factor in (0.6, 0.8, 0.95):
        for before, after in pairwise(sm.time_law(plan, 2.0, factor * reached, tool_speed=0.2).slow):
            assert before.r[1] <= after.r[0]
            assert before.t[1] <= after.t[0]
            met += before.r[1] == after.r[0]
    assert met > 0


def test_the_arm_stands_still_at_corners(cornered):
    timed = sm.time_law(cornered, 5.0, 1.0, tool_speed=0.1)
    assert timed.stops == pytest.approx(cornered.problem.path.breaks.tolist())
    at = timed.law.t[np.searchsorted(timed.law.r, timed.stops[0])]
    assert np.abs(timed.states(at)[1]).max() < 1e-6
    resting = [part.r for part in timed.slow if part.rest]
    assert any(low < timed.stops[0] < high for low, high in resting)
    assert resting[0][0] == 0.0
    assert resting[-1][1] == 1.0
    assert (np.abs(timed.states(between(timed.law))[2]) <= 5.0 * 1.001).all()


def test_samples_are_at_the_rate_and_end_at_the_end(plan):
    timed = sm.time_law(plan, 5.0, 1.0, rate=50.0)
    assert np.diff(timed.t)[:-1] == pytest.approx(0.02)
    assert timed.t[-1] == timed.duration
    assert 0.0 < np.diff(timed.t)[-1] <= 0.02 + 1e-9
    assert timed.joint_names == ("joint1", "joint2", "joint3")
    assert sm.time_law(plan, 5.0).unlimited == timed.joint_names
    assert len(timed.at_rate(500.0).t) > 9 * len(timed.t)
    assert (timed.at_rate(2000.0).jerk > timed.jerk).any()
    # From and to rest, and as large however near to the row before it the last one is.
    assert (timed.jerk >= 50.0 * np.abs(timed.ddq[[0, -1]]).max(axis=0)).all()
    near = timed.at_rate(40.0025 / timed.duration)
    assert (near.jerk <= 2.0 * 5.0 * 1.001 * near.rate).all()
    assert "rows" in repr(timed)
    with pytest.raises(sm.InvalidInputError, match="leaves"):
        timed(timed.duration + 1.0)


def test_an_arm_in_space_has_its_urdf_s_velocities_and_names():
    position = sm.Line([0.45, -0.1, 0.4], [0.5, 0.1, 0.45])
    problem = sm.Problem(sm.named_arm("panda"), sm.PosePath(position, orientation=[0, 1, 0, 0]), samples=100)
    plan = sm.plan(problem, sm.Refine(starts=1, time_limit=10))
    timed = sm.time_law(plan, 50.0, 100.0)
    assert timed.joint_names == problem.arm.chain.names
    assert timed.unlimited == ()
    slow = sm.time_law(plan, 50.0, tool_speed=100.0).slow
    assert {part.name for part in slow} <= set(timed.joint_names)
    assert "of panda_joint" in str(slow[0])
    assert (timed.limits.velocity == problem.arm.chain.velocity).all()
    assert (np.abs(timed.states(between(timed.law))[1]) <= 1.001 * problem.arm.chain.velocity).all()
    assert (sm.time_law(plan, 50.0, 0.3).limits.velocity == 0.3).all()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"max_acceleration": 0.0}, "max_acceleration: must be greater than zero"),
        ({"max_acceleration": [1.0, -1.0, 1.0]}, "max_acceleration.1: must be greater than zero"),
        ({"max_acceleration": [1.0, 1.0]}, "max_acceleration: has 2 entries for 3 joints"),
        ({"max_acceleration": [[1.0]] * 3}, "max_acceleration: has shape"),
        ({"max_acceleration": "fast"}, "max_acceleration: is not made of numbers"),
        ({"max_acceleration": np.inf}, "max_acceleration"),
        ({"max_velocity": -1.0}, "max_velocity: must be greater than zero"),
        ({"max_velocity": [1.0] * 7}, "max_velocity: has 7 entries for 3 joints"),
        ({"max_velocity": np.nan}, "max_velocity"),
        ({"tool_speed": 0.0}, "tool_speed: must be greater than zero"),
        ({"rate": 0.0}, "rate: must be greater than zero"),
        ({"rate": -5}, "rate: must be greater than zero"),
        ({"rate": 1e12}, "rate: makes more than"),
    ],
)
def test_bad_limits_are_refused(plan, options, says):
    with pytest.raises(sm.InvalidInputError, match=says):
        sm.time_law(plan, **{"max_acceleration": 1.0, **options})


def test_plans_that_no_time_law_can_follow_are_refused(plan, seed_problem):
    def through_a_fold(r, order):
        return 0.3 + 0.0 * r[:, None] if order == 0 else np.full((len(r), 1), np.inf)

    motion = Motion(seed_problem.arm, seed_problem.path, through_a_fold, 0, 100)
    with pytest.raises(sm.InvalidInputError, match=r"plan: (has no finite cost|moves a joint infinitely fast)"):
        sm.time_law(sm.Plan(seed_problem, motion, "steep", {}), 1.0)
    narrow = sm.Problem(sm.PlanarArm([0.5, 0.4, 0.3], [(3.0, 3.1), None, None]), plan.problem.path)
    with pytest.raises(sm.InvalidInputError, match="plan: does not hold"):
        sm.time_law(sm.Plan(narrow, plan.motion, "elsewhere", {}), 1.0)


def test_without_toppra_it_says_what_to_install(plan, monkeypatch):
    for name in [name for name in sys.modules if name.split(".")[0] == "toppra"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "toppra", None)
    with pytest.raises(sm.InvalidInputError, match=r"pip install 'selfmotion\[time\]'"):
        sm.time_law(plan, 1.0)
