"""The report's words: every number is of this run, every sentence follows from the numbers."""

import ast
import copy
import re
from importlib import resources
from pathlib import Path

import pytest

from selfmotion.report import cases, seed_3r, seed_6r, seed_runs, verdict
from selfmotion.report.figures import FIGURES
from selfmotion.report.seed_shortest import Answer
from selfmotion.report.text import report_text

PACKAGE = resources.files("selfmotion.report")


def test_the_report_shows_every_row_beside_the_paper(files, results, options):
    text = files["report.md"].decode()
    for name, case in results["cases"].items():
        front = "" if name == "3R" else f"{name} | "
        for label, line in case["table"].items():
            row = next(row for row in text.splitlines() if row.startswith(f"| {front}{label} |"))
            assert f"| {line['fitness']:.8f} |" in row
            if line["printed"]:
                assert f"| {line['printed']['fitness']:.9g} | {line['printed']['f']:.4f} |" in row
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


@pytest.mark.parametrize("best", ["GA", "PSO canonical"])
def test_a_number_that_is_shown_cannot_be_missing(results, best):
    """Whatever changes the text when it changes, must stop the report when it is gone."""
    results["best"] = results["six"]["best"] = best
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
    assert {at[1:] for at in shown if at[0] == "cases" and len(at) == 6 and at[2] == "comparison"} == {
        (name, "comparison", copy_name, label, key)
        for name in seed_runs.CASES
        for copy_name, rows in results["cases"][name]["comparison"].items()
        for label in rows
        for key in per_run
    }
    for name, case in results["cases"].items():
        assert ("cases", name, "scan", "fitness") in shown
        for label, line in case["table"].items():
            at = ("cases", name, "table", label)
            assert {(*at, key) for key in ("fitness", "f", "excess")} <= shown
            if line["printed"]:
                assert {(*at, "printed", "fitness"), (*at, "printed", "f"), (*at, "computed_at_printed_f")} <= shown
    checked = ("cost", "cost_error", "l1_travel", "max_tracking_error", "min_limit_margin")
    for key in (*checked, "cost_sampled", "l2_travel", "max_joint_step"):
        assert ("cases", "3R", "table", best, key) in shown
    for at in (("motion",), ("whole_arm", "moving"), ("whole_arm", "from_start"), ("whole_arm", "free")):
        assert {("six", *at, key) for key in checked} <= shown
    for searched, rows in results["six"]["sums"].items():
        for label in rows:
            for counted in seed_6r.READINGS:
                for kind in ("sampled", "integral"):
                    assert ("six", "sums", searched, label, counted, kind) in shown
    for name in results["shortest"]:
        proved = {("shortest", name, kind, key) for kind in ("shortest", "free") for key in ("cost", "lower_bound")}
        families = {("shortest", name, kind, "cost") for kind in ("sinusoid", "harmonics", "spline")}
        assert proved | families | {("shortest", name, "start")} <= shown
    assert len(shown) > 300


# Names and places in the paper; no number that anything computes.
NAMES = ("3R", "6R", "(22)", "sin(2π f r)", "(1a)", "l1 ", "l1_travel", "l2 ", "utf-8")


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
    assert cells == list(seed_3r.MISPRINTS)


# The verdict follows the numbers.


@pytest.fixture
def numbers(results):
    """Results in which nothing differs: everyone finds the optimum with every seed, and the paper is right."""
    for case in results["cases"].values():
        for rows in case.get("comparison", {}).values():
            for line in rows.values():
                line.update(median=1e-8, found=results["seeds"])
        for label in cases.PAPER:
            line = case["table"][label]
            line["computed_at_printed_f"] = line["printed"]["fitness"]
        case["scan"]["fitness"] = min(case["table"][label]["printed"]["fitness"] for label in cases.PAPER)
    return results


@pytest.fixture
def three(numbers):
    """Results on the 3R arm among them."""
    return numbers["cases"]["3R"]


@pytest.mark.parametrize("name", ["3R", *seed_6r.NAMES])
def test_verdict_on_the_printed_values(numbers, name):
    case = numbers["cases"][name]
    assert "values follow from the printed data" in verdict.on_printed_values(numbers, name)
    case["table"]["GA"]["computed_at_printed_f"] += 0.25
    assert "do not follow" in (text := verdict.on_printed_values(numbers, name))
    assert "0.000 to 0.250" in text
    assert "No frequency" not in text
    assert "The least F" not in text
    case["scan"]["fitness"] += 1e-9
    assert "is printed for PSO" in verdict.on_printed_values(numbers, name)
    case["scan"]["fitness"] -= 0.125
    assert text in verdict.on_printed_values(numbers, name)
    assert "The least F is lower than the least printed one, by 0.125." in verdict.on_printed_values(numbers, name)


def test_verdict_on_who_finds_the_optimum(numbers, three):
    plain = three["comparison"]["plain"]
    plain["GA"]["found"], plain["PSO"]["found"] = 1, 0
    text = verdict.on_seeds(numbers, "3R")[0]
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
def test_verdict_on_the_ranking(numbers, three, medians, found, says):
    for label, median in medians.items():
        three["comparison"]["plain"][label].update(median=median, found=found[label])
    three["lower_than"] = {"GA": 3, "GWO": 0}
    text = verdict.on_seeds(numbers, "3R")[1]
    assert "**The paper ranks** PSO, GWO, GA," in text
    assert says in text
    assert "lower than GA with every seed and GWO with no seed." in text


def test_verdict_on_chance(numbers, three):
    plain = three["comparison"]["plain"]
    plain["random search"]["median"] = 1e-3
    assert "every optimizer did better" in verdict.on_seeds(numbers, "3R")[2]
    plain["PSO"]["median"] = 2e-3
    assert "median excess of 1.0e-03; PSO did worse" in verdict.on_seeds(numbers, "3R")[2]


def test_verdict_on_the_shift(numbers, three):
    shifted = three["comparison"]["shifted"]
    text = verdict.on_seeds(numbers, "3R")[3]
    assert "1.0e-08, no more and no less than before; it finds the optimum with every seed, as before." in text
    assert "by less than 1e-12, and they find the optimum exactly as often" in text
    shifted["GWO"].update(median=2.5e-6, found=1)
    shifted["GA"].update(median=3e-8, found=2)
    text = verdict.on_seeds(numbers, "3R")[3]
    assert "2.5e-06 instead of 1.0e-08, 250 times as much" in text
    assert "with 1 of 3 seeds instead of with every seed" in text
    assert "by 2.0e-08 at most, and they find the optimum as often as before, except GA." in text
    shifted["GWO"]["median"] = 1e-9
    assert "10 times less" in verdict.on_seeds(numbers, "3R")[3]


def test_verdict_on_equal_printed_values(numbers):
    """PSO and GWO are printed alike: either may be the better one."""
    moving = numbers["cases"]["moving base"]
    plain = moving["comparison"]["plain"]
    plain["GA"].update(median=1e-3, found=0)
    plain["GWO"].update(median=0.0)
    text = verdict.on_seeds(numbers, "moving base")[1]
    assert "**The paper ranks** PSO = GWO, GA, from" in text
    assert "order is GWO (< 1e-12), PSO (1.0e-08), GA" in text
    assert "order holds." in text
    plain["GWO"].update(median=2e-3)
    assert "order holds by the count only." in verdict.on_seeds(numbers, "moving base")[1]


def test_verdict_on_an_optimum_on_the_wall(numbers):
    text = verdict.on_seeds(numbers, "moving base")[0]
    assert "on the wall of the box, f = 0:" in text
    assert "wall" not in verdict.on_seeds(numbers, "fixed base")[0]


def test_verdict_on_what_modules_cost(results):
    six = results["six"]
    six["motion"]["cost"] = 15.0
    for name, cost in (("moving", 10.0), ("from_start", 8.0), ("free", 7.5)):
        six["whole_arm"][name]["cost"] = cost
    text = verdict.on_modules(results)
    assert "2.00 times" in text
    assert "the modules pay 9.0000, and 2.0000 would do from the same start posture, 1.5000 from the best" in text
    six["motion"]["cost"] = 7.5
    assert "Nothing shorter was found" in verdict.on_modules(results)


@pytest.fixture
def answered(results):
    """The 3R case as it may be answered: printed 4.84829399 at least, and 5.2775 by the best sinusoid."""
    found = results["shortest"]["3R"]
    found["sinusoid"]["cost"] = 5.2775112
    found["shortest"].update(cost=4.8894466, cost_error=3e-12, lower_bound=4.88903987)
    found["free"].update(cost=4.65, cost_error=3e-12, lower_bound=4.64)
    for kind in Answer._fields:
        found[kind]["cost_sampled"] = found[kind]["cost"]
    found["spline"]["cost_sampled"] -= 2.1e-5
    return results


def test_verdict_on_a_printed_value_below_the_bound(answered):
    text = verdict.on_shortest(answered, "3R")
    assert "**3R: 5.2775 → 4.8894, proved within 0.0084 % of the best possible.**" in text
    assert "costs 7.9 % more" in text
    assert "The printed F = 4.84829 cannot be attained from the printed data:" in text
    assert "u = 0.3 costs at least 4.8890 as an integral, which is more by 0.041; chord sums" in text
    assert "less than integrals by 3e-05 at most for these motions. From another" in text
    assert "From another start it could: the shortest motion of all costs 4.6500." in text
    answered["shortest"]["3R"]["free"].update(cost=4.9, lower_bound=4.89999)
    assert "Nor from any other start: there nothing costs less than 4.8999." in verdict.on_shortest(answered, "3R")
    answered["shortest"]["3R"]["free"].update(lower_bound=4.8)
    assert verdict.on_shortest(answered, "3R").endswith("for these motions.")


def test_verdict_on_a_printed_value_above_the_bound(answered):
    answered["shortest"]["3R"]["shortest"].update(cost=4.848, lower_bound=4.847)
    text = verdict.on_shortest(answered, "3R")
    assert "cannot be attained" not in text
    assert "does not rule out the printed F = 4.84829: there are motions that cost less." in text
    assert "none of the paper's sinusoids does: by the dense scan they cost at least 5.2775." in text
    answered["cases"]["3R"]["scan"]["fitness"] = 4.8
    assert "none of" not in verdict.on_shortest(answered, "3R")


def test_bounds_are_rounded_down_and_distances_up(answered):
    row = next(
        row
        for row in report_text({**answered, "run": {"options": "", "wall_time_s": 0.0}}).splitlines()
        if row.startswith("| 3R | u = 0.3 |")
    )
    assert row.endswith("| 4.889447 | 4.889039 | 0.0084 % |")
    answered["shortest"]["3R"]["shortest"].update(lower_bound=4.8890399999)
    text = report_text({**answered, "run": {"options": "", "wall_time_s": 0.0}})
    assert "| 4.889447 | 4.889039 | 0.0084 % |" in text


def test_chord_sums_are_as_far_off_as_the_farthest(answered):
    for found in answered["shortest"].values():
        for one in found.values():
            if isinstance(one, dict):
                one["cost_sampled"] = one["cost"]
    answered["shortest"]["moving base"]["free"]["cost_sampled"] -= 3.1e-4
    assert "less by 4e-04 at most" in verdict.on_chords(answered)
