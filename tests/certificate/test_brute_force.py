"""The sampled oracle of connectedness by itself: planted answers, and the package's own where they are clear-cut."""

import numpy as np
import pytest
from brute_force import brute_force_connected, flood, given_parts, limit_cut_problem, sample
from scenes import planar_scene
from scipy.optimize import brentq

import selfmotion as sm
from clearance import oracle

FINE, COARSE = (200, 400), (100, 240)


@pytest.mark.parametrize("ends", [([1.5, -2.5], [1.5, 2.5]), ([1.5, 2.5], [1.5, -2.5])])
def test_the_known_case_of_limits_that_block_a_reachable_line(ends):
    line = sm.Line(*ends)
    tight = sm.Problem(sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), line)
    connected, r = brute_force_connected(tight, 200, 1000)
    assert not connected
    assert abs(line(r)[1]) == pytest.approx(0.41, abs=0.02)
    assert all(pose.ok.any() for pose in sample(tight, np.linspace(0, 1, 101), 240))
    wide = sm.Problem(sm.PlanarArm([1, 1, 1], [(-2.2, 2.2)] * 3), line)
    assert brute_force_connected(wide, *FINE) == (True, None)


@pytest.mark.parametrize(("sweep", "connected"), [(6.2, True), (9.8, True), (10.5, False), (12.5, False)])
def test_turns_of_a_limited_joint_are_counted(sweep, connected):
    """With θ2 and θ3 all but locked θ1 turns as the target does, from one limit to the other at most."""
    arm = sm.PlanarArm([1, 0.8, 0.6], [(-5, 5), (0.8, 1.0), (-0.5, -0.3)])
    start = arm.forward([-5, 0.9, -0.4])
    path = sm.Arc([0, 0], np.hypot(*start), np.arctan2(*start[::-1]), sweep)
    found, r = brute_force_connected(sm.Problem(arm, path), *FINE)
    assert found == connected
    if not connected:
        assert r * sweep == pytest.approx(10, abs=0.2)
    free = sm.PlanarArm([1, 0.8, 0.6], [None, (0.8, 1.0), (-0.5, -0.3)])
    assert brute_force_connected(sm.Problem(free, path), *FINE)[0]


@pytest.mark.parametrize(("theta2", "side", "connected"), [(0.2, 1, True), (-0.2, 1, True), (-0.2, -1, False)])
def test_elbows_are_joined_at_folds_and_only_there(theta2, side, connected):
    """|θ2| ≤ 0.3 leaves two short pieces of self-motion, each through a fold; θ2 = 1.1 lies between them."""
    arm = sm.PlanarArm([1, 1, 0.5], [None, (-0.3, 0.3), None])

    def posture(theta2, side):
        def excess(theta3):
            return np.hypot(*arm.forward([0, theta2, theta3])) - 2.2

        q = np.array([0, theta2, side * brentq(lambda theta3: excess(side * theta3), 0.3, np.pi - 0.3)])
        q[0] = -np.arctan2(*arm.forward(q)[::-1])
        return q

    first, last = posture(0.2, 1), posture(theta2, side)
    last[0] += 0.5
    problem = sm.Problem(arm, sm.Arc([0, 0], 2.2, 0, 0.5), start={"q": first}, end={"q": last})
    assert brute_force_connected(problem, *FINE)[0] == connected


def test_a_direction_is_a_fourth_joint():
    arm = sm.PlanarArm([1, 1, 1, 0.3], [None, None, None, (-0.5, 0.5)], direction=0.0)
    across = sm.Line([1.6, -1.0], [1.6, 1.0])
    assert brute_force_connected(sm.Problem(arm, across), *COARSE)[0]
    # (1.6, 2.6) is in reach, but for no u = −θ4 in (−0.5, 0.5).
    up = sm.Line([1.6, 0.0], [1.6, 2.6])
    assert not brute_force_connected(sm.Problem(arm, up), *COARSE)[0]
    free = sm.PlanarArm([1, 1, 1, 0.3], None, direction=0.0)
    assert brute_force_connected(sm.Problem(free, up), *COARSE)[0]


def test_clear_cut_answers_are_those_of_the_structure_and_hold_backwards():
    clear = {True: 0, False: 0}
    for seed in range(20):
        problem = limit_cut_problem(seed)
        with_slack = [brute_force_connected(problem, *COARSE, slack) for slack in (0.02, -0.02)]
        connected = with_slack[0][0]
        if connected != with_slack[1][0]:
            continue
        clear[connected] += 1
        assert problem.structure.is_connected == connected
        back = sm.Problem(problem.arm, sm.Reversed(problem.path))
        assert brute_force_connected(back, *COARSE)[0] == connected
        if not connected:
            # Of a part that shrinks away the last is missed.
            end = problem.structure.dead_end[0]
            assert with_slack[1][1] - 0.01 < end < with_slack[0][1] + 0.05
    assert min(clear.values()) > 5


def test_loops_that_are_made_otherwise_in_between_are_not_taken_for_one_kind():
    """Short links before a long one: the wrist's reach joins and parts the loops between two poses of one kind."""
    problem = planar_scene(492)
    truth = oracle(problem)

    def poses(r):
        return sample(problem, r, 240, 0.0, truth.allowed)

    assert flood(problem, poses(np.linspace(0, 1, 81)), 240, 0.0, poses, truth.allowed) == (True, None)


def test_a_given_start_that_is_forbidden_with_one_elbow_is_not_moved_to_where_it_is_allowed():
    """Only what is given may be started from, not an allowed posture near it."""
    problem = planar_scene(513)
    q = np.array([problem.arm.solve(problem.path(0.0), problem.start.u, branch)[0] for branch in (0, 1)])
    truth = oracle(problem)
    assert truth.allowed(q).tolist() == [False, True]
    (pose,) = sample(problem, [0.0], 720, 0.0, truth.allowed)
    near = np.abs(pose.q - q[0]).max(axis=-1)
    (forbidden,) = set(pose.part[pose.ok & (near < 0.05)].tolist())
    assert forbidden not in given_parts(problem, problem.start, pose, 0.0, truth.allowed)
