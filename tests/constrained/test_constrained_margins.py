"""Margins against shapely and searches along links; gradients against differences."""

import numpy as np
import pytest
from small_scenes import planar, postures, spatial

pytest.importorskip("shapely")

import selfmotion as sm
from clearance import Planar, Spatial, by_coal
from selfmotion.arms.cells import Cells
from selfmotion.constrained import SingularityMargin
from selfmotion.scene import BoxObstacle, CircleObstacle, MeshObstacle, PolygonObstacle, Scene

TORCH = {"translation": [0.05, 0.02, 0.15], "rpy": [0.0, 0.6, 0.0]}
ARMS = [("panda", None), ("iiwa14", None), ("ur5e", TORCH), ("kr6r900", TORCH)]


def agree(margins, left, scale):
    """Positive margins are exact; where something is touched, both are negative or rounding."""
    assert np.abs(margins - left)[left > 1e-9 * scale].max(initial=0.0) < 1e-9 * scale
    assert (margins[left < -1e-9 * scale] < 0.0).all()
    assert (margins[left <= 1e-9 * scale] <= 2e-9 * scale).all()
    assert (left > 0).any()
    assert (left < 0).any()


def box_mesh(size, at):
    """A cube as a mesh, from a corner on."""
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return MeshObstacle.of_triangles(size * corners + at, faces)


@pytest.mark.parametrize("seed", range(8))
def test_margins_in_the_plane_are_those_of_shapely(seed):
    problem = planar(seed)
    q = postures(problem, np.random.default_rng(seed), 1500)
    agree(problem.scene.margins(q).min(axis=1), Planar(problem).left(q), problem.arm.reach)


@pytest.mark.parametrize(("name", "tool"), ARMS)
def test_margins_in_space_are_those_of_a_search(name, tool):
    problem = spatial(name, tool)
    q = postures(problem, np.random.default_rng(1), 300)
    left = Spatial(problem).left(q)
    agree(np.append(problem.scene.margins(q).min(axis=1), [1.0, -1.0]), np.append(left, [1.0, -1.0]), problem.arm.reach)


def test_margins_from_boxes_are_those_of_coal():
    pytest.importorskip("coal")
    box = BoxObstacle((0.3, 0.3, 0.5), (0.2, 0.3, 0.4), (0.3, 0.2, -0.5))
    x = spatial().path
    problem = sm.Problem(spatial().arm.bare, x, obstacles=[box])
    q = postures(problem, np.random.default_rng(2), 60)
    oracle = Spatial(problem)
    ends, left = oracle.ends(q), np.full(len(q), np.inf)
    for c in oracle.moving:
        left = np.minimum(left, by_coal(box, ends[:, c, 0], ends[:, c, 1], oracle.parts[c].radius))
    margins = problem.scene.margins(q).min(axis=1)
    apart = left > 1e-3
    assert apart.sum() > 20
    np.testing.assert_allclose(margins[apart], left[apart], atol=1e-5)
    assert (margins[left < -1e-3] < 0).all()


def differences(constraint, q, step=1e-6):
    rates = []
    for j in range(q.shape[1]):
        turn = np.zeros(q.shape[1])
        turn[j] = step
        rates.append((constraint.margins(q + turn) - constraint.margins(q - turn)) / (2 * step))
    return np.stack(rates, axis=-1)


def check_gradients(problem, q, positive):
    for constraint in problem.arm.constraints:
        margins, rates = constraint.gradients(q)
        np.testing.assert_allclose(margins, constraint.margins(q), atol=1e-12)
        # Where a margin has a kink, differences to both sides are no derivative: these are few.
        smooth = margins > -constraint.scale if not positive else margins > 1e-3
        off = np.abs(rates - differences(constraint, q)).max(axis=-1)[smooth]
        assert np.quantile(off, 0.98) < 1e-5 * constraint.scale
        assert len(off) > 30


@pytest.mark.parametrize("seed", range(6))
def test_gradients_in_the_plane_are_those_of_differences(seed):
    problem = planar(seed)
    check_gradients(problem, postures(problem, np.random.default_rng(seed), 200), True)


@pytest.mark.parametrize(("name", "tool"), ARMS)
def test_gradients_in_space_are_those_of_differences(name, tool):
    problem = spatial(name, tool)
    check_gradients(problem, postures(problem, np.random.default_rng(3), 60), True)


@pytest.mark.parametrize("arm", ["3R", "4R", *[name for name, _ in ARMS]])
def test_singular_values_change_no_faster_than_is_said(arm):
    """The bound that enclosures rest on, tried by going uphill: no step raises σ by more."""
    bare = {"3R": sm.PlanarArm([1.0, 0.3, 2.0]), "4R": sm.PlanarArm([1.0, 0.5, 0.4, 0.3], direction=0.3)}.get(arm)
    bare = bare or sm.named_arm(arm, tool=dict(ARMS)[arm])
    margin, rng = SingularityMargin(bare, 0.05), np.random.default_rng(7)
    q = rng.uniform(-np.pi, np.pi, (3000, bare.n))
    most = np.zeros(bare.n)
    for size in (1e-5, 0.1, 1.0):
        for j in range(bare.n):
            step = np.zeros(bare.n)
            step[j] = size
            most[j] = max(most[j], np.abs(margin.margins(q + step) - margin.margins(q)).max() / size)
        step = rng.normal(0.0, size, q.shape)
        change = np.abs(margin.margins(q + step) - margin.margins(q))[:, 0]
        assert (change <= np.abs(step) @ margin._fastest + 1e-12).all()
    assert (most <= margin._fastest).all()
    assert most.max() > 0.05


def test_meshes_far_away_change_nothing_but_the_time(monkeypatch):
    """Where a mesh's extent says enough its distance is not asked for: least margins and verdicts are the same."""
    pytest.importorskip("coal")
    meshes = [box_mesh(0.2, [0.4, 0.0, 0.3]), box_mesh(0.2, [-0.5, 0.3, 0.6])]
    arm, rng = sm.named_arm("panda"), np.random.default_rng(3)
    scene = Scene(arm, meshes, clearance=0.03)
    q = rng.uniform(arm.limits.lower, arm.limits.upper, (400, arm.n))
    least, which = scene.least_margins(q)
    every = scene.margins(q)
    assert np.array_equal(least, every.min(axis=1))
    assert np.array_equal(every[np.arange(len(q)), which], least)
    ends = q + rng.normal(0.0, 0.02, q.shape)
    cells = Cells(q, ends, np.full(q.shape, 1e-3), np.zeros((len(q), 4)), np.arange(len(q)))
    state = scene.of_cells(cells).state
    assert {-1, 1} <= set(state.tolist())
    monkeypatch.setattr(MeshObstacle, "no_less", lambda self, p, q: np.full(len(p), -np.inf))
    assert np.array_equal(scene.of_cells(cells).state, state)


def test_what_distances_to_meshes_are_short_by_blocks_nothing():
    """A cube as a mesh, and a clearance that is kept by less than coal is sure of: undecided, not blocked."""
    pytest.importorskip("coal")
    arm, mesh = sm.named_arm("panda"), box_mesh(1.0, [0.5, 0.6, 0.1])
    q = np.array([[0.1, 0.3, -0.2, -1.5, 0.2, 1.6, 0.4]])
    point = Cells(q, q, np.zeros_like(q), np.zeros((1, 4)), np.arange(1))
    far = float(Scene(arm, [BoxObstacle((1.0, 1.1, 0.6), (1.0, 1.0, 1.0))]).least_margins(q)[0][0])
    assert far > 0.0
    assert Scene(arm, [mesh], clearance=far - 5e-8).of_cells(point).state == 0
    assert Scene(arm, [mesh], clearance=far - 1e-6).of_cells(point).state == 1
    assert Scene(arm, [mesh], clearance=far + 1e-6).of_cells(point).state == -1


def test_obstacles_out_of_reach_are_doubted_with_self_collision_too():
    arm = sm.PlanarArm([1.0, 1.0, 1.0], thickness=0.1)
    for self_collision in (False, True):
        (doubt,) = Scene(arm, [CircleObstacle((1e3, 0.0), 1.0)], 0.0, self_collision).doubts()
        assert "no obstacle is in reach" in doubt


@pytest.mark.parametrize(("size", "by"), [(600.0, "0.001"), (6e-4, "1000")])
def test_meshes_in_another_unit_are_doubted(size, by):
    """A mesh in millimetres encloses the arm, and so is not out of reach: its size alone gives it away."""
    pytest.importorskip("coal")
    arm, at = sm.named_arm("panda"), [0.3, 0.2, 0.1]
    mesh = box_mesh(size, at)
    mesh.name = "bench"
    (doubt,) = Scene(arm, [mesh]).doubts()
    assert doubt.startswith(f"obstacle 1 (bench): the mesh extends over {size:.3g}")
    assert f"{by} times as large" in doubt
    assert "scale" in doubt
    assert Scene(arm, [box_mesh(0.6, at), box_mesh(20.0, [-10.0, -10.0, -21.0])]).doubts() == []


def test_turns_of_obstacles_in_degrees_are_doubted(tmp_path):
    pytest.importorskip("coal")
    arm, file = sm.named_arm("panda"), tmp_path / "corner.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")

    def scene(rpy):
        return Scene(arm, [BoxObstacle((0.5, 0.0, 0.2), (0.1, 0.1, 0.1), rpy), MeshObstacle(str(file), rpy=rpy)])

    said = "rpy turns by 90 rad, more than a full turn: is it in degrees? it is in radians"
    assert scene((0.0, 0.0, 90.0)).doubts() == [f"obstacle 1: {said}", f"obstacle 2: {said}"]
    assert scene((0.0, 0.0, 2 * np.pi)).doubts() == []


@pytest.mark.parametrize("obstacle", [CircleObstacle((0.0, 9.0), 1.0), PolygonObstacle([[0, 9], [1, 9], [1, 10]])])
def test_nothing_is_sure_of_what_is_no_number(obstacle):
    q = np.array([[np.nan, 0.0, 0.0]])
    cell = Cells(q, q, np.zeros_like(q), np.zeros((1, 4)), np.arange(1))
    assert Scene(sm.PlanarArm([1.0, 1.0, 1.0]), [obstacle]).of_cells(cell).state == 0
