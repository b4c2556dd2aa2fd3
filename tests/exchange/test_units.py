"""Units that contradict each other, and sizes that say so: of what goes out, and of a path for an arm in metres."""

import json

import pytest

import selfmotion as sm
from selfmotion.units import unlikely


@pytest.fixture
def placed(tmp_path):
    """A problem file with a table of waypoints in mm for a planar arm, and the warnings about it."""
    (tmp_path / "track.csv").write_text("x,y\n300,0\n350,100\n")

    def write(placement, links=(260, 220, 110), arm_unit="mm", **changes):
        inner = {"kind": "file", "file": "track.csv", "unit": "mm", "arm_unit": arm_unit}
        data = {
            "arm": {"kind": "planar", "links": list(links), "placement": placement},
            "path": {"kind": "reversed", "path": inner},
        }
        file = tmp_path / "placed.json"
        file.write_text(json.dumps({**data, **changes}))
        return str(file)

    return write


@pytest.mark.parametrize(
    ("placement", "links", "arm_unit", "says"),
    [
        ({"plane": "xz"}, (260, 220, 110), "mm", ["path is in mm (arm_unit)", "m (placement.unit)", "reaches 590 m"]),
        ({"unit": "mm"}, (0.26, 0.22, 0.11), "m", ["path is in m (arm_unit)", "mm (placement.unit)", "0.00059 m"]),
        ({"unit": "mm", "base": [200e3, 0, 500e3]}, (260, 220, 110), "mm", ["(200, 0, 500) m", "913 times its reach"]),
        (
            {"unit": "mm", "base": [0.2, 0, 0.5]},
            (260, 220, 110),
            "mm",
            ["(0.0002, 0, 0.0005) m", "1096th of its reach"],
        ),
        ({"unit": "mm", "base": [200, 0, 500]}, (260, 220, 110), "mm", []),
        ({"unit": "mm"}, (260, 220, 110), "mm", []),
        (None, (260, 220, 110), "mm", []),
    ],
)
def test_a_placement_s_unit_that_is_none_of_the_path_is_a_warning(
    run, placed, tmp_path, placement, links, arm_unit, says
):
    file = placed(placement, links, arm_unit)
    found = "\n".join(sm.load_problem(file).problem.warnings)
    assert bool(found) is bool(says)
    for words in says:
        assert words in found
    if placement is not None:
        code, out, err = run("urdf", file, "--out", str(tmp_path / "arm.urdf"), "--json")
        assert code == 0
        assert err.count("selfmotion: warning: ") == len(json.loads(out)["warnings"])
        assert bool(err) is bool(says)


def test_the_command_says_sizes_in_metres(run, placed, tmp_path):
    place = {"unit": "mm", "base": [200, 0, 500], "frame": "cell"}
    out = tmp_path / "arm.urdf"
    code, said, err = run("urdf", placed(place), "--out", str(out))
    assert (code, err) == (0, "")
    assert said == f"3 joints written to {out}\n  reach 0.59 m, base at (0.2, 0, 0.5) m in cell\n"
    assert sm.load_chain(out).offsets[0][:3, 3] == pytest.approx([0.2, 0, 0.5], abs=1e-15)
    said = json.loads(run("urdf", placed(place), "--out", str(out), "--json")[1])
    assert (said["status"], said["joints"], said["reach"], said["frame"]) == ("written", 3, 0.59, "cell")
    assert said["base"] == pytest.approx([0.2, 0, 0.5])


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (
            ["--unit", "mm", "--arm-unit", "mm"],
            "path is in mm (arm_unit) and the arm in m: its 560 mm are taken for 560 m",
        ),
        (
            ["--unit", "mm", "--arm-unit", "inch"],
            "path is in inch (arm_unit) and the arm in m: its 22 inch are taken",
        ),
        (["--unit", "m"], "the path extends over 560 m"),
        (["--unit", "mm"], None),
    ],
)
def test_an_arm_in_metres_and_a_path_that_is_not(run, tmp_path, words, says):
    file = tmp_path / "bahn_mm.csv"
    file.write_text("x,y\n0,0\n560,100\n")
    problem = tmp_path / "arm.json"
    path = {"kind": "bezier", "control_points": [[0, 0], [1, 1]]}
    problem.write_text(json.dumps({"arm": {"kind": "named", "name": "panda"}, "path": path}))
    for arm in ("panda", str(problem)):
        code, out, _ = run("path", str(file), *words, "--arm", arm)
        assert code == 0
        assert ("warning" in out) is (says is not None)
        assert says is None or says in out
    if says is not None:
        assert "--arm-unit m" in out or "0.56 m" in out


def test_a_path_in_another_unit_than_metres_for_an_arm_in_metres_is_a_warning_of_the_problem(tmp_path):
    (tmp_path / "poses.csv").write_text("x,y,z,qx,qy,qz,qw\n400,0,400,1,0,0,0\n500,0,400,1,0,0,0\n")
    inner = {"kind": "file", "file": "poses.csv", "unit": "mm", "arm_unit": "cm", "scale": 0.01}
    data = {"arm": {"kind": "named", "name": "panda"}, "path": inner}
    (tmp_path / "p.json").write_text(json.dumps(data))
    assert "path is in cm (arm_unit) and the arm in m" in sm.load_problem(tmp_path / "p.json").problem.warnings[0]


def test_a_drawing_of_unlikely_size_is_said_in_one_sentence():
    said = unlikely(560.0, 1.0, "m, as nothing else is said")
    assert said == (
        "it extends over 560 m, its numbers being in m, as nothing else is said; "
        "it would extend over 0.56 m if they were in mm"
    )
    assert unlikely(0.5, 1.0, "m") is None


URDF = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j1" type="revolute"><parent link="a"/><child link="b"/><limit lower="-180" upper="3"/></joint>
<joint name="j2" type="prismatic"><parent link="b"/><child link="c"/><limit lower="0" upper="2000"/></joint>
</robot>"""


def test_limits_in_degrees_and_rails_in_millimetres_are_warnings(run, tmp_path, seed_file):
    arm = sm.PlanarArm([30, 30, 20], [None, (0, 180), (-8, 25)])
    (said,) = sm.Problem(arm, sm.Line([50, 0], [60, 0])).warnings
    assert said.startswith("joint 2 may turn from 0 to 180 rad, and 180 rad is 10313°")
    (tmp_path / "r.urdf").write_text(URDF)
    code, out, err = run("arms", str(tmp_path / "r.urdf"), "--json")
    assert code == 0
    assert "joint j1 may turn from -180 to 3 rad" in err
    assert "joint j2 may slide from 0 to 2000 m" in err
    assert len(json.loads(out)["warnings"]) == 2
