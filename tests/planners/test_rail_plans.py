"""The global planner on arms on a rail: seams longer than the arm, planted optima, rivals, weights, and no motion."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.certificate.joined import ends
from selfmotion.errors import InfeasibleError
from selfmotion.planners.ladder import ladder

DOWN = [0, 1, 0, 0]


def seam(half, x=0.4, up=0.3):
    """A straight line along y, the tool pointing down."""
    return sm.PosePath(sm.Line([x, -half, up], [x, half, up]), DOWN)


def problem(name="irb120", low=-1.0, high=1.0, half=1.0, **given):
    arm = sm.named_arm(name, rail={"axis": [0, 1, 0], "limits": [low, high]})
    return sm.Problem(arm, seam(half), samples=101, **{"objective": "l2", **given})


def brute_force(task, r, u):
    """The cheapest way over a grid of u on all branches, by l2 chords, in numpy only."""
    arm, before, cheapest = task.arm, None, None
    for x in task.path(r):
        solved = [arm.solve(np.tile(x, (len(u), 1)), u[:, None], b) for b in range(8)]
        q = np.concatenate([found[ok] for found, ok in solved])
        q = np.concatenate([q + 2 * np.pi * k * np.eye(7)[j] for j in (4, 6) for k in (-1, 0, 1)])
        q = q[((q >= arm.limits.lower - 1e-12) & (q <= arm.limits.upper + 1e-12)).all(axis=1)]
        if before is None:
            cheapest = np.zeros(len(q))
        else:
            steps = np.sqrt((((q[:, None] - before) * task.weights) ** 2).sum(axis=2))
            cheapest = (cheapest + steps).min(axis=1)
        before = q
    return float(cheapest.min())


@pytest.mark.parametrize("name", ["irb120", "kr6r900", "ur5e"])
@pytest.mark.parametrize("objective", ["l2", "joint_travel"])
def test_a_seam_longer_than_the_arm_is_planned_to_a_thousandth(name, objective):
    task = problem(name, half=1.0, objective=objective)
    assert task.path.length > task.arm.reach
    plan = sm.plan(task, sm.Global(gap=1e-3))
    assert plan.gap <= 1e-3
    assert plan.verification.holds
    assert plan.verification.max_tracking_error < 1e-9
    q = plan(np.linspace(0, 1, 301))
    assert (task.arm.limits.margin(q) >= -1e-9).all()
    assert np.abs(np.diff(q, axis=0)).max() < 0.2
    assert plan.u(np.linspace(0, 1, 301)) == pytest.approx(q[:, :1], abs=1e-9)


def test_a_rival_on_a_grid_is_above_the_bound_and_near_the_plan():
    task = problem("irb120")
    plan = sm.plan(task, sm.Global(gap=1e-3))
    rival = brute_force(task, np.linspace(0, 1, 13), np.linspace(-1, 1, 241))
    assert rival >= plan.lower_bound - 2e-3 * plan.cost  # chords are shorter than what they span
    assert rival == pytest.approx(plan.cost, rel=0.03)
    other = ladder(task, 121)
    assert other.cost_sampled >= plan.lower_bound - 1e-3 * plan.cost
    assert (other.q[:, 0] >= -1.0).all()
    assert (other.q[:, 0] <= 1.0).all()


@pytest.mark.parametrize("name", ["irb120", "ur5e"])
def test_where_the_rail_is_cheap_it_does_all_of_it(name):
    """No joint takes the tool farther than reach times its step: w per metre, w < 1/reach, is the least for a metre."""
    weights = [0.2, 1, 1, 1, 1, 1, 1]
    plan = sm.plan(problem(name, -2.0, 2.0, objective="l1", weights=weights), sm.Global(gap=2e-2))
    assert 1.0 / plan.problem.arm.reach > 0.2
    assert plan.lower_bound <= 0.2 * 2.0 * (1 + 1e-12)
    assert plan.cost == pytest.approx(0.2 * 2.0, rel=1e-3)
    assert plan.gap <= 2e-2


def test_the_dearer_the_rail_the_less_it_moves():
    moved = []
    for weight in (0.1, 1.0, 10.0):
        plan = sm.plan(problem(weights=[weight, 1, 1, 1, 1, 1, 1]), sm.Global(gap=1e-2))
        moved.append(float(np.abs(np.diff(plan(np.linspace(0, 1, 501))[:, 0])).sum()))
    assert moved[0] > moved[1] + 0.05
    assert moved[1] > moved[2] + 0.05


def test_a_rail_that_is_too_short_is_proved_to_be_and_by_how_much():
    with pytest.raises(InfeasibleError) as caught:
        sm.plan(problem(low=-0.58, high=0.7), sm.Global(time_limit=20))
    need = caught.value.needs[0]
    assert (need.joint, need.side, need.unit) == (1, "lower", "m")
    assert "q1 needs" in str(need)
    assert " m more below its lower limit" in str(need)
    # The need is that of the middle of what is blocked; with what the end of the seam needs besides there is a motion.
    assert sm.plan(problem(low=-0.58 - 2.5 * need.by, high=0.7), sm.Global(gap=0.5)).verification.holds


def test_a_start_is_kept_and_a_rail_of_thirty_metres_is_none_to_wrap():
    free = sm.plan(problem("kr6r900", -16.0, 16.0, half=15.0), sm.Global(gap=1e-2))
    assert np.ptp(free(np.linspace(0, 1, 501))[:, 0]) > 28.0
    q = free(0.0)
    other = problem("kr6r900", -16.0, 16.0, half=15.0, start={"q": q + 0.0})
    assert sm.plan(other, sm.Global(gap=1e-2)).cost == pytest.approx(free.cost, rel=2e-2)
    away = problem("kr6r900", -16.0, 16.0, half=15.0, start={"u": q[:1]})
    plan = sm.plan(away, sm.Global(gap=1e-2))
    assert plan(0.0)[0] == pytest.approx(q[0], abs=1e-9)
    with pytest.raises(sm.InvalidInputError, match="out of reach"):
        problem("kr6r900", -16.0, 16.0, half=15.0, start={"u": q[:1] + 2 * np.pi})


def test_a_profile_of_angles_is_refused():
    with pytest.raises(sm.InvalidInputError, match=r"this arm's u is a length"):
        sm.plan(problem(start={"u": [-0.9]}), sm.Harmonics(span=[0.1], optimizer=sm.PSO(4, 2)))


def test_refine_finds_as_good_a_motion():
    task = problem("ur5e")
    bound = sm.plan(task, sm.Global(gap=1e-2)).lower_bound
    plan = sm.plan(task, sm.Refine())
    assert plan.verification.holds
    assert plan.cost >= bound * (1 - 1e-6)


def test_a_start_that_is_given_by_u_does_not_stop_a_proof():
    """The proof that the rail is too short, which allows any start since u alone does not tell postures at folds."""
    task = problem(low=-0.58, high=0.7, start={"u": [-0.5]})
    assert ends(task, "start").q is None  # any posture: a proof is of more than was asked
    with pytest.raises(InfeasibleError):
        sm.plan(task, sm.Global(time_limit=20))
