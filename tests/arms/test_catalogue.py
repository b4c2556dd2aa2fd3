"""Arms by name and from URDF files: what they are, what a tool and other limits make of them, what is refused."""

import subprocess
import sys
from importlib.resources import files

import jsonschema
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import selfmotion as sm
from selfmotion.arms import ARMS, CATALOGUE, how_solved
from selfmotion.exchange.schema import build, json_schema
from selfmotion.rotations import matrix

DATA = files("selfmotion.arms") / "data"
SEVEN = [name for name in CATALOGUE if CATALOGUE[name].chain().n == 7]
SIX = [name for name in CATALOGUE if CATALOGUE[name].chain().n == 6]
PATH = {"kind": "line", "start": [1, 0], "end": [2, 0]}


def transforms(poses):
    """Poses (k, 7) as matrices (k, 4, 4)."""
    found = np.tile(np.eye(4), (len(poses), 1, 1))
    found[:, :3, :3], found[:, :3, 3] = matrix(poses[:, 3:]), poses[:, :3]
    return found


def postures(arm, count=50):
    return np.random.default_rng(1).uniform(arm.limits.lower, arm.limits.upper, (count, arm.n))


def test_the_catalogue_is_the_folder_of_data_files():
    assert sorted(entry.file for entry in CATALOGUE.values()) == sorted(file.name for file in DATA.iterdir())
    assert all(entry.file == f"{name}.urdf" for name, entry in CATALOGUE.items())


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_entry_says_what_it_is(name):
    entry = CATALOGUE[name]
    chain = entry.chain()
    assert (chain.base, chain.tip) == (entry.base, entry.tip)
    assert all((entry.title, entry.maker, entry.source))
    assert chain.limits.limited.all()


def test_the_pandas_tool_frame_is_its_hand():
    last = CATALOGUE["panda"].chain().offsets[-1]
    np.testing.assert_allclose(last[:3, 3], [0, 0, 0.107], atol=1e-15)
    np.testing.assert_allclose(last[:3, :3], Rotation.from_euler("z", -45, degrees=True).as_matrix(), atol=1e-12)


@pytest.mark.parametrize("name", SEVEN)
def test_a_named_arm_moves_as_its_chain_and_is_solved_on_every_branch_it_lists(name):
    arm, solved = sm.named_arm(name), how_solved(name)
    assert isinstance(arm, sm.SpatialArm)
    assert (solved.joints, solved.branches, solved.why_not) == (7, len(arm.branches), None)
    assert solved.closed_form
    assert solved.rigorous
    assert solved.parameter == {"p": "q7", "f": "q7", "i": "arm angle"}[name[0]]
    q = postures(arm)
    np.testing.assert_allclose(transforms(arm.forward(q)), CATALOGUE[name].chain().forward(q), atol=1e-12)
    back, ok = zip(*(arm.solve(arm.forward(q), arm.u_of(q), b) for b in range(solved.branches)), strict=True)
    near = [np.where(r, np.abs((p - q + np.pi) % (2 * np.pi) - np.pi).max(axis=-1), 9) for p, r in zip(back, ok)]  # noqa: B905
    assert np.min(near, axis=0).max() < 1e-6


@pytest.mark.parametrize("name", SIX)
def test_a_named_arm_with_six_joints_lets_its_tool_roll(name):
    arm, solved = sm.named_arm(name), how_solved(name)
    assert (solved.joints, solved.parameter, solved.branches) == (6, "roll", len(arm.branches))
    assert (arm.n, arm.n_u, arm.dimension) == (6, 1, 7)
    q = postures(arm)
    np.testing.assert_allclose(transforms(arm.forward(q)), CATALOGUE[name].chain().forward(q), atol=1e-12)


@pytest.mark.parametrize("name", ["panda", "ur5e"])
def test_an_arm_s_joints_are_points_that_keep_their_distances_and_end_at_the_tool(name):
    arm = sm.named_arm(name)
    points = arm.joint_positions(postures(arm))
    assert points.shape == (50, arm.n + 1, 3)
    np.testing.assert_allclose(points[:, -1], arm.forward(postures(arm))[:, :3], atol=1e-12)
    lengths = np.linalg.norm(np.diff(points, axis=1), axis=2)
    np.testing.assert_allclose(lengths, lengths[:1] + 0 * lengths, atol=1e-12)
    assert lengths[0].max() > 0.1
    with pytest.raises(sm.InvalidInputError, match="one redundant degree"):
        arm.line([0.0], [1.0])


def test_an_arm_with_fewer_joints_than_its_task_is_refused_with_their_number(tmp_path):
    (tmp_path / "robot.urdf").write_bytes((DATA / "panda.urdf").read_bytes())
    with pytest.raises(sm.InvalidInputError, match="file: has 5 joints, fewer than") as caught:
        sm.urdf_arm(tmp_path / "robot.urdf", tip="panda_link5")
    assert "seven" in caught.value.remedy


TURN = Rotation.from_euler("xyz", [0.3, -0.5, 1.1])
TURNED = {
    "rpy": [0.3, -0.5, 1.1],
    "quaternion": np.roll(TURN.as_quat(), 1).tolist(),
    "matrix": TURN.as_matrix().tolist(),
    "nothing": None,
}


@pytest.mark.parametrize("way", TURNED)
def test_a_tool_is_a_transform_after_the_tip(way):
    tool = {"translation": [0.01, -0.02, 0.1], **({} if way == "nothing" else {way: TURNED[way]})}
    data = {"kind": "named", "name": "panda", "tool": tool}
    jsonschema.validate({"arm": data, "path": PATH}, json_schema())
    arm, bare = build("arm", data), sm.named_arm("panda")
    after = np.eye(4)
    after[:3, 3] = tool["translation"]
    after[:3, :3] = np.eye(3) if way == "nothing" else TURN.as_matrix()
    q = postures(bare)
    np.testing.assert_allclose(transforms(arm.forward(q)), transforms(bare.forward(q)) @ after, atol=1e-9)


def test_limits_replace_those_of_the_catalogue_and_null_frees_a_joint():
    limits = [[-1, 1], None, [None, 2], *[[-0.5, 0.5]] * 4]
    data = {"kind": "named", "name": "iiwa7", "limits": limits}
    jsonschema.validate({"arm": data, "path": PATH}, json_schema())
    arm = build("arm", data)
    assert arm.limits.as_list() == limits
    np.testing.assert_array_equal(arm.chain.velocity, CATALOGUE["iiwa7"].chain().velocity)


def test_an_arm_from_a_file_is_the_one_by_name(tmp_path):
    (tmp_path / "robot.urdf").write_bytes((DATA / "panda.urdf").read_bytes())
    data = {"kind": "urdf", "file": "robot.urdf", "base": "panda_link0", "tip": "panda_hand"}
    jsonschema.validate({"arm": data, "path": PATH}, json_schema())
    arm, named = build("arm", data, str(tmp_path)), sm.named_arm("panda")
    np.testing.assert_array_equal(arm.chain.offsets, named.chain.offsets)
    assert arm.limits.as_list() == named.limits.as_list()
    np.testing.assert_array_equal(sm.urdf_arm(tmp_path / "robot.urdf").chain.offsets, named.chain.offsets)


BAD = {
    "name": {"name": "pandas"},
    "tool": {"tool": {"rpy": [0, 0, 1], "quaternion": [1, 0, 0, 0]}},
    "tool.rotation": {"tool": {"rotation": [0, 0, 1]}},
    "tool.quaternion": {"tool": {"quaternion": [1, 1, 0, 0]}},
    "tool.matrix": {"tool": {"matrix": [[2, 0, 0], [0, 2, 0], [0, 0, 2]]}},
    "tool.translation": {"tool": {"translation": [0, 1]}},
    "limits": {"limits": [None] * 6},
    "limits.2": {"limits": [None, None, [1, -1], None, None, None, None]},
}


@pytest.mark.parametrize("field", BAD)
def test_bad_arms_name_their_field_and_a_remedy(field):
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.named_arm(**{"name": "panda", **BAD[field]})
    assert caught.value.field == field
    assert caught.value.remedy
    if field == "name":
        assert "did you mean 'panda'?" in caught.value.remedy
        assert "iiwa14" in caught.value.remedy


def test_seven_joints_that_no_closed_form_solves_are_refused_without_eaik(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "eaik.pybindings", None)
    text = (DATA / "panda.urdf").read_text().replace('rpy="-1.570796326794897 0 0"', 'rpy="-1.5 0 0"', 1)
    assert 'rpy="-1.5 0 0"' in text
    (tmp_path / "bent.urdf").write_text(text)
    with pytest.raises(sm.InvalidInputError, match="file: has 7 joints that no closed form solves") as caught:
        sm.urdf_arm(tmp_path / "bent.urdf")
    assert "panda" in caught.value.remedy


def test_arms_are_listed_and_problems_read_without_compiling_anything():
    code = "import sys, selfmotion.exchange; from selfmotion.arms import ARMS; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    assert list(ARMS) == ["planar", "named", "urdf"]
