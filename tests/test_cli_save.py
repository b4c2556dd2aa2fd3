"""``plan --save``: what is stored, what is said of it, and that no plan is lost where it cannot be stored."""

import json

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.exchange import plan_file

REFUSAL = sm.InvalidInputError("motion", "is one that a plan file cannot hold", "store its trajectory instead")


def refuse(*_):
    raise REFUSAL


def test_a_plan_along_a_program_is_stored_and_said_to_be(run, seed_file, tmp_path):
    program = tmp_path / "a.nc"
    program.write_text("G21 G17 G90\nG0 X50000 Y0\nG1 X45000 Y9000\nG3 X43000 Y11000 I-2000 J0\nM30\n")
    problem = seed_file(path={"kind": "gcode", "file": "a.nc"}, planner={"kind": "refine", "starts": 1})
    stored = tmp_path / "stored.json"
    code, said, err = run("plan", problem, "--save", str(stored), "--out", str(tmp_path / "out"))
    assert (code, err) == (0, "")
    assert said.splitlines()[-2:] == [f"plan stored in {stored}", f"written to {tmp_path / 'out'}"]
    program.unlink()
    table = np.genfromtxt(tmp_path / "out" / "trajectory.csv", delimiter=",", names=True)
    assert np.array_equal(sm.load_plan(stored)(table["r"])[:, 0], table["q1"])


@pytest.mark.parametrize("as_json", [False, True])
def test_a_plan_that_cannot_be_stored_is_printed_and_written_all_the_same(
    run, seed_file, tmp_path, monkeypatch, as_json
):
    monkeypatch.setattr(plan_file, "motion_object", refuse)
    stored, out = tmp_path / "stored.json", tmp_path / "out"
    options = ["--json"] if as_json else []
    code, said, err = run("plan", seed_file(), "--save", str(stored), "--out", str(out), *options)
    assert code == 2
    assert err.startswith("selfmotion: motion: is one that a plan file cannot hold")
    assert not stored.exists()
    assert (out / "trajectory.csv").exists()
    written = json.loads((out / "plan.json").read_text())
    assert written["status"] == "solved"
    if as_json:
        printed = json.loads(said)
        assert printed.pop("error")["field"] == "motion"
        assert printed == written
    else:
        assert said.startswith("solved: cost")
        assert "stored in" not in said
        assert said.splitlines()[-1] == f"written to {out}"


def test_a_problem_that_cannot_be_stored_is_refused_before_it_is_planned(run, seed_file, tmp_path, monkeypatch):
    def plan(*_):
        raise AssertionError("was planned")

    monkeypatch.setattr(plan_file, "problem_object", refuse)
    monkeypatch.setattr(sm.Sinusoid, "plan", plan)
    code, _, err = run("plan", seed_file(), "--save", str(tmp_path / "stored.json"), "--out", str(tmp_path / "out"))
    assert code == 2
    assert "cannot hold" in err
    assert not (tmp_path / "out").exists()
