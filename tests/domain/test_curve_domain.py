"""The angle domain of arms in space along a path of poses: sets, samples as strips, picture, command."""

import json
import os

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.angles import TAU
from selfmotion.arms import Cause, named_arm
from selfmotion.domain import Run, SampledDomain
from selfmotion.domain.strands import _partners
from selfmotion.plot import draw_sampled_domain, figure, figure_data, sampled_domain_figure

CIRCLE = "0.45,{y:.12f},{z:.12f},1,0,0,0"


def circle_path(count=41):
    t = np.linspace(0, TAU, count)
    return sm.PoseWaypoints(
        np.column_stack(
            [np.full(count, 0.45), 0.2 * np.cos(t), 0.4 + 0.2 * np.sin(t), np.tile([0, 1, 0, 0], (count, 1))]
        )
    )


def line_path(count=200):
    x = np.linspace(0.45, -0.45, count)
    return sm.PoseWaypoints(np.column_stack([x, np.tile([0.5422, 0.7885, 1, 0, 0, 0], (count, 1))]))


@pytest.fixture(scope="module", params=["circle", "line"])
def case(request):
    domain = sm.angle_domain(named_arm("panda"), circle_path() if request.param == "circle" else line_path())
    return domain, SampledDomain(domain, range(8), 60)


def is_feasible(domain, r, u, branch):
    arm = domain.self_motion.arm
    q, ok = arm.solve(domain.path(r), np.asarray(u)[:, None], branch)
    return ok & (arm.limits.excess(np.where(ok[:, None], q, 0.0)).max(axis=-1) <= 0.0)


def test_the_domain_is_what_the_closed_form_says(case):
    domain, _ = case
    u = np.linspace(-np.pi, np.pi, 2001)
    for r in (0.0, 0.123, 0.5, 0.77):
        for branch, name in enumerate(domain.self_motion.branches):
            found = domain(r, name)
            clear = found.distance_to_ends(u) > 1e-7
            np.testing.assert_array_equal(found.contains(u)[clear], is_feasible(domain, r, u, branch)[clear])


def test_an_island_that_is_seen_is_there():
    """On the line one branch is feasible on a piece 6e-4 rad short for a few hundredths of the path."""
    domain = sm.angle_domain(named_arm("panda"), line_path())
    u = np.linspace(-0.76, -0.74, 20001)
    island = u[is_feasible(domain, 0.59, u, 2)]
    assert len(island) > 5
    assert [pair for pair in domain(0.59, 2) if pair[0] <= island[0] and island[-1] <= pair[1] <= island[-1] + 2e-6]


def test_what_blocks_is_told_of_the_branch_that_is_asked_for():
    arm, path = named_arm("panda"), circle_path(101)
    for branch in ("q4- q5in q2+", "q4- q5out q2-", "q4+ q5in q2+"):
        k = arm.branches.index(branch)
        sampled = SampledDomain(sm.angle_domain(arm, path), [k], 60)
        blocked = sm.Problem(arm, path, elbow=branch).blocked
        ends = np.array([0.0, *(end for part in sampled.stretches(k) for end in part), 1.0]).reshape(-1, 2)
        expected = [pair for pair in ends if pair[1] - pair[0] > 0.02]
        np.testing.assert_allclose(
            np.reshape([part.r for part in blocked], (-1, 2)), np.reshape(expected, (-1, 2)), atol=0.02
        )
        assert all(part.cause == "joint limits" for part in blocked)


def test_strips_hold_what_is_feasible(case):
    domain, sampled = case
    rng = np.random.default_rng(0)
    checked = 0
    for branch in range(8):
        strips = sampled.strips(branch)
        for r in rng.uniform(0, 1, 12):
            u = rng.uniform(-np.pi, np.pi, 200)
            inside = np.zeros(len(u), bool)
            for strip in strips:
                if strip.r[0] <= r <= strip.r[-1] and len(strip.r) > 1:
                    low, high = np.interp(r, strip.r, strip.low), np.interp(r, strip.r, strip.high)
                    inside |= np.mod(u - low, TAU) <= high - low
            clear = domain(r, branch).distance_to_ends(u) > 0.03
            wanted = is_feasible(domain, r, u, branch)
            np.testing.assert_array_equal(inside[clear], wanted[clear], err_msg=f"{branch} {r}")
            checked += wanted.sum()
    assert checked > 100


def test_changes_are_closed_in_upon(case):
    _, sampled = case
    assert len(sampled.r) > 60
    assert np.diff(sampled.r).min() < 0.2 / 60
    for branch in range(8):
        for low, high in sampled.stretches(branch):
            assert 0.0 <= low <= high <= 1.0
        assert bool(sampled.stretches(branch)) == any(sampled.runs[branch])


def test_limits_of_both_sides_bound_the_circle(case):
    domain, sampled = case
    causes = {cause for runs in sampled.runs[0] for run in runs for end in run.causes for cause in end}
    assert {cause.kind for cause in causes} <= {"fold", "lower limit", "upper limit"}
    assert {cause.joint for cause in causes if cause.kind == "fold"} == {4}
    assert domain.self_motion.causes[0].joint == 0


def test_runs_go_on_by_their_ends_and_what_they_share():
    one, two = (Cause("lower limit", 1, -1.0),), (Cause("upper limit", 1, 1.0),)
    before = [Run(-1.0, 0.0, (one, two)), Run(1.0, 2.0, (one, two))]
    assert _partners(before, [Run(1.1, 2.1, (one, two)), Run(-0.9, 0.1, (one, two))]) == [1, 0]
    assert _partners(before, [Run(0.9 + TAU, 2.1 + TAU, (one, two))]) == [1]
    assert _partners(before, [Run(-1.0, 0.0, (two, one))]) == [None]
    assert _partners(before[:1], [Run(0.1, 0.2, (one, two))]) == [0]
    assert _partners(before, [Run(0.1, 0.2, (one, two))]) == [None]


def test_what_is_not_told_is_said(case):
    domain, _ = case
    with pytest.raises(sm.InvalidInputError, match="structure along a path"):
        _ = domain.structure
    with pytest.raises(sm.InvalidInputError, match="branch"):
        domain(0.5, "positive")


def test_the_picture_shows_branches_limits_folds_and_the_motion(case):
    domain, sampled = case
    r = np.linspace(0, 1, 40)
    u = np.array([domain(x, 0).intervals[0].mean() for x in r])
    files = sampled_domain_figure(sampled, (r, u, np.zeros(40, int)))
    assert set(files) == {"domain.png", "domain.svg"}
    with figure() as (canvas, (axes,)):
        draw_sampled_domain(axes, sampled, 0, (r, u, r < 0.5))
        canvas.canvas.draw()
        shown = figure_data(canvas)["axes"][0]
    labels = [line["label"] for line in shown["lines"]]
    assert "fold θ5 = ±π/2" in labels
    assert "θ2 upper" in labels
    motion = next(line for line in shown["lines"] if line["label"] == "motion")
    drawn = [value for value in motion["y"] if value is not None and np.isfinite(value)]
    np.testing.assert_allclose(drawn, u[r < 0.5], atol=1e-12)
    assert shown["title"] == domain.self_motion.branches[0]


def test_nothing_feasible_is_a_picture_too():
    far = circle_path(5)
    x = far(far.waypoints)
    x[:, 0] = 3.0
    sampled = SampledDomain(sm.angle_domain(named_arm("panda"), sm.PoseWaypoints(x)), range(8), 5)
    assert all(sampled.strips(branch) == [] for branch in range(8))
    assert set(sampled_domain_figure(sampled)) == {"domain.png", "domain.svg"}


def test_the_command_writes_picture_and_intervals(run, tmp_path):
    t = np.linspace(0, 1.5, 12)
    rows = [CIRCLE.format(y=0.2 * np.cos(s), z=0.4 + 0.2 * np.sin(s)) for s in t]
    (tmp_path / "poses.csv").write_text("x,y,z,qx,qy,qz,qw\n" + "\n".join(rows) + "\n")
    problem = {"arm": {"kind": "named", "name": "panda"}, "path": {"kind": "file", "file": "poses.csv"}, "samples": 40}
    (tmp_path / "problem.json").write_text(json.dumps(problem))
    out = tmp_path / "out"
    code, printed, err = run("domain", str(tmp_path / "problem.json"), "--out", str(out))
    assert (code, err) == (0, "")
    assert "q4- q5in q2+: feasible for r in [0, 1]" in printed
    assert sorted(os.listdir(out)) == [".selfmotion.json", "domain.json", "domain.png", "domain.svg"]
    found = json.loads((out / "domain.json").read_text())
    assert found["status"] == "drawn"
    assert found["blocked"] is None
    assert len(found["u"]) == len(found["ends"]) == 8
    assert len(found["r"]) == len(found["u"]["q4- q5in q2+"]) >= 100
    domain = sm.angle_domain(named_arm("panda"), sm.load_problem(tmp_path / "problem.json").problem.path)
    for k in (0, 50, -1):
        wanted = domain(found["r"][k], 0).intervals
        np.testing.assert_allclose(found["u"]["q4- q5in q2+"][k], wanted, atol=1e-12)
        assert all(
            cause["joint"] in range(1, 8) for pair in found["ends"]["q4- q5in q2+"][k] for end in pair for cause in end
        )
