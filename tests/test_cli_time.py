"""The command time: from a problem or a stored plan to a trajectory file."""

import json
import os

import numpy as np
import pytest

import selfmotion as sm

pytest.importorskip("toppra")
LIMITS = ("--max-velocity", "1", "--max-acceleration", "4")


@pytest.fixture
def stored(run, seed_file, tmp_path):
    """A stored plan."""
    file = str(tmp_path / "stored.json")
    assert run("plan", seed_file(), "--save", file)[0] == 0
    return file


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
    ("name", "begins"),
    [
        ("t.csv", b"t,r,q1"),
        ("t", b"t,r,q1"),
        ("t.JSON", b'{"selfmotion_trajectory"'),
        ("t.npz", b"PK"),
        ("t.yaml", b"header:"),
        ("t.yml", b"header:"),
        ("t.mcap", b"\x89MCAP"),
    ],
)
def test_the_file_s_name_says_its_form(run, stored, tmp_path, name, begins):
    if name.endswith("mcap"):
        pytest.importorskip("rosbags")
    assert run("time", stored, *LIMITS, "--out", str(tmp_path / name))[0] == 0
    assert (tmp_path / name).read_bytes().startswith(begins)
    assert len(sm.load_trajectory(tmp_path / name).t) > 10


@pytest.mark.parametrize(
    ("name", "options", "says"),
    [
        ("t.bag", [], "--format: is not given, and .bag says none"),
        ("t.mcap", ["--format", "csv"], "--format: is csv, and a file .mcap holds mcap"),
        ("t.json", ["--format", "ros"], "--format: is ros, and a file .json holds json"),
    ],
)
def test_a_name_that_says_no_form_or_another_one_is_refused(run, stored, tmp_path, name, options, says):
    code, _, err = run("time", stored, *LIMITS, *options, "--out", str(tmp_path / name))
    assert code == 2
    assert says in err
    assert not (tmp_path / name).exists()
    assert run("time", stored, *LIMITS, "--format", "csv", "--out", str(tmp_path / "t.txt"))[0] == 0


def test_joints_without_a_velocity_limit_are_named_with_their_peaks(run, stored, tmp_path):
    out = str(tmp_path / "t.csv")
    code, said, _ = run("time", stored, "--max-acceleration", "4", "--out", out, "--force")
    assert code == 0
    peaks = np.abs(sm.load_trajectory(out).dq).max(axis=0)
    assert "velocities up to" not in said.splitlines()[1]
    assert "velocities not limited: joint1 up to" in said
    assert all(f"joint{j} up to {peak:.3g} rad/s" in said for j, peak in enumerate(peaks, 1))
    result = json.loads(run("time", stored, "--max-acceleration", "4", "--out", out, "--json")[1])
    assert result["velocity_unlimited"] == ["joint1", "joint2", "joint3"]
    assert result["velocity_used"] == [None] * 3
    assert result["velocity_peak"] == pytest.approx(peaks)
    bounded = json.loads(run("time", stored, *LIMITS, "--out", out, "--json")[1])
    assert bounded["velocity_unlimited"] == []
    assert max(bounded["velocity_used"]) <= 1.001
    assert "not limited" not in run("time", stored, *LIMITS, "--out", out)[1]


def test_the_result_object_of_a_run_is_not_timed(run, seed_file, tmp_path):
    assert run("plan", seed_file(), "--out", str(tmp_path / "own"))[0] == 0
    code, _, err = run("time", str(tmp_path / "own" / "plan.json"), *LIMITS, "--out", str(tmp_path / "t.csv"))
    assert code == 2
    assert "plan.json: is the result object of a run" in err
    assert "plan --save FILE stores a plan" in err


@pytest.mark.parametrize("command", ["plan", "urdf", "verify"])
def test_a_stored_plan_is_no_problem(run, stored, tmp_path, command):
    more = {"plan": [], "urdf": ["--out", str(tmp_path / "a.urdf")], "verify": [stored]}[command]
    code, _, err = run(command, stored, *more)
    assert code == 2
    assert "is a stored plan, not a problem file; time and sm.load_plan read it" in err


def test_corners_are_counted_and_the_first_ones_listed_with_the_remedy(run, seed_file, tmp_path):
    planner = {"kind": "refine", "starts": 1, "time_limit": 5}
    points = [[50 - k, 20 * (k % 2)] for k in range(12)]
    for count, says in ((12, "stands still at 10 corners, r = "), (3, "stands still at 1 corner, r = ")):
        path = {"kind": "waypoints", "points": points[:count]}
        problem = seed_file(path=path, planner=planner)
        code, said, _ = run("time", problem, *LIMITS, "--out", str(tmp_path / "t.csv"))
        assert code == 0
        (line,) = [line for line in said.splitlines() if "stands still" in line]
        assert says in line
        assert "interpolation: spline" in line
        assert len(line) < 160
        assert ("…" in line) == (count == 12)


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
