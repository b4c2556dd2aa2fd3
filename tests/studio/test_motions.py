"""Motions as plain data: postures are the arm's, and what is wrong is where dense inverse kinematics says so."""

import math

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.plan_file import plan_from_text
from selfmotion.studio.answers import ANSWERS
from selfmotion.studio.cases import CASES
from selfmotion.studio.hand import hand_of
from selfmotion.studio.motions import curve_object, plan_object, sinusoid_of, tube_object
from selfmotion.studio.panels import branch_window
from selfmotion.studio.place import Place
from selfmotion.studio.problems import problem_of
from selfmotion.studio.wire import unpacked

SEED = CASES[0].problem


def hand(problem, rows, branch="positive"):
    return hand_of(problem.arm, {"branch": branch, "coefficients": rows})


def arrays(motion, *names):
    return [unpacked(name, motion[name]) for name in names]


def inside(stretches, r):
    return any(a <= r <= b for a, b in stretches)


def test_a_motion_that_holds_has_the_arms_postures_and_its_plans_figures():
    problem = problem_of(SEED, None).problem
    told = curve_object(problem, hand(problem, [[0.3] * 8]), "hand")
    r, u, q, branch, points = arrays(told, "r", "u", "q", "branch", "points")
    assert told["holds"]
    assert told["wrong"] == []
    np.testing.assert_array_equal(r, problem.rows)
    np.testing.assert_allclose(u, 0.3, atol=1e-12)
    np.testing.assert_allclose(problem.arm.forward(q), problem.path(r), atol=1e-9)
    np.testing.assert_allclose(points, problem.arm.joint_positions(q), atol=1e-4)
    assert set(branch) == {0.0}
    assert told["margin"] == pytest.approx(problem.arm.margins(q).min(), abs=1e-6)
    assert told["tool_error"] < 1e-9 * problem.arm.reach
    assert told["max_step"] == pytest.approx(np.abs(np.diff(q, axis=0)).max())
    fast = curve_object(problem, hand(problem, [[0.3] * 8]), "hand", settled=False)
    assert fast["cost"] == told["cost"]
    assert fast["l1"] == pytest.approx(told["l1"], rel=1e-4)
    assert fast["tool_error"] is None


WIDE = [[0.3, 0.5, 2.9, 2.0, 0.0, -1.9, -2.5, -0.6, 0.2]]


def test_wrong_stretches_are_where_no_posture_exists_or_limits_are_left():
    arm = sm.PlanarArm([30, 30, 20], [(-1.0, 1.2), (0, 1.9), (-1.4, 1.3)])
    problem = sm.Problem(arm, sm.Bezier(SEED["path"]["control_points"]), samples=2000)
    curve = hand(problem, WIDE)
    told = curve_object(problem, curve, "hand")
    reach = [part["r"] for part in told["wrong"] if part["kind"] == "reach"]
    assert reach
    assert told["cost"] is None
    assert not told["holds"]
    r = np.random.default_rng(1).uniform(0, 1, 4000)
    order = np.argsort(r)
    r = r[order]
    u = curve.curve(r, 0)
    _, ok = arm.solve(problem.path(r), u, 0)
    near = 1.0 / 1999
    ends = np.array(reach).ravel()
    told_far = np.abs(r[:, None] - ends).min(axis=1) > near
    assert all(inside(reach, at) != fine for at, fine in zip(r[told_far], ok[told_far], strict=True))
    shown_r, shown_q = arrays(told, "r", "q")
    missing = ~np.isfinite(shown_q).all(axis=1)
    assert missing.sum() == sum(inside(reach, at) for at in shown_r) > 20
    assert all(inside(reach, at) for at in shown_r[missing])
    # limits: where the posture that is shown is outside of them, and nowhere else
    for j in range(arm.n):
        stretches = [part["r"] for part in told["wrong"] if part["kind"] == "limit" and part["joint"] == j]
        with np.errstate(invalid="ignore"):
            out = (shown_q[:, j] < arm.limits.lower[j] - 1e-6) | (shown_q[:, j] > arm.limits.upper[j] + 1e-6)
        well = np.isfinite(shown_q[:, j])
        assert all(inside(stretches, at) for at in shown_r[out])
        assert all(inside(stretches, at) for at in shown_r[well & out])
        clear = well & ~out
        clear[1:] &= ~out[:-1] & well[:-1]
        clear[:-1] &= ~out[1:] & well[1:]
        assert not any(inside(stretches, at) for at in shown_r[clear])


def test_by_how_much_is_the_largest_overrun_of_the_stretch():
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), (-2.0, 0.05)])
    problem = sm.Problem(arm, sm.Bezier(SEED["path"]["control_points"]))
    told = curve_object(problem, hand(problem, [[0.3, 0.3, 0.6, 0.9, 0.9, 0.6, 0.3, 0.3]]), "hand")
    r, q = arrays(told, "r", "q")
    limits = [part for part in told["wrong"] if part["kind"] == "limit"]
    assert limits
    for part in limits:
        assert part["joint"] == 2
        here = (r >= part["r"][0]) & (r <= part["r"][1])
        assert part["by"] == pytest.approx((q[here, 2] - 0.05).max(), rel=1e-9)
        assert part["text"] == f"θ3 above its upper limit by {part['by']:.3g} rad"
        lower, upper = (np.interp(end, r, q[:, 2]) for end in part["r"])
        if part["r"][0] > 0:
            assert lower == pytest.approx(0.05, abs=1e-9)
        if part["r"][1] < 1:
            assert upper == pytest.approx(0.05, abs=1e-9)


def test_what_breaks_between_samples_is_found_when_it_is_settled():
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
    path = sm.Line([60, -10], [60, 30])
    problem = sm.Problem(arm, path, samples=12)
    rows = np.full((1, 60), 0.3)
    rows[0, 29:31] = 2.6  # a swing that eleven samples step over
    curve = hand(problem, rows.tolist())
    fast, settled = (curve_object(problem, curve, "hand", settled) for settled in (False, True))
    dense = problem.path(np.linspace(0, 1, 3001))
    _, ok = arm.solve(dense, curve.curve(np.linspace(0, 1, 3001), 0), 0)
    assert not ok.all()
    assert fast["holds"]
    assert not settled["holds"]
    assert settled["wrong"][0]["kind"] in ("tracking", "limit", "continuity")


def test_a_start_or_a_branch_that_is_not_kept_is_wrong():
    data = {**SEED, "start": {"u": [0.5]}, "elbow": "positive"}
    problem = problem_of(data, None).problem
    kinds = {part["kind"] for part in curve_object(problem, hand(problem, [[0.3] * 8]), "hand", False)["wrong"]}
    assert kinds == {"start"}
    fine = curve_object(problem, hand(problem, [[0.5] * 8]), "hand", False)
    assert "start" not in {part["kind"] for part in fine["wrong"]}
    free = problem_of({**SEED, "arm": {"kind": "planar", "links": [30, 30, 20]}, "elbow": "positive"}, None).problem
    kinds = {part["kind"] for part in curve_object(free, hand(free, [[0.3] * 8], "negative"), "hand")["wrong"]}
    assert "elbow" in kinds


def test_a_motion_that_must_close_and_does_not_is_wrong():
    problem = sm.Problem(sm.PlanarArm([30, 30, 20]), sm.Circle([45, 10], 8), cyclic="exact")
    closed = curve_object(problem, hand(problem, [[0.3] * 8]), "hand")
    assert closed["holds"]
    told = curve_object(problem, hand(problem, [np.linspace(0.3, 0.6, 8).tolist()]), "hand")
    assert [part["kind"] for part in told["wrong"]] == ["closure"]


def test_the_planners_sinusoid_is_shown_at_any_frequency():
    problem, planner = problem_of(SEED, None)
    curve = sinusoid_of(problem, planner, [2.5])
    r = np.linspace(0, 1, 100)
    np.testing.assert_allclose(curve.curve(r, 0)[:, 0], 0.3 + 0.4 * np.sin(2 * np.pi * 2.5 * r), atol=1e-14)
    assert curve.branch == 0
    with pytest.raises(InvalidInputError, match="frequency"):
        sinusoid_of(problem, None, [2.5])
    with pytest.raises(InvalidInputError, match="frequency"):
        sinusoid_of(problem, planner, [2.5, 1.0])


@pytest.fixture(scope="module")
def proved():
    problem, planner = problem_of(CASES[1].problem, None)
    return planner.plan(problem)


@pytest.fixture(scope="module")
def crossing():
    case = next(case for case in CASES if case.name == "both-elbows")
    problem, planner = problem_of(case.problem, None)
    return planner.plan(problem)


def distance_to(polygons, r, u):
    """How far (r, u) is from the nearest polygon over r; polygons are trapezoids with vertical sides."""
    least = math.inf
    for (left, a), (right, c), (_, d), (_, b) in polygons:
        if left - 1e-12 <= r <= right + 1e-12:
            part = (r - left) / (right - left)
            low, high = a + part * (c - a), b + part * (d - b)
            least = min(least, max(low - u, u - high, 0.0))
    return least


@pytest.mark.parametrize("name", ["proved", "crossing"])
def test_the_tube_contains_the_motion(name, request):
    plan = request.getfixturevalue(name)
    arm = plan.problem.arm
    found = {
        part["branch"]: unpacked("p", part["polygons"]) for part in tube_object(plan.problem, plan.certificate.tube)
    }
    slices = np.array([part.r for part in plan.certificate.tube])
    q = plan(slices)
    on, u = arm.branch_of(q), arm.u_of(q)[:, 0]
    clear = np.abs(np.sin(q[:, 1])) > 0.05  # at a fold a posture is on either side
    assert clear.sum() > 10
    for r, branch, value in zip(slices[clear], on[clear], u[clear], strict=True):
        shown = float(branch_window(plan.problem, int(branch)).wrapped(np.asarray(value)))
        assert distance_to(found[int(branch)], r, shown) < 5e-3
        assert distance_to(found[int(branch)], r, shown + 1.0) > 0.1


def test_a_plan_as_plain_data_is_the_plan(proved):
    told = plan_object(proved)
    assert told["motion"]["cost"] == proved.cost
    assert told["summary"] == proved.summary()
    assert "proved within" in told["verdict"]
    assert told["levels"][-1]["bound"] == proved.certificate.levels[-1].bound
    again = plan_from_text(told["plan"])
    r = np.linspace(0, 1, 77)
    np.testing.assert_array_equal(again(r), proved(r))
    assert again.lower_bound == proved.lower_bound
    shown_r, shown_q = arrays(told["motion"], "r", "q")
    np.testing.assert_array_equal(proved(shown_r), shown_q)


def test_a_motion_through_a_fold_is_on_both_branches(crossing):
    told = plan_object(crossing)["motion"]
    branch, u = arrays(told, "branch", "u")
    assert set(branch) == {0.0, 1.0}
    assert np.abs(np.diff(u[:, 0])).max() < 1.0


def test_progress_is_told_while_planning():
    data = {**SEED, "planner": {**SEED["planner"], "optimizer": {"kind": "pso", "population": 8, "iterations": 5,
                                                                 "bounds": [0, 2], "seed": 1}}}  # fmt: skip
    heard = []
    told = ANSWERS["plan"]({"problem": data}, lambda *words: heard.append(words), Place())
    assert [(done, total) for done, total, _ in heard] == [(k, 5) for k in range(1, 6)]
    assert heard[-1][2] == pytest.approx(told["history"][0]["best"][-1])
    with pytest.raises(InvalidInputError, match="planner"):
        ANSWERS["plan"]({"problem": {key: value for key, value in data.items() if key != "planner"}}, print, Place())


def test_long_motions_are_thinned_and_keep_both_ends():
    problem = problem_of({**SEED, "samples": 9000}, None).problem
    told = curve_object(problem, hand(problem, [[0.3] * 8]), "hand", False)
    r, q = arrays(told, "r", "q")
    assert len(r) == len(q) == 2001
    assert (r[0], r[-1]) == (0.0, 1.0)
    assert (np.diff(r) > 0).all()


@pytest.fixture(scope="module")
def panda():
    return problem_of(next(case.problem for case in CASES if case.name == "panda-circle"), None).problem


def test_of_an_arm_in_space_postures_that_do_not_exist_are_missing(panda):
    r = panda.rows
    seen = set()
    for branch in panda.elbow_branches:
        rows = [np.linspace(-2.6, 2.6, 12).tolist()]
        curve = hand(panda, rows, panda.arm.branches[branch])
        told = curve_object(panda, curve, "hand")
        _, ok = panda.arm.solve(panda.path(r), curve.curve(r, 0), branch)
        (q,) = arrays(told, "q")
        np.testing.assert_array_equal(np.isfinite(q).all(axis=1), ok)
        reach = [part["r"] for part in told["wrong"] if part["kind"] == "reach"]
        assert all(inside(reach, at) != fine for at, fine in zip(r, ok, strict=True))
        assert panda.arm.task_error(q[ok], panda.path(r[ok])).max(initial=0.0) < 1e-8
        seen |= set(ok.tolist())
    assert seen == {True, False}


def test_of_an_arm_in_space_limits_are_told_by_joint(panda):
    branch = panda.elbow_branches[0]
    curve = hand(panda, [[0.8] * 8], panda.arm.branches[branch])
    told = curve_object(panda, curve, "hand", settled=False)
    r, q = arrays(told, "r", "q")
    for j in range(7):
        stretches = [part["r"] for part in told["wrong"] if part["kind"] == "limit" and part["joint"] == j]
        margin = np.minimum(q[:, j] - panda.arm.limits.lower[j], panda.arm.limits.upper[j] - q[:, j])
        assert all(inside(stretches, at) for at in r[margin < -1e-6])
        deep = (margin > 0) & (np.roll(margin, 1) > 0) & (np.roll(margin, -1) > 0)
        assert not any(inside(stretches, at) for at in r[deep])
