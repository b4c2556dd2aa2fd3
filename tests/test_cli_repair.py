"""`selfmotion repair` as a user and as a script meet it."""

import json
import os

import numpy as np
import pytest

import selfmotion as sm

R = np.linspace(0, 1, 120)
HEADER = "r,q1,q2,q3"


@pytest.fixture
def broken(seed_path):
    """A motion of the seed's arm without limits, some of it on the other elbow."""
    arm = sm.PlanarArm([30, 30, 20])
    q = arm.solve(seed_path(R), 0.3 + 0.4 * np.sin(3.4 * R)[:, None], 0)[0]
    q[50:60] = arm.solve(seed_path(R[50:60]), [0.6], 1)[0]
    return q


@pytest.fixture
def write(tmp_path):
    def csv(q, r=R, header=HEADER, name="motion.csv"):
        table = np.column_stack([r, q]) if len(np.shape(q)) == 2 else q
        np.savetxt(tmp_path / name, table, delimiter=",", header=header, comments="", fmt="%.17g")
        return str(tmp_path / name)

    return csv


@pytest.fixture
def problem(seed_file):
    return seed_file(arm={"kind": "planar", "links": [30, 30, 20]})


def test_it_mends_and_verify_accepts(run, problem, broken, write, tmp_path):
    out = str(tmp_path / "out")
    code, text, err = run("repair", problem, write(broken), "--out", out)
    assert code == 0, err
    assert "data row 50" in text
    assert "repaired: 110 of 120 rows kept" in text
    assert {"repaired.csv", "repair.json", "before.png", "before.svg", "after.png", "after.svg"} <= set(os.listdir(out))
    assert run("verify", problem, os.path.join(out, "repaired.csv"))[0] == 0
    first = {name: (tmp_path / "out" / name).read_bytes() for name in os.listdir(out)}
    assert run("repair", problem, write(broken), "--out", out)[0] == 0
    assert first == {name: (tmp_path / "out" / name).read_bytes() for name in os.listdir(out)}
    code, text, _ = run("repair", problem, os.path.join(out, "repaired.csv"), "--out", str(tmp_path / "b"), "--json")
    assert code == 0
    assert json.loads(text)["status"] == "holds"


def test_json_says_each_break(run, problem, broken, write, tmp_path):
    code, text, _ = run("repair", problem, write(broken), "--out", str(tmp_path / "out"), "--json")
    assert code == 0
    result = json.loads(text)
    assert result == json.loads((tmp_path / "out" / "repair.json").read_text())
    assert [(part["row"], part["kind"], part["joint"]) for part in result["breaks"]] == [
        (50, "changes branch", 2), (60, "changes branch", 2),
    ]  # fmt: skip
    assert result["rows_given"] == 120
    assert result["rows_kept"] == 110


def test_what_cannot_be_mended_says_where(run, seed_file, write, tmp_path):
    arm = {"kind": "planar", "links": [1, 1, 1], "limits": [[-1.45, 1.45]] * 3}
    line = {"kind": "line", "start": [1.5, -2.5], "end": [1.5, 2.5]}
    problem = seed_file(arm=arm, path=line, planner=None)
    loaded = sm.load_problem(problem).problem
    q = loaded.arm.solve(loaded.path(R), [0.0], 0)[0]
    out = tmp_path / "out"
    code, text, err = run("repair", problem, write(q), "--out", str(out), "--json")
    assert code == 3
    assert json.loads(text)["status"] == "infeasible"
    assert "r = 0.5822682796" in err
    assert "upper limit of θ1 and lower limit of θ3" in err
    assert sorted(os.listdir(out)) == [".selfmotion.json", "repair.json"]


def nan_at(q, row, joint):
    q = q.copy()
    q[row, joint] = np.nan
    return q


@pytest.mark.parametrize(
    ("make", "expected"),
    [
        (lambda q: {"q": nan_at(q, 7, 1)}, "row 8, column q2"),
        (lambda q: {"q": q, "r": R[::-1]}, "row 2, column r"),
        (lambda q: {"q": q, "r": R + 0.5}, "column r"),
        (lambda q: {"q": q[:, :2], "header": "r,q1,q2"}, "row 1"),
        (lambda q: {"q": q, "header": "r,a,b,c"}, "row 1"),
        (lambda q: {"q": np.column_stack([q, q[:, 0]]), "header": "r,q1,q2,q3,q4"}, "row 1"),
        (lambda q: {"q": q + 0.5}, "columns q1…q3"),
    ],
)
def test_bad_motions_are_refused_with_row_and_column(run, problem, broken, write, tmp_path, make, expected):
    out = tmp_path / "out"
    code, text, err = run("repair", problem, write(**make(broken)), "--out", str(out))
    assert code == 2
    assert text == ""
    assert expected in err
    assert "motion.csv" in err
    assert len(err.splitlines()) == 1
    assert not out.exists()


def test_an_arm_with_more_redundancy_is_bad_input_of_the_problem(run, seed_file, write, tmp_path):
    problem = seed_file(arm={"kind": "planar", "links": [30, 30, 20, 10]}, planner=None)
    q = np.zeros((120, 4))
    code, _, err = run("repair", problem, write(q, header="r,q1,q2,q3,q4"), "--out", str(tmp_path / "o"))
    assert code == 2
    assert "problem.json" in err
    assert "redundant" in err


def test_foreign_files_stay(run, problem, broken, write, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "repaired.csv").write_text("mine")
    assert run("repair", problem, write(broken), "--out", str(tmp_path / "out"))[0] == 2
    assert (tmp_path / "out" / "repaired.csv").read_text() == "mine"
