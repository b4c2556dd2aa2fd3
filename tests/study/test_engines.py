"""Engines: whichever works off a study, the rows are the same; and what becomes of workers that die."""

import ast
import threading
import time

import pytest
import study_tasks
from study_tasks import ENGINES, SMALL, contents, rows_of, runs, study

import selfmotion as sm
from selfmotion.errors import InvalidInputError
from selfmotion.study import Dask, InProcess, Processes, Store, run_study
from selfmotion.study.engines import Outcome, perform


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """A study with searches, proofs, an infeasible problem, a failing one, and random problems; and its rows."""
    import json

    paths = {**SMALL["problems"]["paths"], "too far": {"kind": "line", "start": [50, 0], "end": [90, 0]}}
    problems = {**SMALL["problems"], "paths": paths, "random": {"kind": "reachable", "count": 2}}
    file = tmp_path_factory.mktemp("planned") / "study.yaml"
    file.write_text(json.dumps({**SMALL, "problems": problems, "seeds": [1, 2]}))
    rows_of(file, "processes")  # compiles what is not compiled yet
    return file, rows_of(file, "in-process")


def test_results_are_those_of_plans_without_times(planned):
    file, found = planned
    case = sm.Study.load(file)
    kinds = {(run.problem, run.planner): [] for run in case.runs}
    for run in case.runs:
        kinds[run.problem, run.planner].append(found[run.id])
    assert all(row[0] == "done" and "'status': 'solved'" in row[1] for row in kinds["three curve", "sinusoid"])
    assert all("'status': 'infeasible'" in row[1] and "'blocked'" in row[1] for row in kinds["three too far", "proof"])
    assert all("'status': 'solved'" in row[1] for row in kinds["reachable 0", "proof"])
    assert all(row[0] == "failed" and row[3][0] == "InvalidInputError" for row in kinds["reachable 1", "sinusoid"])
    assert not any("seconds'" in row[1] or "wall_time" in row[1] for row in found.values())
    plan = sm.plan(
        sm.Problem(
            sm.PlanarArm([30, 30, 20], [None, (0, 3.141592653589793), None]), sm.Line([50, -10], [60, 20]),
            elbow="positive", samples=200,
        ),
        sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.GWO(population=8, iterations=10, bounds=(0, 5), seed=2)),
    )  # fmt: skip
    (run,) = [run for run in case.runs if (run.problem, run.optimizer, run.seed) == ("three line", "GWO", 2)]
    result, (search,) = ast.literal_eval(found[run.id][1]), ast.literal_eval(found[run.id][2])
    assert result["cost"] == pytest.approx(plan.cost, rel=1e-12)
    assert search["best"] == pytest.approx(plan.history[0].best, rel=1e-12)
    assert search["evaluations"] == plan.history[0].evaluations


@pytest.mark.parametrize("name", list(ENGINES)[1:])
def test_every_engine_gives_the_same_rows(planned, name):
    file, expected = planned
    assert rows_of(file, name) == expected


def test_work_is_taken_only_a_few_pieces_ahead():
    for engine, most in ((InProcess(), 1), (InProcess(2), 5), (Processes(1), 3)):
        taken = []
        work = (taken.append(run) or run.work() for run in runs("number", 100))
        outcomes = engine.outcomes(work)
        next(outcomes)
        assert len(taken) <= most
        outcomes.close()
        assert len(taken) <= most


def test_what_a_task_raises_or_returns_that_is_no_json_is_a_failure():
    (outcome,) = InProcess().outcomes(run.work() for run in runs("failing", 1))
    assert outcome.result is None
    assert '"type":"ArithmeticError"' in outcome.failure
    (outcome,) = InProcess().outcomes(run.work() for run in runs("no_json", 1))
    assert '"type":"ValueError"' in outcome.failure
    missing = runs("number", 1)[0].work()._replace(task="study_tasks:nothing")
    assert '"type":"AttributeError"' in perform(missing).failure


@pytest.mark.parametrize("engine", [InProcess(), InProcess(2), Processes(1)], ids=["here", "threads", "processes"])
def test_linear_algebra_has_one_thread(engine):
    import scipy.linalg  # noqa: F401 (what is to be limited must be loaded)
    from threadpoolctl import threadpool_limits

    with threadpool_limits(2):
        outcomes = list(engine.outcomes(run.work() for run in runs("threads", 4)))
        assert {outcome.result for outcome in outcomes} == {'{"threads":1}'}
        assert study_tasks.threads({}) == {"threads": 2}


def test_a_worker_that_dies_once_changes_no_row(tmp_path):
    fatal = tmp_path / "fatal"
    fatal.touch()
    some = [*runs("number", 6), *runs("deadly", 1, file=str(fatal), once=True), *runs("sleeping", 4, seconds=0.01)]
    found = contents(run_study(study(*some), engine=Processes(2)))
    assert not fatal.exists()
    assert found == contents(run_study(study(*some)))


@pytest.mark.parametrize("engine", ["processes", "dask"])
def test_a_run_that_always_kills_its_worker_fails_alone(tmp_path, engine):
    (tmp_path / "fatal").touch()
    deadly = runs("deadly", 1, file=str(tmp_path / "fatal"), once=False)
    store = run_study(study(*runs("number", 5), *deadly, *runs("sleeping", 3, seconds=0.01)), engine=ENGINES[engine]())
    rows = {row.id: row for row in store.rows()}
    assert rows.pop(deadly[0].id).failure["message"] == "its worker process ended"
    assert len(rows) == 8
    assert {row.status for row in rows.values()} == {"done"}


def test_a_dask_worker_that_is_killed_changes_no_row(tmp_path):
    fatal = tmp_path / "fatal"
    fatal.touch()
    some = [*runs("number", 3), *runs("deadly", 1, file=str(fatal), once=True), *runs("sleeping", 6, seconds=0.05)]
    found = contents(run_study(study(*some), engine=Dask(workers=2)))
    assert not fatal.exists()
    assert found == contents(run_study(study(*some)))


def test_no_scheduler_there_is_said(monkeypatch):
    monkeypatch.setattr("selfmotion.study.engines._PATIENCE", 1)
    with pytest.raises(InvalidInputError, match=r"--scheduler: does not answer .* is it running\?"):
        run_study(study(*runs("number", 1)), engine=Dask("tcp://127.0.0.1:1"))
    with pytest.raises(InvalidInputError, match="--scheduler: does not answer"):
        run_study(study(*runs("number", 1)), engine=Dask("nonsense://x"))


def test_an_address_of_a_scheduler_is_enough():
    from distributed import LocalCluster

    options = {"n_workers": 1, "threads_per_worker": 2, "processes": False, "dashboard_address": "127.0.0.1:0"}
    with LocalCluster(**options) as cluster:
        store = run_study(study(*runs("number", 5)), engine=Dask(cluster.scheduler_address))
    assert contents(store) == contents(run_study(study(*runs("number", 5))))


def test_an_engine_that_stops_in_the_middle_loses_nothing_and_ends_its_workers(tmp_path):
    store = Store(tmp_path / "study.sqlite")
    seen = []

    def stop(step):
        seen.append(step)
        if len(seen) == 5:
            raise KeyboardInterrupt

    case = study(*runs("sleeping", 4, seconds=0.0), *runs("sleeping", 6, seconds=30.0))
    case = study(*case.runs[:4], *runs("number", 1), *case.runs[4:])
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run_study(case, store, Processes(2), stop)
    assert time.monotonic() - began < 20  # not what the runs that sleep would have taken
    assert len(store.states()) == 5
    assert not [thread for thread in threading.enumerate() if "QueueManager" in thread.name]


def test_ctrl_c_that_a_planner_makes_an_answer_of_is_no_outcome(monkeypatch):
    """The global planner, interrupted, returns the best that it has: another run must not find that in the store."""
    import os
    import signal

    def swallowing(specification):
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(5)
        except KeyboardInterrupt:
            return {"status": "solved", "cost": 1.0}

    monkeypatch.setattr(study_tasks, "swallowing", swallowing, raising=False)
    store = Store()
    with pytest.raises(KeyboardInterrupt):
        run_study(study(*runs("number", 2), *runs("swallowing", 2)), store)
    assert len(store.states()) == 2
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_engine_that_gives_an_outcome_twice_makes_one_row(tmp_path):
    class Twice:
        def outcomes(self, work):
            for piece in work:
                outcome = perform(piece)
                yield outcome
                yield outcome._replace(result='{"status":"solved","cost":0.0}')

    store = Store(tmp_path / "study.sqlite")
    run_study(study(*runs("number", 3)), store, Twice())
    assert [row.result["cost"] for row in store.rows()] == [1.0, 0.5, 1 / 3]
    assert issubclass(Outcome, tuple)
