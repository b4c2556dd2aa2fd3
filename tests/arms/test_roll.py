"""Six-axis arms whose tool may roll: the task and its derivatives, covers, and plans."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms.catalogue import named_arm
from selfmotion.arms.roll import RollArm, _frame_spin, _reference

NAMES = ("irb120", "kr6r900", "ur5e", "ur10e")
TORCH = {"translation": [0.05, 0.02, 0.15], "rpy": [0.0, 0.6, 0.0]}


def arms():
    return [named_arm(name, tool=TORCH) for name in NAMES]


def postures(arm, rng, count):
    return rng.uniform(np.maximum(arm.limits.lower, -3), np.minimum(arm.limits.upper, 3), (count, 6))


def test_the_frame_of_rolls_is_one_and_turns_as_it_says():
    rng = np.random.default_rng(0)
    d = rng.normal(size=(50, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    d = d[d[:, 2] < 0.9]
    frame = _reference(d)
    assert np.abs(np.swapaxes(frame, 1, 2) @ frame - np.eye(3)).max() < 1e-14
    assert np.linalg.det(frame) == pytest.approx(1.0)
    assert (frame[:, :, 2] == d).all()
    change, h = np.cross(rng.normal(size=d.shape), d), 1e-6
    ahead, behind = ((d + s * h * change) / np.linalg.norm(d + s * h * change, axis=1)[:, None] for s in (1, -1))
    rate = (_reference(ahead) - _reference(behind)) / (2 * h) @ np.swapaxes(frame, 1, 2)
    spin = np.stack([rate[:, 2, 1], rate[:, 0, 2], rate[:, 1, 0]], axis=1)
    assert spin == pytest.approx(_frame_spin(d, change), abs=1e-7)


@pytest.mark.parametrize("arm", arms(), ids=NAMES)
def test_postures_are_found_again_at_their_roll(arm):
    assert isinstance(arm, RollArm)
    rng = np.random.default_rng(1)
    q = postures(arm, rng, 400)
    x, u, branch = arm.forward(q), arm.u_of(q), arm.branch_of(q)
    for b in range(8):
        found, ok = arm.solve(x[branch == b], u[branch == b], b)
        assert ok.all()
        assert arm.task_error(found, x[branch == b]).max(initial=0.0) < 1e-12
        off = np.abs(np.angle(np.exp(1j * (found - q[branch == b])))).max(axis=1)
        assert np.quantile(off, 0.99) < 1e-9
    # Only position and direction count: the same tool rolled by anything is the same task.
    rolled = x.copy()
    half = 0.5 * rng.uniform(-3, 3, len(x))
    w, a, b, c = x[:, 3:].T
    rolled[:, 3:] = np.stack(
        [w * np.cos(half) - c * np.sin(half), a * np.cos(half) + b * np.sin(half),
         b * np.cos(half) - a * np.sin(half), c * np.cos(half) + w * np.sin(half)], axis=1,
    )  # fmt: skip
    assert arm.task_error(q, rolled).max() < 1e-12


@pytest.mark.parametrize("arm", arms(), ids=NAMES)
def test_the_task_has_its_derivatives(arm):
    rng, h = np.random.default_rng(2), 1e-6
    q, dq = postures(arm, rng, 60), rng.normal(size=(60, 6))
    ahead, behind = arm.task_residual(q, arm.forward(q + h * dq)), arm.task_residual(q, arm.forward(q - h * dq))
    along = (arm.jacobian(q) @ dq[:, :, None])[:, :, 0]
    assert (ahead - behind) / (2 * h) == pytest.approx(along, abs=1e-6)
    rate = (arm.jacobian(q + h * dq) - arm.jacobian(q - h * dq)) / (2 * h)
    assert rate == pytest.approx(arm.jacobian_rate(q, dq), abs=1e-5)


@pytest.mark.parametrize("name", ["irb120", "ur5e"])
def test_covers_hold_postures_and_plans_are_bounded(name):
    arm = named_arm(name, tool=TORCH)
    cover, rng = arm.cover(), np.random.default_rng(3)
    for q in postures(arm, rng, 6):
        x = arm.forward(q)
        cells = cover.cells(x, 0.1)
        for branch in range(8):
            found, ok = arm.solve(np.tile(x, (30, 1)), rng.uniform(-np.pi, np.pi, (30, 1)), branch)
            for posture in found[ok & (arm.limits.excess(np.nan_to_num(found)) <= 0).all(axis=1)]:
                assert _is_held(cells, posture)
    start = np.array([0.3, -1.0, 1.2, 0.4, 0.9, 0.2]) if name == "ur5e" else np.array([0.3, 0.2, 0.3, 0.4, 0.9, 0.2])
    pose, t = arm.forward(start), np.linspace(0, 1, 11)[:, None]
    path = sm.PoseWaypoints(np.hstack([pose[:3] + t * np.array([0.0, 0.15, 0.05]), np.tile(pose[3:], (11, 1))]))
    plan = sm.plan(sm.Problem(arm, path, objective="l2", samples=100), sm.Global(gap=2e-2))
    assert plan.gap <= 2e-2
    assert plan.verification.holds


def _is_held(cells, q):
    """Whether a posture is in a cell, whole turns aside."""
    step = cells.b - cells.a
    off = np.angle(np.exp(1j * (q - cells.a)))
    length = (step**2).sum(axis=1)
    s = np.clip((off * step).sum(axis=1) / np.where(length > 0, length, 1.0), 0, 1)[:, None]
    return bool((np.abs(off - s * step) <= cells.dev * 1.001 + 1e-9).all(axis=1).any())


def test_a_branch_cannot_be_asked_for():
    arm = named_arm("ur5e")
    with pytest.raises(sm.InvalidInputError, match="cannot be asked of an arm whose tool rolls"):
        arm.cover(arm.branches[0])


@pytest.mark.parametrize("lean", [1e-3, 1e-5, 1e-8, 0.0])
def test_tools_that_point_straight_up_have_frames_and_covers(lean):
    frame = _reference(np.array([0.6 * lean, 0.8 * lean, np.sqrt(1 - lean**2)]))
    assert np.abs(frame.T @ frame - np.eye(3)).max() < 1e-15
    assert np.linalg.det(frame) == pytest.approx(1.0)
    arm = named_arm("ur5e", tool=TORCH)
    q = np.array([-1.43032719450, -1.20905313952, 1.88535444357, -1.6561242, 1.4603152, 1.73366431])
    turn = np.array([np.cos(0.2), np.sin(0.2) * 0.0, 0.0, np.sin(0.2)])
    if lean:
        turn = np.array([np.cos(lean / 2), -0.8 * np.sin(lean / 2), 0.6 * np.sin(lean / 2), 0.0])
    x = np.concatenate([arm.forward(q)[:3], turn])
    assert 100 < len(arm.cover().cells(x, 0.3)) < 2000
