"""The report's words: every number is of this run, every sentence follows from the numbers."""

import ast
import copy
import re
from importlib import resources
from pathlib import Path

import pytest

from selfmotion.report import seed_study, verdict
from selfmotion.report.figures import FIGURES
from selfmotion.report.text import report_text

PACKAGE = resources.files("selfmotion.report")


def test_the_report_shows_every_row_beside_the_paper(files, results, options):
    text = files["report.md"].decode()
    for label, line in results["table"].items():
        row = next(row for row in text.splitlines() if row.startswith(f"| {label} |"))
        assert f"{line['cost_sampled']:.8f}" in row
        if line["printed"]:
            assert f"{line['printed']['fitness']:.9g}" in row
    assert "do not follow from the printed data" in text
    assert f"selfmotion reproduce {options}" in text
    for name in FIGURES:
        assert f"\nselfmotion reproduce --only {name} {options}\n" in text
        assert f"]({name}.png)" in text


def _places(value, at=()):
    """Yield the way to every value of a tree of dicts, and to every branch."""
    if at:
        yield at
    if isinstance(value, dict):
        for key, one in value.items():
            yield from _places(one, (*at, key))


def _holder(results, at):
    for key in at[:-1]:
        results = results[key]
    return results


def _other(value):
    if isinstance(value, int | float):
        return value + 1 if isinstance(value, int) else value * 1.7 + 0.013
    return "another"


@pytest.mark.parametrize("best", seed_study.IN_TABLE)
def test_a_number_that_is_shown_cannot_be_missing(results, best):
    """Whatever changes the text when it changes, must stop the report when it is gone."""
    results["best"] = best
    text = report_text(results)
    shown = set()
    for at in _places(results):
        changed = copy.deepcopy(results)
        _holder(changed, at)[at[-1]] = _other(_holder(results, at)[at[-1]])
        try:
            differs = report_text(changed) != text
        except (KeyError, TypeError, ValueError, AttributeError):  # the report reads it and cannot use the other value
            differs = True
        if differs:
            shown.add(at)
            del _holder(changed, at)[at[-1]]
            with pytest.raises(KeyError):
                report_text(changed)
    assert {at[0] for at in shown} == set(results)
    per_run = {"best", "lower_quartile", "median", "upper_quartile", "worst", "found", "median_f_error"}
    assert {at[1:] for at in shown if at[0] == "comparison" and len(at) == 4} == {
        (copy_name, label, key)
        for copy_name, rows in results["comparison"].items()
        for label in rows
        for key in per_run
    }
    for label, line in results["table"].items():
        assert ("table", label, "cost_sampled") in shown
        assert ("table", label, "excess") in shown
        if line["printed"]:
            assert ("table", label, "printed", "fitness") in shown
            assert ("table", label, "computed_at_printed_f") in shown
    for key in (
        "cost",
        "cost_error",
        "l1_travel",
        "l2_travel",
        "max_tracking_error",
        "min_limit_margin",
        "max_joint_step",
    ):
        assert ("table", results["best"], key) in shown
    assert len(shown) > 120


# Names and places in the paper; no number that anything computes.
NAMES = ("3R", "(22)", "sin(2π f r)", "(1a)", "l1 ", "l2 ", "utf-8")


def _digits(text):
    for name in NAMES:
        text = text.replace(name, "")
    return [word for word in text.split() if any(character.isdigit() for character in word)]


def test_no_number_is_written_into_the_template():
    template = PACKAGE.joinpath("report.md.in").read_text(encoding="utf-8")
    assert _digits(re.sub(r"{[^{}]*}", "", template)) == []
    for figure in FIGURES.values():
        assert _digits(re.sub(r"{[^{}]*}", "", figure.caption + " " + figure.alt)) == []


@pytest.mark.parametrize("module", ["verdict.py", "text.py"])
def test_no_number_is_written_into_the_sentences(module):
    """Neither in plain strings nor between the fields of f-strings; docstrings and formats are something else."""
    tree = ast.parse(PACKAGE.joinpath(module).read_text(encoding="utf-8"))
    nodes = list(ast.walk(tree))
    skipped = {
        id(node.body[0].value)
        for node in nodes
        if isinstance(node, ast.Module | ast.FunctionDef) and isinstance(node.body[0], ast.Expr)
    }
    for node in nodes:
        if isinstance(node, ast.FormattedValue) and node.format_spec is not None:
            skipped |= {id(part) for part in ast.walk(node.format_spec)}
    strings = [
        node.value
        for node in nodes
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in skipped
    ]
    assert len(strings) > 20
    assert [word for text in strings for word in _digits(text)] == []


def test_misprints_are_those_of_the_docs():
    docs = (Path(__file__).parents[2] / "docs" / "mathematics.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\(.*)\|$", docs.split("## What the paper prints")[1].split("\n## ")[0], re.MULTILINE)
    cells = [tuple(cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", row)) for row in rows]
    assert cells == list(seed_study.MISPRINTS)


# The verdict follows the numbers.


@pytest.fixture
def numbers(results):
    """Results in which nothing differs: everyone finds the optimum with every seed, and the paper is right."""
    for rows in results["comparison"].values():
        for line in rows.values():
            line.update(median=1e-8, found=results["seeds"])
    for label in seed_study.PRINTED:
        line = results["table"][label]
        line["computed_at_printed_f"] = line["printed"]["fitness"]
    results["scan"]["fitness"] = 4.8
    return results


def test_verdict_on_the_printed_values(numbers):
    assert "values follow from the printed data" in verdict.on_printed_values(numbers)
    numbers["table"]["GA"]["computed_at_printed_f"] += 0.25
    assert "do not follow" in (text := verdict.on_printed_values(numbers))
    assert "0.000 to 0.250" in text
    assert "No frequency" not in text
    numbers["scan"]["fitness"] = 4.84829400
    assert "is printed for PSO." in verdict.on_printed_values(numbers)


def test_verdict_on_who_finds_the_optimum(numbers):
    plain = numbers["comparison"]["plain"]
    plain["GA"]["found"], plain["PSO"]["found"] = 1, 0
    text = verdict.on_seeds(numbers)[0]
    assert "GWO, PSO canonical and random search with every seed; GA with 1 of 3 seeds; PSO with no seed." in text


@pytest.mark.parametrize(
    ("medians", "found", "says"),
    [
        ({"PSO": 1e-9, "GWO": 2e-9, "GA": 3e-9}, {"PSO": 3, "GWO": 2, "GA": 1}, "order holds."),
        ({"PSO": 1e-9, "GWO": 2e-9, "GA": 3e-9}, {"PSO": 1, "GWO": 2, "GA": 3}, "order holds by the median only."),
        ({"PSO": 3e-9, "GWO": 2e-9, "GA": 1e-9}, {"PSO": 3, "GWO": 2, "GA": 1}, "order holds by the count only."),
        ({"PSO": 3e-9, "GWO": 2e-9, "GA": 1e-9}, {"PSO": 1, "GWO": 2, "GA": 3}, "order does not hold."),
    ],
)
def test_verdict_on_the_ranking(numbers, medians, found, says):
    for label, median in medians.items():
        numbers["comparison"]["plain"][label].update(median=median, found=found[label])
    numbers["lower_than"] = {"GA": 3, "GWO": 0}
    text = verdict.on_seeds(numbers)[1]
    assert "**The paper ranks** PSO, GWO, GA," in text
    assert says in text
    assert "lower than GA with every seed and GWO with no seed." in text


def test_verdict_on_chance(numbers):
    plain = numbers["comparison"]["plain"]
    plain["random search"]["median"] = 1e-3
    assert "every optimizer did better" in verdict.on_seeds(numbers)[2]
    plain["PSO"]["median"] = 2e-3
    assert "median excess of 1.0e-03; PSO did worse" in verdict.on_seeds(numbers)[2]


def test_verdict_on_the_shift(numbers):
    shifted = numbers["comparison"]["shifted"]
    text = verdict.on_seeds(numbers)[3]
    assert "no more and no less" in text
    assert "by less than 1e-12, and they find the optimum exactly as often" in text
    shifted["GWO"].update(median=2.5e-6, found=1)
    shifted["GA"].update(median=3e-8, found=2)
    text = verdict.on_seeds(numbers)[3]
    assert "2.5e-06 instead of 1.0e-08, 250 times as much" in text
    assert "with 1 of 3 seeds instead of with every seed" in text
    assert "by 2.0e-08 at most, and they find the optimum as often as before, except GA." in text
    shifted["GWO"]["median"] = 1e-9
    assert "10 times less" in verdict.on_seeds(numbers)[3]
