"""Repair by self-motion: whatever comes out passes `judge`, whatever cannot is named with its place."""

import numpy as np
import pytest

import selfmotion as sm
from oracle import random_arm
from selfmotion.judgement import judge
from selfmotion.mending.filling import on_path

R = np.linspace(0, 1, 200)
U = 0.3 + 0.4 * np.sin(2 * np.pi * 0.54 * R)


@pytest.fixture
def free(seed_path):
    return sm.Problem(sm.PlanarArm([30, 30, 20]), seed_path)


def samples(problem, u=U, branch=0, rows=slice(None)):
    return problem.arm.solve(problem.path(R[rows]), u[rows, None], branch)[0]


def assert_repaired(problem, found):
    assert found.judgement.holds
    again = judge(problem, found.r, found.q)
    assert again.holds, again.failures
    assert sm.connectivity(problem, found.r, found.q).holds
    assert (np.diff(found.r) >= 0).all()


def rows_of(found, r, q):
    """Which given rows stand in the repaired motion as they were, free joints modulo 2π."""
    off = [np.abs(np.sin(0.5 * (found.q - posture))).max(axis=1) for posture in q]
    return np.array([any((found.r == at) & (miss < 1e-12)) for at, miss in zip(r, off, strict=True)])


def test_a_connected_motion_is_left_as_it_is(free):
    q = samples(free)
    found = sm.repair(free, R, q)
    np.testing.assert_array_equal(found.q, q)
    assert found.kept.all()
    assert not found.breaks


def test_a_few_improper_postures_are_replaced(free):
    """The seed's Fig. 1: postures with the other elbow in the middle of a motion."""
    q = samples(free)
    good = q.copy()
    q[80:90] = samples(free, branch=1, rows=slice(80, 90))
    found = sm.repair(free, R, q)
    assert_repaired(free, found)
    np.testing.assert_array_equal(np.flatnonzero(~found.kept), np.arange(80, 90))
    np.testing.assert_array_equal(found.kept, rows_of(found, R, q))
    assert len(found.r) == len(R)
    assert np.abs(found.q - good).max() < 0.05


def test_two_halves_on_different_elbows_are_joined_through_a_fold(free):
    q = samples(free)
    q[100:] = samples(free, branch=1, rows=slice(100, None))
    found = sm.repair(free, R, q)
    assert_repaired(free, found)
    assert found.kept.all()
    assert len(found.r) > len(R)
    between = found.q[(found.r >= R[99]) & (found.r <= R[100])]
    assert np.abs(np.sin(between[:, 1])).min() < 0.05  # through θ2 = 0


def test_what_rows_are_worth_decides_which_are_kept(free):
    q = samples(free)
    q[80:90] = samples(free, branch=1, rows=slice(80, 90))
    assert sm.repair(free, R, q, keep=1e4).kept.all()
    assert not sm.repair(free, R, q, keep=30.0).kept.all()


def test_rounded_angles_are_put_back_on_the_path(free):
    q = samples(free)
    found = sm.repair(free, R, np.round(q, 3))
    assert_repaired(free, found)
    assert not found.kept.any()
    assert np.abs(found.q - q).max() < 5e-3


def test_a_motion_that_ends_early_is_completed(seed_problem):
    q = samples(seed_problem)
    found = sm.repair(seed_problem, R[:150], q[:150])
    assert_repaired(seed_problem, found)
    assert found.r[-1] == 1.0
    assert found.kept.all()


def test_start_and_end_postures_are_kept(seed_path):
    problem = sm.Problem(sm.PlanarArm([30, 30, 20]), seed_path, start=[0.9], end=[-0.4])
    found = sm.repair(problem, R, samples(problem))
    assert_repaired(problem, found)
    assert problem.arm.u_of(found.q[0])[0] == pytest.approx(0.9, abs=1e-6)
    assert problem.arm.u_of(found.q[-1])[0] == pytest.approx(-0.4, abs=1e-6)


def test_a_way_round_what_limits_forbid():
    """Unit 3R, |θ| ≤ 2.2: postures from sheets that die are given up for the one sheet that goes through."""
    arm, line = sm.PlanarArm([1, 1, 1], [(-2.2, 2.2)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5])
    problem = sm.Problem(arm, line)
    domain = sm.angle_domain(arm, line)
    q = []
    for r in R:
        branch = 0 if domain(r, 0).measure > 0 else 1
        low, high = domain(r, branch).intervals[0]
        q.append(arm.solve(line(r), [0.5 * (low + high)], branch)[0])
    found = sm.repair(problem, R, np.array(q))
    assert_repaired(problem, found)
    assert len(found.breaks) > 2


def test_a_motion_that_cannot_be_repaired_is_named_with_the_place():
    arm, line = sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5])
    problem = sm.Problem(arm, line)
    q = np.array([arm.solve(line(r), [0.0], 0)[0] for r in R])
    with pytest.raises(sm.UnrepairableError, match="upper limit of θ1 and lower limit of θ3") as caught:
        sm.repair(problem, R, q)
    assert caught.value.r == pytest.approx(0.5822682796, abs=1e-9)
    assert caught.value.proved
    assert caught.value.exit_code == 3
    assert caught.value.status == "infeasible"


def test_an_arm_with_more_redundancy_is_refused(seed_path):
    problem = sm.Problem(sm.PlanarArm([30, 30, 20, 10]), seed_path)
    with pytest.raises(sm.InvalidInputError, match="redundant degrees"):
        sm.repair(problem, R, np.zeros((200, 4)))


def halves(problem, first, second, rows=100):
    """Postures a third of the way through the domain of one elbow, then two thirds through that of another."""
    domain, r = sm.angle_domain(problem.arm, problem.path), np.linspace(0, 1, rows)
    q = []
    for at in r:
        low, high = domain(at, second if at >= 0.5 else first).intervals[0]
        u = low + (0.7 if at >= 0.5 else 0.3) * (high - low)
        q.append(problem.arm.solve(problem.path(at), [u], second if at >= 0.5 else first)[0])
    return r, np.array(q)


def test_smoothing_does_not_break_what_it_smooths():
    problem = sm.Problem(sm.PlanarArm([1, 0.8, 0.5]), sm.Line([1.2, -1], [1.2, 1]))
    found = sm.repair(problem, *halves(problem, 0, 1))
    assert_repaired(problem, found)


@pytest.mark.parametrize("mode", ["exact", "modulo"])
def test_a_closed_motion_along_a_closed_path(mode):
    problem = sm.Problem(sm.PlanarArm([1, 0.8, 0.5]), sm.Circle([1.6, 0], 0.3), cyclic=mode)
    found = sm.repair(problem, *halves(problem, 0, 0))
    assert_repaired(problem, found)
    assert np.abs(found.q[-1] - found.q[0]).max() < 1e-6


def test_the_elbow_asked_for_is_kept():
    problem = sm.Problem(sm.PlanarArm([1, 0.8, 0.5]), sm.Line([1.2, -1], [1.2, 1]), elbow="negative")
    found = sm.repair(problem, *halves(problem, 0, 1))
    assert_repaired(problem, found)
    assert (np.sin(found.q[:, 1]) < 1e-6).all()


def test_postures_are_put_on_the_path_inside_their_limits_or_not_at_all():
    rng = np.random.default_rng(5)
    put = 0
    for _ in range(100):
        arm = random_arm(rng)
        q, r = rng.uniform(-3, 3, (20, arm.n)), rng.random(20)
        ends = arm.annulus[0] + rng.uniform(-0.9, 0.9, (2, 2)) * arm.links[:3].sum()
        try:
            problem = sm.Problem(arm, sm.Line(*ends), elbow=("any", "positive", "negative")[rng.integers(3)])
        except sm.InvalidInputError:
            continue
        found, ok = on_path(problem, r, q)
        x = problem.path(r)
        for branch in set(range(2)) - set(problem.elbow_branches):
            assert not (np.abs(np.sin(found[ok, 1])) > 1e-6)[arm.branch_of(found[ok]) == branch].any()
        np.testing.assert_array_less(-1e-9, arm.limits.margin(found[ok]))
        np.testing.assert_array_less(arm.task_error(found[ok], x[ok]), 1e-10 * arm.reach)
        put += ok.sum()
    assert put > 150


def broken_motion(problem, rng):
    """Feasible postures row by row, on a branch, interval and place in it that change every ten rows or so."""
    domain = sm.angle_domain(problem.arm, problem.path)
    r = np.linspace(0, 1, 80)
    arcs, branch, part, q = domain.sample(r), 0, rng.random(), []
    for k in range(len(r)):
        if rng.random() < 0.1:
            branch, part = 1 - branch, rng.random()
        for b in (branch, 1 - branch):
            feasible = arcs[b].interval_set(k)
            if feasible.measure > 1e-6:
                low, high = feasible.intervals[int(part * len(feasible))]
                posture = problem.arm.solve(problem.path(r[k]), [low + (high - low) * (0.1 + 0.8 * part)], b)[0]
                q.append(problem.arm.limits.lift(posture[None, None])[0][0, 0])
                break
        else:
            q.append(q[-1] if q else np.zeros(problem.arm.n))
    return r, np.array(q)


@pytest.mark.parametrize("part", range(2))
def test_broken_motions_of_random_problems(part):
    """Where the domain connects start and end every motion is repaired; where not, each is named with its place."""
    rng = np.random.default_rng(70 + part)
    repaired = named = 0
    while repaired < 14 or named < 4:
        arm = random_arm(rng)
        if rng.random() < 0.4:  # limits of a turn and more
            spans = [None, (-np.pi, np.pi), (-2 * np.pi, 2 * np.pi), (-1.0, 6.0)]
            arm = sm.PlanarArm(arm.links, [spans[k] for k in rng.integers(0, 4, arm.n)], arm.direction)
        start = arm.annulus[0] + rng.uniform(-0.6, 0.6, 2) * arm.reach
        try:
            problem = sm.Problem(arm, sm.Line(start, start + rng.uniform(-0.35, 0.35, 2) * arm.reach))
        except sm.InvalidInputError:
            continue
        r, q = broken_motion(problem, rng)
        if arm.task_error(q, problem.path(r)).min() > 1e-6 * arm.reach:
            continue  # nothing is feasible anywhere
        if problem.structure.is_connected:
            found = sm.repair(problem, r, q)
            assert_repaired(problem, found)
            np.testing.assert_array_equal(found.kept & ~rows_of(found, r, q), False)
            repaired += 1
        else:
            with pytest.raises(sm.UnrepairableError) as caught:
                sm.repair(problem, r, q)
            ends = {sheet.r[1] for sheet in problem.structure.sheets} | {0.0}
            assert caught.value.r in ends
            named += 1
