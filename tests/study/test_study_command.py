"""selfmotion study: what it prints, its exit codes, Ctrl-C, reports and exports."""

import csv
import io
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

QUICK = {
    "planners": {"sinusoid": {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4]}},
    "optimizers": {"PSO": {"kind": "pso", "population": 6, "iterations": 5, "bounds": [0, 5]},
                   "random": {"kind": "random", "population": 6, "iterations": 5, "bounds": [0, 5]}},
    "seeds": [3, 4],
}  # fmt: skip
HERE = ("--engine", "in-process")
# Measuring which lines are run, every process loads what it measures with, and writes about it when it is killed.
unmeasured = pytest.mark.skipif("coverage" in sys.modules, reason="is about the processes themselves")


@pytest.fixture
def quick(study_file):
    return study_file(**QUICK)


def test_a_study_is_run_told_and_not_run_again(run, quick, tmp_path):
    code, out, err = run("study", "status", quick)
    assert (code, err) == (0, "")
    assert out.startswith("small: 0 of 8 runs done, 0 failed, 8 left\n")
    assert not (tmp_path / "study.sqlite").exists()
    code, out, err = run("study", "run", quick, *HERE, "--limit", "3")
    assert (code, out, err) == (0, f"small: 3 of 8 runs done, 0 failed, 5 left\nkept in {tmp_path}/study.sqlite\n", "")
    code, out, _ = run("study", "run", quick, *HERE, "--json")
    assert code == 0
    assert json.loads(out) == {
        "study": "small", "runs": 8, "done": 8, "failed": 0, "left": 0, "others": 0,
        "methods": [
            {"planner": "sinusoid", "optimizer": name, "done": 4, "failed": 0, "left": 0} for name in ("PSO", "random")
        ],
    }  # fmt: skip
    before = (tmp_path / "study.sqlite").read_bytes()
    assert run("study", "run", quick, *HERE)[0] == 0
    assert (tmp_path / "study.sqlite").read_bytes()[100:] == before[100:]
    _, out, _ = run("study", "status", quick)
    assert out.splitlines()[1:] == [
        "planner   optimizer  done  failed  left", "sinusoid  PSO        4     0       0",
        "sinusoid  random     4     0       0",
    ]  # fmt: skip


def test_failed_runs_are_said_by_the_exit_code(run, study_file):
    planners = {"sinusoid": {"kind": "sinusoid", "offset": [3.0], "amplitude": [0.4]}}
    file = study_file(**{**QUICK, "planners": planners})
    code, out, err = run("study", "run", file, *HERE)
    assert code == 1
    assert "0 of 8 runs done, 8 failed, 0 left" in out
    assert err == "selfmotion: 8 runs failed; export them to see why, --retry does them again\n"
    assert run("study", "run", file, *HERE)[0] == 1
    assert run("study", "status", file)[0] == 0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--engine", "cloud"), "--engine: is not known (got 'cloud')"),
        (("--engine", "in-process", "--workers", "2"), "--workers: is given with --engine in-process"),
        (("--engine", "process", "--scheduler", "tcp://x:1"), "--scheduler: is given with --engine"),
        (("--workers", "0"), "Invalid value for '--workers'"),
        (("--store", "nowhere/x.sqlite", *HERE), "nowhere/x.sqlite: cannot be opened or made"),
    ],
)
def test_bad_options_are_said(run, quick, options, says):
    code, out, err = run("study", "run", quick, *options)
    assert (code, out) == (2, "")
    assert says in err
    assert err.count("\n") == 1


def test_bad_files_are_said(run, quick, tmp_path):
    assert run("study", "run", str(tmp_path / "none.yaml"))[0] == 2
    code, _, err = run("study", "status", quick, "--store", quick)
    assert code == 2
    assert "is no store of a study" in err
    code, out, _ = run("study", "status", quick, "--store", quick, "--json")
    assert json.loads(out)["status"] == "error"
    for target in ("rows.txt", "rows"):
        assert "is neither a CSV nor a Parquet file" in run("study", "export", quick, "--out", target)[2]


def test_a_report_says_what_the_rows_say(run, study_file, tmp_path):
    file = study_file()
    assert run("study", "run", file, *HERE)[0] == 0
    code, out, _ = run("study", "report", file, "--out", str(tmp_path / "report"))
    assert (code, out) == (0, f"{tmp_path}/report/report.md\n")
    text = (tmp_path / "report" / "report.md").read_text()
    assert "# Study small" in text
    assert "14 of 14 runs are done, 0 failed, 0 are left. 2 problems have a motion; of 2 of them" in text
    rows = list(csv.DictReader(io.StringIO((tmp_path / "report" / "runs.csv").read_text())))
    bounds = {row["problem"]: float(row["lower_bound"]) for row in rows if row["planner"] == "proof"}
    for name, seeded in (("sinusoid, PSO", True), ("proof", False)):
        own = [row for row in rows if row["optimizer"] == ("PSO" if seeded else "")]
        excess = [float(row["cost"]) / bounds[row["problem"]] - 1 for row in own]
        quartiles = [f"{value:.3g}" for value in np.percentile(excess, [25, 50, 75])]
        found = str(sum(value <= 1e-3 for value in excess))
        (line,) = [line for line in text.splitlines() if line.startswith(f"| {name} |") and line.count("|") > 5]
        assert line.split(" | ")[1:8] == [str(len(own)), "0", str(len(own)), found, *quartiles]


def test_a_report_of_searches_has_their_convergence(run, quick, tmp_path):
    assert run("study", "run", quick, *HERE)[0] == 0
    assert run("study", "report", quick, "--out", str(tmp_path / "report"))[0] == 0
    assert (tmp_path / "report" / "convergence.png").read_bytes().startswith(b"\x89PNG")
    text = (tmp_path / "report" / "report.md").read_text()
    assert "Tests need 6 problems at least" in text
    assert "![Convergence](convergence.png)" in text
    (tmp_path / "report" / "report.md").write_text("mine")
    code, _, err = run("study", "report", quick, "--out", str(tmp_path / "report"))
    assert code == 2
    assert "--force" in err


@pytest.mark.parametrize(("offset", "limit", "pictured"), [(0.3, 1, True), (0.3, 5, True), (3.0, 8, False)])
def test_a_report_of_little_or_nothing_is_one(run, study_file, tmp_path, offset, limit, pictured):
    planners = {"sinusoid": {"kind": "sinusoid", "offset": [offset], "amplitude": [0.4]}}
    file = study_file(**{**QUICK, "planners": planners})
    run("study", "run", file, *HERE, "--limit", str(limit))
    assert run("study", "report", file, "--out", str(tmp_path / "report"))[0] == 0
    assert (tmp_path / "report" / "convergence.png").exists() is pictured


def test_exports_have_every_row_and_every_digit(run, quick, tmp_path):
    from pyarrow import parquet

    from selfmotion.study import Store

    assert run("study", "run", quick, *HERE)[0] == 0
    for suffix in ("csv", "parquet"):
        code, out, _ = run("study", "export", quick, "--out", str(tmp_path / f"rows.{suffix}"))
        assert (code, out) == (0, f"8 rows written to {tmp_path}/rows.{suffix}\n")
    stored = {row.id: row for row in Store(tmp_path / "study.sqlite").rows()}
    rows = list(csv.DictReader(io.StringIO((tmp_path / "rows.csv").read_text())))
    table = parquet.read_table(tmp_path / "rows.parquet").to_pylist()
    assert len(rows) == len(table) == 8
    for text, typed in zip(rows, table, strict=True):
        row = stored[text["id"]]
        assert typed["id"] == row.id
        assert float(text["cost"]) == typed["cost"] == row.result["cost"]
        assert int(text["seed"]) == typed["seed"]
        assert typed["history"] == [[np.inf if best is None else best for best in row.history[0]["best"]]]
    assert [row["optimizer"] for row in rows[:4]] == ["PSO", "PSO", "random", "random"]


def test_parquet_without_pyarrow_names_the_extra(run, quick, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    code, _, err = run("study", "export", quick, "--out", str(tmp_path / "rows.parquet"))
    assert code == 2
    assert "pip install 'selfmotion[parquet]'" in err


def test_dask_without_distributed_names_the_extra(run, quick, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code, _, err = run("study", "run", quick, "--engine", "dask")
    assert code == 2
    assert "pip install 'selfmotion[cluster]'" in err


def started(*arguments):
    code = "import sys; from selfmotion.cli import main; main(sys.argv[1:])"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments], env=environment, text=True, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


@unmeasured
@pytest.mark.parametrize("engine", [HERE, ("--workers", "2")], ids=["here", "processes"])
def test_ctrl_c_keeps_what_is_done_and_a_second_run_goes_on(run, study_file, tmp_path, engine):
    file = study_file(**{**QUICK, "seeds": {"count": 200}})
    process = started("study", "run", file, *engine)
    until = time.monotonic() + 120
    while time.monotonic() < until and not any(
        json.loads(run("study", "status", file, "--json")[1])[k] for k in ("done",)
    ):
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to all processes
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    done = json.loads(run("study", "status", file, "--json")[1])["done"]
    assert 0 < done < 800
    assert (out, err) == ("", f"selfmotion: interrupted; {done} of 800 runs are kept, run again to go on\n")
    code, out, _ = run("study", "run", file, *HERE, "--limit", "2")
    assert code == 0
    assert f"{done + 2} of 800 runs done" in out


def test_progress_is_a_table_on_a_terminal(study_file, monkeypatch):
    from rich.console import Console

    from selfmotion.commands.study import _Board
    from selfmotion.study import Study, run_study

    case = Study.load(study_file(**QUICK))
    board = _Board(case)
    run_study(case, progress=board)
    console = Console(file=io.StringIO(), width=100)
    console.print(board.table())
    shown = console.file.getvalue()
    assert "small: 8 of 8 runs, 0 s left" in shown
    assert [line.split("│")[1:4] for line in shown.splitlines() if "PSO" in line] == [
        [" sinusoid ", " PSO       ", "      4 "]
    ]


@unmeasured
def test_a_study_needs_nothing_heavy_to_say_what_it_can():
    code = (
        "import sys\nfrom selfmotion.cli import _run\n_run(['study', '--help'])\n"
        "sys.exit(str({'numpy', 'numba', 'scipy', 'yaml', 'distributed', 'sqlite3'} & set(sys.modules)))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, env=environment)
    assert done.stderr == "set()\n"
    assert Path(sys.executable).exists()
