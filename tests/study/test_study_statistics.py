"""Statistics of studies, against closed forms, scipy's own and planted differences."""

import numpy as np
import pytest
from scipy import stats

from selfmotion.study.statistics import Method, compared, holm

A, B, C = (Method("search", name) for name in "ABC")


def row(problem, method, seed, cost, **more):
    planner, optimizer = method
    status = "solved" if np.isfinite(cost) else "unknown"
    return {
        "problem": problem, "planner": planner, "optimizer": optimizer, "seed": seed, "run": "done", "status": status,
        "cost": cost if np.isfinite(cost) else None, "lower_bound": None, "timed_out": False, "seconds": 0.5, **more,
    }  # fmt: skip


def table(problems=20, seeds=5, seed=0):
    """B is best on most problems, A and C do not differ."""
    rng, rows = np.random.default_rng(seed), []
    for k in range(problems):
        scale = 10.0 ** rng.uniform(-3, 3)
        for method, worse in ((A, 0.3), (B, 0.1), (C, 0.3)):
            rows += [row(f"p{k}", method, s, scale * (1 + worse * rng.random())) for s in range(seeds)]
    return rows


def proof(problem, bound, cost):
    return row(problem, Method("proof", ""), None, cost, lower_bound=bound)


def test_holm_s_correction_is_that_of_the_textbook():
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([0.6, 0.9]) == [1.0, 1.0]
    assert holm([]) == []


def test_what_is_planted_is_found():
    found = compared(table())
    assert found.friedman < 1e-4
    by = {(one.first, one.second): one for one in found.differences}
    assert by[A, B].corrected < 0.01
    assert by[B, C].corrected < 0.01
    assert by[A, C].corrected > 0.05
    assert by[A, B].losses > by[A, B].wins
    assert min(found.summaries, key=lambda one: one.rank).method == B


def test_tests_are_those_of_scipy_on_the_medians():
    rows = table(seed=3)
    found = compared(rows)
    best = {r["problem"]: min(s["cost"] for s in rows if s["problem"] == r["problem"]) for r in rows}
    medians = np.array([
        [np.median([r["cost"] for r in rows if (r["problem"], r["optimizer"]) == (name, m)]) / low - 1 for m in "ABC"]
        for name, low in best.items()
    ])  # fmt: skip
    assert found.friedman == pytest.approx(stats.friedmanchisquare(*medians.T).pvalue)
    assert found.differences[0].p == pytest.approx(stats.wilcoxon(medians[:, 0], medians[:, 1]).pvalue)
    assert [one.rank for one in found.summaries] == pytest.approx(stats.rankdata(medians, axis=1).mean(axis=0))
    assert found.compared == 20


def test_scale_of_problems_does_not_matter():
    rows = table(seed=4)
    scaled = [{**r, "cost": r["cost"] * 2.0 ** int(r["problem"][1:])} for r in rows]
    assert [one.p for one in compared(rows).differences] == [one.p for one in compared(scaled).differences]


def test_what_is_proved_is_the_reference_and_the_best_known_elsewhere():
    rows = [row("p", A, 1, 2.2), row("p", A, 2, 2.4), proof("p", 2.0, 2.002), row("q", A, 1, 3.0), row("q", A, 2, 3.3)]
    found = compared(rows)
    assert (found.problems, found.proved) == (2, 1)
    search, proved = found.summaries
    assert search.quartiles == pytest.approx(tuple(np.percentile([0.1, 0.2, 0.0, 0.1], [25, 50, 75])))
    assert search.found == 1
    assert proved.quartiles[1] == pytest.approx(1e-3)
    assert np.isnan(proved.rank)


def test_runs_without_a_motion_are_the_worst_and_failures_are_not_counted():
    rows = [row("p", A, s, 1.0 + s if s < 2 else np.inf) for s in range(4)]
    rows.append({**row("p", A, 9, np.inf), "run": "failed", "status": None})
    (one,) = compared(rows).summaries
    assert (one.runs, one.failed, one.solved) == (5, 1, 2)
    assert one.quartiles[0] == pytest.approx(0.75)
    assert np.isinf(one.quartiles[1:]).all()


def test_methods_that_solve_less_lose():
    rows = []
    for k in range(10):
        rows += [row(f"p{k}", A, s, 1.0 + 0.01 * s) for s in range(3)]
        rows += [row(f"p{k}", B, s, 1.0 if s == 0 else np.inf) for s in range(3)]
    found = compared(rows)
    assert found.differences[0].wins == 10
    assert found.differences[0].p < 0.01


def test_equal_methods_are_equal_and_few_problems_tell_nothing():
    rows = [row(f"p{k}", m, 1, 1.0 + k) for k in range(8) for m in (A, B, C)]
    found = compared(rows)
    assert found.friedman == 1.0
    assert {one.corrected for one in found.differences} == {1.0}
    assert {one.ties for one in found.differences} == {8}
    few = compared([r for r in rows if r["problem"] in ("p0", "p1")])
    assert few.friedman is None
    assert few.differences == []
    assert compared([]).summaries == []


def test_bands_are_excesses_over_the_reference_with_searches_one_after_the_other():
    histories = [[{"best": [None, 4.0, 3.0]}, {"best": [3.5, 2.0]}], [{"best": [2.5, 2.5]}]]
    rows = [row("p", A, s, [2.0, 2.5][s], history=history) for s, history in enumerate(histories)]
    found = compared(rows)
    np.testing.assert_allclose(found.bands[A], [[np.nan, 1.0, 0.5, 0.5, 0.0], [0.25] * 5])
