"""The widest chain of postures: what it says of itself is so, and what the global planner makes of it."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.planners import globally_optimal
from selfmotion.planners.widest_chain import COARSE, FINE, widest_chain
from selfmotion.scene import CircleObstacle, HalfPlaneObstacle


def margins_of(problem):
    (scene,) = problem.arm.constraints
    return lambda q: scene.least_margins(q)[0]


@pytest.fixture
def gate(seed_arm, seed_path):
    discs = [CircleObstacle((28.0, -22.0), 4.0), CircleObstacle((20.0, 30.0), 5.0), CircleObstacle((40.0, 24.0), 4.0)]
    return sm.Problem(seed_arm, seed_path, start=[0.3], obstacles=discs)


@pytest.mark.parametrize("fineness", [COARSE, FINE], ids=["coarse", "fine"])
def test_its_postures_are_on_the_path_near_each_other_and_as_far_away_as_it_says(gate, fineness):
    chain = widest_chain(gate, margins_of(gate), fineness)
    assert chain.margin == margins_of(gate)(chain.q).min() > 0.0
    assert gate.arm.task_error(chain.q, gate.path(chain.r)).max() < 1e-9
    step = np.diff(chain.q, axis=0)
    assert np.linalg.norm(2.0 * np.sin(0.5 * step), axis=1).max() <= fineness.step
    assert abs(gate.arm.u_of(chain.q[0])[0] - 0.3) < 1e-9
    assert gate.arm.limits.excess(chain.q).max() < 1e-3


def test_it_is_as_wide_as_any_chain_of_the_same_steps(gate):
    """With all postures below its margin taken away no chain is left: by a flood that knows no widths."""
    free = gate.without("start")
    margins, cover, (rungs, spacing, most) = margins_of(free), free.arm.cover(), COARSE
    least, led = widest_chain(free, margins, COARSE).margin, None
    for r in np.linspace(0.0, 1.0, rungs + 1):
        cells = cover.cells(free.path(r), spacing)
        q = np.concatenate([cells.a, cells.b])
        q = q[margins(q) > least + 1e-9]
        if led is not None:
            step = q[:, None] - led[None]
            step[..., cover.wraps] = 2.0 * np.sin(0.5 * step[..., cover.wraps])  # across, and not along the circle
            q = q[(np.linalg.norm(step, axis=2) <= most).any(axis=1)]
        led = q
    assert not len(led)


def test_there_is_none_where_no_motion_is():
    arm = sm.PlanarArm([1.0, 1.0, 1.0], [(-1.45, 1.45)] * 3)
    problem = sm.Problem(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))
    assert widest_chain(problem, lambda q: np.ones(len(q)), COARSE) is None


def test_a_wall_across_the_path_is_proved_before_anything_is_tried_at_random(monkeypatch, seed_arm, seed_path):
    monkeypatch.setattr(globally_optimal, "random_starts", lambda *_: pytest.fail("there is no chain of postures"))
    wall = [HalfPlaneObstacle((0.0, -3.0), (0.0, 1.0)), CircleObstacle((26.0, 12.0), 7.0)]
    with pytest.raises(sm.InfeasibleError):
        sm.plan(sm.Problem(seed_arm, sm.Line([62.0, -2.0], [40.0, 40.0]), obstacles=wall), sm.Global(time_limit=30.0))
