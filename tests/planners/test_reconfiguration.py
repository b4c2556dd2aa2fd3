"""Motions with the fewest reconfigurations where no continuous one exists."""

import json
import time

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.planners.reconfiguration import break_ranges, explained


def strip_problem(limit, **options):
    arm = sm.PlanarArm([1, 1, 1], [(-limit, limit)] * 3)
    return sm.Problem(arm, sm.Line([1.5, -2.5], [1.5, 2.5]), **options)


@pytest.fixture(scope="module")
def error():
    return explained(strip_problem(1.45), time.perf_counter() + 30.0)


def test_one_break_does_and_its_place_is_bounded(error):
    (part,) = error.reconfigured.breaks
    assert part.r_range == error.blocked[0].r
    assert part.r_range[0] <= part.r <= part.r_range[1]
    assert part.travel > 0.1


def test_the_pieces_are_motions_that_hold(error):
    problem, plans = strip_problem(1.45), error.reconfigured.plans
    (part,) = error.reconfigured.breaks
    assert all(plan.verification.holds for plan in plans)
    edges = [0.0, part.r, 1.0]
    for plan, low, high in zip(plans, edges[:-1], edges[1:], strict=True):
        r = np.linspace(0, 1, 11)
        np.testing.assert_allclose(problem.arm.forward(plan(r)), problem.path(low + (high - low) * r), atol=1e-8)
    np.testing.assert_allclose(plans[0](1.0), part.before)
    np.testing.assert_allclose(plans[1](0.0), part.after)
    total = sum(plan.l1_travel for plan in plans) + np.abs(part.after - part.before).sum()
    assert error.reconfigured.l1_travel == pytest.approx(total)


def test_a_problem_with_a_motion_needs_no_break():
    assert break_ranges(strip_problem(2.2)) == []
    assert explained(strip_problem(2.2), time.perf_counter() + 10.0) is None


def test_ends_on_parts_that_nothing_joins_need_one_break_anywhere():
    """With the tool nearer than the length of a link each elbow is a closed curve of self-motion by itself."""
    arm, path = sm.PlanarArm([1, 1, 1]), sm.Line([0.5, 0.0], [0.6, 0.2])
    start, end = (arm.solve(path(r), [2.0], branch)[0] for r, branch in ((0.0, 0), (1.0, 1)))
    problem = sm.Problem(arm, path, start={"q": start}, end={"q": end})
    assert break_ranges(problem) == [(0.0, 1.0)]


def test_several_breaks_are_counted():
    """There and back and there again along the strip, each time through the stretch that blocks."""
    arm = sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3)
    there = [[1.5, -2.5], [1.5, 2.5], [1.5, -2.5], [1.5, 2.5]]
    ranges = break_ranges(sm.Problem(arm, sm.Waypoints(there)))
    assert len(ranges) == 3
    for k, (low, high) in enumerate(ranges):
        np.testing.assert_allclose([low, high], (k + np.array([0.4177317, 0.5822683])) / 3, atol=1e-6)


def test_the_command_line_says_it(run, tmp_path, error, monkeypatch):
    """With --json one object: what blocks, what the nearest limit needs, and how many breaks would do."""
    from selfmotion.planners import Refine

    def refuse(self, problem, progress=None):
        raise error

    monkeypatch.setattr(Refine, "plan", refuse)
    file = tmp_path / "problem.json"
    data = {
        "arm": {"kind": "planar", "links": [1, 1, 1], "limits": [[-1.45, 1.45]] * 3},
        "path": {"kind": "line", "start": [1.5, -2.5], "end": [1.5, 2.5]},
        "planner": {"kind": "refine"},
    }
    file.write_text(json.dumps(data))
    code, out, err = run("plan", str(file), "--json")
    result = json.loads(out)
    assert code == 3
    assert result["status"] == "infeasible"
    assert result["reconfigurations"] == 1
    assert result["blocked"][0]["cause"] == "joint limits"
    assert result["needs"][0]["joint"] == 1
    assert result["proof"]["deaths"]
    assert "θ1 needs" in err
