"""Study files: which runs they make, what identifies a run, and what is said of wrong ones."""

import json
from pathlib import Path

import pytest

import selfmotion as sm
from selfmotion.errors import InvalidInputError
from selfmotion.study import Run

EXAMPLES = Path(__file__).parents[2] / "examples"
PROOF = {"proof": {"kind": "global", "gap": 1e-2}}


def test_every_problem_meets_every_planner_with_every_optimizer_and_seed(study_file):
    study = sm.Study.load(study_file())
    assert study.name == "small"
    found = [(run.problem, run.planner, run.optimizer, run.seed) for run in study.runs]
    expected = []
    for problem in ("three curve", "three line"):
        expected += [(problem, "sinusoid", name, seed) for name in ("PSO", "GWO") for seed in (1, 2, 3)]
        expected.append((problem, "proof", "", None))
    assert found == expected
    assert len(study.unique()) == len(study.runs)


def test_a_run_has_all_that_its_outcome_depends_on(study_file):
    run = sm.Study.load(study_file()).runs[4]
    data = json.loads(run.text)
    assert data["problem"]["arm"]["links"] == [30, 30, 20]
    assert data["problem"]["samples"] == 200
    assert data["planner"]["optimizer"]["kind"] == "gwo"
    assert data["seed"] == 2


def test_the_same_data_in_any_order_and_place_is_the_same_run(study_file, tmp_path):
    one, other = {"a": 1, "b": [1.5, None]}, {"b": [1.5, None], "a": 1}
    assert Run("m:f", one).id == Run("m:f", other, "x", "y", "z", 3, "/elsewhere").id
    assert len({Run("m:f", one).id, Run("m:g", one).id, Run("m:f", {**one, "a": 2}).id}) == 3
    here = sm.Study.load(study_file())
    (tmp_path / "deeper").mkdir()
    there = sm.Study.load(study_file("deeper/other.yaml", study="renamed"))
    assert [run.id for run in here.runs] == [run.id for run in there.runs]
    # What is known of a run must outlive versions: a change of this number is one of the store's schema.
    assert Run("m:f", one).id == "83b5748d3d179061bf626280022daddd"


def test_two_names_for_the_same_are_one_run(study_file):
    optimizer = {"kind": "random", "population": 4, "iterations": 2}
    study = sm.Study.load(study_file(optimizers={"one": optimizer, "other": dict(optimizer)}, options={}))
    assert len(study.runs) == 14
    assert len(study.unique()) == 8


def test_problem_files_bring_their_planners(study_file):
    file = study_file(problems={"files": [str(EXAMPLES / "seed_3r.yaml"), str(EXAMPLES / "seed_3r_global.yaml")]},
                      options=None, planners=None, optimizers=None)  # fmt: skip
    runs = sm.Study.load(file).runs
    assert [(Path(run.problem).name, run.planner, run.optimizer, run.seed) for run in runs] == [
        ("seed_3r.yaml", "sinusoid", "pso", 1),
        ("seed_3r.yaml", "sinusoid", "pso", 2),
        ("seed_3r.yaml", "sinusoid", "pso", 3),
        ("seed_3r_global.yaml", "global", "", None),
    ]


def test_an_optimizer_around_another_runs_with_each_of_them(study_file):
    sinusoid = {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4]}
    planners = {"plain": sinusoid, "shifted": {**sinusoid, "optimizer": {"kind": "shifted", "shift": 2.5}}}
    runs = sm.Study.load(study_file(planners=planners, seeds=[4])).runs[:4]
    assert [(run.planner, run.optimizer) for run in runs] == [
        ("plain", "PSO"), ("plain", "GWO"), ("shifted", "PSO"), ("shifted", "GWO"),
    ]  # fmt: skip
    inner = runs[1].specification["planner"]["optimizer"]
    assert inner["kind"] == "gwo"
    assert runs[3].specification["planner"]["optimizer"] == {"kind": "shifted", "shift": 2.5, "optimizer": inner}
    (whole,) = {run.optimizer for run in sm.Study.load(study_file(
        planners={"own": {**sinusoid, "optimizer": {"kind": "shifted", "optimizer": {"kind": "ga"}}}}, optimizers=None,
    )).runs}  # fmt: skip
    assert whole == "shifted"


def test_without_seeds_planners_keep_their_own(study_file):
    optimizers = {"GA": {"kind": "ga", "seed": 7}}
    runs = sm.Study.load(study_file(seeds=None, optimizers=optimizers)).runs
    assert [(run.optimizer, run.seed) for run in runs] == [("GA", None), ("", None)] * 2
    assert runs[0].specification["planner"]["optimizer"]["seed"] == 7


def test_random_problems_are_named_by_generator_and_seed(study_file):
    problems = {"random": {"kind": "reachable", "count": 3, "seed": 5}}
    runs = sm.Study.load(study_file(problems=problems, options=None, planners=PROOF, optimizers=None)).runs
    assert [run.problem for run in runs] == ["reachable 5", "reachable 6", "reachable 7"]
    assert runs[0].specification["problem"] == {"random": {"kind": "reachable", "seed": 5}}


def test_a_file_that_a_path_is_read_from_is_part_of_the_run(study_file, tmp_path):
    points = tmp_path / "points.csv"
    points.write_text("x,y\n50,-10\n60,20\n")
    paths = {"from file": {"kind": "file", "file": "points.csv"}}
    arms = {"three": {"kind": "planar", "links": [30, 30, 20]}}
    given = {"problems": {"arms": arms, "paths": paths}, "planners": PROOF, "optimizers": None, "options": None}
    (before,) = sm.Study.load(study_file(**given)).runs
    assert before.work().specification["folder"] == str(tmp_path)
    points.write_text("x,y\n50,-10\n60,21\n")
    (after,) = sm.Study.load(study_file(**given)).runs
    assert before.id != after.id
    outcomes = sm.run_study(sm.Study("tried", (before, after))).rows()
    assert [(row.status, row.failure and row.failure["message"]) for row in outcomes] == [
        ("failed", "files: has changed since the study was read (got 'points.csv'); run the study again"),
        ("done", None),
    ]


WRONG = [
    ({"study": "my study"}, "study: ", "my study"),
    ({"study": None}, "study: is missing", ""),
    ({"seed": 3}, "seed: is not a known field", "did you mean 'seeds'?"),
    ({"problems": {}}, "problems: names no problem", "random: {kind"),
    (
        {"problems": {"arms": {"a": {"kind": "planar", "links": [1, 1, 1]}}}},
        "problems.paths: is missing beside",
        "both",
    ),
    (
        {"problems": {"files": ["nowhere.yaml"]}, "options": None},
        "problems.files.0: nowhere.yaml: does not exist",
        "check the name",
    ),
    ({"problems": {"random": {"kind": "wild", "count": 2}}}, "problems.random.kind: is not known", "'reachable'"),
    ({"problems": {"random": {"kind": "nR", "count": 0}}}, "problems.random.count", "got 0"),
    ({"options": {"elbow": "up"}}, "options.elbow", "'up'"),
    ({"options": {"sample": 9}}, "options.sample: is not a known field", "did you mean 'samples'?"),
    ({"planners": {"s": {"kind": "sinusiod"}}}, "planners.s.kind", "sinusoid"),
    ({"planners": {"s": {"kind": "sinusoid", "amplitude": ["x"]}}}, "planners.s.amplitude.0: is not a number", "'x'"),
    ({"planners": None}, "planners: is missing", "three curve"),
    ({"planners": PROOF}, "optimizers: is of no use", "leave it out"),
    ({"optimizers": None}, "planners.sinusoid.optimizer: is missing", ""),
    (
        {
            "planners": {"s": {"kind": "sinusoid", "amplitude": [1], "optimizer": {"kind": "shifted"}}},
            "optimizers": None,
        },
        "planners.s.optimizer.optimizer: is missing",
        "",
    ),
    ({"optimizers": {"P": {"kind": "pso", "population": 0}}}, "optimizers.P.population", "0"),
    ({"optimizers": {"P": {"kind": "pso", "seed": 2}}}, "optimizers.P.seed: is given beside the study's seeds", "2"),
    ({"seeds": [1, 1]}, "seeds: is empty or names one twice", "[1, 1]"),
    ({"seeds": {"count": 1_000_000}}, "makes 4000002 runs", "split"),
]


@pytest.mark.parametrize(("changes", "says", "and_says"), WRONG, ids=lambda value: str(value)[:40])
def test_what_is_wrong_is_said_with_its_place(study_file, changes, says, and_says):
    file = study_file(**changes)
    with pytest.raises(InvalidInputError) as caught:
        sm.Study.load(file)
    assert str(caught.value).startswith(f"{file}: {says}") or says in str(caught.value)
    assert and_says in str(caught.value)


def test_a_wrong_arm_is_said_where_the_study_has_it(study_file):
    arms = {"good": {"kind": "planar", "links": [30, 30, 20]}, "bad": {"kind": "planar", "links": [30, -1, 20]}}
    paths = {"line": {"kind": "line", "start": [50, -10], "end": [60, 20]}}
    with pytest.raises(InvalidInputError, match=r"problems\.arms\.bad\.links"):
        sm.Study.load(study_file(problems={"arms": arms, "paths": paths}))
    wrong = {"line": {"kind": "line", "start": [50, -10], "end": [50, -10]}}
    with pytest.raises(InvalidInputError, match=r"problems\.paths\.line"):
        sm.Study.load(study_file(problems={"arms": {"good": arms["good"]}, "paths": wrong}))
