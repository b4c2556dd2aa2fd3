"""The report of the seed's study: every number is of this run, printed ones are the paper's."""

import json

import pytest

from selfmotion.report import FILES, seed_study
from selfmotion.report.reproduce import _report, reproduce


@pytest.fixture(scope="module")
def files():
    return reproduce(1, "selfmotion reproduce --out out --seed 1")


@pytest.fixture(scope="module")
def results(files):
    return json.loads(files["results.json"])


def test_it_writes_what_it_announces(files):
    assert set(files) == set(FILES)
    assert {name for name in files if name.endswith(".png")} == {
        f"{name}.png" for name in ("path", "domain", "joints", "postures", "evolution")
    }


def test_printed_values_are_the_paper_s(results):
    rows = {row["label"]: row for row in results["rows"]}
    assert rows["GA"]["printed"] == {"fitness": 4.8486, "f": 0.5562}
    assert rows["PSO"]["printed"] == {"fitness": 4.84829399, "f": 0.5329}
    assert rows["GWO"]["printed"] == {"fitness": 4.84829414, "f": 0.533}
    assert rows["PSO canonical"]["printed"] is None


def test_computed_values_are_of_this_run(results):
    for row in results["rows"]:
        f = row["parameters"]["f"]
        assert row["cost_sampled"] == pytest.approx(seed_study.fitness(f)[0], abs=1e-12)
        assert row["cost_sampled"] >= results["dense_scan"]["fitness"] - 1e-12
        assert row["evaluations"] == 2000
    best = min(row["cost_sampled"] for row in results["rows"])
    assert best == pytest.approx(5.277515, abs=2e-6)


def test_the_report_shows_every_row_beside_the_paper(files, results):
    text = files["report.md"].decode()
    for row in results["rows"]:
        assert f"| {row['label']} |" in text
        assert f"{row['cost_sampled']:.8f}" in text
    assert "4.84829399" in text
    assert "do not follow from the printed data" in text
    assert "selfmotion reproduce --out out --seed 1" in text


@pytest.mark.parametrize("missing", ["dense_scan", "machine", "versions", "rows", "seed"])
def test_a_number_that_was_not_computed_is_an_error(results, missing):
    with pytest.raises(KeyError):
        _report({key: value for key, value in results.items() if key != missing})


def test_a_missing_value_of_a_row_is_an_error(results):
    rows = [{key: value for key, value in row.items() if key != "cost_sampled"} for row in results["rows"]]
    with pytest.raises(KeyError):
        _report({**results, "rows": rows})


def test_the_same_seed_gives_the_same_report_but_for_times(results):
    again = json.loads(reproduce(1, results["command"])["results.json"])
    for one, two in zip(results["rows"], again["rows"], strict=True):
        assert {**one, "wall_time_s": 0} == {**two, "wall_time_s": 0}
