"""Figs 3, 4 and 5: what is drawn is what was computed."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.plot import draw_extreme_postures, draw_posture_interval, draw_sweep, draw_workspace, figure


@pytest.fixture
def free_problem(seed_path):
    return sm.Problem(sm.PlanarArm([30, 30, 20]), seed_path)


def drawn_chains(axes, n=3):
    """The drawn arms: lines of n + 1 points that start at the base."""
    lines = [np.column_stack(line.get_data()) for line in axes.lines]
    return [points for points in lines if points.shape == (n + 1, 2) and not points[0].any()]


def texts(axes):
    return [text.get_text() for text in axes.texts if text.get_text()]


def test_the_circles_of_the_workspace_have_the_radii(seed_path):
    arm = sm.PlanarArm([30, 30, 20, 8], direction=0.7)
    center = 8 * np.array([np.cos(0.7), np.sin(0.7)])
    with figure() as (_, (axes,)):
        draw_workspace(axes, arm, seed_path)
        circles = [np.column_stack(line.get_data()) for line in axes.lines if len(line.get_xdata()) == 721]
        radii = sorted(round(float(np.hypot(*(points - center).T).mean()), 9) for points in circles)
        assert radii == pytest.approx([20, 40, np.sqrt(3200), 80])
        assert axes.patches[0].r == 80
        assert axes.patches[0].width == pytest.approx(80 - np.sqrt(3200))
        assert texts(axes) == ["$R_{max}$ = 80", "$R^*_{min}$ = 56.57", "$ρ_1$ = 40", "$ρ_2$ = $ρ_3$ = 20"]


def test_without_a_nearest_radius_nothing_is_shaded():
    with figure() as (_, (axes,)):
        draw_workspace(axes, sm.PlanarArm([1, 1, 3]))
        assert not axes.patches
        assert "none" in axes.get_title()


@pytest.mark.parametrize("branch", [0, 1])
def test_the_sweep_drawn_is_the_sweep(free_problem, branch):
    arm, sweep = free_problem.arm, sm.angle_domain(free_problem.arm, free_problem.path).sweep(0.3, branch, 9)
    with figure() as (_, (axes,)):
        draw_sweep(axes, free_problem, 0.3, branch, 9)
        np.testing.assert_array_equal(drawn_chains(axes), arm.joint_positions(sweep.q))
        shades = [line.get_color()[0] for line in axes.lines[:9]]
        assert shades == sorted(shades, reverse=True)


def test_extreme_postures_and_their_marks(free_problem, seed_path):
    with figure() as (_, (axes,)):
        draw_extreme_postures(axes, free_problem, 0.0)
        q = sm.angle_domain(free_problem.arm, seed_path).sweep(0.0, 0, 2).q
        np.testing.assert_array_equal(drawn_chains(axes), free_problem.arm.joint_positions(q))
        assert texts(axes).count("$Δ_1$") == texts(axes).count("$Δ_3$") == 2
    limited = sm.Problem(sm.PlanarArm([30, 30, 20], [None, (0.3, 1.5), None]), seed_path)
    with figure() as (_, (axes,)):
        draw_extreme_postures(axes, limited, 0.5)
        assert not {"$Δ_1$", "$Δ_3$"} & set(texts(axes))  # they belong to stretched postures


def test_a_point_without_extremes_is_refused(seed_path):
    circle = sm.Problem(sm.PlanarArm([1, 1, 0.5]), sm.Line([1.0, 0.1], [1.0, 0.5]))
    with figure() as (_, (axes,)), pytest.raises(sm.InvalidInputError, match="no minimum and maximum"):
        draw_extreme_postures(axes, circle, 0.5)
    beyond = sm.Problem(sm.PlanarArm([1, 1, 0.5]), sm.Line([2, 0], [4, 0]))
    with figure() as (_, (axes,)), pytest.raises(sm.InvalidInputError, match="nothing is feasible"):
        draw_extreme_postures(axes, beyond, 1.0)


def test_the_curves_of_both_elbows_meet_at_the_folds(free_problem):
    with figure() as (_, (axes,)):
        draw_posture_interval(axes, free_problem, 0.0)
        curves = [np.column_stack(line.get_data()) for line in axes.lines if len(line.get_xdata()) > 100]
        assert len(curves) == 6
        for joint in range(3):
            np.testing.assert_allclose(curves[joint][[0, -1]], curves[joint + 3][[0, -1]], atol=1e-9)
            assert np.abs(np.diff(curves[joint][:, 1])).max() < 0.1
