"""Arms as URDF: read back by our own reader they are where the arm is."""

import json
from xml.etree import ElementTree

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms.chain import Chain
from selfmotion.arms.urdf import read_chain
from selfmotion.exchange.urdf_file import arm_urdf, chain_urdf

PLACES = [
    {"plane": "xz", "unit": "mm", "base": [100, 200, 400]},
    {"plane": "yz", "frame": "hall <3>", "joints": ["Schulter", "肘", 'wrist "1"']},
    {"rpy": [0.3, np.pi / 2, -1.1], "unit": "inch"},  # where roll and yaw are about the same axis
    {"rpy": [0.3, -np.pi / 2 + 1e-9, -1.1]},
    {"quaternion": [0.5, -0.5, 0.5, 0.5], "unit": "cm"},
]


@pytest.mark.parametrize("place", PLACES)
def test_a_planar_arm_comes_back_where_its_placement_says(place, tmp_path):
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), (-1, 4)], placement=place)
    sm.save_urdf(arm, tmp_path / "arm.urdf")
    chain = sm.load_chain(tmp_path / "arm.urdf")
    q = np.random.default_rng(0).uniform(-3, 3, (200, 3))
    size = arm.reach * arm.placement.metres
    assert np.abs(chain.forward(q)[:, :3, 3] - arm.placement.to_space(arm.forward(q))).max() < 1e-12 * max(1.0, size)
    assert chain.names == (arm.placement.joints or ("joint1", "joint2", "joint3"))
    assert chain.base == arm.placement.frame
    assert chain.limits.as_list() == arm.limits.as_list()


def test_random_rotations_come_back_to_1e_12():
    """Also those that no single angle of roll, pitch and yaw is certain of."""
    rng = np.random.default_rng(2)
    for k in range(300):
        pitch = rng.uniform(-2, 2) if k % 2 else np.pi / 2 * rng.choice([-1, 1]) + 10.0 ** rng.uniform(-17, -2)
        place = {"base": rng.normal(size=3), "rpy": [rng.uniform(-4, 4), pitch, rng.uniform(-4, 4)]}
        arm = sm.PlanarArm([1, 1, 1], placement=place)
        pose = read_chain(arm_urdf(arm).decode()).offsets[0]
        assert np.abs(pose - arm.placement.pose).max() < 1e-14


@pytest.mark.parametrize("name", ["panda", "ur5e"])
def test_an_arm_in_space_comes_back_as_it_was(name):
    chain = sm.named_arm(name).chain
    again = read_chain(arm_urdf(sm.named_arm(name)).decode())
    q = np.random.default_rng(0).uniform(-2, 2, (100, chain.n))
    assert np.abs(again.forward(q) - chain.forward(q)).max() < 1e-12
    assert (again.names, again.base, again.tip) == (chain.names, chain.base, chain.tip)
    assert np.array_equal(again.limits.lower, chain.limits.lower)
    assert np.array_equal(again.velocity, chain.velocity)


def test_a_joint_that_slides_comes_back():
    offsets = np.broadcast_to(np.eye(4), (3, 4, 4)).copy()
    offsets[1, :3, :3] = [[0, 0, 1], [1, 0, 0], [0, 1, 0]]
    chain = Chain(["rail", "turn"], offsets, [(-1, 2), None], [True, False], [0.5, np.inf])
    again = read_chain(chain_urdf(chain).decode())
    q = np.random.default_rng(0).uniform(-1, 1, (20, 2))
    assert np.abs(again.forward(q) - chain.forward(q)).max() < 1e-15
    assert again.prismatic.tolist() == [True, False]
    free = Chain(["rail"], offsets[:2], None, [True])
    with pytest.raises(sm.InvalidInputError, match="are missing, and URDF wants them"):
        chain_urdf(free)


def test_links_of_the_plane_have_a_box_from_joint_to_joint():
    arm = sm.PlanarArm([300, 200, 100], placement={"unit": "mm"})
    boxes = [link.find("visual") for link in ElementTree.fromstring(arm_urdf(arm)).findall("link")]
    assert [box is not None for box in boxes] == [False, True, True, True, False]
    for box, length in zip(boxes[1:4], (0.3, 0.2, 0.1), strict=True):
        assert float(box.find("origin").get("xyz").split()[0]) == pytest.approx(length / 2)
        assert float(box.find("geometry/box").get("size").split()[0]) == pytest.approx(length)


@pytest.mark.parametrize(
    ("limits", "placement", "says"),
    [
        (None, None, "arm.placement: is missing"),
        ([None, (0, None), None], {}, "limits.1: has one end only"),
        (None, {"frame": "joint1_link"}, "has two links named 'joint1_link'"),
        (None, {"frame": "tool"}, "has two links named 'tool'"),
    ],
)
def test_what_urdf_cannot_say_is_refused(limits, placement, says, tmp_path):
    with pytest.raises(sm.InvalidInputError, match=says):
        sm.save_urdf(sm.PlanarArm([1, 1, 1], limits, placement=placement), tmp_path / "arm.urdf")
    assert not list(tmp_path.iterdir())


def test_the_command_writes_it_and_keeps_somebody_s_file(run, seed_file, tmp_path):
    place = {"base": [0, 0, 400], "plane": "xz", "unit": "mm", "frame": "cell"}
    arm = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, np.pi], None]}
    out = tmp_path / "arm.urdf"
    code, said, err = run("urdf", seed_file(arm={**arm, "placement": place}), "--out", str(out))
    assert (code, err) == (0, "")
    assert said == f"3 joints written to {out}\n  reach 0.08 m, base at (0, 0, 0.4) m in cell\n"
    assert sm.load_chain(out).base == "cell"
    code, _, err = run("urdf", seed_file(arm=arm), "--out", str(out))
    assert code == 2
    assert "arm.placement: is missing" in err
    assert "problem.json" in err
    out.write_text("mine")
    code, _, err = run("urdf", seed_file(arm={**arm, "placement": place}), "--out", str(out))
    assert code == 2
    assert "--force" in err
    assert out.read_text() == "mine"
    assert run("urdf", seed_file(arm={**arm, "placement": place}), "--out", str(out), "--force")[0] == 0


def test_a_placement_in_a_problem_file_is_checked_field_by_field(run, seed_file, tmp_path):
    arm = {"kind": "planar", "links": [30, 30, 20]}
    for place, says in (
        ({"plane": "xq"}, "arm.placement.plane"),
        ({"plan": "xz"}, "arm.placement.plan: is not a known field; did you mean 'plane'?"),
        ({"joints": ["a"]}, "arm.placement.joints"),
        ("xz", "arm.placement"),
    ):
        code, _, err = run("urdf", seed_file(arm={**arm, "placement": place}), "--out", str(tmp_path / "a.urdf"))
        assert code == 2
        assert says in err, err


def test_what_goes_out_bears_the_placement_s_names_and_stored_plans_keep_it(run, seed_file, tmp_path):
    pytest.importorskip("toppra")
    place = {"base": [0, 0, 400], "plane": "xz", "unit": "mm", "frame": "cell", "joints": ["a1", "a2", "a3"]}
    arm = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, np.pi], None], "placement": place}
    stored = tmp_path / "stored.json"
    assert run("plan", seed_file(arm=arm), "--save", str(stored))[0] == 0
    again = sm.load_plan(stored).problem.arm.placement
    assert again.as_mapping() == sm.load_problem(seed_file(arm=arm)).problem.arm.placement.as_mapping()
    for form in ("json", "npz", "ros"):
        out = tmp_path / f"t.{form}"
        limits = ("--max-velocity", "1", "--max-acceleration", "4")
        code, said, _ = run("time", str(stored), *limits, "--format", form, "--out", str(out), "--json")
        assert code == 0
        assert json.loads(said)["frame_id"] == "cell"
        rows = sm.load_trajectory(out)
        assert rows.joint_names == ("a1", "a2", "a3")
        assert rows.frame_id == "cell"
