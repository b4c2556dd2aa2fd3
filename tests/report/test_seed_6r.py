"""The 6R study, checked by other ways to compute it."""

from pathlib import Path

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.report import seed_6r

EXAMPLE = Path(__file__).parents[2] / "examples" / "seed_6r.yaml"


def test_printed_values_are_the_paper_s(results):
    fixed, moving, true = (results["cases"][name]["table"] for name in seed_6r.NAMES)
    assert fixed["GA"]["printed"] == {"fitness": 5.1635, "f": 0.5304}
    assert fixed["PSO"]["printed"] == {"fitness": 5.147048672, "f": 0.5524}
    assert fixed["GWO"]["printed"] == {"fitness": 5.147048758, "f": 0.5523}
    assert moving["GA"]["printed"] == {"fitness": 9.6343, "f": 0.1748}
    assert moving["PSO"]["printed"] == moving["GWO"]["printed"] == {"fitness": 9.6279, "f": 0.1551}
    for label, line in moving.items():
        assert true[label]["printed"] == line["printed"]


def test_the_problem_is_that_of_the_example():
    problem, planner = sm.load_problem(EXAMPLE)[:2]
    ours = seed_6r.problem()
    r = np.linspace(0, 1, 50)
    np.testing.assert_array_equal(ours.path(r), problem.path(r))
    np.testing.assert_array_equal(seed_6r.moving_base()(r), planner.moving_bases[0](r))
    np.testing.assert_array_equal(ours.arm.links, problem.arm.links)
    assert ours.arm.limits.as_list() == problem.arm.limits.as_list()
    assert ours.samples == problem.samples
    assert planner.offset.tolist() == list(seed_6r.OFFSET)
    assert planner.amplitude.tolist() == list(seed_6r.AMPLITUDE)


def _joints(target, u):
    """Return a 3R module's joint angles by the law of cosines, positive elbow, and the travel of each."""
    wrist = target - 30.0 * np.stack([np.cos(u), np.sin(u)], axis=-1)
    bend = np.arccos((wrist**2).sum(axis=-1) / 1800.0 - 1.0)
    first = np.arctan2(wrist[:, 1], wrist[:, 0]) - bend / 2  # links of equal length
    return np.unwrap(np.stack([first, bend, u - first - bend], axis=-1), axis=0)


def _travel(q):
    return np.hypot(np.diff(q, axis=0), 1 / (len(q) - 1)).sum()


@pytest.mark.parametrize(("f1", "f2"), [(0.5933, 0.0), (0.5524, 0.1551), (0.55, 0.3)])
def test_fitness_in_both_readings_is_that_of_the_law_of_cosines(f1, f2):
    r = np.linspace(0, 1, 1000)
    u1, u2 = 0.35 + 0.4 * np.sin(2 * np.pi * f1 * r), 0.4 * np.sin(2 * np.pi * f2 * r)
    base = seed_6r.moving_base()(r)
    first, second = _joints(base, u1), _joints(seed_6r.problem().path(r) - base, u2)
    assert seed_6r.FIXED.fitness(f1)[0] == pytest.approx(_travel(first), abs=1e-11)
    assert seed_6r.MOVING.fitness(f2)[0] == pytest.approx(_travel(second), abs=1e-11)
    second[:, 0] -= u1
    assert seed_6r.true_joints(f1).fitness(f2)[0] == pytest.approx(_travel(second), abs=1e-11)


def test_the_yardsticks_are_what_is_known(results):
    fixed, moving, true = (results["cases"][name]["scan"] for name in seed_6r.NAMES)
    assert (fixed["fitness"], fixed["f"]) == (pytest.approx(4.25546, abs=1e-5), pytest.approx(0.593, abs=5e-4))
    assert (moving["fitness"], moving["f"]) == (pytest.approx(10.779, abs=5e-4), 0.0)
    assert fixed["fitness"] + moving["fitness"] == pytest.approx(15.03, abs=6e-3)
    assert fixed["fitness"] + true["fitness"] == pytest.approx(15.35, abs=6e-3)


def test_computed_values_are_of_this_run(results, study):
    fixed, moving, true = (results["cases"][name]["table"] for name in seed_6r.NAMES)
    for label, line in fixed.items():
        assert line["fitness"] == pytest.approx(seed_6r.FIXED.fitness(line["f"])[0], abs=1e-12)
        assert moving[label]["fitness"] == pytest.approx(seed_6r.MOVING.fitness(moving[label]["f"])[0], abs=1e-12)
        carried = seed_6r.true_joints(study.six.plans["true"][label].parameters["f1"])
        assert true[label]["fitness"] == pytest.approx(carried.fitness(true[label]["f"])[0], abs=1e-12)
        if printed := line["printed"]:
            at = seed_6r.true_joints(printed["f"]).fitness(true[label]["printed"]["f"])[0]
            assert true[label]["computed_at_printed_f"] == at


def test_sums_are_those_of_the_lines_and_of_the_whole_motion(results, study):
    fixed, moving, true = (results["cases"][name]["table"] for name in seed_6r.NAMES)
    sums = results["six"]["sums"]
    for label, line in fixed.items():
        plan = study.six.plans["true"][label]
        whole = line["fitness"] + moving[label]["fitness"]
        assert sums["absolute"][label]["absolute"]["sampled"] == pytest.approx(whole)
        assert sums["true"][label]["true"]["sampled"] == pytest.approx(line["fitness"] + true[label]["fitness"])
        assert sums["true"][label]["true"]["integral"] == pytest.approx(plan.cost, abs=1e-9)
        for rows in sums.values():
            for reading in seed_6r.READINGS:
                sampled, integral = (rows[label][reading][kind] for kind in ("sampled", "integral"))
                assert sampled < integral < sampled + 1e-3
    best = results["six"]["best"]
    assert sums["absolute"][best]["absolute"]["sampled"] == min(
        line["absolute"]["sampled"] for line in sums["absolute"].values()
    )


def test_motions_of_the_whole_arm_hold_and_are_shorter_the_less_they_are_bound(results, study):
    whole, plan = study.six.whole_arm, study.six.plan
    assert all(one.verification.holds for one in (plan, *whole))
    np.testing.assert_allclose(whole.from_start([0.0]), plan([0.0]), atol=1e-9)
    assert whole.free.cost < whole.from_start.cost < plan.cost
    assert whole.moving.cost < plan.cost
    assert whole.free.cost == pytest.approx(6.6703, abs=1e-3)
    assert whole.from_start.cost == pytest.approx(7.875, abs=1e-3)
    assert results["six"]["whole_arm"]["free"]["cost"] == whole.free.cost
