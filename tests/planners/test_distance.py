"""How far a sampled motion is from the best possible one: honest with few rows, silent where nothing is known."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.certificate.verdict import percent
from selfmotion.judgement import Tolerances
from selfmotion.planners.distance import Distance

LOOSE = Tolerances(between=1.0, step=2.0)


@pytest.fixture(scope="module")
def problem(seed_arm, seed_path):
    return sm.Problem(seed_arm, seed_path, start=[0.3])


@pytest.fixture(scope="module")
def best(problem):
    return sm.plan(problem, sm.Global(gap=1e-3))


@pytest.fixture(scope="module")
def sinusoid(problem):
    return sm.plan(problem, sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(seed=1)))


def rows(plan, count):
    r = np.linspace(0, 1, count)
    return r, plan(r)


def test_a_motion_of_known_cost(problem, best, sinusoid):
    found = sm.distance_from_optimum(problem, *rows(sinusoid, 400), best)
    assert found.cost == pytest.approx(sinusoid.cost, rel=2e-5)
    assert found.lower_bound == best.lower_bound
    assert found.optimum == best.cost
    assert found.gap == pytest.approx((sinusoid.cost - best.lower_bound) / sinusoid.cost, abs=2e-5)
    assert found.gap_sampled < found.gap
    assert found.reason is None
    assert str(found) == (
        f"at most {percent(found.gap)} of its cost {found.cost:.6g} could be saved: best motion found 4.88945, "
        f"none is below {best.lower_bound:.6g}"
    )


def test_the_planner_may_be_left_to_itself(problem, best):
    by_default = sm.distance_from_optimum(problem, *rows(best, 200))
    assert by_default.plan.certificate.bound == by_default.lower_bound
    assert 0 <= by_default.gap <= 3e-4
    given = sm.distance_from_optimum(problem, *rows(best, 200), sm.Global(gap=1e-2))
    assert given.lower_bound < by_default.lower_bound
    assert given.gap <= 1.2e-2


@pytest.mark.parametrize("count", [12, 20, 30])
def test_few_rows_flatter_nobody(problem, best, count):
    found = sm.distance_from_optimum(problem, *rows(best, count), best, LOOSE)
    assert found.cost_sampled < best.lower_bound
    assert found.gap_sampled is None
    assert found.cost + found.cost_error > best.lower_bound
    assert 0 < found.gap < 0.02
    assert found.reason is None


@pytest.mark.parametrize(
    ("objective", "links"), [("joint_travel", [3, 2, 2]), ("l1", [3, 2, 2]), ("l2", [2, 2, 2, 0.7])]
)
def test_no_motion_through_rows_is_below_a_dense_chord_sum_of_itself(objective, links):
    arm = sm.PlanarArm(links, direction=0.4 if len(links) == 4 else None)
    problem = sm.Problem(arm, sm.Line([3, 1.5], [4, -1]), objective=objective, start=[0.5], elbow="positive")
    r = np.linspace(0, 1, 30)
    q, ok = arm.solve(problem.path(r), 0.5 + 0.3 * np.sin(5 * r)[:, None], "positive")
    assert ok.all()
    found = sm.distance_from_optimum(problem, r, q, sm.Global(gap=1e-2), LOOSE)
    assert found.cost_sampled <= found.cost
    fine = np.linspace(0, 1, 3001)
    near = np.stack([np.interp(fine, r, joint) for joint in arm.limits.continuous(q).T], axis=-1)
    on_task = near.copy()
    for _ in range(20):
        jacobian = arm.jacobian(on_task)
        lack = arm.task_residual(on_task, problem.path(fine))
        on_task += (np.linalg.pinv(jacobian) @ lack[:, :, None])[:, :, 0]
    chords = problem.objective.sampled(on_task, fine, problem.weights)
    assert found.cost == pytest.approx(chords, rel=2e-3)
    assert found.cost + found.cost_error >= found.lower_bound


def test_rows_that_stand_still_cost_what_their_self_motion_does(problem, best):
    r, q = rows(best, 200)
    u = np.linspace(best.u(0.5)[0], best.u(0.5)[0] + 0.4, 50)[:, None]
    there = problem.arm.solve(problem.path(np.full(50, 0.5)), u, "positive")[0]
    aside = np.concatenate([q[:100], there, there[::-1], q[100:]])
    found = sm.distance_from_optimum(problem, np.concatenate([r[:100], np.full(100, 0.5), r[100:]]), aside, best)
    swing = 2 * np.abs(np.diff(there, axis=0)).sum()
    assert found.cost == pytest.approx(best.cost + swing, rel=1e-3)
    assert found.gap == pytest.approx(swing / found.cost, abs=2e-3)


def test_free_joints_may_be_given_modulo_whole_turns(problem, best):
    r, q = rows(best, 200)
    turned = q + 2 * np.pi * np.array([1, 0, -1]) * np.where(np.arange(200) % 2, 1, 0)[:, None]
    one, two = (sm.distance_from_optimum(problem, r, joints, best) for joints in (q, turned))
    assert two.cost == pytest.approx(one.cost, rel=1e-12)


def test_a_start_missed_within_tolerance_is_put_right(problem, best):
    r, q = rows(best, 200)
    off = problem.arm.solve(problem.path(r[:1]), [[0.3 + 9e-7]], "positive")[0]
    one, two = (sm.distance_from_optimum(problem, r, joints, best) for joints in (q, np.vstack([off, q[1:]])))
    assert two.cost == pytest.approx(one.cost, rel=1e-12)


def test_the_bound_holds_for_every_motion_of_the_other_planners(problem, best, sinusoid):
    others = [sinusoid, sm.plan(problem, sm.Refine(starts=2))]
    for plan in others:
        found = sm.distance_from_optimum(problem, problem.grid, plan(problem.grid), best)
        assert found.gap >= 0
        assert found.cost >= best.lower_bound


def test_another_degree_of_redundancy_leaves_only_the_cost():
    arm = sm.PlanarArm([20, 20, 20, 20])
    problem = sm.Problem(arm, sm.Line([40, 0], [50, 10]))
    plan = sm.plan(problem, sm.Refine(starts=1))
    found = sm.distance_from_optimum(problem, *rows(plan, 100))
    assert found.cost == pytest.approx(plan.cost, rel=1e-4)
    assert found.lower_bound is found.optimum is found.gap is found.plan is None
    assert "one redundant degree" in found.reason
    assert str(found).startswith("distance from the best possible motion: not known (global needs")


def test_no_time_is_no_bound(problem, best):
    found = sm.distance_from_optimum(problem, *rows(best, 100), sm.Global(time_limit=1e-6))
    assert found.lower_bound is None
    assert "time limit" in found.reason


def test_a_gap_that_two_rows_jump_over_is_no_motion():
    """All joints within ±1.45 rad: start and end of the line are in two parts of the domain; see ten-minutes."""
    arm = sm.PlanarArm([1, 1, 1], limits=[(-1.45, 1.45)] * 3)
    problem = sm.Problem(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))
    assert not problem.structure.is_connected
    q = [sm.angle_domain(arm, problem.path).sweep(at, 0).q[1] for at in (0.0, 1.0)]
    found = sm.distance_from_optimum(problem, [0, 1], q, sm.Global(time_limit=3), Tolerances(between=10.0, step=10.0))
    assert found.cost is found.gap is found.gap_sampled is None
    assert str(found).startswith("distance from the best possible motion: not known (")


def test_what_has_no_distance_is_refused(problem, best, sinusoid, seed_problem):
    r, q = rows(best, 100)
    with pytest.raises(sm.InvalidInputError, match="q: is no motion that holds: tracking"):
        sm.distance_from_optimum(problem, r, q + 0.01, best)
    with pytest.raises(sm.InvalidInputError, match="optimum: is a plan of another problem"):
        sm.distance_from_optimum(seed_problem, r, q, best)
    with pytest.raises(sm.InvalidInputError, match="optimum: is a plan by sinusoid, which proves no bound"):
        sm.distance_from_optimum(problem, r, q, sinusoid)
    with pytest.raises(sm.InvalidInputError, match="optimum: is neither"):
        sm.distance_from_optimum(problem, r, q, sm.Refine())
    with pytest.raises(sm.InvalidInputError, match="r: does not run through q"):
        sm.distance_from_optimum(problem, r[:-1], q, best)


def test_many_rows_speak_for_themselves(problem, best):
    found = sm.distance_from_optimum(problem, *rows(best, 50_001), best)
    assert found.cost is None
    assert found.gap is None
    assert "its chord sum stands for its cost" in found.reason
    assert found.gap_sampled == pytest.approx((best.cost - best.lower_bound) / best.cost, abs=1e-8)
    assert str(found).startswith("at most 0.0")
    assert "of its chord sum 4.88945 could be saved, and more of its cost" in str(found)


@pytest.mark.parametrize(
    ("known", "said"),
    [
        ({"reason": "not asked for"}, "distance from the best possible motion: not known (not asked for)"),
        (
            {"lower_bound": 2.0, "optimum": 2.1, "reason": "why"},
            "distance from the best possible motion: not known; best motion found 2.1, none is below 2 (why)",
        ),
    ],
)
def test_what_is_not_known_is_said(known, said):
    assert str(Distance(1.9, **known)) == said
