"""Plans of arms that are solved but not enclosed: the same motions, estimates instead of bounds, no infeasibility."""

import json
from pathlib import Path

import jsonschema
import numpy as np
import pytest

import robots
import selfmotion as sm
from selfmotion.arms import CATALOGUE
from selfmotion.arms.locked import LockedArm
from selfmotion.certificate.infeasibility import explain
from selfmotion.exchange.schema import json_schema
from selfmotion.planners import compare_ladder, compare_plan, distance_from_optimum
from selfmotion.planners.globally_optimal import _Search
from selfmotion.plans import RESULT_FIELDS

pytest.importorskip("eaik")

LINE = Path(__file__).parents[2] / "examples" / "panda_line.yaml"
Q = np.array([0.2, 0.3, -0.1, 1.2, 0.1, 0.9, 0.3])
ESTIMATES = {"estimated_bound", "estimated_gap"}


def xarm_problem(arm=None, **given):
    """An xArm 7 moves its tool by 27 cm."""
    arm = arm or LockedArm(robots.chain("xarm7"))
    start = LockedArm(robots.chain("xarm7")).forward(Q)
    end = start + np.array([-0.1, 0.25, 0.05, 0, 0, 0, 0])
    return sm.Problem(
        arm, sm.PoseWaypoints(np.linspace(start, end, 21)), objective="joint_travel", samples=200, **given
    )


@pytest.fixture(scope="module")
def planned():
    """An xArm's plan."""
    return sm.plan(xarm_problem(), sm.Global(gap=2e-2))


@pytest.fixture
def xarm_file(tmp_path, planned):
    """A problem file of an xArm, and a way to change it."""
    (tmp_path / "xarm7.urdf").write_text(robots.XARM7)
    x = planned.problem.path(planned.problem.path.waypoints)[:, [0, 1, 2, 4, 5, 6, 3]]
    np.savetxt(tmp_path / "poses.csv", x, delimiter=",", header="x,y,z,qx,qy,qz,qw", comments="", fmt="%.17g")

    def write(**changes):
        data = {
            "arm": {"kind": "urdf", "file": "xarm7.urdf"}, "path": {"kind": "file", "file": "poses.csv"},
            "samples": 200, "planner": {"kind": "global", "gap": 2e-2}, **changes,
        }  # fmt: skip
        jsonschema.validate(data, json_schema())
        (tmp_path / "problem.json").write_text(json.dumps(data))
        return str(tmp_path / "problem.json")

    return write


def test_a_panda_with_a_joint_locked_has_the_motion_that_is_proved_best():
    problem, _ = sm.load_problem(LINE)
    locked = sm.Problem(LockedArm(CATALOGUE["panda"].chain()), problem.path, objective="l2")
    proved, estimated = (sm.plan(given, sm.Global(gap=1e-2)) for given in (problem, locked))
    assert estimated.cost == pytest.approx(proved.cost, rel=1e-3)
    assert (estimated.gap, estimated.lower_bound) == (None, None)
    assert estimated.estimated_gap <= 1e-2
    assert proved.lower_bound <= proved.cost
    assert estimated.estimated_bound == pytest.approx(proved.lower_bound, rel=1e-2)
    assert estimated.estimated_bound <= proved.cost * (1 + 1e-9)
    assert (proved.estimated_gap, proved.estimated_bound) == (None, None)
    assert estimated.verification.holds


def test_results_say_that_they_are_estimates(planned):
    assert planned.verification.holds
    assert not planned.certificate.rigorous
    assert 0.0 < planned.estimated_gap <= 2e-2
    summary = planned.summary()
    assert set(summary) == {*RESULT_FIELDS, *ESTIMATES, "l2_waypoints"}
    assert summary["gap"] is summary["lower_bound"] is None
    assert summary["estimated_bound"] <= summary["cost"]
    assert "an estimate" in summary["parameters"]["argument"]


def test_an_estimate_that_a_motion_refutes_does_not_count(planned):
    search = _Search(sm.Global(), planned.problem, None)
    search.bound, search.threshold = 2.0, 1.0
    found = search._certificate("values")
    assert (found.bound, found.rigorous) == (0.0, False)
    assert "does not count" in found.argument


def test_no_posture_inside_the_limits_is_unknown_not_infeasible():
    arm = LockedArm(robots.chain("xarm7"))
    narrow = arm.relaxed(*(np.where(np.arange(7) == 3, by, 0.0) for by in (-0.2, -3.9)))  # the elbow hardly bends
    problem = xarm_problem(narrow)
    assert problem.blocked == []
    with pytest.raises(
        sm.UndecidedError, match=r"no posture inside the limits was found at r = 0, which proves"
    ) as caught:
        sm.plan(problem, sm.Global(time_limit=5.0))
    assert caught.value.status == "unknown"
    assert caught.value.why == "estimate"
    found = explain(problem, np.inf)
    assert isinstance(found, sm.UndecidedError)


def test_a_motion_that_is_not_found_is_unknown_too(monkeypatch):
    monkeypatch.setattr("selfmotion.planners.globally_optimal._Search._add", lambda *_, **__: None)
    with pytest.raises(sm.UndecidedError, match="no motion was found, which proves nothing"):
        sm.plan(xarm_problem(), sm.Global(time_limit=3.0))


def test_farther_than_all_links_are_long_is_proved_infeasible():
    arm = LockedArm(robots.chain("xarm7"))
    start = arm.forward(Q)
    far = sm.Problem(arm, sm.PoseWaypoints(np.array([start, start + 2.0 * np.eye(7)[0]])))
    with pytest.raises(sm.InfeasibleError, match="out of reach"):
        sm.plan(far, sm.Global(time_limit=5.0))


@pytest.mark.parametrize("start", [{"q": Q}, {"u": [0.3]}])
def test_a_start_may_be_given_either_way(start, planned):
    problem = xarm_problem(start=start)
    plan = sm.plan(problem, sm.Global(gap=2e-2))
    assert plan.verification.holds
    assert plan.u(0.0)[0] == pytest.approx(0.3, abs=1e-6)
    assert plan.estimated_gap <= 2e-2
    assert plan.cost >= planned.estimated_bound


def test_what_cannot_be_asked_is_refused_with_a_reason():
    arm, search = LockedArm(robots.chain("xarm7")), sm.PSO(population=4, iterations=2, seed=1)
    with pytest.raises(sm.InvalidInputError, match="branch: cannot be asked"):
        xarm_problem(elbow="2")
    with pytest.raises(sm.InvalidInputError, match="planner: searches for u"):
        sm.plan(xarm_problem(), sm.Sinusoid([0.3], amplitude=[0.1], optimizer=search))
    with pytest.raises(sm.InvalidInputError, match=r"start\.u: .* choose another redundancy"):
        xarm_problem(arm.relaxed(np.where(np.arange(7) == 6, -6.0, 0.0)), start={"u": [2.0]})
    with pytest.raises(sm.InvalidInputError, match="angle domain is not told"):
        sm.angle_domain(arm, xarm_problem().path)


def test_a_rolling_tool_has_no_branch_to_be_asked_for_either(planned):
    arm = sm.named_arm("ur5e")
    with pytest.raises(sm.InvalidInputError, match="branch: cannot be asked of an arm whose tool rolls"):
        sm.Problem(arm, planned.problem.path, elbow=arm.branches[0])


def test_distances_and_comparisons_are_estimates_too(planned):
    r = planned.problem.rows
    distance = distance_from_optimum(planned.problem, r, planned(r), planned)
    assert distance.lower_bound is distance.gap is distance.gap_sampled is None
    assert 0.0 <= distance.estimated_gap <= 2e-2
    assert "estimated" in str(distance)
    assert set(distance.summary()) >= ESTIMATES
    rows = [compare_plan(planned), compare_ladder(planned, 60)]
    assert [(row.holds, row.why_not, row.gap) for row in rows] == [(True, None, None)] * 2
    assert all(row.estimated_gap > 0 for row in rows)
    assert "estimated_gap" in rows[0].summary()


def test_the_command_line_says_so(run, xarm_file, tmp_path):
    code, out, err = run("plan", xarm_file(), "--out", str(tmp_path / "out"))
    assert (code, err) == (0, "")
    assert "estimated to be within" in out
    assert "estimated gap" in out
    assert "proved" not in out.replace("not proved", "")
    code, out, _ = run("compare", xarm_file(), "--ladder", "60", "--json")
    assert code == 0
    found = json.loads(out)
    assert found["lower_bound"] is None
    assert found["estimated_bound"] > 0
    code, out, _ = run("compare", xarm_file(), "--ladder", "")
    assert "estimated gap" in out
    assert "are estimated to cost no less than" in out
    code, out, _ = run("verify", xarm_file(), str(tmp_path / "out" / "trajectory.csv"))
    assert code == 0
    assert "an estimated" in out
    code, _, err = run("domain", xarm_file(), "--out", str(tmp_path / "domain"))
    assert code == 2
    assert "its angle domain is not told" in err


def test_an_infeasible_file_is_unknown_to_the_command_line(run, xarm_file):
    limits = [[-0.1, 0.1]] * 7
    code, out, _ = run("plan", xarm_file(arm={"kind": "urdf", "file": "xarm7.urdf", "limits": limits}), "--json")
    assert code == 4
    result = json.loads(out)
    assert result["status"] == "unknown"
    assert "which proves nothing" in result["error"]["message"]


def test_an_arm_from_a_file_is_listed_with_how_it_is_solved(run, xarm_file, tmp_path):
    file = str(Path(xarm_file()).parent / "xarm7.urdf")
    code, out, _ = run("arms", file, "--json")
    assert code == 0
    (arm,) = json.loads(out)["arms"]
    assert (arm["parameter"], arm["branches"], arm["closed_form"], arm["rigorous"]) == ("q7", 16, False, False)
    assert arm["source"] == file
    code, out, _ = run("arms", file, "--base", "link0", "--tip", "link5")
    assert code == 0
    assert "not planned for" in out
    code, _, err = run("arms", str(tmp_path / "none.urdf"))
    assert code == 2
    assert "none.urdf" in err
