"""Proofs as pictures: the tube drawn is the tube proved, elbows go on through folds, the title says what is proved."""

import numpy as np
import pytest
from drawings import Case

import selfmotion as sm
from selfmotion.plot import draw_optimum, draw_proof, draw_tube, figure, plan_figures
from selfmotion.plot.optimum import merged, tube_intervals
from selfmotion.plot.unfolding import Unfolding


@pytest.fixture(scope="module")
def case():
    return Case()


@pytest.fixture(scope="module")
def proved(seed_arm, seed_path):
    """The seed's case, proved by the planner."""
    return sm.plan(sm.Problem(seed_arm, seed_path, start={"u": [0.3]}), sm.Global(gap=5e-4))


@pytest.fixture(scope="module")
def crossing():
    """A path on which the shortest motion from this start goes through a fold: limits leave it no other way."""
    problem = sm.Problem(sm.PlanarArm([30, 30, 20]), sm.Line([70, -10], [55, 30]))
    start = problem.arm.solve(problem.path(0.0), [0.6], 0)[0]
    end = problem.arm.solve(problem.path(1.0), [0.6], 1)[0]
    return sm.plan(sm.Problem(problem.arm, problem.path, start={"q": start}, end={"q": end}), sm.Refine(starts=4))


def ordinates(chart, plan, r):
    q = plan(r)
    return chart.ordinate(r, plan.problem.arm.u_of(q)[:, 0], plan.problem.arm.branch_of(q))


def chart_of(plan):
    return Unfolding(sm.angle_domain(plan.problem.arm, plan.problem.path))


def test_a_motion_goes_on_smoothly_through_a_fold(crossing):
    assert set(crossing.problem.arm.branch_of(crossing(np.linspace(0, 1, 50)))) == {0, 1}
    chart, r = chart_of(crossing), np.linspace(0, 1, 5001)
    assert chart.kind == "around"
    y = ordinates(chart, crossing, r)
    assert np.abs(np.diff(y)).max() < 0.02
    x, drawn = chart.curve(r, crossing.u(r)[:, 0], crossing.problem.arm.branch_of(crossing(r)))
    np.testing.assert_array_equal(x, r)
    np.testing.assert_array_equal(drawn, y)


@pytest.mark.parametrize("r", [0.0, 0.31, 1.0])
def test_the_chart_goes_once_around_the_self_motion(crossing, r):
    """Ordinates of the closed curve of postures: each elbow fills its own, and both ends are the same posture."""
    chart, arm = chart_of(crossing), crossing.problem.arm
    domain = sm.angle_domain(arm, crossing.problem.path)
    y = []
    for branch in (0, 1):
        u = domain.sweep(r, branch, 4001).u
        y.append(chart.ordinate(np.full(len(u), r), u, np.full(len(u), branch)))
        assert np.diff(np.sort(y[-1])).min() > 0
    assert [y[0].min(), y[0].max()] == pytest.approx([-np.pi / 2, np.pi / 2], abs=1e-5)
    assert (np.abs(y[1]) >= np.pi / 2 - 1e-5).all()
    assert [y[1].min(), y[1].max()] == pytest.approx([-np.pi, np.pi], abs=1e-2)
    psi = float(np.arctan2(*crossing.problem.path(r)[::-1]))
    ends = chart.ordinate(np.full(2, r), psi + np.array([-1e-9, 1e-9]), np.ones(2, dtype=int))
    np.testing.assert_allclose(ends, [-np.pi, np.pi], atol=1e-8)


def distances(case, r, s):
    """Return u from the middle between the folds, from the ordinate: R² + l3² − 2 R l3 cos a = (l1 + l2)²."""
    l1, l2, l3 = case.problem.arm.links
    radius = np.hypot(*case.problem.path(r).T)
    return np.arccos((radius**2 + l3**2 - (l1 + l2) ** 2) / (2 * radius * l3)) * np.sin(s)


@pytest.mark.parametrize("name", ["through_folds", "without_folds", "proved"])
def test_the_unfolded_region_has_the_area_of_both_elbows(case, name):
    plan = getattr(case, name)
    chart, domain = chart_of(plan), sm.angle_domain(plan.problem.arm, plan.problem.path)
    assert chart.kind == {"through_folds": "around", "without_folds": "apart", "proved": "one"}[name]
    drawn = 0.0
    for part in chart.parts():
        ends = [part.low, part.high]
        if chart.kind == "around":
            ends = [distances(plan, part.r, s) for s in ends]
        drawn += np.trapezoid(np.abs(ends[1] - ends[0]), part.r)
    r = np.linspace(0, 1, 1001)
    measure = np.trapezoid([[domain(at, branch).measure for branch in (0, 1)] for at in r], r, axis=0).sum()
    assert drawn == pytest.approx(measure, rel=3e-3)


def test_edges_are_drawn_where_limits_are_and_not_where_elbows_meet(case):
    plan, found = case.through_folds, 0
    arm = plan.problem.arm
    for part in chart_of(plan).parts():
        for edge in part.edges:
            at = np.flatnonzero(np.isfinite(edge))[5:-5:40]
            x = plan.problem.path(part.r[at])
            u = np.arctan2(x[:, 1], x[:, 0]) + distances(plan, part.r[at], edge[at])
            for k in range(len(at)):
                q = arm.solve(x[k], [u[k]], int(abs(edge[at[k]]) > np.pi / 2))[0]
                assert np.abs(np.abs(q) - 2.2).min() < 1e-5
                found += 1
    assert found > 50


def test_elbows_that_only_meet_here_and_there_are_drawn_one_above_the_other():
    """Folds θ2 = π bound the domain for a while, θ2 = 0 never does; the edges drawn are those folds."""
    arm, path = sm.PlanarArm([3, 1.5, 1.2]), sm.Line([2.0, -1.5], [1.5, 2.5])
    chart, found = Unfolding(sm.angle_domain(arm, path)), 0
    assert chart.kind == "apart"
    (positive, negative), shift = chart.names(), np.diff(list(chart.names()))[0]
    assert negative - positive == shift > 2 * np.pi
    for part in chart.parts():
        for edge in part.edges:
            at = np.flatnonzero(np.isfinite(edge))[3:-3:20]
            wrist = path(part.r[at]) - 1.2 * np.stack([np.cos(edge[at]), np.sin(edge[at])], axis=-1)
            above = path(part.r[at]) - 1.2 * np.stack([np.cos(edge[at] - shift), np.sin(edge[at] - shift)], axis=-1)
            reach = np.where(edge[at] > positive + np.pi, np.hypot(*above.T), np.hypot(*wrist.T))
            np.testing.assert_allclose(reach, 1.5, atol=1e-6)
            found += len(at)
    assert found > 20
    ticks, names = chart.ticks()
    assert len(ticks) == len(set(ticks)) == len(names) == 2 * len(set(names))
    for y, name in zip(ticks, names, strict=True):
        assert float(name.replace("−", "-")) == pytest.approx(y if y < positive + np.pi else y - shift)


def test_what_overlaps_is_one_interval():
    chords = np.array([[0.0, 1.0], [0.2, 0.5], [1.0, 1.5], [1.52, 2.0], [3.0, 3.1]])
    np.testing.assert_array_equal(merged(chords[::-1], 1e-6), [[0.0, 1.5], [1.52, 2.0], [3.0, 3.1]])
    np.testing.assert_array_equal(merged(chords, 0.1), [[0.0, 2.0], [3.0, 3.1]])
    assert merged(chords[:0], 0.1).shape == (0, 2)


def test_a_motion_across_the_seam_is_cut_there(crossing):
    chart, r = chart_of(crossing), np.linspace(0, 1, 201)
    x = crossing.problem.path(r)
    u = np.arctan2(x[:, 1], x[:, 0]) + 0.3 * (r - 0.5)
    rows, y = chart.curve(r, u, np.ones(201, dtype=int))
    gap = np.flatnonzero(np.isnan(y))
    assert len(gap) == 1
    assert [y[gap[0] - 1], y[gap[0] + 1]] == [-np.pi, np.pi]
    assert rows[gap[0] - 1] == rows[gap[0] + 1] == pytest.approx(0.5, abs=0.01)
    np.testing.assert_allclose(
        chart.cut(np.array([[0.1, 0.2], [3.1, -3.1]])), [[0.1, 0.2], [3.1, np.pi], [-3.1, -np.pi]]
    )


def test_the_tube_drawn_is_the_tube_proved(proved):
    """Every chord is inside its slice's intervals, ends of intervals are ends of chords, and the motion is inside."""
    arm, tube = proved.problem.arm, proved.certificate.tube
    intervals = tube_intervals(chart_of(proved), arm, tube)
    for part, found in zip(tube, intervals, strict=True):
        ends = np.stack([arm.u_of(part.a)[:, 0], arm.u_of(part.b)[:, 0]], axis=1)  # the elbow is positive throughout
        inside = (found[:, None, 0] <= ends.min(axis=1) + 1e-9) & (ends.max(axis=1) <= found[:, None, 1] + 1e-9)
        assert inside.any(axis=0).all()
        assert np.isin(found.round(9), ends.round(9)).all()
        u = proved.u(np.array([part.r]))[0, 0]
        assert ((found[:, 0] - 1e-3 <= u) & (u <= found[:, 1] + 1e-3)).any()
    with figure() as (_, (axes,)):
        draw_tube(axes, proved)
        drawn = np.vstack([path.vertices for path in axes.collections[0].get_paths()])
    for part, found in zip(tube, intervals, strict=True):
        u = proved.u(np.array([part.r]))[0, 0]
        shown = drawn[np.abs(drawn[:, 0] - part.r) < 1e-12, 1]
        assert shown.min() == pytest.approx(found.min() - u, abs=1e-9)
        assert shown.max() == pytest.approx(found.max() - u, abs=1e-9)


def test_the_title_is_the_verdict_beginning_with_the_cheapest_rival(proved, seed_plan, case):
    with figure() as (_, (axes,)):
        draw_optimum(axes, proved, {"sinusoid": seed_plan, "another": case.rival})
        title = axes.get_title()
        assert title.startswith(f"cost {seed_plan.cost:.4f} → {proved.cost:.4f},\nproved within 0.")
        names = [text.get_text() for text in axes.get_legend().get_texts()]
        assert names[:3] == ["shortest known", "sinusoid", "another"]
        assert names[3].startswith("room for a better one")
        lines = {line.get_label(): line.get_xydata() for line in axes.lines}
        for label, plan in (("shortest known", proved), ("sinusoid", seed_plan)):
            np.testing.assert_allclose(lines[label][:, 1], plan.u(lines[label][:, 0])[:, 0], atol=1e-9)


@pytest.mark.parametrize("draw", [draw_optimum, draw_tube])
def test_without_a_proof_there_is_nothing_to_draw(draw, seed_plan):
    with figure() as (_, (axes,)), pytest.raises(sm.InvalidInputError, match="no certificate"):
        draw(axes, seed_plan)


def test_a_plan_with_a_proof_shows_it(proved):
    files = plan_figures(proved)
    assert set(files) == {f"{n}.{k}" for n in ("postures", "joints", "motion_in_domain") for k in ("png", "svg")}
    assert files == plan_figures(proved)
    assert b"proved within" in files["motion_in_domain.svg"]


@pytest.mark.parametrize("against", ["cells", "seconds"])
def test_the_gap_drawn_is_that_of_the_rounds(proved, against):
    levels = proved.certificate.levels
    with figure() as (_, (axes,)):
        draw_proof(axes, {"it": proved.certificate}, against)
        work, gap = axes.lines[0].get_data()
        assert axes.get_xscale() == axes.get_yscale() == "log"
        assert axes.get_ylim()[0] <= gap.min() <= gap.max() <= axes.get_ylim()[1]
    known = [level for level in levels if np.isfinite(level.cost)]
    np.testing.assert_allclose(gap, [(level.cost - level.bound) / level.bound for level in known])
    assert len(work) == len(known) > 1
    assert work[-1] == (sum(level.cells for level in levels) if against == "cells" else levels[-1].seconds)


def test_work_is_measured_by_what_is_known(proved):
    with figure() as (_, (axes,)), pytest.raises(sm.InvalidInputError, match="against: is not known"):
        draw_proof(axes, {"it": proved.certificate}, "money")
