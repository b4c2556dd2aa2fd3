"""The global planner on seven-joint arms: known cases, infeasibility, and boxes of slabs."""

from importlib.resources import files

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms.spatial import SpatialArm
from selfmotion.arms.urdf import read_chain
from selfmotion.errors import InfeasibleError


def shipped(name):
    return SpatialArm(read_chain((files("selfmotion.arms") / "data" / f"{name}.urdf").read_text()))


PANDA = shipped("panda")


def circle():
    t = np.linspace(0, 2 * np.pi, 101)
    position = np.column_stack([np.full(101, 0.45), 0.2 * np.cos(t), 0.4 + 0.2 * np.sin(t)])
    return sm.PoseWaypoints(np.column_stack([position, np.tile([0.0, 1.0, 0.0, 0.0], (101, 1))]))


def line(up=0.0):
    x = np.linspace(0.45, -0.45, 200)
    position = np.column_stack([x, np.full(200, 0.5422), np.full(200, 0.7885 + up)])
    return sm.PoseWaypoints(np.column_stack([position, np.tile([1.0, 0.0, 0.0, 0.0], (200, 1))]))


def over_waypoints(plan):
    return np.linalg.norm(np.diff(plan(plan.problem.path.waypoints), axis=0), axis=1).sum()


@pytest.mark.parametrize(
    ("path", "known", "best"), [(circle(), 3.694, 3.695), (line(), 3.4527, 3.455)], ids=["circle", "line"]
)
def test_known_cases_are_solved_as_well_as_anyone_did(path, known, best):
    plan = sm.plan(sm.Problem(PANDA, path, objective="l2", samples=200), sm.Global(gap=1e-2))
    assert over_waypoints(plan) <= best
    assert plan.gap <= 1e-2
    assert plan.lower_bound <= known
    assert plan.verification.holds
    assert plan.verification.max_tracking_error < 1e-9


@pytest.mark.parametrize("objective", ["joint_travel", "l1"])
def test_other_objectives_have_bounds_too(objective):
    plan = sm.plan(sm.Problem(PANDA, circle(), objective=objective, samples=200), sm.Global(gap=1e-2))
    assert plan.gap <= 1e-2
    other = sm.plan(sm.Problem(PANDA, circle(), objective="l2", samples=200), sm.Global(gap=0.1))
    rates = other.rates(np.linspace(0, 1, 4001))
    density = np.sqrt(1 + rates**2) if objective == "joint_travel" else np.abs(rates)
    assert plan.lower_bound <= density.sum(axis=1).mean()


def test_a_given_start_is_kept():
    free = sm.plan(sm.Problem(PANDA, line(), objective="l2", samples=100), sm.Global(gap=0.1))
    start = free(0.0)
    for given in ({"q": start}, {"u": free.u(0.0)}):
        problem = sm.Problem(PANDA, line(), start=given, objective="l2", samples=100)
        plan = sm.plan(problem, sm.Global(gap=2e-2))
        assert plan.gap <= 2e-2
        assert plan.cost <= free.cost * 1.001
        assert plan.u(0.0) == pytest.approx(free.u(0.0), abs=1e-6)


@pytest.mark.parametrize("name", ["fr3", "iiwa7", "iiwa14"])
def test_other_arms_follow_a_circle(name):
    arm = shipped(name)
    q = np.array([0.2, 0.7, -0.3, -1.5 if name == "fr3" else 1.4, 0.3, 1.6 if name == "fr3" else -0.8, 0.4])
    pose = arm.forward(q)
    t = np.linspace(0, 1, 41)
    position = pose[:3] + 0.08 * np.column_stack([np.cos(2 * np.pi * t) - 1, np.sin(2 * np.pi * t), 0 * t])
    path = sm.PoseWaypoints(np.column_stack([position, np.tile(pose[3:], (41, 1))]))
    plan = sm.plan(sm.Problem(arm, path, objective="l2", samples=100), sm.Global(gap=2e-2, time_limit=60))
    assert plan.gap <= 2e-2
    assert plan.verification.holds


def test_out_of_reach_says_by_how_much():
    with pytest.raises(InfeasibleError, match=r"out of reach by up to 0\.0431") as caught:
        sm.plan(sm.Problem(PANDA, line(0.1), objective="l2", samples=100), sm.Global(gap=1e-2))
    assert caught.value.blocked[0].short_by == pytest.approx(0.043119, abs=1e-5)
    assert caught.value.blocked[0].r == pytest.approx((0.0, 0.100822), abs=1e-5)


def test_a_limit_that_blocks_is_named_with_what_it_needs():
    arm = PANDA.relaxed(np.zeros(7), -2.05 * (np.arange(7) == 3))
    with pytest.raises(InfeasibleError, match="θ4 needs") as caught:
        sm.plan(sm.Problem(arm, circle(), objective="l2", samples=100), sm.Global(gap=1e-2))
    need = caught.value.needs[0]
    assert (need.joint, need.side) == (4, "upper")
    x = circle()(need.r)
    for part, there in ((0.998, False), (1.0, True)):
        wider = arm.relaxed(np.zeros(7), part * need.by * (np.arange(7) == 3))
        assert bool(len(wider.cover().cells(x, 0.3))) == there


@pytest.mark.parametrize("name", ["panda", "iiwa14"])
def test_boxes_of_slabs_hold_all_postures(name):
    arm, rng, held = shipped(name), np.random.default_rng(3), 0
    for _ in range(5):
        q = rng.uniform(arm.limits.lower, arm.limits.upper)
        q[[1, 5]] = np.array([0.6, 0.9]) * np.array([1.0, 1.0 if name == "panda" else rng.choice([-1.0, 1.0])])
        moved = q + 0.01 * rng.normal(size=7)
        path = sm.PoseWaypoints(arm.forward(np.array([q, np.clip(moved, arm.limits.lower, arm.limits.upper)])))
        cover = arm.slabs(path)
        low, high = np.sort(rng.uniform(0, 1, 2)) if rng.random() < 0.8 else np.full(2, rng.random())
        high = min(high, low + 0.2)
        boxes = cover.boxes(low, high, 0.3)
        finer = cover.split(low, high, boxes, np.full(len(boxes), 0.1))
        for r in np.linspace(low, high, 4):
            x = path(r)
            for branch in range(len(arm.branches)):
                u = rng.uniform(*arm.parameter_range, (40, 1))
                found, ok = arm.solve(np.tile(x, (40, 1)), u, branch)
                inside = ok & (arm.limits.excess(np.where(ok[:, None], found, 0.0)) <= 0).all(axis=1)
                for posture in _turned(arm, found[inside]):
                    assert boxes.contain(posture, cover.wraps, 1e-9).any()
                    assert finer.contain(posture, cover.wraps, 1e-9).any()
                    held += 1
    assert held > 200


def _turned(arm, q):
    middle = 0.5 * (arm.limits.lower + arm.limits.upper)
    return q + 2 * np.pi * np.rint((middle - q) / (2 * np.pi))


def test_slab_boxes_need_not_be_finished_in_time():
    from selfmotion.certificate.chains import Chains

    proof = Chains(PANDA.slabs(circle()), deadline=0.0).prove(0.0)
    assert not proof.proved
    assert proof.stopped == "time"
