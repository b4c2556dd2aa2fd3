"""Arms in space from the command line: planning, judging, comparing, listing, and what is refused."""

import json
import os
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.plans import RESULT_FIELDS
from selfmotion.plot import plan_figure_names, plan_figures

EXAMPLES = Path(__file__).parents[1] / "examples"
GLOBAL = {"kind": "global", "gap": 5e-2}
PANDA = {"kind": "named", "name": "panda"}
POSES = {"kind": "file", "file": "poses.csv"}
CIRCLE = {
    "kind": "placed",
    "path": {"kind": "circle", "center": [0, 0], "radius": 0.2},
    "frame": {"translation": [0.45, 0, 0.4], "normal": [1, 0, 0], "x_axis": [0, 1, 0]},
}
PSO = {"kind": "pso", "population": 4, "iterations": 3, "seed": 1}


def read(out):
    return json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))


@pytest.fixture
def panda_file(tmp_path):
    """A problem file of a quarter of the example's circle, and a way to change it."""
    lines = (EXAMPLES / "panda_circle.csv").read_text().splitlines()
    (tmp_path / "poses.csv").write_text("\n".join(lines[:28]) + "\n")

    def write(name="problem.json", **changes):
        data = {"arm": PANDA, "path": POSES, "objective": "l2", "samples": 60, "planner": GLOBAL, **changes}
        (tmp_path / name).write_text(json.dumps({key: value for key, value in data.items() if value is not None}))
        return str(tmp_path / name)

    return write


@pytest.fixture(scope="module")
def proved():
    """A quarter of the example's circle, planned once."""
    problem, _ = sm.load_problem(EXAMPLES / "panda_circle.yaml")
    quarter = sm.PoseWaypoints(problem.path(problem.path.waypoints)[:26])
    return sm.plan(sm.Problem(problem.arm, quarter, objective="l2", samples=60), sm.Global(gap=5e-2))


def test_the_examples_are_the_paths_they_say():
    circle = sm.load_problem(EXAMPLES / "panda_circle.yaml").problem.path
    x, t = circle(circle.waypoints), np.linspace(0, 2 * np.pi, 101)
    expected = np.column_stack([np.full(101, 0.45), 0.2 * np.cos(t), 0.4 + 0.2 * np.sin(t)])
    np.testing.assert_allclose(x[:, :3], expected, atol=1e-12)
    np.testing.assert_allclose(sm.paths.rotation_matrix(x), np.tile(np.diag([1.0, -1, -1]), (101, 1, 1)), atol=1e-12)
    assert circle.is_closed
    line = sm.load_problem(EXAMPLES / "panda_line.yaml").problem.path
    x = line(line.waypoints)
    np.testing.assert_allclose(x[:, 0], np.linspace(0.45, -0.45, 200), atol=1e-12)
    np.testing.assert_allclose(x[:, 1:], np.tile([0.5422, 0.7885, 1, 0, 0, 0], (200, 1)), atol=1e-12)


def test_plan_writes_its_folder_and_verify_accepts_it(run, panda_file, tmp_path):
    out = tmp_path / "out"
    code, printed, err = run("plan", panda_file(), "--out", str(out), "--json")
    assert (code, err) == (0, "")
    result = read(printed)
    assert set(result) == {*RESULT_FIELDS, "l2_waypoints"}
    assert result["gap"] <= 5e-2
    assert 0 < result["l2_waypoints"] <= result["cost"]
    made = [*plan_figure_names(sm.named_arm("panda")), ".selfmotion.json", "plan.json", "trajectory.csv"]
    assert sorted(os.listdir(out)) == sorted(made)
    table = np.genfromtxt(out / "trajectory.csv", delimiter=",", names=True)
    assert table.dtype.names == ("r", *(f"q{j}" for j in range(1, 8)), "u1")
    np.testing.assert_allclose(table["u1"], table["q7"], atol=1e-9)  # which is what u is
    code, printed, _ = run("verify", panda_file(), str(out / "trajectory.csv"), "--json", "--gap", "0.05")
    assert code == 0
    judged = read(printed)
    assert judged["status"] == "holds"
    assert judged["lower_bound"] <= judged["cost"] + judged["cost_error"]


def test_verify_says_where_a_motion_breaks(run, panda_file, tmp_path, proved):
    r = proved.problem.rows
    q = proved(r)
    q[30, 2] += 1e-3
    write_rows(tmp_path / "t.csv", r, q)
    code, out, _ = run("verify", panda_file(), str(tmp_path / "t.csv"))
    assert code == 1
    assert f"tracking at r = {r[30]:.6g}, data row 31" in out


def write_rows(file, r, q):
    header = ",".join(["r", *(f"q{j + 1}" for j in range(q.shape[1]))])
    np.savetxt(file, np.column_stack([r, q]), delimiter=",", header=header, comments="", fmt="%.17g")


def test_a_branch_can_be_asked_for_by_either_name(run, panda_file, tmp_path, proved):
    names = proved.problem.arm.branches
    on = proved.problem.arm.branch_of(proved(proved.problem.rows))
    other = names[1 - on[0]]
    costs = []
    for field in ("branch", "elbow"):
        code, out, _ = run("plan", panda_file(**{field: other}), "--json")
        assert code == 0
        costs.append(read(out)["cost"])
    assert costs[0] == costs[1] >= proved.lower_bound
    write_rows(tmp_path / "t.csv", proved.problem.rows, proved(proved.problem.rows))
    code, out, _ = run("verify", panda_file(branch=other), str(tmp_path / "t.csv"))
    assert code == 1
    assert "branch at r = 0, data row 1" in out


def test_a_branch_of_a_planar_arm_is_its_elbow(run, seed_file):
    planner = {"kind": "global", "gap": 0.1}
    found = [read(run("plan", seed_file(**{f: "negative"}, planner=planner), "--json")[1]) for f in ("branch", "elbow")]
    assert found[0]["cost"] == found[1]["cost"]
    assert sm.load_problem(seed_file(branch="negative")).problem.elbow == "negative"


def test_the_figure_is_what_the_folder_is_checked_for_and_the_same_each_time(proved, seed_plan):
    files_made = plan_figures(proved)
    assert list(files_made) == plan_figure_names(proved.problem.arm)
    assert files_made == plan_figures(proved)
    assert set(plan_figures(seed_plan)) == set(plan_figure_names(seed_plan.problem.arm))


@pytest.mark.parametrize("planner", [
    {"kind": "sinusoid", "offset": [1.0], "amplitude": [0.05], "optimizer": {**PSO, "bounds": [0, 1]}},
    {"kind": "harmonics", "offset": [1.0], "span": [0.1], "optimizer": PSO},
    {"kind": "bspline", "offset": [1.0], "span": [0.1], "optimizer": PSO},
    {"kind": "refine", "starts": 2, "time_limit": 10},
], ids=lambda planner: planner["kind"])  # fmt: skip
def test_planners_that_need_no_plane_plan_for_it_too(run, panda_file, planner):
    problem = panda_file(planner=planner, samples=120)
    code, out, err = run("plan", problem, "--json")
    assert (code, err) == (0, "")
    assert read(out)["lower_bound"] is None
    if planner["kind"] == "sinusoid":
        assert ", branch q4- q5in q2" in run("plan", problem)[1]


@pytest.mark.parametrize("planner", [
    {"kind": "moving_base", "optimizer": PSO},
    {"kind": "modules", "moving_bases": [{"kind": "line", "start": [0, 0], "end": [1, 1]}], "offset": [0, 0],
     "amplitude": [1, 1], "optimizer": {**PSO, "bounds": [0, 1]}},
], ids=lambda planner: planner["kind"])  # fmt: skip
def test_planners_that_need_the_plane_name_one_that_does_not(run, panda_file, planner):
    code, out, err = run("plan", panda_file(planner=planner))
    assert (code, out) == (2, "")
    assert "planner: is for planar arms" in err
    assert "use planner global" in err


@pytest.mark.parametrize("command", ["animate", "repair"])
def test_what_is_drawn_in_the_plane_only_says_so(run, panda_file, tmp_path, command):
    code, out, err = run(command, panda_file(), "absent.csv", "--out", str(tmp_path / "out"))
    assert (code, out) == (2, "")
    assert "arm: moves in space, and" in err
    assert "planar arms only" in err
    assert not (tmp_path / "out").exists()


def posed(**orientation):
    return {"kind": "pose", "position": CIRCLE, **orientation}


URDF = {"kind": "urdf", "file": "panda.urdf"}
BAD = {
    "URDF without limits": (
        {"arm": {"kind": "urdf", "file": "free.urdf"}},
        ["arm.file: ", "free.urdf, urdf.panda_joint2.limit: has no limits", "write lower and upper"],
    ),
    "wrong tip": (
        {"arm": {**URDF, "tip": "panda_hnd"}},
        ["arm.tip: is not a link of this robot (got 'panda_hnd')", "did you mean panda_hand"],
    ),
    "no file": ({"arm": {"kind": "urdf", "file": "absent.urdf"}}, ["arm.file: ", "absent.urdf: does not exist"]),
    "too few joints": ({"arm": {**URDF, "tip": "panda_link5"}}, ["arm.file: has 5 joints", "seven"]),
    "name": ({"arm": {"kind": "named", "name": "pnda"}}, ["arm.name: is not known", "did you mean 'panda'", "iiwa7"]),
    "tool": ({"arm": {**PANDA, "tool": {"rpi": [0, 0, 1]}}}, ["arm.tool.rpi: is not", "did you mean 'rpy'"]),
    "scaled rotation": (
        {"path": posed(orientation=[[1.1, 0, 0], [0, -1.1, 0], [0, 0, -1.1]])},
        ["path.orientation: is no rotation: it is scaled by 1.1", "unit columns"],
    ),
    "quaternion": (
        {"path": posed(orientation=[0, 2, 0, 0])},
        ["path.orientation: is no unit quaternion: its norm is 2", "divide it by its norm"],
    ),
    "quaternion in a file": (
        {"path": {"kind": "file", "file": "scaled.csv"}},
        ["path.file: ", "scaled.csv, line 3: holds no unit quaternion: its norm is 2"],
    ),
    "millimetres": (
        {"path": {"kind": "file", "file": "mm.csv"}},
        ["path: has no point in reach", "of reach 0.986262", "are the units of arm and path the same?"],
    ),
    "plane path": (
        {"path": {"kind": "circle", "center": [0.5, 0], "radius": 0.1}},
        ["path: is a curve of the plane, and this arm's tool keeps poses", "kind: pose", "placed"],
    ),
    "positions only": ({"path": CIRCLE}, ["path: is positions without orientation", "kind: pose"]),
    "pose path for a planar arm": (
        {"arm": {"kind": "planar", "links": [0.3, 0.3, 0.2]}},
        ["path: leaves the plane that a planar arm moves in"],
    ),
    "branch": ({"branch": "positive"}, ["branch: is not known", "choose one of any, q4- q5in q2+"]),
    "branch and elbow": ({"branch": "any", "elbow": "any"}, ["branch: is given as elbow too"]),
    "branch that is no text": ({"branch": 3}, ["branch: is not text"]),
    "direction": ({"path": {**POSES, "direction": 1.0}}, ["path.direction: is for planar arms"]),
    "start": ({"start": {"u": [-2.5]}}, ["start.u: ", "outside its limits", "u may lie in [0.2989", "on branch q4-"]),
    "start on another branch": (
        {"start": {"q": None}, "branch": "q4- q5in q2+"},
        ["start.q: is not on branch q4- q5in q2+", "change branch or q"],
    ),
    "offset": (
        {"planner": {"kind": "harmonics", "offset": [-2.5], "span": [0.1], "optimizer": PSO}, "samples": 120},
        ["planner.offset: is outside the angle domain", "on branch q4- q5in"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_2_in_one_line(run, panda_file, tmp_path, case):
    changes, said = BAD[case]
    urdf = (files("selfmotion.arms") / "data" / "panda.urdf").read_text()
    (tmp_path / "panda.urdf").write_text(urdf)
    (tmp_path / "free.urdf").write_text(urdf.replace('lower="-1.7628" upper="1.7628" ', ""))
    (tmp_path / "scaled.csv").write_text("x,y,z,qx,qy,qz,qw\n0.4,0,0.4,1,0,0,0\n0.4,0.1,0.4,2,0,0,0\n")
    (tmp_path / "mm.csv").write_text("x,y,z,qx,qy,qz,qw\n400,0,400,1,0,0,0\n400,100,400,1,0,0,0\n")
    if changes.get("start") == {"q": None}:
        arm = sm.named_arm("panda")
        q, _ = arm.solve(np.array([0.45, 0.2, 0.4, 0, 1, 0, 0]), [1.0], "q4- q5in q2-")
        changes = {**changes, "start": {"q": q.tolist()}}
    code, out, err = run("plan", panda_file(**changes))
    assert (code, out) == (2, "")
    assert err.count("\n") == 1
    assert all(part in err for part in said), err


def test_the_unit_of_a_file_is_what_the_millimetres_wanted(panda_file, tmp_path):
    (tmp_path / "mm.csv").write_text("x,y,z,qx,qy,qz,qw\n400,0,400,1,0,0,0\n400,100,400,1,0,0,0\n")
    path = {"kind": "file", "file": "mm.csv", "unit": "mm"}
    np.testing.assert_allclose(sm.load_problem(panda_file(path=path)).problem.path(1.0)[:3], [0.4, 0.1, 0.4])


def test_a_path_that_leaves_the_reach_is_3_with_where(run, panda_file):
    path = {"kind": "pose_waypoints", "poses": [[0.45, 0, 0.4, 0, 1, 0, 0], [1.45, 0, 0.4, 0, 1, 0, 0]]}
    for planner in (GLOBAL, {"kind": "refine"}):
        code, out, _ = run("plan", panda_file(path=path, planner=planner), "--json")
        assert code == 3
        blocked = read(out)["blocked"]
        assert [part["cause"] for part in blocked] == ["out of reach"]
        assert blocked[0]["r"][1] == 1.0


def test_arms_lists_the_catalogue(run):
    code, out, err = run("arms")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].split()[:4] == ["name", "joints", "u", "branches"]
    assert lines[1].startswith("panda    7        q7")
    assert {line.split()[0] for line in lines[1:]} == {*sm.arms.CATALOGUE, "planar", "urdf", "rail"}
    assert lines[5].startswith("ur5e     6        roll")
    listed = read(run("arms", "--json")[1])
    assert [row["name"] for row in listed["arms"]] == list(sm.arms.CATALOGUE)
    panda = listed["arms"][0]
    assert (panda["joints"], panda["parameter"], panda["branches"], panda["tip"]) == (7, "q7", 8, "panda_hand")
    assert panda["rigorous"]
    assert panda["why_not"] is None


def test_compare_puts_the_plan_beside_ladders_and_motions_of_others(run, panda_file, tmp_path, proved):
    good, bad = str(tmp_path / "good.csv"), str(tmp_path / "bad.csv")
    r = proved.problem.rows
    write_rows(good, r, proved(r))
    write_rows(bad, r, proved(r) + 0.01)
    problem = panda_file()
    code, out, err = run("compare", problem, good, bad, "--ladder", "30,120", "--json")
    assert (code, err) == (0, "")
    result = read(out)
    assert (result["status"], result["objective"]) == ("solved", "l2")
    assert [row["name"] for row in result["motions"]] == ["global", "ladder of 30", "ladder of 120", good, bad]
    ours, coarse, fine, same, broken = result["motions"]
    assert [row["holds"] for row in (ours, fine, same, broken)] == [True, True, True, False]
    assert result["lower_bound"] <= ours["cost"] <= fine["cost"]
    assert fine["cost_sampled"] <= coarse["cost_sampled"]
    assert same["cost"] == pytest.approx(ours["cost"], rel=1e-4)
    assert same["l2_waypoints"] == pytest.approx(ours["l2_waypoints"], rel=1e-4)
    assert broken["gap"] is None
    assert broken["why_not"].startswith("tracking")
    code, out, _ = run("compare", problem, bad, "--ladder", "")
    assert code == 0
    lines = out.splitlines()
    assert lines[0].startswith("objective l2: no motion costs less than ")
    assert lines[1].split() == [
        "motion", "holds", "cost", "gap", "chord", "sum", "l2", "waypoints", "largest", "step", "jumps", "time",
    ]  # fmt: skip
    assert lines[2].startswith("global")
    assert lines[-1].startswith(f"{bad}: tracking")


def test_compare_refuses_what_it_cannot_read_and_says_what_has_no_motion(run, panda_file, seed_file):
    for wrong in ("x", "0", "60,,2", "1e3", "999999999"):
        code, _, err = run("compare", panda_file(), "--ladder", wrong)
        assert code == 2
        assert "--ladder: is no list of numbers" in err
    code, _, err = run("compare", panda_file(), "absent.csv")
    assert code == 2
    assert "absent.csv" in err
    path = {"kind": "pose_waypoints", "poses": [[0.45, 0, 0.4, 0, 1, 0, 0], [1.45, 0, 0.4, 0, 1, 0, 0]]}
    assert run("compare", panda_file(path=path))[0] == 3
    four = seed_file(arm={"kind": "planar", "links": [20, 20, 20, 20]}, planner=None)
    code, _, err = run("compare", four)
    assert code == 2
    assert "one redundant degree" in err
