"""The globally shortest motion: known optima, planted ones, and what is promised of bound and gap."""

import time
from itertools import pairwise

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.angles import wrap
from selfmotion.certificate.tube import Tube
from selfmotion.errors import UndecidedError
from selfmotion.planners.globally_optimal import _Search

LIMITS = [None, (0, np.pi), None]
BEZIER = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
ARM, FREE = sm.PlanarArm([30, 30, 20], LIMITS), sm.PlanarArm([30, 30, 20])
KAZEROUNIAN_WANG = sm.Problem(sm.PlanarArm([7, 7, 4, 1.5], direction=np.radians(-60)), sm.Circle([6, 4], 4))

# Problem, and a cost that is known to be reached.
KNOWN = {
    "bezier from 0.3": (sm.Problem(ARM, BEZIER, start=[0.3], elbow="positive"), 4.8894467),
    "bezier": (sm.Problem(ARM, BEZIER, elbow="positive"), 4.6501559),
    "bezier, negative": (sm.Problem(FREE, BEZIER, elbow="negative"), 4.3150457),
    "bezier, any": (sm.Problem(FREE, BEZIER), 4.3150457),
    "kazerounian-wang": (KAZEROUNIAN_WANG, 8.4804486),
}


@pytest.mark.parametrize("name", KNOWN)
def test_known_optima(name):
    problem, cost = KNOWN[name]
    plan = sm.plan(problem, sm.Global(gap=1e-4))
    assert plan.verification.holds
    assert plan.gap <= 1e-4
    assert plan.lower_bound <= cost
    assert plan.cost <= cost * (1 + 1e-6)  # a tenth of what it is polished to for this gap
    assert plan.gap == pytest.approx((plan.cost + plan.cost_error - plan.lower_bound) / plan.cost)


@pytest.mark.parametrize("objective", ["l1", "l2"])
@pytest.mark.parametrize("name", KNOWN)
def test_plain_travel(name, objective):
    problem = KNOWN[name][0]
    start = None if problem.start is None else problem.start.u
    other = sm.Problem(problem.arm, problem.path, start=start, elbow=problem.elbow, objective=objective)
    plan = sm.plan(other, sm.Global(gap=1e-3))
    assert plan.verification.holds
    assert plan.gap <= 1e-3
    assert plan.lower_bound <= sm.plan(other, sm.Refine(starts=4)).cost


def test_a_planted_optimum():
    # θ1 alone turns along a circle about the base: with both ends given, no motion is shorter.
    arm, turn = sm.PlanarArm([1.0, 0.8, 0.6]), 1.1
    q = np.array([0.2, 0.7, -0.4])
    x, y = arm.forward(q)
    path = sm.Arc([0.0, 0.0], float(np.hypot(x, y)), float(np.arctan2(y, x)), turn)
    end = q + np.array([turn, 0, 0])
    plan = sm.plan(sm.Problem(arm, path, start={"q": q}, end={"q": end}), sm.Global(gap=1e-5))
    optimum = 2.0 + np.hypot(1.0, turn)
    assert plan.lower_bound <= optimum <= plan.cost + 1e-9
    assert plan.gap <= 1e-5


def turned(turn):
    """θ1 starts at 3.5 and may go to 4; the path turns the tool about the base."""
    arm = sm.PlanarArm([1.0, 0.8, 0.6], [(-4.0, 4.0), None, None])
    q = np.array([3.5, 1.4, -0.9])
    x, y = arm.forward(q)
    return arm, q, sm.Arc([0.0, 0.0], float(np.hypot(x, y)), float(np.arctan2(y, x)), turn)


def test_a_start_given_by_joints_keeps_its_turns():
    arm, q, path = turned(0.6)
    held = sm.plan(sm.Problem(arm, path, start={"q": q}), sm.Global(gap=1e-3))
    free = sm.plan(sm.Problem(arm, path, start=arm.u_of(q)), sm.Global(gap=1e-3))
    assert max(held.gap, free.gap) <= 1e-3
    assert held.verification.holds
    assert held(0.0)[0] == pytest.approx(3.5)
    assert held.lower_bound > free.cost + 0.001  # from a turn lower θ1 may go as it likes


def test_a_start_whose_turns_leave_no_way_is_infeasible():
    arm, q, path = turned(1.0)
    with pytest.raises(sm.InfeasibleError, match="upper limit of θ1"):
        sm.plan(sm.Problem(arm, path, start={"q": q}), sm.Global(time_limit=20))


def test_no_continuous_motion():
    def problem(limit):
        arm = sm.PlanarArm([1, 1, 1], [(-limit, limit)] * 3)
        return sm.Problem(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))

    with pytest.raises(sm.InfeasibleError) as caught:
        sm.plan(problem(1.45), sm.Global(time_limit=30))
    (low, high) = caught.value.blocked[0].r
    assert low - 0.01 <= (0.41 + 2.5) / 5 <= high + 0.01
    assert sm.plan(problem(2.2), sm.Global(gap=1e-2)).verification.holds


@pytest.mark.parametrize("cyclic", ["exact", "modulo"])
def test_cyclic_motions(cyclic):
    arm = sm.PlanarArm([1, 1, 0.7], [None, (0, np.pi), None])
    problem = sm.Problem(arm, sm.Circle([1.2, 0.3], 0.5), cyclic=cyclic)
    plan = sm.plan(problem, sm.Global(gap=3e-4))
    free = sm.plan(problem.without("cyclic"), sm.Global(gap=3e-4))
    assert np.abs(plan(1.0) - plan(0.0)).max() < 1e-9
    assert plan.gap <= 3e-4
    # Closing costs something, and the bound knows.
    assert free.lower_bound < free.cost < plan.lower_bound < plan.cost


@pytest.mark.parametrize("cyclic", ["exact", "modulo"])
def test_a_cyclic_motion_from_a_given_start_ends_there(cyclic):
    # The end is known then: proofs need not let it be anywhere in a cell about the start.
    arm = sm.PlanarArm([1, 1, 0.7], [None, (0, np.pi), None])
    given = sm.Problem(arm, sm.Circle([1.2, 0.3], 0.5), start=[0.3], cyclic=cyclic)
    plan = sm.plan(given, sm.Global(gap=1e-4, time_limit=20))
    assert np.abs(plan(1.0) - plan(0.0)).max() < 1e-9
    assert plan.gap <= 1e-4
    posture = sm.Problem(arm, given.path, start={"q": plan(0.0)}, end={"q": plan(1.0)})
    assert sm.plan(posture, sm.Global(gap=1e-4)).cost == pytest.approx(plan.cost, rel=1e-4)


def test_what_cannot_be_halved_is_not(monkeypatch):
    halved, halves = [], Tube.halves

    def counted(tube, pull):
        halved.append(len(tube.slices[0].cells))
        return halves(tube, pull)

    monkeypatch.setattr(Tube, "halves", counted)
    monkeypatch.setattr("selfmotion.planners.globally_optimal._TIED", 1e-9)
    arm = sm.PlanarArm([1, 1, 0.7], [None, (0, np.pi), None])
    sm.plan(sm.Problem(arm, sm.Circle([1.2, 0.3], 0.5), cyclic="exact"), sm.Global(gap=1e-3, time_limit=2.0))
    assert halved
    assert min(halved) > 1


def test_gaps_shrink_round_by_round():
    plan = sm.plan(KNOWN["bezier from 0.3"][0], sm.Global(gap=3e-6))
    bounds = [level.bound for level in plan.certificate.levels]
    gaps = [(level.cost - level.bound) / level.cost for level in plan.certificate.levels]
    assert bounds == sorted(bounds)
    assert all(later < earlier for earlier, later in pairwise(gaps))
    assert gaps[-1] <= 3e-6
    assert plan.certificate.bound == plan.lower_bound == bounds[-1]


def test_the_tube_holds_the_best_motion():
    plan = sm.plan(KNOWN["bezier from 0.3"][0], sm.Global(gap=1e-4))
    for part in plan.certificate.tube:
        assert np.ptp(np.concatenate([part.a, part.b]), axis=0).max() < 0.5  # of turns: what is dearer was dropped
        q = plan(part.r)
        step = part.b - part.a
        d = q - part.a
        d -= 2 * np.pi * np.rint((d - 0.5 * step) / (2 * np.pi))
        s = np.clip((d * step).sum(axis=1) / np.maximum((step * step).sum(axis=1), 1e-300), 0, 1)
        assert np.abs(d - s[:, None] * step).max(axis=1).min() < 1e-3


def test_a_time_limit_gives_the_best_pair_so_far():
    began = time.perf_counter()
    plan = sm.plan(KAZEROUNIAN_WANG, sm.Global(gap=1e-9, time_limit=3.0))
    assert time.perf_counter() - began < 15.0
    assert plan.verification.holds
    assert plan.lower_bound <= 8.4804486
    assert "time limit" in plan.certificate.argument


def test_weights_scale_the_bound():
    problem = KNOWN["bezier from 0.3"][0]
    double = sm.Problem(problem.arm, problem.path, start=[0.3], elbow="positive", weights=[2, 2, 2])
    one, two = (sm.plan(p, sm.Global(gap=1e-3)) for p in (problem, double))
    assert two.cost == pytest.approx(2 * one.cost, rel=1e-7)
    assert two.lower_bound == pytest.approx(2 * one.lower_bound, rel=1e-3)


def test_the_same_problem_gives_the_same_bits():
    one, two = (sm.plan(KNOWN["bezier"][0], sm.Global(gap=1e-3)) for _ in range(2))
    assert (one.cost, one.lower_bound) == (two.cost, two.lower_bound)


class _Lost(sm.PlanarArm):
    """An arm whose cover is no number somewhere, or closer to chords than it bends."""

    broken = "a"

    def cover(self, elbow="any"):
        return _LostCover(super().cover(elbow), self.broken)


class _Straight(_Lost):
    broken = "dev"


class _LostCover:
    def __init__(self, cover, broken):
        self.cover, self.n, self.wraps, self.broken = cover, cover.n, cover.wraps, broken

    def cells(self, x, spacing):
        found = self.cover.cells(x, spacing)
        getattr(found, self.broken)[len(found) // 2, 1] *= np.nan if self.broken == "a" else 0.5
        return found

    def split(self, x, cells, spacing):
        return self.cover.split(x, cells, spacing)

    def points(self, q, turned):
        return self.cover.points(q, turned)


def test_an_arm_that_gives_no_numbers_is_told():
    with pytest.raises(sm.InvalidInputError, match=r"arm: its cover at r = 0 holds postures that are not numbers"):
        sm.plan(sm.Problem(_Lost([30, 30, 20]), BEZIER), sm.Global(gap=1e-2))


def test_a_cover_that_bends_more_than_it_says_is_told():
    with pytest.raises(
        sm.InvalidInputError, match=r"arm: its cover at r = 0 has cells that leave their chords by more"
    ):
        sm.plan(sm.Problem(_Straight([30, 30, 20]), BEZIER), sm.Global(gap=1e-2))


def test_one_redundant_degree_is_needed():
    arm = sm.PlanarArm([30] * 5)
    with pytest.raises(sm.InvalidInputError, match="one redundant degree"):
        sm.plan(sm.Problem(arm, BEZIER), sm.Global())


@pytest.mark.parametrize(("x", "u", "free"), [([3.0, 0.0], 0.0, 0), ([1.0, 0.0], np.pi, 0), ([1.0, 0.0], 0.0, 1)])
def test_a_start_at_a_singular_posture_is_every_posture_near_it(x, u, free):
    # Stretched out, on a fold, and with the wrist on the base, where the other joints are anyone's guess.
    arm = sm.PlanarArm([1, 1, 1])
    problem = sm.Problem(arm, sm.Line(x, [1.5, 0.5]), start=[u])
    cells = _Search(sm.Global(), problem, None)._given(arm.cover(), problem.start, 0.0)
    for turn in np.linspace(-np.pi, np.pi, 7 if free else 1):
        q, ok = arm.solve(np.array(x), np.array([u]), 1)
        assert ok
        q = q + turn * free * np.array([1.0, 0.0, -1.0])
        assert arm.task_error(q, np.array(x)) < 1e-12
        off = np.abs(wrap(0.5 * (cells.a + cells.b) - q)) - 0.5 * np.abs(cells.b - cells.a) - cells.dev
        assert (off.max(axis=1) < 1e-9).any()


def test_too_little_time_to_prove_that_there_is_none_is_undecided():
    tight = sm.Problem(sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5]))
    with pytest.raises(UndecidedError) as found:
        sm.plan(tight, sm.Global(time_limit=1e-3))
    assert found.value.why == "budget"
