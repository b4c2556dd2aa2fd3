"""The benchmarks run, agree with the library, and say what is missing."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    out = tmp_path_factory.mktemp("bench")
    command = [sys.executable, "run.py", "--quick", "--only", "seed_study", "--only", "kernels", "--out", str(out)]
    run = subprocess.run(command, cwd=BENCHMARKS, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    return json.loads((out / "results.json").read_text()), (out / "RESULTS.md").read_text()


def test_every_run_finds_the_optimum_or_is_reported_missing(results):
    study, text = results[0]["seed_study"], results[1]
    ours = [row for row in study["rows"] if row["ours"]]
    assert len(ours) == 8
    assert all(row["median_excess"] < 1e-2 for row in ours)
    for row in study["rows"]:
        assert row["missing"] == (f"| {row['name']} | missing here |" in text)
    assert study["optimum"] == pytest.approx(5.2775214177, abs=1e-9)


def test_operations_are_counted(results):
    counted = results[0]["kernels"]["operations"]
    assert counted["chord"]["root"] == counted["node"]["root"] == 4  # |sin θ2|, and an arc per joint
    assert counted["node"]["divide"] == 1
    assert 100 < counted["chord"]["add"] + counted["chord"]["multiply"] < 400


def test_ladders_and_growth_are_those_of_the_library():
    code = (
        "import ladders, growth, selfmotion as sm\n"
        "problem = next(iter(ladders.CASES.values()))\n"
        "u, chords = ladders.ladder(problem, 240, 60)\n"
        "plan = sm.plan(problem, sm.Global(1e-2))\n"
        "assert plan.lower_bound <= ladders.travel(problem, u), (plan.lower_bound, chords)\n"
        "assert chords <= ladders.travel(problem, u)\n"
        "for sizes, make in growth.AXES.values():\n"
        "    for size in sizes[:3]:\n"
        "        problem, profile = make(size)\n"
        "        pso = sm.PSO(**growth.SEARCH)\n"
        "        sm.plan(problem, sm.Sinusoid(profile.offset, amplitude=profile.amplitude, optimizer=pso))\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=BENCHMARKS, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
