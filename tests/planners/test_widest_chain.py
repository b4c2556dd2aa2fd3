"""The widest chain of postures: what it says of itself is so, and what the global planner makes of it."""

import numpy as np
import pytest

import selfmotion as sm
from clearance import oracle
from selfmotion.planners import globally_optimal
from selfmotion.planners.widest_chain import COARSE, FINE, _Rung, _traced, _Ways, widest_chain
from selfmotion.scene import CircleObstacle, HalfPlaneObstacle, PolygonObstacle


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
    rungs = np.isin(chain.r, np.linspace(0.0, 1.0, fineness.rungs + 1))
    assert rungs.sum() == fineness.rungs + 1
    assert gate.arm.task_error(chain.q[rungs], gate.path(chain.r[rungs])).max() < 1e-9
    assert np.diff(chain.r).min() > 0.0
    step = np.diff(chain.q, axis=0)
    assert np.linalg.norm(2.0 * np.sin(0.5 * step), axis=1).max() <= fineness.step
    assert abs(gate.arm.u_of(chain.q[0])[0] - 0.3) < 1e-9
    assert gate.arm.limits.excess(chain.q).max() < 1e-3


def test_it_is_as_wide_as_any_chain_of_the_same_steps(gate):
    """With all postures below its margin taken away no chain is left: by a flood that knows no widths."""
    free = gate.without("start")
    margins, cover, (rungs, spacing, most) = margins_of(free), free.arm.cover(), COARSE

    def near(q, others):
        step = q[:, None] - others[None]
        step[..., cover.wraps] = 2.0 * np.sin(0.5 * step[..., cover.wraps])  # across, and not along the circle
        return (np.linalg.norm(step, axis=2) <= most).any(axis=1)

    least, led = widest_chain(free, margins, COARSE).margin, None
    for r in np.linspace(0.0, 1.0, rungs + 1):
        cells = cover.cells(free.path(r), spacing)
        q = np.concatenate([cells.a, cells.b])
        q = q[margins(q) > least + 1e-9]
        reached = np.full(len(q), True) if led is None else near(q, led)
        while reached.any() and not reached.all():
            further = reached | near(q, q[reached])
            if (further == reached).all():
                break
            reached = further
        led = q[reached]
    assert not len(led)


def test_it_moves_along_the_self_motion_where_only_a_short_part_of_the_path_lets_it_pass():
    """From the given start links have to swing round before the path brings them to an obstacle."""
    points = [[1.01, -5.51], [10.35, 11.84], [0.93, 20.4], [23.57, 1.73], [31.42, -9.03], [18.36, 2.55]]
    obstacles = [
        PolygonObstacle([[8.05, 3.0], [7.4, 4.43], [5.97, 3.79], [6.61, 2.36]]),
        HalfPlaneObstacle((9.12, 13.55), (-1.86, -2.77)),
    ]
    arm = sm.PlanarArm([9.09, 15.29, 9.09])
    problem = sm.Problem(arm, sm.Bezier(points), start=[1.73], obstacles=obstacles, clearance=0.145)
    chain = widest_chain(problem, margins_of(problem), COARSE)
    assert chain.margin > 0.1
    assert len(chain.r) > COARSE.rungs + 1
    plan = sm.plan(problem, sm.Global(gap=0.5, time_limit=30.0))
    assert oracle(problem).left(plan(np.linspace(0.0, 1.0, 20_000))).min() >= 0.0


def test_a_joint_with_one_limit_starts_in_the_turn_that_keeps_it():
    """Joint 2 passes the half turn downwards; from the turn nearest to zero it would end below its limit."""
    arm = sm.PlanarArm([8.83, 6.78, 17.45], [(-3.51, None), (-4.32, None), (-5.98, 2.18)])
    path = sm.Bezier([[-1.1, 4.15], [-25.02, -6.22], [-5.78, -13.77], [5.78, 20.77]])
    obstacle = PolygonObstacle([[1.14, -8.17], [2.21, -9.58], [2.9, -7.94]])
    problem = sm.Problem(arm, path, start=[2.61], end=[0.803], obstacles=[obstacle])
    chain = widest_chain(problem, margins_of(problem), COARSE)
    assert (chain.q >= arm.limits.lower - 1e-9).all()
    assert np.abs(np.diff(chain.q, axis=0)).max() < 0.3


def test_there_is_none_where_no_motion_is():
    arm = sm.PlanarArm([1.0, 1.0, 1.0], [(-1.45, 1.45)] * 3)
    problem = sm.Problem(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))
    assert widest_chain(problem, lambda q: np.ones(len(q)), COARSE) is None


def test_a_wall_across_the_path_is_proved_before_anything_is_tried_at_random(monkeypatch, seed_arm, seed_path):
    monkeypatch.setattr(globally_optimal, "random_starts", lambda *_: pytest.fail("there is no chain of postures"))
    wall = [HalfPlaneObstacle((0.0, -3.0), (0.0, 1.0)), CircleObstacle((26.0, 12.0), 7.0)]
    with pytest.raises(sm.InfeasibleError):
        sm.plan(sm.Problem(seed_arm, sm.Line([62.0, -2.0], [40.0, 40.0]), obstacles=wall), sm.Global(time_limit=30.0))


def test_moves_along_the_last_two_rungs_are_told_in_their_order():
    q = np.arange(3.0)[:, None]
    rungs = [_Rung(q, np.full(3, True))] * 3
    none, way = np.full(3, -1), np.array([-1, 0, 1])
    ways = [_Ways(none, none), _Ways(np.zeros(3, int), way), _Ways(np.full(3, 2), way)]
    r, found = _traced(rungs, ways, 2, np.linspace(0.0, 1.0, 3))
    assert (np.diff(r) > 0.0).all()
    assert (r[0], r[-1]) == (0.0, 1.0)
    np.testing.assert_array_equal(found[:, 0], [0, 0, 1, 2, 0, 1, 2])
