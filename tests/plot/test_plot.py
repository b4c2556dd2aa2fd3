"""Pictures: their data is the computed data, and the same data gives the same bytes."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.plot import draw_domain, draw_evolution, draw_joints, draw_postures, figure, plan_figures
from selfmotion.plot.domain import DomainOutline


def test_the_same_plan_gives_the_same_bytes(seed_plan):
    first, again = plan_figures(seed_plan), plan_figures(seed_plan)
    assert first == again
    assert set(first) == {f"{n}.{k}" for n in ("postures", "joints", "motion_in_domain") for k in ("png", "svg")}
    assert all(first[name].startswith(b"\x89PNG") for name in first if name.endswith("png"))


def test_the_region_drawn_is_the_domain(seed_arm, seed_path):
    domain = sm.angle_domain(seed_arm, seed_path)
    strips = DomainOutline(domain, 0).strips()
    assert len(strips) == 1
    for r, low, high in strips[0].rows[::100]:
        np.testing.assert_allclose(domain(r, 0).intervals, [[low, high]], atol=1e-12)


def test_area_of_a_region_that_splits_and_merges_is_that_of_its_intervals():
    arm = sm.PlanarArm([7, 7, 4, 1.5], [(-2, 2), None, (-1.6, 1.6), (-1, 2.5)], direction=-np.pi / 3)
    domain = sm.angle_domain(arm, sm.Circle([6, 4], 4))
    for branch in (0, 1):
        outline = DomainOutline(domain, branch, 2001)
        assert any(not strip.low_edge for strip in outline.strips()) == (branch == 1)
        drawn = sum(
            np.trapezoid(strip.rows[:, 2] - strip.rows[:, 1], strip.rows[:, 0])
            for strip in outline.strips()
            if len(strip.rows) > 1
        )
        widths = [domain(r, branch).measure for r in outline.r]
        assert drawn == pytest.approx(np.trapezoid(widths, outline.r), rel=5e-3)


def test_a_domain_across_the_seam_is_drawn_in_one_piece():
    arm = sm.PlanarArm([30, 30, 20])
    domain = sm.angle_domain(arm, sm.Line([-60, 10], [-60, -10]))  # ψ passes ±π
    outline = DomainOutline(domain, 0)
    assert len(outline.strips()) == 1
    u = outline.near(np.full(5, np.pi - 0.1))
    assert abs(u[0] - outline.center) < np.pi


def test_axes_show_what_was_computed(seed_plan):
    with figure(columns=2, width=7) as (canvas, (left, right)):
        draw_joints(left, seed_plan)
        np.testing.assert_array_equal(left.lines[0].get_ydata(), seed_plan(seed_plan.problem.rows)[:, 0])
        draw_evolution(right, {"PSO": seed_plan.history[0].best})
        np.testing.assert_array_equal(right.lines[0].get_ydata(), seed_plan.history[0].best)
        canvas.canvas.draw()


def test_the_whole_arm_is_inside_the_picture(seed_plan):
    with figure() as (canvas, (axes,)):
        draw_postures(axes, seed_plan)
        canvas.canvas.draw()
        points = seed_plan.problem.arm.joint_positions(seed_plan(np.linspace(0, 1, 14))).reshape(-1, 2)
        (x0, x1), (y0, y1) = axes.get_xlim(), axes.get_ylim()
        assert (points[:, 0] > x0).all()
        assert (points[:, 0] < x1).all()
        assert (points[:, 1] > y0).all()
        assert (points[:, 1] < y1).all()
        assert axes.get_aspect() == 1.0


def test_an_empty_domain_is_an_empty_picture(seed_arm):
    domain = sm.angle_domain(seed_arm, sm.Line([90, 0], [200, 0]))
    with figure() as (_, (axes,)):
        draw_domain(axes, domain, 0)
        assert not axes.collections
        assert all(len(line.get_xdata()) == 0 for line in axes.lines)


def test_the_seam_of_the_window_is_no_boundary():
    """Without limits and inside the hole-free workspace every direction is feasible: no edge may be drawn."""
    domain = sm.angle_domain(sm.PlanarArm([1, 1, 0.5]), sm.Line([1.0, 0.1], [1.0, 0.5]))
    assert domain(0.5, 0).is_full
    with figure() as (_, (axes,)):
        draw_domain(axes, domain, 0)
        assert all(np.isnan(line.get_ydata()).all() for line in axes.lines if len(line.get_ydata()))


def test_where_a_region_opens_and_closes_it_is_closed():
    arm = sm.PlanarArm([7, 7, 4, 1.5], [(-2, 2), None, (-1.6, 1.6), (-1, 2.5)], direction=-np.pi / 3)
    outline = DomainOutline(sm.angle_domain(arm, sm.Circle([6, 4], 4)), 1, 801)
    fronts = outline.fronts()
    assert fronts
    for r, low, high in fronts:
        k = int(np.argmin(np.abs(outline.r - r)))
        ends = outline.pieces[k].ravel()
        assert np.abs(ends - low).min() < 1e-12
        assert np.abs(ends - high).min() < 1e-12
