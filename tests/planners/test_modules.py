"""Modules of three links on given moving bases: the paper's 6R case, laws, and what is refused."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.paths import Relative
from selfmotion.planners import module_problems

FREE = None
LIMITS = [FREE, (0, np.pi), FREE, FREE, (0, np.pi), FREE]
BASE = [[80, 30], [70, 30], [70, 10], [80, -21]]
OFFSET, AMPLITUDE = [0.35, 0.0], [0.4, 0.4]


def clothoid_problem(limits=LIMITS, **options):
    path = sm.Clothoid([110, 20], 25, [0, -4, 0, 0.33], [-4.712, 0])
    return sm.Problem(sm.PlanarArm([30] * 6, limits), path, **options)


def planner(first_joints="relative", offset=OFFSET, amplitude=AMPLITUDE, bases=None, **changes):
    settings = {"population": 20, "iterations": 60, "bounds": (0, 15), "seed": 1, "variant": "canonical"} | changes
    bases = [sm.Bezier(BASE)] if bases is None else bases
    return sm.Modules(bases, offset, amplitude, sm.PSO(**settings), first_joints)


@pytest.fixture(scope="module")
def problem():
    return clothoid_problem()


@pytest.fixture(scope="module")
def plans(problem):
    return {reading: sm.plan(problem, planner(reading)) for reading in ("absolute", "relative")}


@pytest.fixture(scope="module")
def nine():
    """Three modules, the true first joints of the later ones limited, a path with corners."""
    limits = [FREE, (0, 3), FREE, (-2.5, 2.5), (0, 3), FREE, (-2.5, 2.5), FREE, (-3, 3)]
    arm = sm.PlanarArm([10, 9, 8, 10, 9, 8, 7, 7, 6], limits)
    path = sm.Waypoints([[45, 5], [48, 12], [42, 20]])
    bases = [sm.Line([18, 2], [17, 8]), sm.Bezier([[34, 4], [36, 9], [32, 14]])]
    problem = sm.Problem(arm, path, samples=300)
    return sm.plan(problem, planner(offset=[0.0, 0.1, 0.3], amplitude=[0.3, 0.2, 0.3], bases=bases, bounds=(0, 3)))


def written_out(x, u):
    """Joint angles of a 3R arm of links 30, its first joint absolute, by the cosine rule; positive elbow."""
    w = x - 30 * np.stack([np.cos(u), np.sin(u)], axis=-1)
    theta2 = np.arccos((np.sum(w * w, axis=-1) - 1800) / 1800)
    theta1 = np.arctan2(w[..., 1], w[..., 0]) - theta2 / 2
    return np.stack([theta1, theta2, u - theta1 - theta2], axis=-1)


def chord_sum(q, r):
    return np.sqrt(np.diff(np.unwrap(q, axis=-2), axis=-2) ** 2 + np.diff(r)[:, None] ** 2).sum(axis=(-2, -1))


def test_the_paper_s_modules_by_a_dense_scan_of_the_formulas(plans):
    """First module 4.25546 at f = 0.593, second, absolute, 10.779 at f = 0; in sum 15.03, with true joints 15.35."""
    r = np.linspace(0, 1, 1000)
    base, tool = sm.Bezier(BASE)(r), clothoid_problem().path(r)
    for i, (x, offset) in enumerate([(base, 0.35), (tool - base, 0.0)]):
        f = np.linspace(0, 2, 1001)
        with np.errstate(invalid="ignore"):
            values = chord_sum(written_out(x, offset + 0.4 * np.sin(2 * np.pi * f[:, None] * r)), r)
        best = int(np.nanargmin(values))
        found = plans["absolute"].parameters["modules"][i]
        assert found["f"] == pytest.approx(f[best], abs=2e-3)
        assert found["cost_sampled"]["absolute"] == pytest.approx(values[best], abs=1e-4)
        assert found["cost_sampled"]["absolute"] <= values[best] + 1e-9


def test_the_paper_s_6r_case(plans):
    first, second = plans["absolute"].parameters["modules"]
    assert first["f"] == pytest.approx(0.593, abs=1e-3)
    assert first["cost_sampled"]["absolute"] == pytest.approx(4.25546, abs=1e-4)
    assert first["cost_sampled"]["true"] == pytest.approx(4.25546, abs=1e-4)
    assert second["f"] == 0.0
    assert second["cost_sampled"]["absolute"] == pytest.approx(10.779, abs=1e-3)
    assert first["cost_sampled"]["absolute"] + second["cost_sampled"]["absolute"] == pytest.approx(15.03, abs=0.01)
    assert plans["absolute"].cost_sampled == pytest.approx(15.35, abs=0.01)
    assert plans["absolute"].parameters["first_joints"] == "absolute"


@pytest.mark.parametrize("reading", ["absolute", "relative"])
def test_the_shares_of_the_modules_sum_to_the_cost_in_true_joints(plans, reading):
    plan = plans[reading]
    for name in ("cost_sampled", "cost"):
        shares = [module[name]["true"] for module in plan.parameters["modules"]]
        assert sum(shares) == pytest.approx(getattr(plan, name), rel=1e-10)


def test_the_motion_tracks_the_path_and_its_junction_the_moving_base(plans):
    r = np.linspace(0, 1, 777)
    for plan in plans.values():
        problem, points = plan.problem, plan.problem.arm.joint_positions(plan(r))
        np.testing.assert_allclose(points[:, 6], problem.path(r), atol=1e-9 * problem.arm.reach)
        np.testing.assert_allclose(points[:, 3], sm.Bezier(BASE)(r), atol=1e-9 * problem.arm.reach)
        assert plan.verification.holds
        assert (plan.problem.arm.margins(plan(r)) >= 0).all()


def test_the_rates_are_the_motion_s_derivative(plans, nine):
    h = 1e-6
    for plan in (plans["relative"], nine):
        r = np.linspace(0.01, 0.99, 90)
        numeric = (plan(r + h) - plan(r - h)) / (2 * h)
        np.testing.assert_allclose(plan.rates(r), numeric, rtol=1e-5, atol=1e-6)


def test_absolute_modules_are_sinusoids_planned_each_for_itself(problem, plans):
    modules = module_problems(problem, [sm.Bezier(BASE)])
    r, before = np.linspace(0, 1, 200), 0.0
    for i, module in enumerate(modules):
        seed = plans["absolute"].parameters["modules"][i]["seed"]
        optimizer = planner(seed=seed).optimizer
        alone = sm.plan(module, sm.Sinusoid([OFFSET[i]], amplitude=[AMPLITUDE[i]], optimizer=optimizer))
        assert alone.parameters["f"] == pytest.approx(plans["absolute"].parameters[f"f{i + 1}"], abs=1e-9)
        q = plans["absolute"](r)[:, 3 * i : 3 * i + 3].copy()
        q[:, 0] += before
        np.testing.assert_allclose(np.sin((alone(r) - q) / 2), 0, atol=1e-8)
        before = alone.u(r)[:, 0]


def test_module_seeds_follow_from_the_one_given(plans):
    first, second = plans["relative"].parameters["modules"]
    assert first["seed"] == 1
    assert second["seed"] == int(np.random.SeedSequence([1, 1]).generate_state(1)[0])


def test_relative_counts_the_true_first_joint():
    """A first module that swings: in true joints another motion of the second is the cheaper one."""
    changes = {"offset": [0.35, 0.0], "amplitude": [0.4, 0.2], "bounds": (0.5, 3), "iterations": 40}
    problem = clothoid_problem(samples=400)
    found = {name: sm.plan(problem, planner(name, **changes)) for name in ("absolute", "relative")}
    second = {name: plan.parameters["modules"][1]["cost_sampled"] for name, plan in found.items()}
    assert second["relative"]["true"] <= second["absolute"]["true"]
    assert second["absolute"]["absolute"] <= second["relative"]["absolute"]
    assert found["relative"].parameters["f2"] != found["absolute"].parameters["f2"]


def test_three_modules(nine):
    assert nine.verification.holds
    assert nine.problem.arm.n == 9
    r = np.linspace(0, 1, 333)
    points = nine.problem.arm.joint_positions(nine(r))
    reach = nine.problem.arm.reach
    np.testing.assert_allclose(points[:, 3], sm.Line([18, 2], [17, 8])(r), atol=1e-9 * reach)
    np.testing.assert_allclose(points[:, 6], sm.Bezier([[34, 4], [36, 9], [32, 14]])(r), atol=1e-9 * reach)
    np.testing.assert_allclose(points[:, 9], nine.problem.path(r), atol=1e-9 * reach)
    modules = nine.parameters["modules"]
    assert sum(module["cost_sampled"]["true"] for module in modules) == pytest.approx(nine.cost_sampled, rel=1e-12)
    assert len(nine.history) == sum(len(module["elbows_searched"]) for module in modules) == 4
    # Each last link is the sinusoid that was chosen.
    phi = np.cumsum(nine(r), axis=1)[:, 2::3]
    for i, module in enumerate(modules):
        u = module["offset"] + module["amplitude"] * np.sin(2 * np.pi * module["f"] * r)
        np.testing.assert_allclose(np.sin((phi[:, i] - u) / 2), 0, atol=1e-12)


@pytest.mark.parametrize("reading", ["absolute", "relative"])
def test_limits_of_a_carried_first_joint_are_those_of_the_true_one(plans, reading):
    """The largest true angle of joint 4 is forbidden by 0.02: another frequency must be found, in both readings."""
    most = plans[reading](np.linspace(0, 1, 2000))[:, 3].max() - 0.02
    limits = [*LIMITS[:3], (-3.0, most), *LIMITS[4:]]
    plan = sm.plan(clothoid_problem(limits, samples=400), planner(reading, bounds=(0, 4), iterations=40))
    assert plan.verification.holds
    assert plan(np.linspace(0, 1, 2000))[:, 3].max() <= most + 1e-9
    assert plan.parameters["f2"] > 0
    assert plan.cost > plans[reading].cost


def test_a_carried_joint_keeps_the_turns_that_its_limits_ask_for(plans):
    limits = [*LIMITS[:3], (2 * np.pi - 3, 2 * np.pi + 3), *LIMITS[4:]]
    plan = sm.plan(clothoid_problem(limits, samples=200), planner(iterations=10, bounds=(0, 1)))
    r = np.linspace(0, 1, 50)
    assert plan.verification.holds
    assert (plan(r)[:, 3] > np.pi).all()


def test_later_modules_are_searched_on_both_elbows_where_they_may():
    problem = clothoid_problem([FREE, (0, np.pi), FREE, FREE, FREE, FREE], samples=300)
    plan = sm.plan(problem, planner(iterations=20, bounds=(0, 2)))
    first, second = plan.parameters["modules"]
    assert first["elbows_searched"] == ["positive"]
    assert second["elbows_searched"] == ["positive", "negative"]
    assert plan.evaluations == 3 * 20 * 20
    alone = {}
    for sign, pair in (("positive", (0, np.pi)), ("negative", (-np.pi, 0))):
        case = clothoid_problem([FREE, (0, np.pi), FREE, FREE, pair, FREE], samples=300)
        alone[sign] = sm.plan(case, planner(iterations=20, bounds=(0, 2))).cost_sampled
    assert second["elbow"] == min(alone, key=alone.get)
    assert plan.cost_sampled == pytest.approx(min(alone.values()), abs=1e-9)
    assert np.sign(plan(0.5)[4]) == (1 if second["elbow"] == "positive" else -1)


def test_the_elbow_asked_for_is_that_of_the_first_module():
    limits = [FREE, FREE, FREE, FREE, (0, np.pi), FREE]
    plan = sm.plan(clothoid_problem(limits, elbow="negative", samples=300), planner(iterations=20, bounds=(0, 2)))
    assert plan.parameters["elbow"] == "negative"
    assert [module["elbow"] for module in plan.parameters["modules"]] == ["negative", "positive"]
    assert (plan(np.linspace(0, 1, 50))[:, 1] < 0).all()


def test_one_module_is_a_sinusoid(seed_problem):
    optimizer = sm.PSO(iterations=10, seed=3)
    one = sm.plan(seed_problem, sm.Modules([], [0.3], [0.4], optimizer))
    plain = sm.plan(seed_problem, sm.Sinusoid([0.3], amplitude=[0.4], optimizer=optimizer))
    assert one.parameters["f1"] == plain.parameters["f"]
    assert one.cost_sampled == pytest.approx(plain.cost_sampled, abs=1e-12)


def test_same_seed_same_bits():
    problem = clothoid_problem(samples=200)
    first, again = (sm.plan(problem, planner(iterations=8)) for _ in range(2))
    assert first.parameters == again.parameters
    r = np.linspace(0, 1, 77)
    np.testing.assert_array_equal(first(r), again(r))
    other = sm.plan(problem, planner(iterations=8).with_seed(2))
    assert other.parameters["f1"] != first.parameters["f1"]


def test_progress_counts_every_generation():
    calls = []
    problem = clothoid_problem([FREE] * 6, samples=150, elbow="positive")
    sm.plan(problem, planner(iterations=4), lambda *args: calls.append(args))
    assert [done for done, _, _ in calls] == list(range(1, 13))
    assert {total for _, total, _ in calls} == {12}


def test_the_angle_domain_of_a_module(problem):
    """Fig. 14 at r = 0: without the limits of joint 2 or 5 mattering, |u − ψ| ≤ arccos((R² + 30² − 60²)/(60 R))."""
    for module in module_problems(problem, [sm.Bezier(BASE)]):
        x = module.path(0.0)
        distance, direction = np.hypot(*x), np.arctan2(x[1], x[0])
        half = np.arccos((distance**2 - 2700) / (60 * distance))
        (interval,) = sm.angle_domain(module.arm, module.path)(0.0, "positive").intervals
        np.testing.assert_allclose(interval, [direction - half, direction + half], atol=1e-9)


def test_a_relative_path_has_the_derivatives_and_the_marks_of_both():
    path, origin = (
        sm.Waypoints([[3, 1], [4, 2], [5, 0]]),
        sm.Concatenation([sm.Line([0, 0], [1, 0]), sm.Line([1, 0], [1, 3])]),
    )
    seen = Relative(path, origin)
    assert set(seen.breaks) == {*path.breaks, *origin.breaks}
    assert set(seen.waypoints) == {*path.waypoints, *origin.waypoints}
    smooth = Relative(sm.Circle([3, 0], 1), sm.Bezier(BASE))
    r, h = np.linspace(0.01, 0.99, 40), 1e-5
    np.testing.assert_array_equal(smooth(r), sm.Circle([3, 0], 1)(r) - sm.Bezier(BASE)(r))
    for order in (1, 2):
        numeric = (smooth(r + h, order - 1) - smooth(r - h, order - 1)) / (2 * h)
        np.testing.assert_allclose(smooth(r, order), numeric, rtol=1e-6, atol=1e-5)


FAR = [[80, 30], [110, 30], [110, 10], [80, -21]]
NEAR = [[80, 30], [10, 30], [10, 10], [20, -21]]
REFUSED = {
    "five links": ({"arm": [30] * 5}, {}, "arm.links", "3, 6, 9"),
    "a direction": ({"arm": [30] * 6, "direction": 0.0}, {}, "arm", "no direction"),
    "no moving base": ({}, {"bases": []}, "planner.moving_bases", "give 1"),
    "two moving bases": ({}, {"bases": [sm.Bezier(BASE)] * 2}, "planner.moving_bases", "give 1"),
    "one offset": ({}, {"offset": [0.35], "amplitude": [0.4]}, "planner.offset", "once per module"),
    "a base too far": ({}, {"bases": [sm.Bezier(FAR)]}, "planner.moving_bases.0", "0 to 90 from the arm's base"),
    "a base far from the tool": ({}, {"bases": [sm.Bezier(NEAR)]}, "planner.moving_bases.0", "0 to 90 from the tool"),
    "a base in other units": ({}, {"bases": [sm.Line([800, 0], [810, 0])]}, "planner.moving_bases.0", "units"),
    "an offset outside": ({}, {"offset": [2.9, 0.0]}, "planner.offset.0", "-0.0983763, 0.815918"),
    "a later offset outside": ({}, {"offset": [0.35, 3.0]}, "planner.offset.1", "-1.5182, 1.32756"),
    "start": ({"start": [0.35, 0, 0, 0]}, {}, "start", "planner: refine"),
    "end": ({"end": [0.35, 0, 0, 0]}, {}, "end", "planner: refine"),
    "bounds for two": ({}, {"bounds": [(0, 1), (0, 2)]}, "planner.optimizer.bounds", "one pair"),
    "weights of one module only": ({"weights": [1, 1, 1, 0, 0, 0]}, {}, "weights", "weight"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_modules_cannot_do_is_refused_with_place_and_remedy(case):
    options, changes, field, remedy = REFUSED[case]
    options = dict(options)
    if "arm" in options:
        arm = sm.PlanarArm(options.pop("arm"), direction=options.pop("direction", None))
        problem = sm.Problem(arm, sm.Line([100, 0], [110, 10]))
    else:
        problem = clothoid_problem(**options)
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.plan(problem, planner(**changes))
    assert caught.value.field == field
    assert remedy in caught.value.remedy
    assert caught.value.exit_code == 2


def test_a_base_out_of_reach_is_refused_with_its_stretch_and_by_how_much():
    base = sm.Line([80, 0], [100, 0])
    with pytest.raises(sm.InvalidInputError, match=r"out of reach by up to 10 for r in \[0.5, 1\]"):
        sm.plan(clothoid_problem(), planner(bases=[base]))


def test_a_base_that_the_limits_forbid_is_refused_with_its_stretch():
    limits = [(-0.1, 0.1), (0, 0.1), FREE, FREE, (0, np.pi), FREE]
    with pytest.raises(sm.InvalidInputError, match=r"module 1, joint limits for r in \[0\.39\d+, 0\.92") as caught:
        sm.plan(clothoid_problem(limits), planner())
    assert "joints 1 to 3" in caught.value.remedy


def test_an_offset_that_the_carried_joint_forbids_is_refused():
    limits = [*LIMITS[:3], (2.0, 2.1), *LIMITS[4:]]
    with pytest.raises(sm.InvalidInputError, match=r"joint 4, carried at offset 0\.35") as caught:
        sm.plan(clothoid_problem(limits), planner())
    assert caught.value.field == "planner.offset.1"


def test_an_elbow_that_the_carried_joint_forbids_is_not_searched():
    """At r = 0 joint 4 is at −1.66 with a positive elbow of module 2, at 0.55 with a negative one."""
    calls, problem = [], clothoid_problem([FREE, FREE, FREE, (-1.2, 3.0), FREE, FREE], samples=100, elbow="positive")
    plan = sm.plan(problem, planner(iterations=5, bounds=(0, 1)), lambda *args: calls.append(args))
    assert plan.parameters["modules"][1]["elbows_searched"] == ["negative"]
    assert len(plan.history) == 2
    assert calls[-1][:2] == (10, 10)


def test_cyclic_is_refused():
    circle = sm.Problem(sm.PlanarArm([30] * 6), sm.Circle([110, 0], 10), cyclic="exact")
    with pytest.raises(sm.InvalidInputError, match=r"cyclic.*planner: refine"):
        sm.plan(circle, planner())


@pytest.mark.parametrize(("change", "field"), [
    ({"moving_bases": sm.Bezier(BASE)}, "moving_bases"),
    ({"moving_bases": [3]}, "moving_bases"),
    ({"moving_bases": 3}, "moving_bases"),
    ({"amplitude": [0.4]}, "amplitude"),
    ({"amplitude": [0.4, 0.0]}, "amplitude"),
    ({"first_joints": "true"}, "first_joints"),
    ({"optimizer": "pso"}, "optimizer"),
])  # fmt: skip
def test_a_planner_that_cannot_be_is_refused(change, field):
    given = {
        "moving_bases": [sm.Bezier(BASE)],
        "offset": OFFSET,
        "amplitude": AMPLITUDE,
        "optimizer": sm.PSO(),
    } | change
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.Modules(**given)
    assert caught.value.field == field


def test_a_tool_path_out_of_the_whole_arm_s_reach_is_proved_infeasible():
    problem = sm.Problem(sm.PlanarArm([30] * 6), sm.Line([100, 0], [190, 0]))
    with pytest.raises(sm.InfeasibleError) as caught:
        sm.plan(problem, planner())
    assert caught.value.exit_code == 3


def test_nothing_feasible_names_the_module():
    with pytest.raises(sm.NothingFeasibleError, match="module 2: none of") as caught:
        sm.plan(clothoid_problem(samples=200), planner(amplitude=[0.1, 3.0], bounds=(1, 15), iterations=3))
    assert caught.value.least_violation > 0


def test_candidates_that_break_between_the_samples_are_passed_over():
    """The tool swings, unseen by seven samples, and with it joint 4, out of limits that hold at the samples."""
    base, path = sm.Line([60, 20], [60, 20.001]), sm.Lissajous([112, 20], [3, 3], [0, 6], phase=np.pi / 2)
    still = {"bases": [base], "offset": [0.3, 0.3], "amplitude": [1e-9, 1e-9], "bounds": (0, 0.5), "iterations": 1}
    loose = sm.plan(sm.Problem(sm.PlanarArm([30] * 6, LIMITS), path, samples=7), planner(**still))
    limit = float(loose(0.0)[3])
    arm = sm.PlanarArm([30] * 6, [*LIMITS[:3], (limit - 0.01, limit + 0.01), *LIMITS[4:]])
    assert np.ptp(loose(np.linspace(0, 1, 7))[:, 3]) < 0.001
    assert np.ptp(loose(np.linspace(0, 1, 700))[:, 3]) > 0.05
    with pytest.raises(
        sm.NothingFeasibleError, match=r"module 2: the best 20 of 20 candidates hold at the samples.*between"
    ):
        sm.plan(sm.Problem(arm, path, samples=7), planner(**still))


def test_the_command_line_says_where_a_moving_base_leaves_the_workspace(run, seed_file):
    file = seed_file(
        arm={"kind": "planar", "links": [30] * 6, "limits": [None, [0, np.pi], None, None, [0, np.pi], None]},
        path={"kind": "line", "start": [110, 20], "end": [120, 40]},
        planner={
            "kind": "modules",
            "moving_bases": [{"kind": "line", "start": [80, 0], "end": [100, 0]}],
            "offset": OFFSET,
            "amplitude": AMPLITUDE,
            "optimizer": {"kind": "pso", "population": 4, "iterations": 2, "seed": 1},
        },
    )  # fmt: skip
    code, out, err = run("plan", file)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert "planner.moving_bases.0: leaves the workspace of module 1, out of reach by up to 10 for r in [0.5, 1]" in err
    assert "keep it at a distance of 0 to 90 from the arm's base" in err
