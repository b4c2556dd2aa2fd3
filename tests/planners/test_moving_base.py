"""Moving bases that are chosen: their objective against plans made singly, the paper's 6R case, what is refused."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.optimizers import INFEASIBLE, violation_of
from selfmotion.planners.chain import allowed_elbows
from selfmotion.planners.chain_candidates import bernstein, first_guess
from selfmotion.planners.moving_base import _moved

FREE = None
LIMITS = [FREE, (0, np.pi), FREE, FREE, (0, np.pi), FREE]


def clothoid_problem(limits=LIMITS, **options):
    path = sm.Clothoid([110, 20], 25, [0, -4, 0, 0.33], [-4.712, 0])
    return sm.Problem(sm.PlanarArm([30] * 6, limits), path, **options)


def planner(population=30, iterations=60, seed=1, **changes):
    return sm.MovingBase(sm.DifferentialEvolution(population, iterations, seed=seed), **changes)


@pytest.fixture(scope="module")
def plan():
    return sm.plan(clothoid_problem(), planner(60, 400))


def test_the_paper_s_6r_case_gets_far_cheaper(plan):
    """Between the best motion of the whole arm, at most 8.34, and the modules on the paper's moving base, 15.03."""
    assert 8.34 < plan.cost < 11.2
    assert plan.verification.holds
    # Its frequencies are as good as any: searched again one by one they save less than a thousandth.
    assert plan.cost < 1.001 * sm.plan(clothoid_problem(), modules_of(plan)).cost


def modules_of(plan):
    """The same moving base and sinusoids, their frequencies searched again."""
    modules, bases = plan.parameters["modules"], plan.parameters["moving_bases"]
    return sm.Modules(
        [sm.Bezier(base["control_points"]) for base in bases],
        [module["offset"] for module in modules],
        [module["amplitude"] for module in modules],
        sm.PSO(20, 30, (0, 2), seed=1, variant="canonical"),
    )


def test_its_motion_is_that_of_the_parameters_it_reports(plan):
    r, arm = np.linspace(0, 1, 301), plan.problem.arm
    points = arm.joint_positions(plan(r))
    (base,) = plan.parameters["moving_bases"]
    np.testing.assert_allclose(points[:, 3], sm.Bezier(base["control_points"])(r), atol=1e-9 * arm.reach)
    np.testing.assert_allclose(points[:, 6], plan.problem.path(r), atol=1e-9 * arm.reach)
    phi = np.cumsum(plan(r), axis=1)[:, 2::3]
    for i, module in enumerate(plan.parameters["modules"]):
        u = module["offset"] + module["amplitude"] * np.sin(2 * np.pi * module["f"] * r)
        np.testing.assert_allclose(np.sin((phi[:, i] - u) / 2), 0, atol=1e-12)
    assert sum(module["cost"]["true"] for module in plan.parameters["modules"]) == pytest.approx(plan.cost, rel=1e-10)


@pytest.mark.parametrize("elbows", [(0, 0), (1, 0)])
@pytest.mark.parametrize("objective", ["joint_travel", "l1", "l2"])
def test_a_candidate_costs_what_its_plan_does(elbows, objective):
    """The whole population at once against one motion of the whole arm after the other."""
    weights = [1, 2, 1, 1, 0.5, 1]
    problem = clothoid_problem([FREE] * 6, samples=150, objective=objective, weights=weights)
    candidates = planner(control_points=3).candidates_for(problem, elbows)
    population = np.random.default_rng(3).uniform(-0.4, 0.4, (60, candidates.dimension))
    values, compared = candidates(population), 0
    for a, value in zip(population, values, strict=True):
        if value < INFEASIBLE:
            motion = _moved(problem, candidates, a).motion
            r = problem.grid
            assert problem.objective.sampled(motion(r), r, problem.weights) == pytest.approx(value, rel=1e-9)
            compared += 1
    assert 5 <= compared < 60


def test_candidates_are_ranked_by_how_far_they_leave():
    """A base at rest that is 10 too far from the arm's base leaves the reach of 90 by a ninth."""
    problem = sm.Problem(sm.PlanarArm([30] * 6), sm.Line([150, 0], [150, 1e-3]), samples=50)
    here = sm.Line([100.0, 0.0], [100.0, 1e-9])
    candidates = planner(control_points=2, around=[here]).candidates_for(problem, (0, 0))
    (value,) = candidates(np.zeros((1, candidates.dimension)))  # amplitudes zero, last links along the way
    assert violation_of(value) == pytest.approx(10 / 90, abs=1e-6)


def test_a_candidate_may_rest():
    problem = clothoid_problem([FREE] * 6, samples=50)
    candidates = planner().candidates_for(problem, (0, 0))
    motion = _moved(problem, candidates, np.zeros(candidates.dimension)).motion
    assert np.ptp(motion(problem.grid)[:, :3].sum(axis=1)) < 1e-12


def test_offsets_measure_the_arc_in_reach_at_the_start():
    """At ±1 the first two links of the module are stretched at r = 0."""
    problem = clothoid_problem([FREE] * 6, samples=50)
    candidates = planner().candidates_for(problem, (0, 0))
    population = np.zeros((4, candidates.dimension))
    population[:2, -6], population[2:, -3] = (1.0, -1.0), (1.0, -1.0)
    chosen = candidates.choice(population)
    first = chosen.points[:, 0, 0]
    for rows, i, target in ((slice(0, 2), 0, first), (slice(2, 4), 1, problem.path(0.0) - first)):
        u = chosen.offset[rows, i]
        wrist = target[rows] - 30 * np.stack([np.cos(u), np.sin(u)], axis=-1)
        np.testing.assert_allclose(np.hypot(*wrist.T), 60.0, atol=1e-9)


def test_bernstein_s_polynomials_make_bezier_curves():
    points = np.random.default_rng(0).normal(size=(7, 2))
    r = np.linspace(0, 1, 40)
    np.testing.assert_allclose(bernstein(7, r) @ points, sm.Bezier(points)(r), atol=1e-13)


def test_the_first_guess_gives_each_module_its_share():
    arm = sm.PlanarArm([1, 1, 1, 2, 2, 2, 3, 3, 3])
    problem = sm.Problem(arm, sm.Line([10, 0], [14, 2]))
    guess = first_guess(problem, 3)
    np.testing.assert_allclose(guess[:, 0], [[10 / 6, 0], [5, 0]], atol=1e-12)
    np.testing.assert_allclose(guess[:, -1], [[14 / 6, 2 / 6], [7, 1]], atol=1e-12)
    around = [sm.Bezier([[1, 0], [2, 5], [3, 0]]), sm.Line([4, 0], [5, 0])]
    np.testing.assert_allclose(first_guess(problem, 3, around)[0], around[0].control_points, atol=1e-12)


def test_three_modules_with_carried_joints_limited():
    limits = [FREE, (0, 3), FREE, (-1.0, 1.0), (0, 3), FREE, (-1.2, 1.2), (0, 3), FREE]
    arm = sm.PlanarArm([10, 9, 8, 10, 9, 8, 7, 7, 6], limits)
    problem = sm.Problem(arm, sm.Waypoints([[45, 5], [48, 12], [42, 20]]), samples=200)
    found = sm.plan(problem, planner(40, 80, control_points=4))
    assert found.verification.holds
    assert found.verification.min_limit_margin >= -1e-9
    assert len(found.parameters["moving_bases"]) == 2
    r = np.linspace(0, 1, 101)
    points = arm.joint_positions(found(r))
    for i, base in enumerate(found.parameters["moving_bases"]):
        np.testing.assert_allclose(points[:, 3 * i + 3], sm.Bezier(base["control_points"])(r), atol=1e-9 * arm.reach)


def test_elbows_are_searched_where_limits_allow():
    problem = clothoid_problem([FREE] * 6, samples=60)
    each = sm.plan(problem, planner(20, 40, control_points=3))
    alike = sm.plan(problem, planner(20, 40, control_points=3, elbows="alike"))
    assert len(each.history) == 4
    assert each.evaluations == 4 * 20 * 40
    assert [set(pair) for pair in alike.parameters["elbows_searched"]] == [{"positive"}, {"negative"}]
    assert each.cost_sampled <= alike.cost_sampled
    asked = sm.plan(clothoid_problem([FREE] * 6, samples=60, elbow="negative"), planner(20, 40, control_points=3))
    assert [pair[0] for pair in asked.parameters["elbows_searched"]] == ["negative", "negative"]
    assert (asked(np.linspace(0, 1, 50))[:, 1] <= 0).all()


@pytest.mark.parametrize(("pair", "allowed"), [
    ((0, np.pi), ["positive"]),
    ((-np.pi, 0), ["negative"]),
    ((np.pi, 2 * np.pi), ["negative"]),
    ((-1, 1), ["positive", "negative"]),
    ((2 * np.pi + 1, 2 * np.pi + 2), ["positive"]),
    ((-3 * np.pi / 2, -1.1 * np.pi), ["positive"]),
    ((0.5, None), ["positive", "negative"]),
    ((-7 * np.pi, -6 * np.pi), ["negative"]),
    ((1.0, 1.0), ["positive"]),
    ((0.0, 0.0), []),
    (None, ["positive", "negative"]),
])  # fmt: skip
def test_which_elbows_limits_leave(pair, allowed):
    module = sm.PlanarArm([3, 2, 1], [None, pair, None])
    assert [module.branches[branch] for branch in allowed_elbows(module)] == allowed


def test_same_seed_same_bits():
    problem = clothoid_problem(samples=100)
    first, again = (sm.plan(problem, planner(20, 25)) for _ in range(2))
    assert first.parameters == again.parameters
    np.testing.assert_array_equal(first([0.0, 0.3, 1.0]), again([0.0, 0.3, 1.0]))
    assert sm.plan(problem, planner(20, 25).with_seed(2)).parameters != first.parameters


def test_a_guess_is_where_the_search_begins():
    """With a box this narrow the moving base stays at the paper's."""
    base = sm.Bezier([[80, 30], [70, 30], [70, 10], [80, -21]])
    found = sm.plan(clothoid_problem(samples=200), planner(30, 40, control_points=4, spread=1e-6, around=[base]))
    points = found.parameters["moving_bases"][0]["control_points"]
    np.testing.assert_allclose(points, base.control_points, atol=1e-3)
    assert found.cost < 15.35  # offset and amplitude were chosen too


@pytest.mark.parametrize(("change", "field"), [
    ({"control_points": 1}, "control_points"),
    ({"spread": 0}, "spread"),
    ({"amplitude": -1}, "amplitude"),
    ({"frequency": 0}, "frequency"),
    ({"elbows": "both"}, "elbows"),
    ({"around": sm.Line([0, 0], [1, 0])}, "around"),
    ({"optimizer": "pso"}, "optimizer"),
    ({"optimizer": sm.PSO(bounds=(0, 2))}, "optimizer.bounds"),
])  # fmt: skip
def test_a_planner_that_cannot_be_is_refused(change, field):
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.MovingBase(**({"optimizer": sm.PSO()} | change))
    assert caught.value.field == field
    assert caught.value.remedy


REFUSED = {
    "one module": (lambda: sm.Problem(sm.PlanarArm([30] * 3), sm.Line([50, 0], [60, 0])), {}, "arm.links"),
    "four links": (lambda: sm.Problem(sm.PlanarArm([30] * 4), sm.Line([50, 0], [60, 0])), {}, "arm.links"),
    "start": (lambda: clothoid_problem(start=[0, 0, 0, 0]), {}, "start"),
    "too few samples": (lambda: clothoid_problem(samples=10), {}, "samples"),
    "too fast": (lambda: clothoid_problem(), {"frequency": 100}, "planner.frequency"),
    "two guesses": (lambda: clothoid_problem(), {"around": [sm.Line([0, 0], [1, 0])] * 2}, "planner.around"),
    "32 combinations": (
        lambda: sm.Problem(sm.PlanarArm([30] * 15), sm.Line([100, 0], [110, 0])), {}, "planner.elbows"
    ),
    "no elbow": (lambda: clothoid_problem(elbow="negative"), {}, "elbow"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_it_cannot_do_is_refused(case):
    make, changes, field = REFUSED[case]
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.plan(make(), planner(8, 2, **changes))
    assert caught.value.field == field
    assert caught.value.remedy


def test_nothing_feasible_says_by_how_much():
    tight = [FREE, (3.0, 3.1), FREE, (0.5, 0.51), (3.0, 3.1), (0, 0.1)]
    with pytest.raises(sm.NothingFeasibleError, match="none of 24 candidates") as caught:
        sm.plan(clothoid_problem(tight, samples=50), planner(8, 3))
    assert caught.value.least_violation > 0


def test_progress_counts_every_generation():
    calls = []
    problem = clothoid_problem([FREE] * 6, samples=60)
    sm.plan(problem, planner(20, 30, elbows="alike", control_points=3), lambda *args: calls.append(args))
    assert [done for done, _, _ in calls] == list(range(1, 61))
    assert {total for _, total, _ in calls} == {60}


def test_a_problem_file_may_say_where_to_start(run, seed_file):
    file = seed_file(
        arm={"kind": "planar", "links": [30] * 6, "limits": [None, [0, 3.1], None, None, [0, 3.1], None]},
        path={"kind": "line", "start": [110, 20], "end": [120, 40]},
        planner={
            "kind": "moving_base",
            "control_points": 3,
            "around": [{"kind": "line", "start": [60, 0], "end": [60, 20]}],
            "optimizer": {"kind": "differential_evolution", "population": 20, "iterations": 20, "seed": 1},
        },
        samples=100,
    )
    code, out, err = run("plan", file)
    assert (code, err) == (0, "")
    assert "moving_base, f1 = " in out
