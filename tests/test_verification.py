"""A plan proves itself, and a judge finds every way in which a motion can be wrong."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.judgement import Tolerances, judge
from selfmotion.verification import verify_motion


def test_the_seed_s_plan_holds(seed_plan):
    check = seed_plan.verification
    assert check.holds
    assert check.max_tracking_error <= 1e-12 * 80
    assert check.max_joint_step == pytest.approx(np.abs(np.diff(seed_plan(np.linspace(0, 1, 1000)), axis=0)).max())
    fine = seed_plan(np.linspace(0, 1, 100_001))
    assert check.min_limit_margin <= min(fine[:, 1].min(), np.pi - fine[:, 1].max()) + 1e-12
    assert check.min_limit_margin == pytest.approx(min(fine[:, 1].min(), np.pi - fine[:, 1].max()), abs=1e-8)


def test_summary_has_every_field_of_the_contract(seed_plan):
    summary = seed_plan.summary()
    assert list(summary) == [
        "status", "cost", "cost_error", "cost_sampled", "lower_bound", "gap", "l1_travel", "l2_travel",
        "max_tracking_error", "min_limit_margin", "max_joint_step", "reconfigurations", "blocked", "planner",
        "parameters", "evaluations", "wall_time_s", "version",
    ]  # fmt: skip
    assert summary["status"] == "solved"
    assert summary["lower_bound"] is None
    assert summary["cost"] > summary["cost_sampled"]


def test_travel_is_that_of_a_fine_sampling(seed_plan):
    steps = np.diff(seed_plan(np.linspace(0, 1, 200_001)), axis=0)
    assert seed_plan.l1_travel == pytest.approx(np.abs(steps).sum(), abs=1e-7)
    assert seed_plan.l2_travel == pytest.approx(np.linalg.norm(steps, axis=1).sum(), abs=1e-7)


def test_rates_are_the_derivative_of_the_joints(seed_plan):
    r, h = np.linspace(0.01, 0.99, 99), 1e-6
    np.testing.assert_allclose(seed_plan.rates(r), (seed_plan(r + h) - seed_plan(r - h)) / (2 * h), atol=1e-7)


def broken(plan, change):
    return lambda r: change(np.asarray(r), plan(r))


def dip(r, at, width, depth):
    return depth * np.exp(-(((r - at) / width) ** 2))


@pytest.mark.parametrize(("change", "check"), [
    (lambda r, q: q + 1e-6, "tracking"),
    (lambda r, q: q + np.where(r > 0.5, 2 * np.pi, 0)[:, None], "continuity"),
    (lambda r, q: q + np.where(r > 0.123456, 0.01, 0)[:, None], "continuity"),
    (lambda r, q: q - np.stack([0 * r, dip(r, 0.30042, 2e-4, 1.3), 0 * r], axis=-1), "limits"),
])  # fmt: skip
def test_faults_between_the_samples_are_found(seed_problem, seed_plan, change, check):
    failures = verify_motion(seed_problem, broken(seed_plan, change)).failures
    assert check in {failure.check for failure in failures}


def test_a_jump_is_not_smoothed_over_by_leaving_the_path_for_a_moment(seed_problem, seed_plan):
    """From one exact motion to another in a ten-millionth of the path, which is continuous."""
    arm, path = seed_problem.arm, seed_problem.path

    def motion(r):
        q = seed_plan(r)
        aside = arm.solve(path(r), arm.u_of(q) + 0.02, int(arm.branch_of(q)[0]))[0]
        way = np.clip((r - 0.500123) / 1e-7, 0.0, 1.0)[:, None]
        return (1 - way) * q + way * arm.limits.lift(aside[None].copy(), q[0]).q[0]

    failures = verify_motion(seed_problem, motion).failures
    assert [failure.check for failure in failures] == ["tracking"]
    assert failures[0].r == pytest.approx(0.500123, abs=1e-6)


def test_tracking_is_measured_between_the_samples(seed_problem, seed_plan):
    between = 1200.5 / (4 * 999)  # of the places that are looked at
    fault = broken(seed_plan, lambda r, q: q + dip(r, between, 4e-5, 1.5e-5)[:, None])
    check = verify_motion(seed_problem, fault)
    assert {failure.check for failure in check.failures} == {"tracking"}
    r = np.linspace(between - 1e-4, between + 1e-4, 2001)
    worst = seed_problem.arm.task_error(fault(r), seed_problem.path(r)).max()
    assert check.max_tracking_error == pytest.approx(worst, rel=1e-9)


def test_the_least_margin_is_measured_between_the_samples(seed_problem, seed_plan):
    near = broken(seed_plan, lambda r, q: q - np.stack([0 * r, dip(r, 0.30042, 2e-4, 0.6), 0 * r], axis=-1))
    check = verify_motion(seed_problem, near)
    least = seed_problem.arm.margins(near(np.linspace(0.3, 0.301, 100_001))).min()
    assert "limits" not in {failure.check for failure in check.failures}
    assert check.min_limit_margin == pytest.approx(least, abs=1e-8)
    assert least < check.min_limit_margin + 1e-8 < seed_problem.arm.margins(near(seed_problem.rows)).min() - 1e-4


def test_a_steep_but_continuous_motion_is_no_jump(seed_problem, seed_plan):
    steep = broken(seed_plan, lambda r, q: q + np.tanh((r - 0.5) * 1e5)[:, None])
    assert "continuity" not in {f.check for f in verify_motion(seed_problem, steep).failures}


@pytest.fixture
def rows(seed_plan):
    r = np.linspace(0, 1, 400)
    return r, seed_plan(r)


def test_a_good_trajectory_holds(seed_problem, rows):
    verdict = judge(seed_problem, *rows)
    assert verdict.holds
    assert verdict.failures == ()
    assert verdict.cost_sampled == pytest.approx(5.27751, abs=2e-4)
    assert verdict.min_limit_margin > 1


def flip(r, q, arm, path):
    """The other elbow from the middle on: every row tracks the path."""
    other = arm.solve(path(r), arm.u_of(q), 1)[0]
    return np.where((r > 0.5)[:, None], other, q)


def slide(r, q, arm, path, by):
    """From the middle on another posture of the same self-motion: every row tracks the path."""
    other = arm.solve(path(r), arm.u_of(q) - by, 0)[0]
    return np.where((r > 0.5)[:, None], other, q)


def changed(q, row, column, by):
    q = q.copy()
    q[row, column] += by
    return q


@pytest.mark.parametrize(("change", "check", "joint"), [
    (lambda r, q, a, p: changed(q, 100, 0, 1e-3), "tracking", None),
    (lambda r, q, a, p: changed(q, 0, 2, 1e-4), "tracking", None),
    (lambda r, q, a, p: changed(q, 399, 1, 1e-4), "tracking", None),
    (lambda r, q, a, p: flip(r, q, a, p), "continuity", 2),
    (lambda r, q, a, p: flip(r, q, a, p), "limits", 2),
    (lambda r, q, a, p: slide(r, q, a, p, 0.05), "continuity", None),
    (lambda r, q, a, p: slide(r, q, a, p, 0.3), "continuity", None),
    (lambda r, q, a, p: q[::-1], "tracking", None),
    (lambda r, q, a, p: changed(q, 50, 1, 2 * np.pi), "limits", 2),
])  # fmt: skip
def test_the_judge_finds_what_is_wrong(seed_problem, rows, change, check, joint):
    r, q = rows
    verdict = judge(seed_problem, r, change(r, q, seed_problem.arm, seed_problem.path))
    assert not verdict.holds
    found = [failure for failure in verdict.failures if failure.check == check]
    assert found
    if joint:
        assert found[0].joint == joint
    assert r[found[0].row - 1] == found[0].r
    assert check in str(found[0])


def test_free_joints_may_be_given_modulo_turns(seed_problem, rows):
    r, q = rows
    q = q + 2 * np.pi * np.array([1, 0, 0]) * (r > 0.4)[:, None]
    assert judge(seed_problem, r, q).holds


def test_too_few_rows_leave_the_path_between_them(seed_problem, seed_plan):
    r = np.linspace(0, 1, 5)
    assert "tracking_between" in {f.check for f in judge(seed_problem, r, seed_plan(r)).failures}
    loose = Tolerances(between=0.5, step=2.0)
    assert judge(seed_problem, r, seed_plan(r), loose).holds


def test_the_rest_of_the_problem_is_judged_too(seed_arm, seed_path, rows):
    r, q = rows

    def checks(problem, r=r, q=q):
        return {failure.check for failure in judge(problem, r, q).failures}

    assert checks(sm.Problem(seed_arm, seed_path, start=[0.3])) == set()
    assert checks(sm.Problem(seed_arm, seed_path, start=[0.31])) == {"start"}
    assert checks(sm.Problem(seed_arm, seed_path, end=[0.5])) == {"end"}
    assert checks(sm.Problem(seed_arm, seed_path), r[:-1], q[:-1]) == {"coverage"}
    free = sm.PlanarArm([30, 30, 20])
    assert checks(sm.Problem(free, seed_path, elbow="negative")) == {"elbow"}
    closed = sm.Problem(seed_arm, sm.Circle([50, 0], 10), cyclic="exact")
    assert "closure" in checks(closed)
    turned = sm.PlanarArm([30, 30, 20, 5], direction=0.0)
    assert "tracking" in checks(sm.Problem(turned, seed_path), r, np.column_stack([q, 0 * r + 0.1]))


def test_a_continuous_motion_is_held_to_elbow_and_start_too(seed_path, seed_plan):
    free = sm.PlanarArm([30, 30, 20])

    def checks(**asked):
        failures = verify_motion(sm.Problem(free, seed_path, **asked), seed_plan.motion).failures
        assert all(failure.row is None for failure in failures)
        return {failure.check for failure in failures}

    assert checks(elbow="positive", start=[0.3]) == set()
    assert checks(elbow="negative") == {"elbow"}
    assert checks(start=[0.31]) == {"start"}
    assert checks(end=[0.5]) == {"end"}


def test_a_motion_that_must_close_and_does_not_fails():
    arm, path = sm.PlanarArm([30, 30, 20]), sm.Circle((40, 10), 15)
    open_ended = sm.plan(sm.Problem(arm, path), sm.Refine(starts=1))
    for cyclic in ("exact", "modulo"):
        check = verify_motion(sm.Problem(arm, path, cyclic=cyclic), open_ended)
        (failure,) = check.failures
        assert failure.check == "closure"
        gap = np.abs(open_ended(1.0) - open_ended(0.0))
        assert failure.value == pytest.approx(gap.max())
        assert failure.joint == np.argmax(gap) + 1
    turned = verify_motion(sm.Problem(arm, path, cyclic="modulo"), lambda r: open_ended(0 * r))
    assert "closure" not in {failure.check for failure in turned.failures}
