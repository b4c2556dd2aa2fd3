"""Arms on a rail from the command line: metres and radians are told apart, whatever is printed, timed or refused."""

import json

import numpy as np
import pytest

import selfmotion as sm

ARM = {"kind": "named", "name": "irb120", "rail": {"axis": [0, 1, 0], "limits": [-0.5, 0.5]}}
SEAM = {
    "kind": "pose",
    "position": {"kind": "line", "start": [0.4, -0.4, 0.3], "end": [0.4, 0.4, 0.3]},
    "orientation": [0, 1, 0, 0],
}
GLOBAL = {"kind": "global", "gap": 0.1}


@pytest.fixture
def rail_file(tmp_path):
    """A problem file of a seam, and a way to change it."""

    def write(**changes):
        data = {"arm": ARM, "path": SEAM, "objective": "l2", "samples": 60, "planner": GLOBAL, **changes}
        (tmp_path / "problem.json").write_text(json.dumps(data))
        return str(tmp_path / "problem.json")

    return write


def test_plan_says_both_units_and_writes_joints_that_verify_accepts(run, rail_file, tmp_path):
    code, out, err = run("plan", rail_file(), "--out", str(tmp_path / "out"))
    assert (code, err) == (0, "")
    assert " rad or m from the nearest limit" in out
    assert "joints.png" in {file.name for file in (tmp_path / "out").iterdir()}
    assert "motion_in_domain.png" not in {file.name for file in (tmp_path / "out").iterdir()}
    table = np.genfromtxt(tmp_path / "out" / "trajectory.csv", delimiter=",", names=True)
    np.testing.assert_allclose(table["u1"], table["q1"], atol=1e-12)
    code, out, _ = run("verify", rail_file(), str(tmp_path / "out" / "trajectory.csv"), "--gap", "0.1")
    assert code == 0
    shorter = rail_file(arm={**ARM, "rail": {"axis": [0, 1, 0], "limits": [-0.1, 0.1]}})
    code, out, _ = run("verify", shorter, str(tmp_path / "out" / "trajectory.csv"))
    assert (code, "limits of joint 1" in out) == (1, True)


def test_a_rail_is_timed_in_metres_and_keeps_its_own_limits(run, rail_file, tmp_path):
    pytest.importorskip("toppra")
    stored, out = str(tmp_path / "plan.json"), str(tmp_path / "t.json")
    assert run("plan", rail_file(), "--save", stored)[0] == 0
    slow_rail = ("--max-velocity", "0.1,3,3,3,3,3,3", "--max-acceleration", "0.5,9,9,9,9,9,9")
    code, said, err = run("time", stored, *slow_rail, "--format", "json", "--out", out)
    assert (code, err) == (0, "")
    assert " m/s³ and " in said
    assert " rad/s³" in said
    rows = sm.load_trajectory(out)
    assert rows.joint_names[0] == "rail"
    moved = np.ptp(sm.load_plan(stored)(np.linspace(0, 1, 201))[:, 0])
    assert rows.t[-1] >= moved / 0.1  # at its own limit, which no other joint's is
    assert 0.09 < np.abs(rows.dq[:, 0]).max() <= 0.1 * 1.001
    assert np.abs(rows.ddq[:, 0]).max() <= 0.5 * 1.001
    loose = ("--max-acceleration", "0.5,9,9,9,9,9,9")
    _, said, _ = run("time", stored, *loose, "--out", out)
    assert f"not limited: rail up to {np.abs(sm.load_trajectory(out).dq[:, 0]).max():.3g} m/s" in said
    names, lines = {"ros": "ros.yaml", "csv": "t.csv"}, {}
    for form, name in names.items():
        assert run("time", stored, *slow_rail, "--format", form, "--out", str(tmp_path / name))[0] == 0
        lines[form] = (tmp_path / name).read_text()
    assert '- "rail"' in lines["ros"].splitlines()
    assert run("verify", rail_file(), str(tmp_path / "t.csv"), "--no-optimum")[0] == 0


def test_what_is_wrong_with_a_rail_is_said_in_metres(run, rail_file):
    for start, says in (
        ({"u": [-0.6]}, "0.1 m outside its limits"),
        ({"u": [2000.0]}, "out of reach"),  # not that it is no angle
    ):
        code, _, err = run("plan", rail_file(start=start))
        assert (code, says in err) == (2, True), err


@pytest.mark.parametrize("command", ["domain", "repair", "animate"])
def test_what_is_of_angles_or_of_the_plane_names_what_is_not(run, rail_file, tmp_path, command):
    rows = tmp_path / "t.csv"
    rows.write_text("r,q1,q2,q3,q4,q5,q6,q7\n0,0,0,0,0,0,0,0\n1,0,0,0,0,0,0,0\n")
    given = [rail_file()] if command == "domain" else [rail_file(), str(rows)]
    code, _, err = run(command, *given, "--out", str(tmp_path / "out"))
    assert code == 2
    assert "use plan, verify or compare" in err


def test_arms_says_that_a_file_has_a_rail(run, tmp_path):
    code, out, _ = run("arms")
    assert code == 0
    assert any(line.startswith("rail     1 + 6    the rail's position") for line in out.splitlines())
    axes = "".join(
        f"""<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>
        <origin xyz="{xyz}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" velocity="1" effort="0"/></joint>
        <link name="l{k + 1}"/>"""
        for k, (xyz, axis) in enumerate(
            [("0 0 0.3", "0 0 1"), ("0 0 0", "0 1 0"), ("0 0 0.3", "0 1 0"), ("0.3 0 0", "1 0 0"), ("0 0 0", "0 1 0"),
             ("0 0 0", "1 0 0")], 1,
        )
    )  # fmt: skip
    rail = """<robot name="r"><link name="l0"/><joint name="j0" type="prismatic"><parent link="l0"/><child link="l1"/>
        <axis xyz="0 1 0"/><limit lower="-1" upper="1" velocity="1" effort="0"/></joint><link name="l1"/>"""
    (tmp_path / "r.urdf").write_text(rail + axes + "</robot>")
    code, out, err = run("arms", str(tmp_path / "r.urdf"))
    assert (code, err) == (0, "")
    assert out.splitlines()[1].split()[:6] == ["urdf", "7", "rail", "8", "yes", "yes"]
