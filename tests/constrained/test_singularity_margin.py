"""What the margin from singular postures says of cells and boxes: true, and sharp beside the margin."""

import numpy as np
import pytest
from small_scenes import within

import selfmotion as sm
from selfmotion.arms.cells import Cells
from selfmotion.constrained import BLOCKED, FREE, SingularityMargin
from selfmotion.scene import CircleObstacle

TORCH = {"translation": [0.05, 0.02, 0.15], "rpy": [0.0, 0.6, 0.0]}
ARMS = {
    "3R": lambda: sm.PlanarArm([1.0, 0.3, 2.0]),
    "4R": lambda: sm.PlanarArm([1.0, 0.5, 0.4, 0.3], direction=0.3),
    "short": lambda: sm.PlanarArm([0.1, 0.05, 0.08]),
    "panda": lambda: sm.named_arm("panda"),
    "iiwa14": lambda: sm.named_arm("iiwa14"),
    "ur5e": lambda: sm.named_arm("ur5e", tool=TORCH),
    "irb120": lambda: sm.named_arm("irb120", tool=TORCH),
}


@pytest.fixture(params=ARMS, scope="module")
def arm(request):
    return ARMS[request.param]()


def cells_at_the_margin(margin, arm, size, rng, count=400):
    """Cells of one `size` whose middles are about as near to singular postures as they may be, or 3 sizes off."""
    q = rng.uniform(-np.pi, np.pi, (count, arm.n))
    for _ in range(30):
        lack, rate = margin.gradients(q)
        slope = rate[:, 0]
        step = -lack * slope / np.maximum((slope**2).sum(axis=1, keepdims=True), 1e-3)
        q = q + np.clip(step, -0.2, 0.2)
    q = q[np.abs(margin.margins(q)[:, 0]) < 1e-9]
    assert len(q) > 50
    q = q + size * rng.uniform(-3.0, 3.0, (len(q), 1)) * margin.gradients(q)[1][:, 0]
    half = rng.normal(size=q.shape)
    half *= 0.5 * size / np.linalg.norm(half, axis=1, keepdims=True)
    dev = size**2 * rng.uniform(0.0, 1.0, q.shape) * rng.choice([0.0, 1.0], (len(q), 1))
    return Cells(q - half, q + half, dev, np.zeros((len(q), 4)), np.arange(len(q)))


def test_jacobians_bend_no_more_than_is_said(arm):
    """The other bound that enclosures rest on, tried by second differences along single joints, pairs and all."""
    margin, rng, h = SingularityMargin(arm, 0.04), np.random.default_rng(5), 1e-4
    if not np.isfinite(margin._bend):
        pytest.skip("the tool may roll: nothing is said")
    q = rng.uniform(-np.pi, np.pi, (4000, arm.n))
    step = rng.normal(size=q.shape) * (rng.random(q.shape) < rng.choice([0.15, 0.4, 1.0], (len(q), 1)))
    step[:, -1] += ~step.any(axis=1)
    step /= np.abs(step).sum(axis=1, keepdims=True)
    one, middle, two = (margin._jacobian(q + k * h * step) for k in (-1, 0, 1))
    bend = np.linalg.norm(one - 2 * middle + two, axis=(1, 2)) / h**2
    assert 0.05 * margin._bend < bend.max() <= margin._bend * (1 + 1e-6)
    rate = np.linalg.norm(two - one, axis=(1, 2)) / (2 * h)
    assert (rate <= np.abs(step) @ margin._fastest * (1 + 1e-6)).all()


@pytest.mark.parametrize("size", [1e-3, 0.03, 0.3])
def test_what_is_said_of_cells_and_boxes_at_the_margin_is_true(arm, size):
    margin, rng = SingularityMargin(arm, 0.04), np.random.default_rng(11)
    cells = cells_at_the_margin(margin, arm, size, rng)
    low, high = np.minimum(cells.a, cells.b), np.maximum(cells.a, cells.b)
    of_cells, of_boxes = margin.of_cells(cells).state, margin.of_boxes(low, high).state
    for _ in range(60):
        corners = np.where(rng.random(low.shape) < 0.5, low, high)
        for state, q in ((of_cells, within(cells, rng)), (of_boxes, corners), (of_boxes, rng.uniform(low, high))):
            left = margin.margins(q)[:, 0]
            assert (left[state == FREE] >= -1e-12).all()
            assert (left[state == BLOCKED] < 0.0).all()


def test_small_cells_are_decided_by_how_fast_the_singular_value_does_change(arm):
    """Three of four cells that are all on one side are; by how fast it may change, fewer would be."""
    margin, rng = SingularityMargin(arm, 0.04), np.random.default_rng(12)
    if not np.isfinite(margin._bend):
        pytest.skip("the tool may roll: only by how fast it may")
    cells = cells_at_the_margin(margin, arm, 1e-5, rng)
    middle = 0.5 * (cells.a + cells.b)
    inside = np.stack([margin.margins(within(cells, rng))[:, 0] for _ in range(40)])
    for surely, state in (((inside < 0.0).all(axis=0), BLOCKED), ((inside >= 0.0).all(axis=0), FREE)):
        assert surely.sum() > 20
        told = (margin.of_cells(cells).state == state)[surely].mean()
        may = (np.abs(margin.margins(middle)[:, 0]) > 0.5 * np.abs(cells.b - cells.a) @ margin._fastest)[surely].mean()
        assert told > 0.75
        assert may < told - 0.05


def test_a_motion_that_stays_at_the_margin_is_found_and_verified(seed_problem):
    """Its singular value is the least allowed one along a stretch: by how fast σ may change nothing would be sure."""
    discs = [CircleObstacle((28.0, -22.0), 4.0), CircleObstacle((20.0, 30.0), 5.0), CircleObstacle((40.0, 24.0), 4.0)]
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None], thickness=2.0)
    problem = sm.Problem(arm, seed_problem.path, obstacles=discs, clearance=1.0, least_singular_value=0.205)
    plan = sm.plan(problem, sm.Global(gap=1e-2, time_limit=120.0))
    values = np.linalg.svd(problem.arm.jacobian(plan(np.linspace(0.0, 1.0, 20001))) / problem.arm.reach)[1][:, -1]
    assert 0.205 - 1e-9 <= values.min() < 0.205 + 1e-5
    assert (values < 0.205 + 1e-4).mean() > 0.02
    assert plan.gap <= 1e-2
