"""What the study computes, checked by other ways to compute it."""

import statistics

import numpy as np
import pytest

from selfmotion.report import seed_3r, seed_runs

CASES = list(seed_runs.CASES)
THREE = seed_3r.CASE


@pytest.fixture
def case(request, study):
    """One case of the study."""
    return study.cases[request.param]


every_case = pytest.mark.parametrize("case", CASES, indirect=True)


def test_printed_values_are_the_paper_s(results):
    table = results["cases"]["3R"]["table"]
    assert table["GA"]["printed"] == {"fitness": 4.8486, "f": 0.5562}
    assert table["PSO"]["printed"] == {"fitness": 4.84829399, "f": 0.5329}
    assert table["GWO"]["printed"] == {"fitness": 4.84829414, "f": 0.533}
    assert table["PSO canonical"]["printed"] is None


def test_computed_values_are_of_this_run(results):
    table, scan = results["cases"]["3R"]["table"], results["cases"]["3R"]["scan"]
    for line in table.values():
        assert line["fitness"] == line["cost_sampled"]
        assert line["fitness"] == pytest.approx(THREE.fitness(line["f"])[0], abs=1e-12)
        assert line["excess"] == line["fitness"] - scan["fitness"]
        assert line["evaluations"] == results["evaluations"] == 2000
    best = min(line["fitness"] for line in table.values())
    assert table[results["best"]]["fitness"] == best == pytest.approx(5.277515, abs=2e-6)


@every_case
def test_the_dense_scan_finds_what_a_local_search_from_every_dip_finds(case):
    from scipy.optimize import minimize_scalar

    f = np.linspace(0, 15, 1501)
    values = case.case.fitness(f)
    dips = np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] < values[2:])) + 1
    found = [(values[k], f[k]) for k in (0, -1)]
    for k in dips[values[dips] < values.min() + 1.0]:
        dip = minimize_scalar(
            lambda x: case.case.fitness(x)[0], bounds=(f[k - 1], f[k + 1]), method="bounded", options={"xatol": 1e-9}
        )
        found.append((dip.fun, dip.x))
    least = min(found)
    assert case.scan.fitness == pytest.approx(least[0], abs=1e-12)
    assert case.scan.f == pytest.approx(least[1], abs=1e-6)


def test_the_single_run_is_the_first_of_the_many(study):
    for label, plan in study.three.plans.items():
        np.testing.assert_allclose(study.cases["3R"].runs["plain"][label].best[0], plan.history[0].best, rtol=1e-14)


@every_case
def test_every_run_has_the_same_budget_and_its_own_seed(case):
    for rows in case.runs.values():
        assert list(rows) == ["GA", "PSO", "GWO", "PSO canonical", "random search"]
        for runs in rows.values():
            assert (runs.evaluations == 2000).all()
            assert runs.best.shape == (3, 100)
            best = np.where(np.isnan(runs.best), 1e300, runs.best)
            assert (np.diff(best, axis=1) <= 0).all()
            assert (best[:, -1] == runs.fitness).all()
            assert len(set(runs.f)) == 3 or (runs.f == case.scan.f).any()
            np.testing.assert_allclose(runs.fitness, case.case.fitness(runs.f), atol=1e-12)


def test_the_shifted_copy_is_the_same_problem_elsewhere(study):
    """What knows no origin ends in the same place; GWO, drawn to the origin, does not."""
    assert seed_runs.SHIFT == 7.5
    runs = study.cases["3R"].runs
    plain, shifted = runs["plain"], runs["shifted"]
    for label in ("GA", "PSO", "PSO canonical", "random search"):
        np.testing.assert_allclose(shifted[label].f, plain[label].f, atol=1e-6)
    assert (np.abs(shifted["GWO"].best - plain["GWO"].best).max(axis=1) > 1e-4).all()


@every_case
def test_what_searches_the_shifted_copy_judges_the_same_motions(case):
    f = np.linspace(0.0, 15.0, 40)[:, None]
    shifted = case.case.candidates().shifted(seed_runs.SHIFT)(f - seed_runs.SHIFT)
    np.testing.assert_allclose(shifted, case.case.fitness(f[:, 0]), rtol=1e-12)


@every_case
def test_statistics_are_those_of_the_standard_library(case, results):
    for copy_name, rows in case.runs.items():
        for label, runs in rows.items():
            shown = results["cases"][case.case.name]["comparison"][copy_name][label]
            excess = [value - case.scan.fitness for value in runs.fitness.tolist()]
            lower, median, upper = statistics.quantiles(excess, n=4, method="inclusive")
            expected = {"best": min(excess), "lower_quartile": lower, "median": median, "upper_quartile": upper}
            for key, value in {**expected, "worst": max(excess)}.items():
                assert shown[key] == pytest.approx(value, rel=1e-9, abs=1e-15)
            assert shown["found"] == sum(abs(value) <= 1e-6 for value in excess)
            assert shown["median_f_error"] == statistics.median(abs(f - case.scan.f) for f in runs.f.tolist())
            assert shown["fitness"] == runs.fitness.tolist()
