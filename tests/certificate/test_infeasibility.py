"""Why there is no motion: where it must break, what the nearest limit would have to give, and what is undecided."""

import time

import numpy as np
import pytest
from brute_force import brute_force_connected, limit_cut_problem

import selfmotion as sm
from selfmotion.certificate.infeasibility import explain
from selfmotion.certificate.joined import leads_on
from selfmotion.certificate.needs import widened
from selfmotion.errors import UndecidedError
from selfmotion.scene import CircleObstacle

STRIP = sm.Line([1.5, -2.5], [1.5, 2.5])
CRITICAL = 1.5202645672


def strip_problem(limit, **options):
    return sm.Problem(sm.PlanarArm([1, 1, 1], [(-limit, limit)] * 3), STRIP, **options)


def explained(problem, seconds=20.0):
    return explain(problem, time.perf_counter() + seconds)


@pytest.fixture(scope="module")
def strip():
    return explained(strip_problem(1.45))


def test_the_strip_is_blocked_near_0_41(strip):
    (part,) = strip.blocked
    assert strip.status == "infeasible"
    assert part.cause == "joint limits"
    assert part.r[1] == pytest.approx((0.41 + 2.5) / 5, abs=0.003)
    assert part.r[0] == pytest.approx(1 - part.r[1], abs=1e-6)
    assert "upper limit of θ1" in part.limits
    assert explained(strip_problem(2.2)) is None


def test_each_part_at_the_start_is_proved_to_end_where_the_structure_says(strip):
    (death,) = strip.proof.deaths
    assert death.r[0] == strip.blocked[0].r[1]
    assert death.r[0] < death.r[1] <= death.r[0] + 1e-3
    assert strip.proof.proved_within[0] <= strip.blocked[0].r[0]
    assert strip.proof.proved_within[1] >= strip.blocked[0].r[1]
    assert strip.proof.resolution > 0
    assert strip.proof.boxes > 0


def test_what_a_limit_needs_is_what_it_needs(strip):
    problem, need = strip_problem(1.45), strip.needs[0]
    assert 0 < need.by < 0.2
    enough, too_little = (widened(problem, need.joint - 1, need.side, part * need.by) for part in (1.05, 0.95))
    assert brute_force_connected(enough, 800, 1440)[0]
    assert not brute_force_connected(too_little, 800, 1440)[0]
    assert explained(too_little).status == "infeasible"
    assert explained(enough) is None
    assert 0 < need.r < 1
    # No other limit gets by with less.
    for joint in range(3):
        for side in ("lower", "upper"):
            assert not leads_on(widened(problem, joint, side, 0.98 * need.by))


def test_the_message_says_where_what_and_by_how_much(strip):
    text = str(strip)
    assert "\n" not in text
    for part in ("0.582", "upper limit of θ1", "θ1 needs 0.118 rad more"):
        assert part in text


@pytest.mark.parametrize("by", ["q", "u and q"])
def test_ends_that_nothing_joins_are_infeasible(by):
    """With the tool nearer than the length of a link each elbow is a closed curve of self-motion by itself."""
    arm, path = sm.PlanarArm([1, 1, 1]), sm.Line([0.5, 0.0], [0.6, 0.2])
    for first in (0, 1):
        for last in (0, 1):
            start, end = (arm.solve(path(r), [2.0], branch)[0] for r, branch in ((0.0, first), (1.0, last)))
            elbow = "any" if by == "q" else ("positive", "negative")[first]
            if by != "q" and first != last:
                continue
            given = {"q": start} if by == "q" else {"u": [2.0]}
            problem = sm.Problem(arm, path, start=given, end={"q": end}, elbow=elbow)
            error = explained(problem, 4.0)
            assert leads_on(problem) == (first == last)
            if first == last:
                assert error is None
            else:
                assert error.status == "infeasible"
                assert error.blocked[0].cause == "start and end"
                assert "another start or end" in str(error)


def test_a_path_out_of_reach_is_still_said_to_be():
    arm = sm.PlanarArm([1, 1, 1], [(-2, 2)] * 3)
    error = explained(sm.Problem(arm, sm.Line([1.5, -3.0], [1.5, 3.5])))
    assert {part.cause for part in error.blocked} == {"out of reach"}


def test_a_tangency_is_undecided_and_says_so():
    error = explained(strip_problem(CRITICAL - 2e-11), 3.0)
    assert isinstance(error, UndecidedError)
    assert error.why == "tangency"
    assert error.exit_code == 4


def test_too_little_time_is_undecided_and_says_so():
    error = explained(strip_problem(CRITICAL - 1e-4), 1e-3)
    assert isinstance(error, UndecidedError)
    assert error.why == "budget"


@pytest.mark.parametrize("seed", [1, 7, 19, 41, 201, 275])
def test_limit_cut_problems_are_explained(seed):
    problem = limit_cut_problem(seed)
    error = explained(problem)
    assert error.status == "infeasible"
    assert error.proof.deaths
    for need in error.needs[:1]:
        assert leads_on(widened(problem, need.joint - 1, need.side, 1.01 * need.by))
        assert not leads_on(widened(problem, need.joint - 1, need.side, 0.99 * need.by))


def test_a_path_that_leaves_the_reach_between_two_samples_is_said_to():
    """The tip of an ellipse is 3e-4 beyond the reach for a moment, which 24 samples miss."""
    arm = sm.PlanarArm([1.0, 1.0, 1.0])
    path = sm.Ellipse([2.0, 0.0], [1.0003, 0.9], start_angle=-2.0, sweep=3.0)
    disc = sm.CircleObstacle((-2.0, 0.0), 0.1)
    problem = sm.Problem(arm, path, obstacles=[disc], samples=24)
    with pytest.raises(sm.InfeasibleError) as error:
        sm.plan(problem, sm.Global(gap=1e-2, time_limit=30.0))
    (blocked,) = error.value.blocked
    assert blocked.cause == "out of reach"
    assert 0.0 < blocked.short_by <= 3.001e-4
    assert np.linalg.norm(path(np.array(blocked.r)), axis=1).min() >= 3.0 - 1e-9


def test_limits_that_leave_no_way_are_named_whatever_obstacles_stand_around():
    """What limits need is told as without obstacles, and the pieces of the reconfigured motion keep clear of them."""
    line, arm = sm.Line([1.5, -2.5], [1.5, 2.5]), sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3)
    problem = sm.Problem(arm, line, obstacles=[CircleObstacle((2.3, 0.0), 0.3)])
    assert not leads_on(problem)
    with pytest.raises(sm.InfeasibleError) as caught:
        sm.plan(problem, sm.Global(time_limit=30.0))
    with pytest.raises(sm.InfeasibleError) as bare:
        sm.plan(sm.Problem(arm, line), sm.Global(time_limit=30.0))
    assert caught.value.needs == bare.value.needs
    assert str(caught.value) == str(bare.value)
    assert all("clearance" in plan.verification.margins for plan in caught.value.reconfigured.plans)


def test_an_obstacle_that_leaves_nothing_for_a_moment_is_what_is_named():
    """A disc smaller than a step of the samples, on the path of an arm without any limit."""
    path, disc = sm.Line([0.8, 0.8], [1.8, 0.8]), CircleObstacle((1.26975, 0.8), 0.002)
    with pytest.raises(sm.InfeasibleError) as error:
        sm.plan(sm.Problem(sm.PlanarArm([1, 1, 1]), path, obstacles=[disc], samples=24), sm.Global(time_limit=60.0))
    (blocked,) = error.value.blocked
    assert blocked.cause == "obstacles"
    assert "link 3 against obstacle 1" in blocked.limits
    assert blocked.r[0] < 0.46975 < blocked.r[1]
