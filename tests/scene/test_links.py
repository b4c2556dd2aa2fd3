"""Links: levers never below what postures show, capsules where the chain takes them, pairs that may meet."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

import selfmotion as sm
from selfmotion.arms.catalogue import CATALOGUE
from selfmotion.arms.chain import Chain, turned_to_z
from selfmotion.arms.shapes import Capsule, Shapes
from selfmotion.errors import InvalidInputError
from selfmotion.rotations import matrix
from selfmotion.scene.links import Links, segment_distances

NAMES = sorted(CATALOGUE)


def of_chain(chain):
    """Return the links of a chain that no arm may solve."""
    return Links.of(SimpleNamespace(chain=chain))


def rods(chain, rng):
    """Return a chain with random capsules, one in every frame."""
    parts = [Capsule(f"link {j}", j, rng.normal(0, 0.2, (2, 3)), 0.01) for j in range(-1, chain.n)]
    return chain.with_shapes(Shapes(tuple(parts)))


def postures(limits, count, rng):
    low, high = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
    found = rng.uniform(low, high, (count, len(low)))
    # Extremes are where joints are straight, at right angles or at their limits.
    special = np.array([0.0, np.pi / 2, -np.pi / 2, np.pi])[rng.integers(0, 4, found.shape)]
    special = np.where(rng.random(found.shape) < 0.2, np.where(rng.random(found.shape) < 0.5, low, high), special)
    return np.concatenate([found, np.clip(special, low, high)])


def seen(links, q, step=1e-6):
    """Return how fast ends move by each joint, at most, from differences of placed ends."""
    most = np.zeros_like(links.levers)
    for j in range(q.shape[1]):
        by = np.zeros(q.shape[1])
        by[j] = step
        rate = (links.ends_at(q + by) - links.ends_at(q - by)) / (2 * step)
        most[:, :, j] = np.linalg.norm(rate, axis=-1).max(axis=0)
    return most


def random_chain(rng, n, slides=0):
    turns = matrix(rng.normal(size=(n + 1, 4)) / np.linalg.norm(rng.normal(size=(n + 1, 4)), axis=1)[:, None])
    origins = np.broadcast_to(np.eye(4), (n + 1, 4, 4)).copy()
    origins[:, :3, :3] = np.linalg.qr(turns)[0]
    origins[:, :3, :3] *= np.linalg.det(origins[:, :3, :3])[:, None, None]
    origins[:, :3, 3] = rng.normal(0, 0.3, (n + 1, 3)) * (rng.random((n + 1, 3)) < 0.6)
    limits = [sorted(rng.uniform(-2, 2, 2)) if k < slides or rng.random() < 0.5 else None for k in range(n)]
    names = [f"j{k}" for k in range(n)]
    return Chain(names, turned_to_z(origins, rng.normal(size=(n, 3))), limits, np.arange(n) < slides)


@pytest.mark.parametrize("name", NAMES)
def test_no_posture_is_faster_than_the_levers_and_they_are_near(name):
    rng = np.random.default_rng(3)
    chain = rods(CATALOGUE[name].chain(), rng)
    links = of_chain(chain)
    most = seen(links, postures(chain.limits, 5000, rng))
    assert (links.levers >= most - 1e-8).all()
    moved = most > 1e-3
    assert (links.levers[moved] <= 1.5 * most[moved]).all()
    assert np.mean(links.levers[moved] / most[moved]) < 1.15


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 7), slides=st.integers(0, 2))
def test_no_posture_of_any_chain_is_faster_than_the_levers(seed, n, slides):
    rng = np.random.default_rng(seed)
    chain = rods(random_chain(rng, n, min(slides, n)), rng)
    links = of_chain(chain)
    assert (links.levers >= seen(links, postures(chain.limits, 200, rng)) - 1e-8).all()


def test_levers_are_one_for_joints_that_slide_and_zero_beyond_a_link():
    chain = CATALOGUE["irb120"].chain().on_rail([0, 1, 0], [-1, 1])
    links = of_chain(rods(chain, np.random.default_rng(0)))
    assert links.first == 1
    moved = links.frame[:, None] >= np.arange(chain.n)
    assert (links.levers[:, :, 0] == np.where(moved[:, :1], 1.0, 0.0)).all()
    assert (links.levers[~moved[:, None, :].repeat(2, axis=1)] == 0).all()
    assert (links.levers[moved[:, None, :].repeat(2, axis=1)] > 0).all()


@pytest.mark.parametrize(("links", "direction"), [([3, 2, 1], None), ([3, 2, 1, 0.5], 0.3), ([1] * 7, None)])
def test_links_of_the_plane_reach_from_joint_to_joint(links, direction):
    arm = sm.PlanarArm(links, direction=direction)
    made = Links.of(arm)
    q = np.random.default_rng(1).uniform(-3, 3, (50, arm.n))
    points = arm.joint_positions(q)
    ends = made.ends_at(q)
    assert np.abs(ends[..., 0, :2] - points[:, :-1]).max() < 1e-14 * 50
    assert np.abs(ends[..., 1, :2] - points[:, 1:]).max() < 1e-14 * 50
    assert not ends[..., 2].any()
    assert made.names[0] == "link 1"
    assert (made.radius == 0).all()
    # The farthest a tip is from a joint is all links between them in a row.
    expected = np.cumsum(links[::-1])[::-1]
    assert made.levers[-1, 1] == pytest.approx(expected, rel=1e-12)
    assert made.pairs.tolist() == [[i, k] for i in range(arm.n) for k in range(i + 2, arm.n)]


@pytest.mark.parametrize(
    ("thickness", "radius"), [(0.2, [0.1] * 3), ([0.2, 0.4, 0.6], [0.1, 0.2, 0.3]), (0.0, [0] * 3)]
)
def test_links_of_the_plane_are_as_thick_as_the_arm_says(thickness, radius):
    assert Links.of(sm.PlanarArm([3, 2, 1], thickness=thickness)).radius == pytest.approx(radius)


def test_links_that_always_touch_are_never_checked():
    """A link shorter than its neighbours are thick: these touch across it in every posture."""
    links = [1.0, 0.1, 1.0, 1.0]
    assert Links.of(sm.PlanarArm(links, thickness=0.3)).pairs.tolist() == [[0, 3], [1, 3]]
    assert Links.of(sm.PlanarArm(links, thickness=0.05)).pairs.tolist() == [[0, 2], [0, 3], [1, 3]]


def test_an_arm_of_a_thousand_links_is_no_matter():
    arm = sm.PlanarArm(np.ones(1000))
    made = Links.of(arm)
    assert len(made.pairs) == 999 * 998 // 2
    assert made.levers[-1, 1, 0] == pytest.approx(1000.0)


@pytest.mark.parametrize("name", NAMES)
def test_capsules_are_where_the_chain_takes_them(name):
    """Each link's capsules against the forward kinematics of the chain that ends in it."""
    entry = CATALOGUE[name]
    arm = sm.named_arm(name)
    links = Links.of(arm)
    rng = np.random.default_rng(2)
    q = rng.uniform(-1, 1, (20, arm.n))
    ends = links.ends_at(q)
    for k, (frame, link) in enumerate(zip(links.frame, links.names, strict=True)):
        if frame < 0:
            assert (ends[:, k] == links.ends[k]).all()
            continue
        shorter = sm.arms.chain.Chain(
            arm.chain.names[: frame + 1], [*arm.chain.offsets[: frame + 1], np.eye(4)],
            arm.chain.limits.as_list()[: frame + 1],
        )  # fmt: skip
        pose = shorter.forward(q[:, : frame + 1])
        expected = np.einsum("pxy,ky->pkx", pose[:, :3, :3], links.ends[k]) + pose[:, None, :3, 3]
        assert np.abs(ends[:, k] - expected).max() < 1e-14, link
    assert set(links.names) <= {*_links_of(entry.file)}


def _links_of(file):
    from importlib.resources import files
    from xml.etree import ElementTree

    robot = ElementTree.fromstring((files("selfmotion.arms") / "data" / file).read_text("utf-8"))
    return [link.get("name") for link in robot.findall("link")]


@pytest.mark.parametrize("name", NAMES)
def test_shipped_arms_cover_their_axes_and_can_hold_still(name):
    """Every joint's origin is inside a link or touches the gap to the next one, and most postures meet nothing."""
    arm = sm.named_arm(name)
    links = Links.of(arm)
    rng = np.random.default_rng(4)
    low, high = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    q = rng.uniform(low, high, (500, arm.n))
    ends = links.ends_at(q)
    points = arm.joint_positions(q)[:, 1:-1]
    rods, spots = np.broadcast_arrays(ends[:, None], np.stack([points, points], axis=-2)[:, :, None])
    gap = (segment_distances(rods, spots) - links.radius).min(axis=-1)
    assert gap.max() < 0.03
    one, other = links.pairs.T
    meets = segment_distances(ends[:, one], ends[:, other]) <= links.radius[one] + links.radius[other]
    assert not meets.all(axis=0).any()
    assert (~meets.any(axis=1)).mean() > 0.3


def test_links_said_never_to_meet_are_not_checked():
    chain = rods(CATALOGUE["panda"].chain(), np.random.default_rng(0))
    told = chain.with_shapes(Shapes(chain.shapes.capsules, apart=(("link 5", "link 0"),)))
    everything = of_chain(chain).pairs.tolist()
    assert [pair for pair in everything if pair not in of_chain(told).pairs.tolist()] == [[1, 6]]


def test_a_closed_form_s_own_angles_play_no_part():
    """Capsules are placed by the arm's joint positions, from which kernels may count otherwise."""
    arm = sm.named_arm("kr6r900", tool={"translation": [0, 0, 0.1], "rpy": [0, 0.4, 0]})
    assert arm.shift.any()
    q = np.array([[0.3, -1.0, 0.9, 0.2, -0.4, 0.1]])
    flange = Links.of(arm).ends_at(q)[0, -1]
    assert np.linalg.norm(flange.mean(axis=0) - arm.joint_positions(q)[0, -2]) < 0.05


def test_shapes_that_are_not_known_are_named():
    with pytest.raises(InvalidInputError, match="no links with a shape"):
        of_chain(Chain(["a"], [np.eye(4)] * 2))
    part = Capsule("arm", 0, np.zeros((2, 3)), 1.0)
    shapes = Shapes((part,), {"wrist": "has a mesh, which is not read"})
    with pytest.raises(InvalidInputError, match="wrist has a mesh, which is not read; give it <collision>"):
        of_chain(Chain(["a"], [np.eye(4)] * 2, shapes=shapes))
    with pytest.raises(InvalidInputError, match="joint b, which slides beyond one that turns"):
        of_chain(Chain(["a", "b"], [np.eye(4)] * 3, [None, (0, 1)], [False, True], shapes=Shapes((part,))))


def test_postures_of_another_arm_are_refused():
    with pytest.raises(InvalidInputError, match="give"):
        Links.of(sm.PlanarArm([3, 2, 1])).ends_at(np.zeros(4))


NUMBER = st.floats(-2, 2).map(lambda value: round(value, 3))


@settings(max_examples=200, deadline=None)
@given(arrays(float, (2, 2, 3), elements=NUMBER))
def test_segments_are_as_far_apart_as_their_nearest_points(pair):
    """Never more than between any two points, and reached by some, within the step of the grid."""
    part = np.linspace(0, 1, 41)
    one, other = (ends[0] + part[:, None] * (ends[1] - ends[0]) for ends in pair)
    grid = np.linalg.norm(one[:, None] - other, axis=-1).min()
    step = (np.linalg.norm(pair[0, 1] - pair[0, 0]) + np.linalg.norm(pair[1, 1] - pair[1, 0])) / 80
    found = segment_distances(pair[0], pair[1])
    assert found <= grid + 1e-9
    assert found >= grid - step - 1e-9
