"""Pictures of an arm in modules: what is drawn is where the arm is."""

import numpy as np
import pytest
from drawings import Case

import selfmotion as sm
from selfmotion.plot import draw_joints, draw_modules, draw_postures, figure


@pytest.fixture(scope="module")
def case():
    return Case()


@pytest.fixture(scope="module")
def six(case):
    return case.modules


def test_an_absolute_joint_is_the_direction_of_its_link(six):
    r = six.problem.rows
    points = six.problem.arm.joint_positions(six(r))
    link = points[:, 4] - points[:, 3]
    with figure() as (_, (axes,)):
        draw_joints(axes, six, range(3, 6), [3])
        fourth, fifth, _ = axes.lines[:3]
        np.testing.assert_allclose(30 * np.cos(fourth.get_ydata()), link[:, 0], atol=1e-9)
        np.testing.assert_allclose(30 * np.sin(fourth.get_ydata()), link[:, 1], atol=1e-9)
        np.testing.assert_array_equal(fifth.get_ydata(), six(r)[:, 4])
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["θ4 absolute", "θ5", "θ6"]


def test_limits_of_a_joint_that_is_drawn_absolute_are_not_shown():
    problem = sm.Problem(sm.PlanarArm([1, 1, 1], [(-1, 1), None, None]), sm.Line([1.5, 0.2], [1.6, -0.2]))
    plan = sm.plan(problem, sm.Sinusoid([-0.5], amplitude=[0.1], optimizer=sm.PSO(iterations=2, bounds=(0, 1))))
    for absolute, texts in (((), 2), ([0], 0)):
        with figure() as (_, (axes,)):
            draw_joints(axes, plan, [0, 1], absolute)
            assert len(axes.texts) == texts


@pytest.mark.parametrize("r", [0.0, 0.3, 1.0])
def test_modules_are_drawn_where_they_are_and_frames_at_their_bases(case, six, r):
    chain = six.problem.arm.joint_positions(six([r]))[0]
    with figure() as (canvas, (axes,)):
        draw_modules(axes, six, [case.base], r)
        lines = {line.get_label(): line.get_xydata() for line in axes.lines}
        np.testing.assert_array_equal(lines["module 1"], chain[:4])
        np.testing.assert_array_equal(lines["module 2"], chain[3:])
        np.testing.assert_allclose(lines["module 2"][0], case.base(r), atol=1e-9)
        np.testing.assert_allclose(lines["path of the tool"][[0, -1]], six.problem.path([0.0, 1.0]), atol=1e-9)
        np.testing.assert_allclose(lines["path of a moving base"][[0, -1]], case.base([0.0, 1.0]), atol=1e-9)
        frames = {text.get_text(): np.array(text.xy) for text in axes.texts if text.get_text()}
        assert set(frames) == {"x", "y", "x′", "y′"}
        for primes, origin in (("", chain[0]), ("′", chain[3])):
            along, up = frames["x" + primes] - origin, frames["y" + primes] - origin
            assert along[0] == pytest.approx(up[1])
            assert along[1] == pytest.approx(0) == up[0]
        canvas.canvas.draw()


def test_the_reach_is_drawn_where_it_can_be_seen(case, six):
    for plan, seen in ((case.plan, True), (six, False)):
        with figure() as (_, (axes,)):
            draw_postures(axes, plan)
            assert ("reach" in axes.get_title()) == seen
