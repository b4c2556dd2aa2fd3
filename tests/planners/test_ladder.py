"""The plain ladder against all chains there are, its laws, and what it is compared by."""

from itertools import product

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms import JointLimits
from selfmotion.planners import compare_ladder, compare_plan, compare_rows, ladder
from selfmotion.planners.ladder import turned, wide

TAU = 2 * np.pi
POINTS = [[50, -10], [60, 0], [58, 20], [40, 35]]
# Its angle domain is in two parts (test_cli), so that no continuous motion exists.
PARTED = sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5])


@pytest.fixture(scope="module")
def poses():
    t = np.linspace(0, 2, 12)
    rows = np.zeros((12, 7))
    rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 4] = 0.45, 0.2 * np.cos(t), 0.4 + 0.2 * np.sin(t), 1.0
    return sm.Problem(sm.named_arm("panda"), sm.PoseWaypoints(rows), objective="l2", samples=50)


@pytest.mark.parametrize("objective", ["joint_travel", "l1", "l2"])
def test_of_all_chains_it_finds_the_cheapest(objective):
    arm = sm.PlanarArm([30, 30, 20], [None, (-1, 3), (-2, 2)])
    problem = sm.Problem(arm, sm.Waypoints(POINTS), objective=objective, weights=[1, 2, 0.5])
    found = ladder(problem, 9)
    r, u = problem.path.waypoints, np.linspace(-np.pi, np.pi, 9, endpoint=False)
    rungs = []
    for at in r:
        solved = [arm.solve(problem.path(at), u[:, None], branch) for branch in (0, 1)]
        q = np.concatenate([q[ok] for q, ok in solved])
        rungs.append(q[(arm.margins(q) >= 0).all(axis=1)])
    assert found.postures == sum(map(len, rungs))
    costs = [
        problem.objective.sampled(arm.limits.continuous(np.array(chain)), r, problem.weights)
        for chain in product(*rungs)
    ]
    assert found.cost_sampled == pytest.approx(min(costs), rel=1e-12)
    np.testing.assert_allclose(arm.forward(found.q), problem.path(r), atol=1e-9)
    assert arm.margins(found.q).min() >= -1e-9


def test_with_more_of_the_same_values_it_is_never_dearer(poses, seed_problem):
    for problem in (poses, seed_problem):
        costs = [ladder(problem, values).cost_sampled for values in (30, 60, 120)]
        assert costs == sorted(costs, reverse=True)
        assert costs[0] > costs[-1]


def test_its_postures_hold_the_tool_on_the_poses_inside_the_limits(poses):
    found = ladder(poses, 60)
    np.testing.assert_array_equal(found.r, poses.path.waypoints)
    assert poses.arm.task_error(found.q, poses.path(found.r)).max() < 1e-9
    assert poses.arm.margins(found.q).min() >= -1e-9
    assert found.jumps == ()


def test_start_end_and_branch_are_kept(seed_arm, seed_path):
    problem = sm.Problem(seed_arm, seed_path, start=[0.3], end=[0.1], elbow="positive", samples=60)
    found = ladder(problem, 50)
    np.testing.assert_array_equal(found.r, problem.grid)
    np.testing.assert_allclose(seed_arm.u_of(found.q[[0, -1]])[:, 0], [0.3, 0.1], atol=1e-12)
    assert (seed_arm.branch_of(found.q) == 0).all()
    given = sm.Problem(seed_arm, seed_path, start={"q": found.q[0]}, samples=60)
    np.testing.assert_array_equal(ladder(given, 50).q[0], found.q[0])


def test_where_no_motion_exists_it_jumps_and_says_where():
    problem = sm.Problem(*PARTED, samples=100)
    found = ladder(problem, 200)
    assert len(found.jumps) >= 1
    steps = np.abs(np.diff(found.q, axis=0)).max(axis=1)
    assert int(np.argmax(steps)) in found.jumps


def test_postures_get_the_one_turn_that_puts_them_inside_and_are_dropped_without():
    limits = JointLimits([(-7, 7), (6, 7), None, (2, None), (-9, -8)], 5)
    np.testing.assert_array_equal(wide(limits), [True, False, True, True, False])
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (2000, 5))
    found = turned(limits, q)
    assert limits.margin(found)[:, [1, 4]].min() >= -1e-9
    angles = np.arange(-3, 4)[:, None, None] * TAU + q[:, [1, 4]]
    inside = ((angles >= [6, -9]) & (angles <= [7, -8])).any(axis=0).all(axis=1)
    assert 0 < inside.sum() < 2000
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * q[inside]), atol=1e-12)
    np.testing.assert_array_equal(found[:, [0, 2, 3]], q[inside][:, [0, 2, 3]])


def test_joints_that_can_turn_all_the_way_are_moved_into_their_limits_as_a_whole():
    arm = sm.PlanarArm([30, 30, 20], [(1.0, 9.0), (-2.5, 2.5), (-4.0, 4.0)])
    problem = sm.Problem(arm, sm.Waypoints(POINTS), objective="l2")
    found = ladder(problem, 60)
    assert arm.margins(found.q).min() >= -1e-9
    free = sm.Problem(sm.PlanarArm([30, 30, 20], [None, (-2.5, 2.5), None]), sm.Waypoints(POINTS), objective="l2")
    assert found.cost_sampled == pytest.approx(ladder(free, 60).cost_sampled, rel=1e-12)


def test_what_a_ladder_cannot_do_is_refused(seed_problem):
    four = sm.Problem(sm.PlanarArm([20, 20, 20, 20]), sm.Line([50, 0], [60, 0]))
    with pytest.raises(sm.InvalidInputError, match="arm: has 2 redundant degrees"):
        ladder(four, 10)
    with pytest.raises(sm.InvalidInputError, match="values: is outside"):
        ladder(seed_problem, 0)
    narrow = sm.Problem(sm.PlanarArm([30, 30, 20], [None, None, (0.1, 0.101)]), sm.Line([50, 0], [60, 0]), samples=9)
    with pytest.raises(sm.NothingFeasibleError, match="none of 3 values"):
        ladder(narrow, 3)


@pytest.fixture(scope="module")
def proved(poses):
    return sm.plan(poses, sm.Global(gap=2e-2))


def test_a_plan_stands_beside_a_ladder_that_the_bound_holds_for_too(proved):
    ours, theirs = compare_plan(proved), compare_ladder(proved, 120)
    assert ours.holds
    assert theirs.holds
    assert (ours.jumps, theirs.jumps) == (0, 0)
    assert ours.gap <= 2e-2
    assert theirs.cost + theirs.cost_error >= proved.lower_bound
    assert theirs.cost > ours.cost
    assert theirs.gap == pytest.approx((theirs.cost + theirs.cost_error - proved.lower_bound) / theirs.cost)
    assert theirs.l2_waypoints == pytest.approx(theirs.cost_sampled)  # its rows are the waypoints


def test_rows_of_a_motion_are_judged_and_lose_their_bound_if_they_do_not_hold(proved):
    problem = proved.problem
    r = problem.rows
    same = compare_rows("same", proved, r, proved(r))
    assert same.holds
    assert same.cost == pytest.approx(proved.cost, rel=1e-6)
    assert same.l2_waypoints == pytest.approx(proved.l2_waypoints, rel=1e-12)
    q = proved(r)
    q[20:, 0] += 0.3
    broken = compare_rows("broken", proved, r, q)
    assert not broken.holds
    assert broken.cost is broken.gap is None
    assert broken.jumps == 1
    assert "tracking" in broken.why_not
    thin = compare_rows("thin", proved, problem.grid, proved(problem.grid))
    assert thin.l2_waypoints is None  # it leaves given points out


def test_travel_over_the_given_points_is_the_sum_of_their_chords(proved, seed_plan):
    problem = proved.problem
    q = proved(problem.path.waypoints)
    assert proved.l2_waypoints == pytest.approx(np.linalg.norm(np.diff(q, axis=0), axis=1).sum(), rel=1e-14)
    assert proved.l2_waypoints <= proved.l2_travel
    assert proved.summary()["l2_waypoints"] == proved.l2_waypoints
    assert seed_plan.l2_waypoints is None
    assert "l2_waypoints" not in seed_plan.summary()
    weighted = sm.Problem(problem.arm, problem.path, objective="l2", weights=[2.0] * 7, samples=50)
    assert sm.planners.Plan(weighted, proved.motion, "same", {}).l2_waypoints == pytest.approx(2 * proved.l2_waypoints)
