"""The command time: from a problem or a stored plan to a trajectory file."""

import json
import os

import numpy as np
import pytest

import selfmotion as sm

pytest.importorskip("toppra")
LIMITS = ("--max-velocity", "1", "--max-acceleration", "4")


def test_a_problem_and_its_stored_plan_are_timed_alike(run, seed_file, tmp_path):
    stored = str(tmp_path / "stored.json")
    assert run("plan", seed_file(), "--save", stored)[0] == 0
    assert sm.load_plan(stored).verification.holds
    for source, out in ((seed_file(), "a.csv"), (stored, "b.csv")):
        code, said, err = run("time", source, *LIMITS, "--rate", "50", "--out", str(tmp_path / out))
        assert (code, err) == (0, "")
        assert "rows written to" in said
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    code, said, _ = run("verify", seed_file(), str(tmp_path / "a.csv"), "--no-optimum")
    assert code == 0, said


def test_json_says_how_long_how_hard_and_where_it_is_slow(run, seed_file, tmp_path):
    out = str(tmp_path / "t.npz")
    code, said, err = run("time", seed_file(), *LIMITS, "--tool-speed", "20", "--format", "npz", "--out", out, "--json")
    assert (code, err) == (0, "")
    result = json.loads(said)
    assert result["status"] == "timed"
    assert result["rows"] == len(sm.load_trajectory(out).t)
    assert max(result["velocity_used"] + result["acceleration_used"]) <= 1.001
    assert result["slow"][0]["rest"] is True
    assert result["stops"] == []
    assert len(result["jerk"]) == 3


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--max-acceleration", "0"], "must be greater than zero"),
        (["--max-acceleration", "4", "--max-velocity", "-1"], "must be greater than zero"),
        (["--max-acceleration", "1,2"], "has 2 entries for 3 joints"),
        (["--max-acceleration", "fast"], "is no list of numbers"),
        (["--max-acceleration", "4", "--rate", "0"], "--rate: must be greater than zero"),
        (["--max-acceleration", "4", "--format", "xls"], "--format: is not known"),
        (["--max-acceleration", "4", "--tool-speed", "0"], "tool_speed: must be greater than zero"),
        ([], "max-acceleration"),
    ],
)
def test_bad_options_are_bad_input(run, seed_file, tmp_path, options, says):
    out = tmp_path / "new" / "t.csv"
    code, _, err = run("time", seed_file(), *options, "--out", str(out))
    assert code == 2
    assert says in err
    assert not out.exists()


def test_a_folder_that_cannot_be_written_to_and_somebody_s_file_are_bad_input(run, seed_file, tmp_path):
    mine = tmp_path / "mine.csv"
    mine.write_text("mine")
    for out in (mine, mine / "t.csv", "/proc/t.csv", tmp_path):
        code, _, err = run("time", seed_file(), *LIMITS, "--out", str(out))
        assert code == 2, out
        assert err.startswith("selfmotion: --out")
    assert mine.read_text() == "mine"
    assert run("time", seed_file(), *LIMITS, "--out", str(mine), "--force")[0] == 0


def test_plan_files_that_are_damaged_and_problems_without_a_planner_are_bad_input(run, seed_file, tmp_path):
    stored = tmp_path / "stored.json"
    run("plan", seed_file(), "--save", str(stored))
    stored.write_text(stored.read_text()[:-100])
    code, _, err = run("time", str(stored), *LIMITS, "--out", str(tmp_path / "t.csv"))
    assert code == 2
    assert "incomplete or damaged" in err
    code, _, err = run("time", seed_file(planner=None), *LIMITS, "--out", str(tmp_path / "t.csv"))
    assert code == 2
    assert "planner: is missing" in err


def test_a_plan_of_an_earlier_run_does_not_stay_behind_as_the_answer(run, seed_file, tmp_path):
    stored = tmp_path / "stored.json"
    assert run("plan", seed_file(), "--save", str(stored))[0] == 0
    short = {"kind": "planar", "links": [20, 20, 15]}
    assert run("plan", seed_file(arm=short), "--save", str(stored))[0] == 3
    assert not stored.exists()
    assert np.array_equal(sorted(os.listdir(tmp_path)), [".selfmotion.json", "problem.json"])
