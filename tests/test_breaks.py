"""n-connectivity of sampled motions: each planted break is found where it was planted, and named for what it is."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.breaks import Break

R = np.linspace(0, 1, 200)
U = 0.3 + 0.4 * np.sin(2 * np.pi * 0.54 * R)


@pytest.fixture
def free(seed_path):
    return sm.Problem(sm.PlanarArm([30, 30, 20]), seed_path)


def samples(problem, u=U, branch=0, rows=slice(None)):
    return problem.arm.solve(problem.path(R[rows]), u[rows, None], branch)[0]


def kinds(found):
    return [(part.row, part.kind) for part in found.breaks]


def test_a_continuous_motion_has_no_breaks(free, seed_problem, seed_plan):
    assert sm.connectivity(free, R, samples(free)).holds
    assert sm.connectivity(seed_problem, R, seed_plan(R)).holds


def test_a_flip_of_the_elbow(free):
    q = samples(free)
    q[80:90] = samples(free, branch=1, rows=slice(80, 90))
    found = sm.connectivity(free, R, q)
    assert kinds(found) == [(80, "changes branch"), (90, "changes branch")]
    assert found.breaks[0].r == R[79]
    assert found.breaks[0].size == pytest.approx(np.abs(q[80] - q[79]).max())
    assert "elbow changes" in str(found.breaks[0])
    np.testing.assert_array_equal(np.flatnonzero(found.broken_steps), [79, 89])


def test_a_jump_along_one_self_motion(free):
    found = sm.connectivity(free, R, samples(free, U - 0.8 * (R > 0.5)))
    assert kinds(found) == [(100, "jumps")]


def test_a_jump_over_what_limits_keep_apart():
    """Unit 3R, |θ| ≤ 1.45, near y = 0: each elbow has its own part, which no motion there connects."""
    other = sm.Problem(sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -0.4], [1.5, 0.4]))
    domain = sm.angle_domain(other.arm, other.path)
    u = [np.mean(domain(0.3, branch).intervals[0]) for branch in (0, 1)]
    r = np.array([0.0, 0.28, 0.3, 0.32, 1.0])
    q = np.array([other.arm.solve(other.path(s), [u[int(s > 0.3)]], int(s > 0.3))[0] for s in r])
    found = sm.connectivity(other, r, q)
    assert (3, "another part") in kinds(found)


def test_a_whole_turn_of_a_limited_joint(seed_path):
    problem = sm.Problem(sm.PlanarArm([30, 30, 20], [(-9, 9), None, None]), seed_path)
    q = samples(problem)
    q[120:, 0] += 2 * np.pi
    found = sm.connectivity(problem, R, q)
    assert kinds(found) == [(120, "whole turn")]
    assert found.breaks[0].joint == 1
    free = q.copy()
    free[120:, 1] += 2 * np.pi  # a joint without limits is an angle modulo 2π
    assert kinds(sm.connectivity(problem, R, free)) == [(120, "whole turn")]


def test_bad_rows_are_told_from_broken_steps(seed_problem):
    q = samples(seed_problem)
    q[50] += 0.01
    q[70] = samples(seed_problem, branch=1, rows=[70])
    found = sm.connectivity(seed_problem, R, q)
    assert kinds(found) == [(51, "off the path"), (71, "outside a limit")]
    assert found.breaks[1].joint == 2
    assert not found.breaks[0].is_step
    np.testing.assert_array_equal(np.flatnonzero(found.bad_rows), [50, 70])
    np.testing.assert_array_equal(np.flatnonzero(found.broken_steps), [49, 50, 69, 70])


def test_the_elbow_that_was_asked_for(seed_path):
    problem = sm.Problem(sm.PlanarArm([30, 30, 20]), seed_path, elbow="negative")
    found = sm.connectivity(problem, R, samples(problem))
    assert {part.kind for part in found.breaks} == {"wrong elbow"}


def test_rows_too_far_apart(free):
    few = slice(None, None, 40)
    found = sm.connectivity(free, R[few], samples(free, rows=few))
    assert {part.kind for part in found.breaks} <= {"too coarse", "jumps"}
    assert not found.holds


def test_the_motion_of_another_arm_is_bad_input(free):
    other = sm.PlanarArm([25, 35, 30])
    q = other.solve(free.path(R), U[:, None], 0)[0]
    with pytest.raises(sm.InvalidInputError, match=r"row \d+, columns q1…q3.*this arm's motion") as caught:
        sm.connectivity(free, R, q)
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("change", [{"r": R[::-1]}, {"q": np.full((200, 3), np.nan)}, {"q": np.zeros((200, 2))}])
def test_what_is_no_motion_is_bad_input(free, change):
    with pytest.raises(sm.InvalidInputError):
        sm.connectivity(free, **{"r": R, "q": samples(free), **change})


def test_a_small_jump_is_no_whole_turn():
    problem = sm.Problem(sm.PlanarArm([1, 1, 0.5]), sm.Line([1.2, -0.5], [1.2, 0.5]))
    r = np.linspace(0, 1, 1000)
    q = problem.arm.solve(problem.path(r), np.where(r < 0.5, 0.3, 0.315)[:, None], 0)[0]
    assert kinds(sm.connectivity(problem, r, q)) == [(500, "jumps")]


def test_every_kind_has_words():
    for kind in ("off the path", "outside a limit", "wrong elbow", "whole turn", "changes branch", "jumps",
                 "another part", "too coarse"):  # fmt: skip
        assert "{" not in str(Break(1, 0.0, kind, 1.0, 2))


def test_arms_with_more_redundancy_are_looked_at_too():
    arm = sm.PlanarArm([1, 1, 1, 1])
    problem = sm.Problem(arm, sm.Line([2, 0], [2.2, 0.5]))
    r = np.linspace(0, 1, 50)
    q = arm.solve(problem.path(r), np.array([0.5, -0.5]) + 0 * r[:, None], 0)[0]
    assert sm.connectivity(problem, r, q).holds
    q[25:] = arm.solve(problem.path(r[25:]), np.array([0.5, -0.5]), 1)[0]
    assert kinds(sm.connectivity(problem, r, q)) == [(25, "changes branch")]
