"""The globally shortest motion from the command line, and how far from it a motion is that anyone made."""

import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.commands.printed import json_text
from selfmotion.plans import RESULT_FIELDS

GLOBAL = {"kind": "global", "gap": 1e-3}
START = {"u": [0.3]}
KEYS = ("cost", "cost_error", "lower_bound", "optimum", "gap", "gap_sampled", "reason")


def read(out):
    return json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


@pytest.fixture
def written(tmp_path):
    """Write a trajectory: a plan at some rows, or r and q."""

    def write(plan, count=300):
        r = np.linspace(0, 1, count)
        table = np.column_stack([r, plan(r)])
        file = tmp_path / f"{plan.planner}{count}.csv"
        header = ",".join(["r", *(f"q{j + 1}" for j in range(table.shape[1] - 1))])
        np.savetxt(file, table, delimiter=",", header=header, comments="", fmt="%.17g")
        return str(file)

    return write


def test_the_verdict_says_bound_and_gap(run, seed_file):
    code, out, err = run("plan", seed_file(planner=GLOBAL, start=START))
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].startswith("solved: cost 4.88944")
    assert lines[1].startswith("  cost 4.8894, proved within 0.0")
    assert "of the best possible: no motion costs less than 4.88" in lines[1]
    assert lines[2].startswith("  global, values on cells of the self-motion")


def test_json_holds_the_proof_in_plain_types(run, seed_file, tmp_path):
    code, out, err = run("plan", seed_file(planner=GLOBAL, start=START), "--json", "--out", str(tmp_path / "out"))
    assert (code, err) == (0, "")
    result = read(out)
    assert set(result) == set(RESULT_FIELDS)
    assert result == read((tmp_path / "out" / "plan.json").read_text())
    assert 0 < result["gap"] <= 1e-3
    assert result["lower_bound"] <= result["cost"] <= result["lower_bound"] * (1 + 2e-3)
    parameters = result["parameters"]
    assert parameters["settings"] == {"gap": 1e-3, "time_limit": 60.0}
    bounds = [level["bound"] for level in parameters["levels"]]
    assert bounds == sorted(bounds)
    assert bounds[-1] == result["lower_bound"]
    assert parameters["tube"]["cells"] > 0
    code, out, _ = run("verify", seed_file(start=START), str(tmp_path / "out" / "trajectory.csv"), "--json")
    assert code == 0
    assert read(out)["gap"] < 1.5e-3


def test_a_blocked_problem_is_3_with_its_proof_in_json(run, tmp_path):
    file = tmp_path / "blocked.yaml"
    file.write_text(
        "arm: {kind: planar, links: [1, 1, 1], limits: [[-1.45, 1.45], [-1.45, 1.45], [-1.45, 1.45]]}\n"
        "path: {kind: line, start: [1.5, -2.5], end: [1.5, 2.5]}\n"
        "planner: {kind: global, time_limit: 60}\n"
    )
    code, out, err = run("plan", str(file), "--json", "--out", str(tmp_path / "out"))
    result = read(out)
    assert (code, result["status"], result["error"]["message"] in err) == (3, "infeasible", True)
    low, high = result["blocked"][0]["r"]
    assert low < (0.41 + 2.5) / 5 < high
    assert {(need["joint"], need["side"]) for need in result["needs"]} == {(1, "upper"), (1, "lower")}
    assert all(0.1 < need["by"] < 0.12 for need in result["needs"])
    assert result["proof"]["proved_within"][0] <= low < high <= result["proof"]["proved_within"][1]
    assert result["reconfigurations"] == len(result["breaks"]) == 1
    assert result == read((tmp_path / "out" / "plan.json").read_text())


def test_what_is_not_known_while_no_motion_was_found_is_null_in_json():
    assert read(json_text({"levels": [{"cost": np.inf}, (np.nan, 1.0)]})) == {"levels": [{"cost": None}, [None, 1.0]]}


def test_verify_says_how_far_from_the_best_possible(run, seed_file, written, seed_plan):
    problem, motion = seed_file(start=START), written(seed_plan)
    code, out, err = run("verify", problem, motion)
    assert (code, err) == (0, "")
    assert out.splitlines()[0].startswith("the motion holds: travel 5.277")
    assert out.splitlines()[1].startswith(
        "  at most 7.5 % of its cost 5.27749 could be saved: best motion found 4.88945"
    )
    result = read(run("verify", problem, motion, "--json", "--gap", "1e-2")[1])
    assert result["status"] == "holds"
    assert result["cost_sampled"] < result["cost"]
    assert result["gap"] == pytest.approx((result["cost"] - result["lower_bound"]) / result["cost"], abs=1e-8)
    assert result["optimum"] == pytest.approx(4.8894466, rel=1e-6)
    assert result["reason"] is None


def test_verify_without_is_what_it_was(run, seed_file, written, seed_plan):
    problem, motion = seed_file(start=START), written(seed_plan)
    code, out, _ = run("verify", problem, motion, "--no-optimum")
    assert code == 0
    assert out.count("\n") == 1
    result = read(run("verify", problem, motion, "--no-optimum", "--json")[1])
    assert [result[key] for key in KEYS] == [None] * 6 + ["not asked for"]


def test_a_broken_motion_gets_no_distance(run, seed_file, written, seed_plan):
    motion = written(seed_plan)
    code, out, _ = run("verify", seed_file(start={"u": [0.2]}), motion)
    assert code == 1
    assert "saved" not in out
    code, out, _ = run("verify", seed_file(start={"u": [0.2]}), motion, "--json")
    assert code == 1
    result = read(out)
    assert [result[key] for key in KEYS] == [None] * 6 + ["the motion does not hold"]


def test_few_rows_are_not_better_than_the_bound(run, seed_file, written, seed_problem):
    best = sm.plan(sm.Problem(seed_problem.arm, seed_problem.path, start=[0.3]), sm.Global(gap=1e-3))
    loose = ["--tolerance-between", "1", "--max-step", "2"]
    problem, motion = seed_file(start=START), written(best, 15)
    result = read(run("verify", problem, motion, "--json", *loose)[1])
    assert result["cost_sampled"] < result["lower_bound"] < result["cost"]
    assert result["gap"] > 0
    assert result["gap_sampled"] is None
    assert "-" not in run("verify", problem, motion, *loose)[1].splitlines()[1]


def test_another_degree_of_redundancy_is_no_error(run, seed_file, written):
    arm = {"kind": "planar", "links": [20, 20, 20, 20]}
    problem = seed_file(arm=arm, planner={"kind": "refine", "starts": 1})
    loaded = sm.load_problem(problem)
    motion = written(sm.plan(loaded.problem, loaded.planner))
    code, out, err = run("verify", problem, motion)
    assert (code, err) == (0, "")
    assert "not known (global needs an arm with one redundant degree of freedom, and this one has 2)" in out
    result = read(run("verify", problem, motion, "--json")[1])
    assert result["cost"] > result["cost_sampled"]
    assert result["lower_bound"] is result["gap"] is result["optimum"] is None


BAD = {
    "planner.gap": {"planner": {"kind": "global", "gap": 0}},
    "planner.gap (negative)": {"planner": {"kind": "global", "gap": -1e-3}},
    "planner.gap (above 1)": {"planner": {"kind": "global", "gap": 1.5}},
    "planner.gap (text)": {"planner": {"kind": "global", "gap": "small"}},
    "planner.time_limit": {"planner": {"kind": "global", "time_limit": 0}},
    "planner.time_limit (negative)": {"planner": {"kind": "global", "time_limit": -5}},
    "planner.time_limit (null)": {"planner": {"kind": "global", "time_limit": None}},
    "timelimit": {"planner": {"kind": "global", "timelimit": 5}},
    "planner: global needs": {"arm": {"kind": "planar", "links": [20, 20, 20, 20]}, "planner": GLOBAL},
    "path.end": {"path": {"kind": "line", "start": [50, 0], "end": [50, 0]}, "planner": GLOBAL},
    "path.control_points": {"path": {"kind": "bezier", "control_points": [[50, 0]] * 3}, "planner": GLOBAL},
    "start.u": {"start": {"u": [3.0]}, "planner": GLOBAL},
    "start.q": {"start": {"q": [0.0, 0.5, 0.2]}, "planner": GLOBAL},
    "end.u": {"end": {"u": [3.0]}, "planner": GLOBAL},
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_2_with_its_field(run, seed_file, case):
    code, out, err = run("plan", seed_file(**BAD[case]))
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert case.split(" (")[0] in err


def test_a_start_beyond_a_limit_says_which(run, seed_file):
    q = sm.PlanarArm([30, 30, 20]).solve([50, -10], [0.3], "negative")[0]
    for start, said in (({"q": q.tolist()}, "puts joint 2 at -"), ({"u": [1.66]}, "puts joint 3 at ")):
        arm = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3], [-2, 1.5]]}
        code, _, err = run("plan", seed_file(arm=arm, start=start, planner=GLOBAL))
        assert code == 2
        assert said in err
        assert "rad outside its limits" in err
        assert "u may lie in" in err


@pytest.mark.parametrize(
    ("option", "value"), [("--gap", "0"), ("--gap", "2"), ("--time-limit", "-1"), ("--time-limit", "0")]
)
def test_verify_refuses_what_makes_no_planner(run, seed_file, written, seed_plan, option, value):
    code, out, err = run("verify", seed_file(), written(seed_plan), option, value)
    assert (code, out) == (2, "")
    assert option.strip("-").replace("-", "_") in err.replace("-", "_")


@pytest.mark.skipif(os.name != "posix", reason="interrupts by signal")
def test_interrupted_it_gives_the_best_pair_so_far(seed_file):
    file = seed_file(planner={"kind": "global", "gap": 1e-9, "time_limit": 300}, start=START)
    command = [sys.executable, "-m", "selfmotion", "plan", file, "--json"]
    for wait in (5, 20, 60):  # a busy machine may not have found a motion yet
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
            time.sleep(wait)
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=60)
        if running.returncode == 0:
            break
    assert (running.returncode, err) == (0, "")
    result = read(out)
    assert result["status"] == "solved"
    assert result["lower_bound"] <= result["cost"]
    assert "interrupted" in result["parameters"]["argument"]
