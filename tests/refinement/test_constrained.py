"""Motions that keep further constraints on postures: discs that links must not touch."""

import numpy as np
import pytest
from cases import ENDS, random_collocation
from discs import Discs, least_margin, with_discs
from test_collocation import central, relative

import selfmotion as sm
from selfmotion.errors import NothingFeasibleError
from selfmotion.refinement import Optima, SplineSpace, minimise, random_starts, start_from
from selfmotion.refinement.dips import dips, spread
from selfmotion.refinement.follow import followed, freed, is_clear
from selfmotion.refinement.linear import BandedLinear, DenseLinear, SoftRows
from selfmotion.refinement.walls import Walls

SEED_POINTS = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]


def seed(centers, radii, **more):
    arm = with_discs(sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None]), centers, radii)
    return sm.Problem(arm, sm.Bezier(SEED_POINTS), **more)


def constrained_collocation(rng, ends, count=2):
    problem, c = random_collocation(rng, ends)
    reach = problem.arm.reach
    discs = Discs(problem.arm, rng.uniform(-0.6, 0.6, (count, 2)) * reach, rng.uniform(0.02, 0.2, count) * reach)
    problem.constraints = (discs,)
    return problem, c


@pytest.mark.parametrize("mu", [1e-2, 1e-4])
@pytest.mark.parametrize("ends", ENDS)
def test_the_barrier_has_its_derivatives_inside_and_where_it_is_relaxed(ends, mu):
    broken = 0
    for number in range(6):
        rng = np.random.default_rng(number)
        problem, c = constrained_collocation(rng, ends)
        walls, d = Walls(problem, c, mu), rng.normal(size=c.shape)

        def slope(at, walls=walls, problem=problem):
            return -walls.at(problem.postures(at), mu).pull.T @ problem.values

        # The third differences of distances jump at the ends of links: one step may straddle such a place.
        wall = walls.at(problem.postures(c), mu)
        broken += (wall.margins < 0).any()
        found = float((slope(c) * d).sum())
        wanted = float(central(lambda at: walls.value(at, mu), c, d, 1e-7))  # noqa: B023
        assert found == pytest.approx(wanted, rel=1e-4, abs=1e-6)
        moved = problem.values @ d.T
        bent = (wall.curvature @ moved[:, :, None])[:, :, 0].T @ problem.values
        assert relative(bent, central(slope, c, d, 1e-7)) < 1e-3
    assert broken > 3


def test_the_shift_is_what_margins_must_exceed():
    problem, c = constrained_collocation(np.random.default_rng(3), "free")
    margins = problem.margins(problem.postures(c))
    shifted = problem.shifted(margins - 0.01)
    wall = Walls(shifted, c, 1e-3).at(shifted.postures(c), 1e-3)
    assert wall.margins == pytest.approx(np.full_like(margins, 0.01))


def soft_rows(rng, problem, rows=3):
    k = len(problem.points)
    weights = 10.0 ** rng.uniform(-2, 6, (k, rows)) * (rng.random((k, rows)) < 0.6)
    return SoftRows(rng.normal(size=(k, rows, problem.arm.n)), weights)


@pytest.mark.parametrize("ends", ENDS)
def test_soft_rows_are_what_they_would_be_inside_the_metric(ends):
    rng = np.random.default_rng(11)
    problem, c = random_collocation(rng, ends)
    n, f = c.shape
    matrices = problem.stiffness(np.ones((len(problem.space.nodes), n)), 1.0)
    soft, q = soft_rows(rng, problem), problem.postures(c)
    whole = np.zeros((n, f, n, f))
    whole[np.arange(n), :, np.arange(n), :] = matrices
    for gradients, weights in ((soft.gradients[:, a], soft.weights[:, a]) for a in range(3)):
        rows = gradients[:, :, None] * problem.values[:, None, :]
        whole += np.einsum("k,kia,kjb->iajb", weights, rows, rows)
    square = whole.reshape(n * f, n * f)
    task = (problem.arm.jacobian(q)[:, :, :, None] * problem.values[:, None, None, :]).reshape(-1, n * f)
    k = len(task)
    both = np.block([[square, -task.T], [task, np.zeros((k, k))]])
    slope = rng.normal(size=c.shape)
    wanted = np.linalg.solve(both, np.concatenate([slope.ravel(), np.zeros(k)]))
    kinds = [DenseLinear, BandedLinear] if ends != "cyclic" else [DenseLinear]
    for linear in (kind(problem, q, matrices, soft) for kind in kinds):
        size = np.abs(wanted[: n * f]).max()
        assert linear.tangent(slope).ravel() == pytest.approx(wanted[: n * f], abs=1e-6 * size)
        assert linear.multipliers(slope).ravel() == pytest.approx(-wanted[n * f :], rel=1e-4, abs=1e-4)
        a, b = rng.normal(size=(2, n, f))
        assert linear.product(a, b) == pytest.approx(a.ravel() @ square @ b.ravel(), rel=1e-10)
        lack = rng.normal(size=(len(problem.points), task.shape[0] // len(problem.points)))
        assert linear.at(q).task(linear.at(q).towards(lack)) == pytest.approx(lack, abs=1e-6)


def nearby(problem, motion, half=0.02, columns=121, values=61):
    """The cheapest chain of free postures within `half` of a motion's u and, narrower and narrower, of itself."""
    r = np.linspace(0.0, 1.0, columns)
    u, arm, cost = motion.u(r)[:, 0], problem.arm, np.inf
    for _ in range(7):
        at = u[:, None] + np.linspace(-half, half, values)
        q, ok = arm.solve(problem.path(r)[:, None], at[..., None], 0)
        flat = np.where(np.isfinite(q), q, 0.0).reshape(-1, arm.n)
        free = ok & (arm.constraints[0].margins(flat).min(axis=1) >= 0).reshape(ok.shape)
        least, before = np.where(free[0], 0.0, np.inf), []
        for k in range(1, columns):
            steps = q[k][:, None] - q[k - 1][None]
            steps -= 2 * np.pi * np.rint(steps / (2 * np.pi))
            cost_of = least + problem.objective.chord(steps, np.full(steps.shape[:2], r[1]), problem.weights)
            before.append(cost_of.argmin(axis=1))
            least = np.where(free[k], cost_of.min(axis=1), np.inf)
        way = [int(least.argmin())]
        cost = float(least.min())
        for best in reversed(before):
            way.append(int(best[way[-1]]))
        u, half = at[np.arange(columns), way[::-1]], 0.6 * half
    return cost


BITING = [
    ([[25.0, -2.0], [20.0, -20.0]], [4.0, 3.0]),
    ([[31.3, 8.3], [30.5, -2.5]], [4.2, 2.0]),  # a gap between two discs
    ([[58.0, 8.0]], [1.5]),  # the wrist: where two links end
]


@pytest.mark.parametrize(
    ("centers", "radii", "objective"), [(*discs, "joint_travel") for discs in BITING] + [(*BITING[0], "l2")]
)
def test_no_chain_of_free_postures_near_the_motion_is_cheaper(centers, radii, objective):
    problem = seed(centers, radii, objective=objective)
    plan = sm.plan(problem, sm.Refine(starts=2))
    assert plan.verification.holds
    assert least_margin(plan) >= 0
    cheapest = nearby(problem, plan.motion)
    assert cheapest * (1 - 1e-3) < plan.cost < cheapest * (1 + 1e-3)


def test_the_discs_bite():
    """Else the tests above say nothing."""
    margins = [least_margin(sm.plan(seed(*discs), sm.Refine(starts=2))) for discs in BITING[:2]]
    assert margins == pytest.approx([0, 0], abs=1e-5)


def test_without_constraints_every_bit_is_the_same(seed_arm, seed_path):
    bare = sm.plan(sm.Problem(seed_arm, seed_path), sm.Refine(starts=2))
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
    arm.constraints = ()
    other = sm.plan(sm.Problem(arm, seed_path), sm.Refine(starts=2))
    assert np.array_equal(bare.motion.coefficients, other.motion.coefficients)


def test_constraints_that_are_far_away_hardly_cost_anything(seed_arm, seed_path):
    bare = sm.plan(sm.Problem(seed_arm, seed_path), sm.Refine(starts=12))
    plan = sm.plan(seed([[-60.0, 60.0]], [5.0]), sm.Refine(starts=12))
    assert plan.cost == pytest.approx(bare.cost, rel=1e-6)


@pytest.fixture(scope="module")
def bitten():
    return sm.plan(seed(*BITING[0]), sm.Refine(starts=2))


@pytest.mark.parametrize("which", ["start", "end", "l1"])
def test_other_problems_keep_clear_too(bitten, which):
    start, end = {"start": bitten.u(0.0) + 0.1}, {"end": bitten.u(1.0) - 0.1, "weights": [1.0, 2.0, 0.5]}
    more = {"start": start, "end": end, "l1": {"objective": "l1"}}[which]
    plan = sm.plan(seed(*BITING[0], **more), sm.Refine(starts=2))
    assert plan.verification.holds
    assert least_margin(plan) >= 0


def test_cyclic_motions_keep_clear_too():
    arm = with_discs(sm.PlanarArm([1.0, 1.0, 1.0]), [[0.6, 0.75]], [0.2])
    plan = sm.plan(sm.Problem(arm, sm.Circle((1.5, 0.0), 0.4), cyclic="exact"), sm.Refine(starts=4))
    assert plan.verification.holds
    assert least_margin(plan) >= 0


@pytest.mark.parametrize("n", [6, 10])
def test_arms_of_many_joints_keep_clear(n):
    links = [80.0 / n] * n
    path = sm.Bezier(SEED_POINTS)
    limits = [None] + [(-2.0, 2.0)] * (n - 1)
    free = sm.plan(sm.Problem(sm.PlanarArm(links, limits), path), sm.Refine(starts=2))
    points = free.problem.arm.joint_positions(free.motion(np.array([0.2, 0.5, 0.8])))
    centers = [points[0, 3] + [0.0, 1.0], points[1, n // 2] + [0.5, 1.0], points[2, n // 2 - 1] - [0.0, 1.5]]
    arm = with_discs(sm.PlanarArm(links, limits), centers, [1.5, 2.0, 2.0])
    assert arm.constraints[0].margins(free.motion(np.linspace(0.0, 1.0, 201))).min() < 0
    plan = sm.plan(sm.Problem(arm, path), sm.Refine(starts=2))
    assert plan.verification.holds
    assert least_margin(plan) >= 0


def test_a_start_that_breaks_a_constraint_is_pushed_out(seed_arm, seed_path):
    free = sm.plan(sm.Problem(seed_arm, seed_path), sm.Refine(starts=2))
    r = np.linspace(0.0, 1.0, 201)
    q = free.motion(r)
    problem = seed([[20.0, -2.0]], [4.0])
    assert problem.arm.constraints[0].margins(q).min() < -0.5
    optima = Optima(problem, 1e-6, np.inf)
    for near in (False, True):
        optimum = optima.refined(optima.add(start_from(problem, q, r), near))
        assert optimum.check.holds
        assert not optimum.dips.any()
        assert optimum.cost > free.cost


def test_newton_s_steps_do_not_grow_in_number_as_the_barrier_gets_steep():
    problem = seed(*BITING[1])
    optima = Optima(problem, 1e-6, np.inf)
    start = next(iter(random_starts(problem, np.random.default_rng(0), 8)))
    space = SplineSpace.with_spans(48, np.empty(0))
    collocation = optima._collocation(start, space, 0.1)
    sampled = np.stack([np.interp(space.collocation, start.r, joint) for joint in start.q.T], axis=-1)
    counts = []
    for tolerance in (1e-4, 1e-7, 1e-10):
        found = minimise(collocation, space.interpolating(sampled), tolerance)
        assert found.converged
        counts.append(found.iterations)
    assert counts[-1] <= 60
    assert counts[2] - counts[1] <= 30


def test_a_place_without_a_way_out_is_no_motion():
    on_the_path = sm.Bezier(SEED_POINTS)(0.5)
    with pytest.raises(NothingFeasibleError) as caught:
        sm.plan(seed([on_the_path], [2.0]), sm.Refine(starts=2))
    assert caught.value.remedy


def test_postures_are_freed_by_their_self_motion():
    problem = seed([[20.0, -5.0]], [4.0])
    arm, x = problem.arm, problem.path(0.5)
    u = np.linspace(-1.5, 1.5, 200)[:, None]
    q, ok = arm.solve(x, u, 0)
    q = q[ok & (arm.constraints[0].margins(np.where(ok[:, None], q, 0.0)).min(axis=1) < 0)]
    assert len(q) > 5
    moved, free = freed(arm, x, arm.boxes()[0], q)
    assert free.mean() > 0.5
    assert is_clear(arm, moved[free]).all()
    assert arm.task_error(moved[free], x).max() < 1e-6


def test_what_is_caught_goes_on_as_a_copy_of_what_is_not():
    problem = seed(*BITING[1])
    arm, path, box = problem.arm, problem.path, problem.arm.boxes()[0]
    u = np.linspace(-0.5, 1.5, 12)[:, None]
    q, ok = arm.solve(path(0.0), u, 0)
    q = q[ok]
    r = np.linspace(0.0, 1.0, 201)
    motions, reached = followed(arm, path, box, q, np.zeros_like(q), r, np.random.default_rng(1))
    assert (reached == 1.0).all()
    for motion in motions:
        assert is_clear(arm, motion).all()
        assert np.abs(np.diff(motion, axis=0)).max() < 0.3


def test_dips_between_the_points_are_found_where_they_are():
    problem = seed([[58.0, 8.0]], [1.5])
    optima = Optima(problem, 1e-6, np.inf)
    start = next(iter(random_starts(problem, np.random.default_rng(0), 8)))
    optimum = optima.add(start)
    margins = optimum.collocation.margins(optimum.motion(np.linspace(0, 1, 200_001)))
    optimum.collocation.constraints[0].radii = np.array([1.5 + 80 * (margins.min() + 1e-7)])  # all but nothing dips
    found = dips(optimum.collocation, optimum.motion)
    assert found.max() == pytest.approx(1e-7, abs=2e-9)
    assert (found > 0).sum() == 1
    by_point = spread(optimum.collocation, found)
    span = int(found.max(axis=1).argmax())
    low, high = optimum.collocation.space.edges[[span, span + 1]]
    near = by_point.max(axis=1) > 0
    points = optimum.collocation.points
    assert near.sum() >= 2
    assert points[near].min() <= low
    assert points[near].max() >= high


def test_when_time_is_up_followers_stay_where_they_are(seed_problem):
    """And starts are made of them all the same: a first one is always tried."""
    arm, path, r = seed_problem.arm, seed_problem.path, np.linspace(0.0, 1.0, 101)
    q = arm.solve(path(0.0), [0.3], 0)[0][None]
    motions, reached = followed(arm, path, arm.boxes()[0], q, np.zeros_like(q), r, deadline=0.0)
    assert reached.tolist() == [r[1]]
    assert np.abs(motions[0, 1:] - motions[0, 1]).max() == 0.0
    assert np.abs(motions[0, 1] - motions[0, 0]).max() > 0.0
    starts = list(random_starts(seed_problem, np.random.default_rng(0), 8, deadline=0.0))
    assert 0 < len(starts) <= 16
    assert all(start.reached < 1.0 for start in starts)
