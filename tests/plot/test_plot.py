"""Pictures: their data is the computed data, and the same data gives the same bytes."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion import plot
from selfmotion.domain.strips import strips
from selfmotion.exchange import read_drawing
from selfmotion.plot import draw_domain, draw_evolution, draw_joints, draw_postures, figure, plan_figures
from selfmotion.plot.window import Window


def test_the_same_plan_gives_the_same_bytes(seed_plan):
    first, again = plan_figures(seed_plan), plan_figures(seed_plan)
    assert first == again
    assert set(first) == {f"{n}.{k}" for n in ("postures", "joints", "motion_in_domain") for k in ("png", "svg")}
    assert all(first[name].startswith(b"\x89PNG") for name in first if name.endswith("png"))


@pytest.fixture(scope="module")
def eventful():
    arm = sm.PlanarArm([7, 7, 4, 1.5], [(-2, 2), None, (-1.6, 1.6), (-1, 2.5)], direction=-np.pi / 3)
    return sm.angle_domain(arm, sm.Circle([6, 4], 4))


def filled(axes):
    """The areas drawn, as polygons (k, 2)."""
    return [path.vertices for area in axes.collections for path in area.get_paths()]


def test_the_region_drawn_is_the_domain(seed_arm, seed_path):
    domain = sm.angle_domain(seed_arm, seed_path)
    with figure() as (_, (axes,)):
        draw_domain(axes, domain, 0)
        (polygon,) = filled(axes)
        for r in polygon[::37, 0]:
            u = polygon[polygon[:, 0] == r, 1]
            np.testing.assert_allclose(domain(r, 0).intervals, [[u.min(), u.max()]], atol=1e-9)
        assert len(axes.lines) == 2


@pytest.mark.parametrize("causes", [False, True])
@pytest.mark.parametrize("branch", [0, 1])
def test_area_of_a_region_that_splits_and_merges_is_that_of_its_intervals(eventful, branch, causes):
    with figure() as (_, (axes,)):
        draw_domain(axes, eventful, branch, causes=causes)
        drawn = 0.0
        for x, y in (polygon.T for polygon in filled(axes)):
            drawn += abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2
    r = np.linspace(0, 1, 2001)
    assert drawn == pytest.approx(np.trapezoid([eventful(at, branch).measure for at in r], r), rel=2e-3)


def test_a_domain_across_the_seam_is_drawn_in_one_piece():
    arm = sm.PlanarArm([30, 30, 20])
    domain = sm.angle_domain(arm, sm.Line([-60, 10], [-60, -10]))  # ψ passes ±π
    window = Window.around(strips(domain.structure, 0))
    u = window.near(np.full(5, np.pi - 0.1))
    assert abs(u[0] - window.center) < np.pi
    with figure() as (_, (axes,)):
        draw_domain(axes, domain, 0)
        assert len(filled(axes)) == 1
        assert all(np.isfinite(line.get_ydata()).all() for line in axes.lines)


def test_what_crosses_the_seam_is_drawn_on_both_of_its_sides():
    """The arm turns its whole domain once around while the path goes once around the base."""
    domain = sm.angle_domain(sm.PlanarArm([30, 30, 20]), sm.Circle([0, 0], 60))
    with figure() as (_, (axes,)):
        draw_domain(axes, domain, 0)
        assert len(filled(axes)) > 1
        low, high = np.min([part[:, 1].min() for part in filled(axes)]), np.max([p[:, 1].max() for p in filled(axes)])
        assert high - low == pytest.approx(2 * np.pi)
        for line in axes.lines:
            r, u = line.get_data()
            assert np.nanmin(u) >= low - 1e-9
            assert np.nanmax(u) <= high + 1e-9
            gap = np.flatnonzero(np.isnan(u))
            assert len(gap) == 1
            np.testing.assert_allclose(u[gap - 1] - u[gap + 1], 2 * np.pi)
            ends = [domain(float(at), 0).intervals.ravel() for at in r[np.isfinite(r)][::29]]
            off = [
                np.abs(np.exp(1j * e) - np.exp(1j * at)).min()
                for e, at in zip(ends, u[np.isfinite(u)][::29], strict=True)
            ]
            assert max(off) < 1e-9


def test_axes_show_what_was_computed(seed_plan):
    with figure(columns=2, width=7) as (canvas, (left, right)):
        draw_joints(left, seed_plan)
        np.testing.assert_array_equal(left.lines[0].get_ydata(), seed_plan(seed_plan.problem.rows)[:, 0])
        draw_evolution(right, {"PSO": seed_plan.history[0].best})
        np.testing.assert_array_equal(right.lines[0].get_ydata(), seed_plan.history[0].best)
        canvas.canvas.draw()


def test_limits_of_joints_are_in_the_picture_or_named_below_it():
    """A motion far from its limits used to look as if it had none."""
    arm = sm.PlanarArm([1, 1, 1], [(-2.9, 2.9), None, (-60, 180)])
    plan = sm.plan(
        sm.Problem(arm, sm.Line([2.0, 0.1], [2.1, -0.1]), start=[0.4], elbow="negative"), sm.Refine(starts=1)
    )
    with figure() as (_, (axes,)):
        draw_joints(axes, plan)
        low, high = axes.get_ylim()
        assert -3.6 < low < -2.9 < 2.9 < high < 3.6
        assert [text.get_text() for text in axes.texts] == ["limit θ1", "limit θ1"]
        assert axes.get_xlabel().endswith("not shown: limits of θ3")


def test_a_space_curve_says_that_its_height_is_not_shown_and_its_arrow_is_clear_of_its_start(tmp_path):
    angle = np.linspace(0, 5, 60)
    rows = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
    np.save(tmp_path / "helix.npy", rows)
    with figure() as (_, (axes,)):
        plot.draw_drawing(axes, read_drawing(tmp_path / "helix.npy"))
        assert "z, from 0 to 0.5 m, is not shown" in axes.get_xlabel()
        (arrow,) = [text for text in axes.texts if text.arrow_patch is not None]
        assert np.hypot(*(np.array(arrow.xy) - rows[0, :2])) > 0.15


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
        draw_domain(axes, domain, 0, causes=True)
        assert not axes.lines
        assert axes.get_legend() is None
        assert np.ptp(filled(axes)[0][:, 1]) == pytest.approx(2 * np.pi)


def test_a_joint_that_is_locked_leaves_a_curve():
    domain = sm.angle_domain(sm.PlanarArm([30, 30, 20], [None, (1.0, 1.0), None]), sm.Line([50, -10], [60, 10]))
    with figure() as (_, (axes,)):
        draw_domain(axes, domain, 0, causes=True)
        assert "single postures only" in axes.get_title()
        for line in axes.lines:
            r, u = line.get_data()
            for at, value in zip(r[::16], u[::16], strict=True):
                assert domain(float(at), 0).contains(value, 1e-9)


@pytest.mark.parametrize("branch", [0, 1])
def test_each_boundary_has_the_look_and_the_name_of_its_constraint(eventful, branch):
    arm = eventful.self_motion
    with figure() as (_, (axes,)):
        draw_domain(axes, eventful, branch, causes=True)
        by_look, looks = {}, {}
        for line in axes.lines:
            if line.get_linestyle() != "None":
                look = line.get_color(), str(line._unscaled_dash_pattern)
                by_look.setdefault(look, []).append(np.column_stack(line.get_data()))
                if not line.get_label().startswith("_"):
                    looks[look] = line.get_label()
        assert set(by_look) == set(looks)
        assert len(set(looks.values())) == len(looks)
        limits = {
            f"θ{j + 1} {side} limit": (j, value)
            for side, bounds in (("lower", arm.limits.lower), ("upper", arm.limits.upper))
            for j, value in enumerate(bounds)
        }
        for look, name in looks.items():
            joint, value = limits[name]
            points = np.vstack(by_look[look])
            for r, u in points[np.isfinite(points).all(axis=1)][3::20]:
                q, _ = arm.solve(arm.pose(eventful.path(np.array([r]))), [[u]], branch)
                assert abs(np.exp(1j * q[0, 0, joint]) - np.exp(1j * value)) < 1e-5, (name, r, u)


@pytest.mark.parametrize("branch", [0, 1])
def test_each_event_has_its_mark(eventful, branch):
    words = {"opens": "interval opens", "closes": "interval closes", "splits": "interval splits"}
    words |= {"merges": "intervals merge"}
    expected = {}
    for event in eventful.structure.events:
        if event.branch == branch and event.kind in words:
            expected.setdefault(words[event.kind], []).append((event.r, event.u))
    with figure() as (_, (axes,)):
        draw_domain(axes, eventful, branch, causes=True)
        marks = {
            line.get_label(): np.column_stack(line.get_data()) for line in axes.lines if line.get_linestyle() == "None"
        }
        named = [text.get_text() for text in axes.get_legend().get_texts()]
        assert set(marks) <= set(named)
        assert len(named) == len(set(named))
    components = {"component appears", "component dies"}
    assert set(marks) - components == set(expected)
    assert components <= set(marks)
    for name, places in expected.items():
        np.testing.assert_allclose(np.exp(1j * marks[name]), np.exp(1j * np.array(places)), atol=1e-12)
