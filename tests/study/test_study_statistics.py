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
    (group,) = found.groups
    assert (group.name, group.methods, group.problems) == ("search", [A, B, C], 20)
    assert group.friedman < 1e-4
    by = {(one.first, one.second): one for one in group.differences}
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
    (group,) = found.groups
    assert group.friedman == pytest.approx(stats.friedmanchisquare(*medians.T).pvalue)
    assert group.differences[0].p == pytest.approx(stats.wilcoxon(medians[:, 0], medians[:, 1]).pvalue)
    assert [one.rank for one in found.summaries] == pytest.approx(stats.rankdata(medians, axis=1).mean(axis=0))
    assert group.problems == 20


def test_scale_of_problems_does_not_matter():
    rows = table(seed=4)
    scaled = [{**r, "cost": r["cost"] * 2.0 ** int(r["problem"][1:])} for r in rows]
    (before,), (after,) = compared(rows).groups, compared(scaled).groups
    assert [one.p for one in before.differences] == [one.p for one in after.differences]


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
    (group,) = found.groups
    assert group.differences[0].wins == 10
    assert group.differences[0].p < 0.01


def test_equal_methods_are_equal_and_few_problems_tell_nothing():
    rows = [row(f"p{k}", m, 1, 1.0 + k) for k in range(8) for m in (A, B, C)]
    found = compared(rows)
    (group,) = found.groups
    assert group.friedman == 1.0
    assert {one.corrected for one in group.differences} == {1.0}
    assert {one.ties for one in group.differences} == {8}
    (few,) = compared([r for r in rows if r["problem"] in ("p0", "p1")]).groups
    assert few.friedman is None
    assert few.differences == []
    assert compared([]).summaries == []
    assert compared([]).groups == []


def test_what_differs_by_rounding_is_a_tie():
    rows = [row(f"p{k}", m, 1, (1.0 + k) * (1 + 1e-11 * j)) for k in range(8) for j, m in enumerate((A, B, C))]
    (group,) = compared(rows).groups
    assert {one.ties for one in group.differences} == {8}


def test_searches_are_held_against_the_best_of_them_too():
    rows = [row("p", A, 1, 2.2), row("p", A, 2, 2.4), row("p", B, 1, 2.0 + 1e-7), row("p", B, 2, 2.0)]
    rows[-1]["parameters"] = {"f": 0.5, "elbow": "positive"}
    found = compared([*rows, proof("p", 1.0, 1.5)])
    a, b, proved = found.summaries
    assert a.behind == pytest.approx(tuple(np.percentile([0.1, 0.2], [25, 50, 75])))
    assert a.quartiles == pytest.approx(tuple(np.percentile([1.2, 1.4], [25, 50, 75])))
    assert (a.reached, b.reached) == (0, 2)
    assert np.isnan(proved.behind).all()
    (case,) = found.cases
    assert (case.lower_bound, case.best, case.searched) == (1.0, 1.5, 2.0)
    assert case.at == {"f": 0.5}
    assert case.behind == {A: pytest.approx(0.15), B: pytest.approx(2.5e-8)}


def test_problems_that_no_search_solves_count_for_none_of_them():
    rows = [row("p", m, s, 1.0 + s) for m in (A, B) for s in range(4)]
    rows += [row("q", m, s, np.inf) for m in (A, B) for s in range(4)]
    found = compared([*rows, proof("p", 1.0, 1.0), proof("q", 1.0, 1.1)])
    assert (found.problems, found.proved, found.searched) == (2, 2, 1)
    search, _, proved = found.summaries
    assert search.quartiles == pytest.approx((0.75, 1.5, 2.25))
    assert (search.runs, search.solved) == (8, 4)
    assert proved.quartiles[2] == pytest.approx(0.075)
    assert found.groups[0].problems == 1


def test_planners_are_compared_apart_and_where_their_optimizers_are_the_same():
    plain, shifted = ([Method(planner, name) for name in "AB"] for planner in ("plain", "shifted"))
    costs = {plain[0]: 1.0, plain[1]: 1.2, shifted[0]: 1.0, shifted[1]: 1.5}
    rows = [row(f"p{k}", method, 1, (1.0 + k) * cost) for k in range(8) for method, cost in costs.items()]
    found = compared(rows)
    assert [(group.name, group.methods) for group in found.groups] == [("plain", plain), ("shifted", shifted)]
    assert [one.rank for one in found.summaries] == [1.0, 2.0, 1.0, 2.0]
    assert [(one.first, one.second, one.wins, one.ties) for one in found.across] == [
        (plain[0], shifted[0], 0, 8), (plain[1], shifted[1], 8, 0),
    ]  # fmt: skip
    assert found.across[1].corrected == pytest.approx(2 * stats.wilcoxon(np.arange(1, 9)).pvalue)


def test_planners_with_one_optimizer_each_are_compared_together():
    singles = [Method("one", "A"), Method("two", "B")]
    found = compared([row(f"p{k}", m, 1, 1.0 + j) for k in range(7) for j, m in enumerate(singles)])
    (group,) = found.groups
    assert (group.name, group.methods) == ("", singles)
    assert group.differences[0].wins == 7


def test_bands_are_excesses_over_the_best_search_with_branches_side_by_side():
    histories = [[{"best": [None, 4.0, 3.0]}, {"best": [3.5, 2.0]}], [{"best": [2.5, 2.5]}]]
    rows = [row("p", A, s, [2.0, 2.5][s], history=history) for s, history in enumerate(histories)]
    found = compared([*rows, proof("p", 1.0, 1.0)])
    np.testing.assert_allclose(found.bands[A], [[0.75, 0.0, 0.0], [0.25] * 3])
