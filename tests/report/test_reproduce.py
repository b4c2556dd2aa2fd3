"""The command's files: announced, the same every time, in part the same as whole."""

import json

import pytest

from selfmotion.errors import InvalidInputError
from selfmotion.report import Study, cases, file_names, reproduce, seed_3r, seed_6r, seed_runs, seed_shortest
from selfmotion.report.figures import FIGURES


def test_it_writes_what_it_announces(files):
    assert list(files) == file_names()
    assert set(files) == {"report.md", "report.html", "results.json"} | {
        f"{name}.{suffix}" for name in FIGURES for suffix in ("png", "svg", "json")
    }


def test_the_same_command_gives_the_same_bytes_whatever_the_number_of_processes(study, files, results, options):
    other = Study(seed=1, seeds=3, workers=2)
    # These take long, are planned in one process anyway, and planners have tests of their own.
    other.six, other.shortest = study.six, study.shortest
    again = reproduce(other, options)
    for name in files:
        if name.endswith((".png", ".svg")) or name.removesuffix(".json") in FIGURES:
            assert again[name] == files[name], name
    assert _without_times(json.loads(again["results.json"])) == _without_times(results)


def _without_times(value):
    if isinstance(value, dict):
        return {key: _without_times(one) for key, one in value.items() if key != "wall_time_s"}
    return value


def test_another_seed_gives_other_figures(files):
    other = reproduce(Study(seed=2, seeds=3), only=["fig12a_joints"])
    assert other["fig12a_joints.json"] != files["fig12a_joints.json"]


@pytest.mark.parametrize("name", FIGURES)
def test_one_figure_alone_is_that_of_the_whole_report(files, study, name):
    alone = reproduce(study, only=[name])
    assert list(alone) == file_names([name])
    for file, data in alone.items():
        assert files[file] == data


@pytest.mark.parametrize(
    ("name", "needs"),
    [
        ("fig10a_path", set()),
        ("domain_causes", set()),
        ("fig12a_joints", {"plans"}),
        ("fig11_evolution", {"runs 3R"}),
        ("seeds_spread", {"runs 3R"}),
        ("fig13_modules", {"plans absolute"}),
        ("fig15_evolution", {"runs fixed base"}),
        ("seeds_spread_modules", {"runs fixed base", "runs moving base"}),
        ("fig17b_true", {"plans absolute"}),
        ("shortest_motions", {"answer 3R", "answer fixed base", "answer moving base", "shortest"}),
        ("shortest_proof", {"answer 3R", "answer fixed base", "answer moving base"}),
    ],
)
def test_one_figure_runs_only_what_it_needs(monkeypatch, study, name, needs):
    ran = set()
    # All of it is made before anything is replaced: what a study has not made yet it would ask the replacements for.
    three, six, whole = study.three.plans, {one: study.six.plans[one] for one in study.six.plans}, study.six.whole_arm
    runs = {one: case.runs for one, case in study.cases.items()}

    def noting(what, value):
        return lambda *arguments: ran.add(what(*arguments)) or value(*arguments)

    monkeypatch.setattr(seed_3r, "plans", noting(lambda *_: "plans", lambda *_: three))
    monkeypatch.setattr(seed_6r, "plans", noting(lambda one, *_: f"plans {one}", lambda one, *_: six[one]))
    monkeypatch.setattr(seed_6r, "whole_arm", noting(lambda *_: "whole arm", lambda *_: whole))
    answers, shortest = study.shortest.answers, study.shortest.without_limits
    monkeypatch.setattr(seed_shortest, "answer", noting(lambda one, *_: f"answer {one}", lambda one, *_: answers[one]))
    monkeypatch.setattr(seed_shortest, "shortest", noting(lambda *_: "shortest", lambda *_: shortest))
    monkeypatch.setattr(seed_runs, "many_seeds", noting(lambda one, *_: f"runs {one}", lambda one, *_: runs[one]))
    reproduce(Study(seed=1, seeds=3), only=[name])
    assert ran == needs


def test_a_figure_that_does_not_exist_is_named():
    with pytest.raises(InvalidInputError, match="fig99") as caught:
        reproduce(Study(), only=["fig10a_path", "fig99"])
    assert "fig10a_path" in caught.value.remedy


def test_progress_counts_every_stage_to_its_end(monkeypatch):
    monkeypatch.setattr(cases, "ITERATIONS", 2)
    seen = []
    study = Study(seed=1, seeds=2, progress=lambda *step: seen.append(step))
    assert study.three.plans
    assert study.cases["3R"].runs
    totals = [8, 20]
    for total in totals:
        done = [step[0] for step in seen if step[1] == total]
        assert done == list(range(1, total + 1))
    assert len(seen) == sum(totals)
