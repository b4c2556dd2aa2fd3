"""What a proof is asked of a path's ends, and what the nearest limit needs, where both are known in closed form."""

import time

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.certificate.joined import earliest, ends, leads_on, parts_at_start, sheets_at_end, with_arm
from selfmotion.certificate.needs import needs, needs_of_pose, widened

TAU = 2 * np.pi


def bent_problem(least, radius=2.9, low=True):
    """Unit links whose elbow must stay bent by `least`: the tool gets as far as 1 + 2 cos(least/2)."""
    limit = (least, 3.0) if low else (-3.0, -least)
    return sm.Problem(sm.PlanarArm([1, 1, 1], [None, limit, None]), sm.Line([2.0, 0.0], [radius, 0.0]))


def wanted(least, radius):
    return least - 2 * np.arccos((radius - 1) / 2)


@pytest.mark.parametrize("low", [True, False])
@pytest.mark.parametrize("least", [1.1, 1.3])
def test_what_a_pose_needs_is_what_bends_the_elbow_too_much(least, low):
    problem = bent_problem(least, low=low)
    (part,) = problem.blocked
    (need,) = needs_of_pose(problem)
    assert (need.joint, need.side, need.unit) == (2, "lower" if low else "upper", "rad")
    assert need.r == 0.5 * sum(part.r)
    # That less does not do is proved, by boxes: what is said may be a little less than what does.
    assert 0.95 <= need.by / wanted(least, 2.0 + 0.9 * need.r) <= 1.001


def test_what_no_cover_says_to_be_blocked_needs_nothing():
    """By so little that the boxes do not see it: to say that a limit needs 0 rad more would help nobody."""
    assert len(bent_problem(0.7).blocked) == 1
    assert needs_of_pose(bent_problem(0.7)) == []


def test_what_a_motion_needs_is_what_its_worst_place_does():
    problem = bent_problem(0.7)
    (need,) = needs(problem, ())
    assert (need.joint, need.side) == (2, "lower")
    assert need.by == pytest.approx(wanted(0.7, 2.9), rel=2e-3)
    assert not leads_on(problem)
    assert leads_on(widened(problem, 1, "lower", need.by))
    assert not leads_on(widened(problem, 1, "lower", 0.99 * need.by))
    assert not leads_on(widened(problem, 1, "upper", 1.0))


def test_no_limit_is_asked_to_give_more_than_a_radian():
    arm = sm.PlanarArm([1, 1, 1], [None, (2.2, 3.0), None])
    for (near, far), enough in (((2.7, 2.9), False), ((2.4, 2.45), True)):
        problem = sm.Problem(arm, sm.Line([near, 0.0], [far, 0.0]))
        for found in (needs_of_pose(problem), needs(problem, ())):
            assert bool(found) == enough


def test_what_is_found_by_the_deadline_is_said():
    assert needs_of_pose(bent_problem(1.1), time.perf_counter() - 1.0) == []
    assert needs(bent_problem(0.7), (), time.perf_counter() - 1.0) == []


def test_one_limit_of_one_joint_gets_wider():
    problem = sm.Problem(sm.PlanarArm([1, 1, 1], [(-1, 1)] * 3), sm.Line([1.5, 0], [1.6, 0]))
    for joint in range(3):
        for side, by in (("lower", (0.25, 0.0)), ("upper", (0.0, 0.25))):
            limits = widened(problem, joint, side, 0.25).arm.limits
            change = np.arange(3) == joint
            np.testing.assert_array_equal(limits.lower, -1 - by[0] * change)
            np.testing.assert_array_equal(limits.upper, 1 + by[1] * change)
    assert problem.arm.limits.lower[0] == -1


def test_another_arm_has_another_structure():
    tight, wide = sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.PlanarArm([1, 1, 1], [(-2.2, 2.2)] * 3)
    problem = sm.Problem(tight, sm.Line([1.5, -2.5], [1.5, 2.5]))
    assert not leads_on(problem)
    assert leads_on(with_arm(problem, wide))
    assert not leads_on(problem)
    assert problem.arm is tight


def near_problem(**options):
    """With the tool nearer than the length of a link each elbow is a closed curve of self-motion by itself."""
    return sm.Problem(sm.PlanarArm([1, 1, 1], options.pop("limits", None)), sm.Line([0.5, 0.0], [0.6, 0.2]), **options)


def test_where_nothing_is_asked_any_posture_is_an_end():
    assert ends(near_problem(), "start").q is None
    assert ends(near_problem(start=[1.0]), "end").q is None


def test_a_posture_asked_for_is_an_end_up_to_rounding_and_turns_of_free_joints():
    arm = sm.PlanarArm([1, 1, 1])
    q = arm.solve(np.array([0.6, 0.2]), [2.0], 0)[0]
    found = ends(near_problem(end={"q": q}, limits=[None, (-3.2, 3.2), None]), "end")
    np.testing.assert_array_equal(found.q, q[None])
    assert 0 < found.tolerance <= 1e-4
    np.testing.assert_array_equal(found.modulo, [True, False, True])


def test_a_direction_asked_for_is_the_postures_of_all_elbows_that_may_be_used():
    arm = sm.PlanarArm([1, 1, 1])
    for elbow, branches in (("any", (0, 1)), ("positive", (0,)), ("negative", (1,))):
        found = ends(near_problem(start=[2.0], elbow=elbow), "start")
        np.testing.assert_array_equal(
            found.q, [arm.solve(np.array([0.5, 0.0]), [2.0], branch)[0] for branch in branches]
        )
        assert 0 < found.tolerance < 0.01
        assert found.modulo.all()


def test_where_a_joint_is_free_a_direction_says_nothing():
    """With the wrist on the base the other joints are anyone's guess."""
    problem = sm.Problem(sm.PlanarArm([1, 1, 1]), sm.Line([1.0, 0.0], [1.5, 0.5]), start=[0.0])
    assert ends(problem, "start").q is None


def test_sheets_at_an_end_are_those_that_are_asked_for():
    """Both elbows closed curves: two sheets from end to end, and which is which is told by postures."""
    arm, r = sm.PlanarArm([1, 1, 1]), {"start": 0.0, "end": 1.0}
    for name, at in r.items():
        every = sheets_at_end(near_problem(), name)
        assert len(every) == 2
        mine = [sheets_at_end(near_problem(**{name: [2.0]}, elbow=elbow), name) for elbow in ("positive", "negative")]
        assert sheets_at_end(near_problem(**{name: [2.0]}), name) == every
        assert all(len(part) == 1 for part in mine)
        q = arm.solve(near_problem().path(at), [2.0], 1)[0]
        (one,) = sheets_at_end(near_problem(**{name: {"q": q}}), name)
        assert one in every
    assert [sheet for sheet, _ in parts_at_start(near_problem())] == sheets_at_end(near_problem(), "start")
    for _, q in parts_at_start(near_problem()):
        assert arm.task_error(q, np.array([0.5, 0.0])) < 1e-12


def test_the_earliest_place_is_where_what_leads_on_begins():
    """Of the strip that is blocked: it is its own mirror image."""
    problem = sm.Problem(sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5]))
    first = earliest(problem, sheets_at_end(problem, "end"))
    last, _ = problem.structure.farthest(sheets_at_end(problem, "start"))
    assert first == pytest.approx(1 - last, abs=1e-9)
    assert first == pytest.approx(1 - 0.58227, abs=1e-4)
    assert earliest(problem, []) == 1.0
