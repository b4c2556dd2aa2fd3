"""The seed's planner: its 3R case, its claims about candidates, and what it refuses."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.judgement import Tolerances, judge
from selfmotion.optimizers import INFEASIBLE, violation_of
from selfmotion.planners import Candidates
from selfmotion.profiles import SinusoidProfile
from selfmotion.report import seed_3r


def sinusoid(**changes):
    settings = {"population": 20, "iterations": 100, "bounds": (0, 15), "seed": 1} | changes
    return sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(**settings))


def test_plain_reading_of_the_3r_case():
    """Least F = 5.277515 at f = 0.5385 over 1000 samples."""
    scan = seed_3r.CASE.dense_scan()
    assert scan.fitness == pytest.approx(5.277515, abs=2e-6)
    assert scan.f == pytest.approx(0.5385, abs=1e-3)


def test_canonical_pso_finds_it_on_29_of_30_seeds(seed_problem):
    best = seed_3r.CASE.dense_scan().fitness
    hits = [sm.plan(seed_problem, sinusoid(seed=seed)).cost_sampled - best < 1e-5 for seed in range(30)]
    assert sum(hits) >= 29


def test_the_fitness_is_the_chord_sum_written_out(seed_arm, seed_path):
    """(1a) for 1000 samples, from nothing but forward kinematics and the two-link cosine rule."""
    f, r = 0.7, np.linspace(0, 1, 1000)
    u = 0.3 + 0.4 * np.sin(2 * np.pi * f * r)
    x = seed_path(r)
    w = x - 20 * np.stack([np.cos(u), np.sin(u)], axis=-1)
    d = np.hypot(*w.T)
    theta2 = np.arccos((d**2 - 1800) / 1800)
    theta1 = np.arctan2(w[:, 1], w[:, 0]) - np.arctan2(30 * np.sin(theta2), 30 + 30 * np.cos(theta2))
    q = np.column_stack([theta1, theta2, u - theta1 - theta2])
    expected = np.sqrt(np.diff(q, axis=0) ** 2 + np.diff(r)[:, None] ** 2).sum()
    assert seed_3r.CASE.fitness(f)[0] == pytest.approx(expected, abs=1e-11)


def test_same_seed_same_bits(seed_problem):
    first, again = (sm.plan(seed_problem, sinusoid(seed=5)) for _ in range(2))
    assert first.parameters == again.parameters
    assert (first.cost, first.cost_sampled) == (again.cost, again.cost_sampled)
    r = np.linspace(0, 1, 77)
    np.testing.assert_array_equal(first(r), again(r))
    assert sm.plan(seed_problem, sinusoid(seed=5).with_seed(6)).parameters != first.parameters


def test_candidates_outside_are_ranked_by_how_far_they_leave():
    problem = seed_3r.problem()
    profile = SinusoidProfile([0.3], [1.6])
    values = Candidates(problem, profile, 0)(np.array([[0.02], [0.2], [0.25], [0.5]]))
    assert values[0] < INFEASIBLE
    short = [violation_of(value) for value in values[1:]]
    assert (values[1:] > INFEASIBLE).all()
    # How far |w| overshoots l1 + l2, in parts of the reach, by dense sampling of the geometry.
    r = np.linspace(0, 1, 1000)
    for f, violation in zip((0.2, 0.25, 0.5), short, strict=True):
        u = 0.3 + 1.6 * np.sin(2 * np.pi * f * r)
        w = problem.path(r) - 20 * np.stack([np.cos(u), np.sin(u)], axis=-1)
        assert violation == pytest.approx((np.hypot(*w.T).max() - 60) / 80, rel=1e-9)


def test_the_negative_elbow_is_infeasible_under_the_seed_s_limits(seed_arm, seed_path):
    problem = sm.Problem(seed_arm, seed_path, elbow="negative")
    with pytest.raises(sm.InvalidInputError, match=r"no posture is feasible|outside the angle domain"):
        sm.plan(problem, sinusoid())


def test_both_elbows_are_searched_when_both_may_be_used(seed_path):
    arm = sm.PlanarArm([30, 30, 20])
    free = sm.plan(sm.Problem(arm, seed_path), sinusoid())
    costs = {elbow: sm.plan(sm.Problem(arm, seed_path, elbow=elbow), sinusoid()).cost for elbow in arm.branches}
    assert free.evaluations == 4000
    assert free.cost == min(costs.values())
    assert free.parameters["elbow"] == min(costs, key=costs.get)


def test_two_redundant_degrees():
    arm = sm.PlanarArm([3, 3, 2, 2], [None, (0.0, 3.0), None, (-2.0, 2.0)])
    problem = sm.Problem(arm, sm.Circle([4, 2], 1.5), samples=200, weights=[1, 2, 1, 1])
    optimizer = sm.PSO(20, 40, [(0, 2), (0, 3)], seed=2)
    plan = sm.plan(problem, sm.Sinusoid([0.4, 0.9], amplitude=[0.3, 0.3], optimizer=optimizer))
    assert plan.verification.holds
    assert set(plan.parameters) >= {"f1", "f2"}
    np.testing.assert_allclose(plan.u(0.0), [0.4, 0.9])
    np.testing.assert_allclose(arm.forward(plan([0.0, 0.31, 1.0])), problem.path([0.0, 0.31, 1.0]), atol=1e-13)


def test_a_4r_with_fixed_direction():
    arm = sm.PlanarArm([7, 7, 4, 1.5], direction=-np.pi / 3)
    problem = sm.Problem(arm, sm.Circle([6, 4], 4), samples=400)
    planner = sm.Sinusoid([0.5], amplitude=[0.5], optimizer=sm.PSO(20, 30, (0, 4), seed=0))
    plan = sm.plan(problem, planner)
    q = plan(np.linspace(0, 1, 50))
    np.testing.assert_allclose(np.sin((q.sum(axis=1) + np.pi / 3) / 2), 0, atol=1e-14)


def test_turns_are_kept_inside_limits_that_span_more_than_one(seed_path):
    """Limits [2π − 2, 2π + 5] of θ1: the motion must come out one turn up."""
    arm = sm.PlanarArm([30, 30, 20], [(2 * np.pi - 2, 2 * np.pi + 5), (0, np.pi), None])
    plan = sm.plan(sm.Problem(arm, seed_path), sinusoid(iterations=10))
    assert (plan(np.linspace(0, 1, 100))[:, 0] > np.pi).all()
    assert plan.verification.min_limit_margin > 0


def test_a_start_given_by_joints_fixes_turns_and_elbow(seed_path):
    arm = sm.PlanarArm([30, 30, 20])
    q = arm.solve(seed_path(0.0), [0.3], 1)[0] + [2 * np.pi, 0, -2 * np.pi]
    plan = sm.plan(sm.Problem(arm, seed_path, start={"q": q}), sm.Sinusoid(amplitude=[0.2], optimizer=sm.PSO(10, 10)))
    np.testing.assert_allclose(plan(0.0), q, atol=1e-12)
    assert plan.parameters["elbow"] == "negative"


def test_proved_infeasible_whichever_planner_is_asked():
    arm = sm.PlanarArm([1, 1, 1], [(-2, 2)] * 3)
    with pytest.raises(sm.InfeasibleError) as caught:
        sm.plan(sm.Problem(arm, sm.Line([1.5, -3], [1.5, 3.5])), sinusoid())
    assert [part.cause for part in caught.value.blocked] == ["out of reach"] * 2
    assert caught.value.exit_code == 3


@pytest.mark.parametrize("start", [None, [0.3]])
def test_a_path_that_starts_out_of_reach_is_infeasible_with_a_start_too(start):
    arm = sm.PlanarArm([1, 1, 1], [(-2, 2)] * 3)
    problem = sm.Problem(arm, sm.Line([1.5, -3], [1.5, 0]), start=start)
    with pytest.raises(sm.InfeasibleError):
        sm.plan(problem, sinusoid())


def test_nothing_feasible_says_so_and_by_how_much(seed_problem):
    planner = sm.Sinusoid([0.3], amplitude=[3.0], optimizer=sm.PSO(10, 5, (1, 15), seed=0))
    with pytest.raises(sm.NothingFeasibleError) as caught:
        sm.plan(seed_problem, planner)
    assert caught.value.evaluations == 50
    assert 0 < caught.value.least_violation < 10
    assert "angle domain" in str(caught.value)
    assert caught.value.exit_code == 4


def test_a_motion_that_breaks_between_the_samples_is_passed_over():
    """Seven samples see nothing of a limit that the path crosses between them."""
    arm = sm.PlanarArm([1, 1, 1], [None, (1.45, 3.0), None])
    path = sm.Lissajous([1.9, 0.0], [0.3, 0.3], [0, 6], phase=np.pi / 2)  # at the samples: y = 0
    coarse = sm.Problem(arm, path, samples=7, elbow="positive")
    planner = sm.Sinusoid([0.5], amplitude=[0.05], optimizer=sm.PSO(6, 4, (0, 0.5), seed=0))
    fine = sm.Problem(arm, path, samples=700, elbow="positive")
    candidates = Candidates(coarse, SinusoidProfile([0.5], [0.05]), 0)(np.linspace(0, 0.5, 11)[:, None])
    assert (candidates < INFEASIBLE).all()
    with pytest.raises(sm.NothingFeasibleError, match="between"):
        sm.plan(coarse, planner)
    with pytest.raises(sm.NothingFeasibleError, match="none of 24 candidates"):
        sm.plan(fine, planner)


def test_progress_counts_every_generation(seed_path):
    calls = []
    arm = sm.PlanarArm([30, 30, 20])
    sm.plan(sm.Problem(arm, seed_path), sinusoid(iterations=7), lambda *args: calls.append(args))
    assert [done for done, _, _ in calls] == list(range(1, 15))
    assert {total for _, total, _ in calls} == {14}


REFUSED = {
    "offset outside the domain": (lambda a, p: sm.Problem(a, p), [2.5], "planner.offset"),
    "offset disagrees with start": (lambda a, p: sm.Problem(a, p, start=[0.4]), [0.3], "planner.offset"),
    "offset too long": (lambda a, p: sm.Problem(a, p), [0.3, 0.3], "planner.offset"),
    "no offset, no start": (lambda a, p: sm.Problem(a, p), None, "planner.offset"),
    "end posture": (lambda a, p: sm.Problem(a, p, end=[0.3]), [0.3], "end"),
    "too few samples": (lambda a, p: sm.Problem(a, p, samples=100), [0.3], "samples"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_a_sinusoid_cannot_do_is_refused(seed_arm, seed_path, case):
    make, offset, field = REFUSED[case]
    amplitude = [0.4] * (len(offset) if offset else 1)
    planner = sm.Sinusoid(offset, amplitude=amplitude, optimizer=sm.PSO(4, 2, (0, 15)))
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.plan(make(seed_arm, seed_path), planner)
    assert caught.value.field == field
    assert caught.value.remedy


def test_cyclic_is_refused(seed_arm):
    problem = sm.Problem(seed_arm, sm.Circle([50, 0], 10), cyclic="exact")
    with pytest.raises(sm.InvalidInputError, match="cyclic"):
        sm.plan(problem, sinusoid())


def test_a_start_on_one_elbow_proves_nothing_about_motions_through_a_fold():
    """A motion exists that starts at qa and passes θ2 = 0; the sinusoid cannot follow it, and that is no proof."""
    qa, qb = np.array([0.27, 0.36, 0.37]), np.array([-0.02, -0.75, 0.75])
    joints = qa + (qb - qa) * np.linspace(0, 1, 9)[:, None]
    arm = sm.PlanarArm([1, 1, 0.7], [(-0.05, 0.30), (-0.78, 0.39), (0.34, 0.78)])
    path = sm.Waypoints(arm.forward(joints), "spline")
    planner = sm.Sinusoid(amplitude=[0.05], optimizer=sm.PSO(iterations=2, bounds=(0, 2)))
    with pytest.raises(sm.NothingFeasibleError):
        sm.plan(sm.Problem(arm, path, start={"q": qa}), planner)


@pytest.mark.parametrize("elbow", ["positive", "negative"])
def test_a_start_on_a_fold_may_go_either_way_but_not_the_wrong_one(elbow):
    arm = sm.PlanarArm([1, 1, 1])
    start = np.array([0.3, 0.0, 1.2])
    x = arm.forward(start)
    problem = sm.Problem(arm, sm.Line(x, x * 0.8), start={"q": start}, elbow=elbow)
    planner = sm.Sinusoid(amplitude=[0.05], optimizer=sm.PSO(iterations=5, bounds=(0, 2)))
    plan = sm.plan(problem, planner)
    assert plan.parameters["elbow"] == elbow
    assert np.sign(plan(1.0)[1]) == (1 if elbow == "positive" else -1)
    assert judge(problem, problem.grid, plan(problem.grid), Tolerances(step=3.0, between=1.0)).holds


def test_a_swing_that_no_node_sees_leaves_the_cost_s_error_unknown():
    """The wrist passes the base at 1e-12: θ1 and θ3 turn by π within a step; the chord sum shows it."""
    d, t0, t1 = 1e-12, -0.5002, 0.4998
    path = sm.Bezier([[1 + t0, d + t0 * t0], [1 + (t0 + t1) / 2, d + t0 * t1], [1 + t1, d + t1 * t1]])
    problem = sm.Problem(sm.PlanarArm([1, 1, 1]), path, objective="l1")
    planner = sm.Sinusoid([0.0], amplitude=[1e-200], optimizer=sm.RandomSearch(1, 1, bounds=(0, 1)))
    plan = sm.plan(problem, planner)
    assert plan.cost_error == np.inf or plan.cost + plan.cost_error >= 9.27
    assert plan.summary()["cost_error"] is None or plan.summary()["cost_error"] > 0


def test_a_limit_broken_in_many_places_between_the_samples_is_found():
    path = sm.Lissajous([1.5, 0.4], [0.05, 0.05], [452.2421483892154, 263.2782099003896], 0.3)
    arm = sm.PlanarArm([1, 1, 1], [None, (-3, 2.4952562831616913), None])
    planner = sm.Sinusoid([0.6], amplitude=[1e-200], optimizer=sm.RandomSearch(1, 1, bounds=(0, 1)))
    with pytest.raises(sm.NothingFeasibleError, match="between"):
        sm.plan(sm.Problem(arm, path, elbow="positive"), planner)


def test_samples_must_resolve_the_path_s_corners(seed_arm):
    zigzag = sm.Waypoints([[50 + (k % 2), 0.1 * k] for k in range(60)])
    planner = sinusoid(population=4, iterations=2, bounds=(0, 2))
    with pytest.raises(sm.InvalidInputError, match=r"59 pieces.*at least 236"):
        sm.plan(sm.Problem(seed_arm, zigzag, samples=235), planner)
    assert sm.plan(sm.Problem(seed_arm, zigzag, samples=236), planner).verification.holds
