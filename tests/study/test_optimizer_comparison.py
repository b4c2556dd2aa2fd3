"""The comparison of the optimizers: a small one is run here, and the docs say what the committed one found."""

import csv
import importlib.util
import io
import re
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml

import selfmotion as sm
from selfmotion.study.report import report_files

ROOT = Path(__file__).parents[2]
FILE = ROOT / "benchmarks" / "optimizers_sinusoid.yaml"
KEPT = ROOT / "benchmarks" / "optimizers_sinusoid"
PAGE = (ROOT / "docs" / "optimizer-comparison.md").read_text("utf-8")
COPIES = ("plain", "shifted")
FRONT = {"differential evolution", "CMA-ES"}
SPECIFICATION = importlib.util.spec_from_file_location("comparison", ROOT / "docs" / "comparison.py")
comparison = importlib.util.module_from_spec(SPECIFICATION)
SPECIFICATION.loader.exec_module(comparison)


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The report of the study with two problems more than the paper's, two seeds and a coarse proof."""
    data = yaml.safe_load(FILE.read_text("utf-8"))
    data["problems"]["random"]["count"] = 2
    data["seeds"]["count"] = 2
    data["planners"]["proof"]["gap"] = 0.1
    file = tmp_path_factory.mktemp("study") / "small.yaml"
    file.write_text(yaml.safe_dump(data))
    study = sm.Study.load(file)
    return data, report_files(study, sm.run_study(study))


def test_a_small_one_finds_motions_near_the_best_and_only_the_wolves_care_for_the_shift(small):
    data, files = small
    problems, methods = rows(files["problems.csv"].decode()), rows(files["methods.csv"].decode())
    assert [row["problem"] for row in problems] == ["seed 3R", "sinusoid 0", "sinusoid 1"]
    assert all(row["solved"] == row["runs"] for row in methods)
    seed = problems[0]
    assert float(seed["best_search"]) == pytest.approx(5.2775214177, abs=1e-8)
    assert seed["at"].startswith("f=0.538")
    assert float(seed["lower_bound"]) <= float(seed["best"]) <= float(seed["best_search"])
    for name in data["optimizers"]:
        plain, shifted = ([float(row[f"{planner}, {name}"]) for row in problems] for planner in COPIES)
        if name == "GWO":
            assert plain != shifted
        else:
            np.testing.assert_allclose(plain, shifted, rtol=0.05, atol=1e-9)


def test_a_small_one_s_report_has_a_section_for_each_copy_and_one_for_both(small):
    text = small[1]["report.md"].decode()
    assert [line for line in text.splitlines() if line.startswith("###")] == ["### plain", "### shifted"]
    assert "![Spread](spread.png)" in text
    assert {"spread.png", "convergence.png"} <= small[1].keys()


# What was found, as it is committed.


def test_what_is_committed_is_all_of_the_study_and_none_of_it_failed():
    study = sm.Study.load(FILE)
    methods, problems = comparison.rows("methods"), comparison.rows("problems")
    assert sum(int(row["runs"]) for row in methods) == len(study.unique())
    assert {row["failed"] for row in methods} == {"0"}
    assert [row["problem"] for row in problems] == list(dict.fromkeys(run.problem for run in study.runs))
    assert {(row["planner"], row["optimizer"]) for row in methods} == {
        (run.planner, run.optimizer) for run in study.runs
    }
    assert sum(file.stat().st_size for file in KEPT.glob("*.csv")) < 100_000


def per_cent(value):
    return f"{100 * value:.0f} %"


class Pair(NamedTuple):
    """Problems on which the first of two methods is better and worse, and the corrected p-value."""

    wins: int
    losses: int
    p: float


def pairs(section):
    """The pairs of one section of the committed report."""
    text = (KEPT / "report.md").read_text("utf-8").split(f"### {section}\n")[1].split("\n#")[0]
    lines = [line.strip("| ").split(" | ") for line in text.split("p corrected")[1].splitlines()[2:] if " | " in line]
    found = {}
    for first, second, losses, _, _, p in lines:
        name, wins = first.rsplit(": ", 1)
        found[name, second] = Pair(int(wins), int(losses), float(p))
    return found


def facts():
    """What the page says in words, from the committed tables."""
    methods = {(row["planner"], row["optimizer"]): row for row in comparison.rows("methods")}
    problems = comparison.rows("problems")
    reached = {key: comparison.share(row) for key, row in methods.items() if row["optimizer"]}
    f = np.array([float(row["at"].removeprefix("f=")) for row in problems])
    over = np.array([float(row["best_search"]) / float(row["lower_bound"]) - 1 for row in problems])
    origin, moved = (float(methods[copy, "GWO"]["behind_median"]) for copy in COPIES)
    seed = problems[0]
    yield f"{len(problems)} problems instead of one"
    yield f"{len(problems) - 1} problems of the generator"
    yield f"in {reached['plain', 'GWO']} of its runs, the paper's PSO in {reached['plain', 'PSO seed']}."
    yield f"the other way round, {reached['shifted', 'GWO']} against {reached['shifted', 'PSO seed']}"
    yield f"below 1 in {(f < 1).sum()} of {len(f)} problems and never above {np.ceil(10 * f.max()) / 10:.1f}."
    yield f"In {(f < 1e-3).sum()} it is zero itself"
    yield f"excess {float(f'{moved / origin:.2g}'):.0f} times as large"
    across = pairs("The same optimizer with other planners")["plain, GWO", "shifted, GWO"]
    assert across.losses == 0
    yield f"worse on {across.wins} problems, better on none"
    plain, shifted = pairs("plain"), pairs("shifted")
    front = [p for pair, (_, _, p) in [*plain.items(), *shifted.items()] if set(pair) <= FRONT]
    behind = [p for pair, (_, _, p) in shifted.items() if "GWO" in pair and set(pair) & FRONT]
    after = [copy[pair].p for copy in (plain, shifted) for pair in copy if "PSO canonical" in pair and {*pair} & FRONT]
    assert (len(front), len(behind), len(after)) == (2, 2, 4)
    assert min(p for pair, (_, _, p) in plain.items() if "GWO" in pair and set(pair) & FRONT) > 0.2
    yield f"(p of {min(front):.2g} or more, corrected)"
    yield f"behind both (p of {max(after):.2g} or less)"
    yield f"(p of {max(behind):.2g} or less)"
    yield f"{reached['plain', 'differential evolution']} of its runs end at the best sinusoid"
    yield f"has {reached['plain', 'PSO canonical']} against its {reached['plain', 'PSO seed']}"
    yield f"itself costs {per_cent(np.median(over))} more than the proved bound in the median problem"
    yield f"more than {per_cent(np.percentile(over, 75))} in every fourth"
    yield f"f = {f[0]:.4f}, which costs {float(seed['best_search']):.4f} and {per_cent(over[0])} more than"


@pytest.mark.parametrize("fact", list(facts()))
def test_the_page_says_what_was_found(fact):
    assert fact in " ".join(PAGE.split())


def test_what_the_page_says_of_all_is_so():
    methods = {(row["planner"], row["optimizer"]): row for row in comparison.rows("methods")}
    ranks = {name: float(methods["plain", name]["mean_rank"]) for name in comparison.optimizers()}
    assert ranks["GA"] > ranks["random search"] > max(ranks[name] for name in ranks.keys() - {"GA", "random search"})
    for name in ranks.keys() - {"GWO"}:
        plain, shifted = (methods[copy, name] for copy in COPIES)
        for part in ("lower_quartile", "median", "upper_quartile"):
            assert float(shifted[f"behind_{part}"]) == pytest.approx(float(plain[f"behind_{part}"]), rel=0.02, abs=1e-9)
        assert abs(int(plain["reached"]) - int(shifted["reached"])) <= 2e-3 * int(plain["runs"])
    for name in ranks.keys() - {"GA", "random search"}:
        assert float(methods["shifted", name]["behind_median"]) < 1e-5


def test_the_tables_of_the_page_have_every_optimizer_and_copy(tmp_path):
    comparison.write_comparison(tmp_path)
    for name, lines in (("optimizers_compared", 14), ("optimizers_seed_3r", 7)):
        assert f"_generated/{name}.md" in PAGE
        assert len((tmp_path / f"{name}.md").read_text("utf-8").splitlines()) == lines + 2


def test_a_number_of_the_page_that_is_not_there_is_found_out():
    assert not re.search("@[A-Z]+@", PAGE)
    assert all(fact not in PAGE.replace(" %", "") for fact in facts() if "%" in fact)
