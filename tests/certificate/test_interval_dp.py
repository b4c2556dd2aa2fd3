"""The plain lower bound by itself: its intervals enclose, its boxes cover, its bound stays below every motion."""

import mpmath
import numpy as np
import pytest
from interval_dp import GivenEnd, Interval, Slice, chords, corner, cover, direction, interval_bound, uniform_bound

import selfmotion as sm
from oracle import Arms, random_arm, random_path
from selfmotion.objectives import OBJECTIVES

TAU = 2 * np.pi
OBJECTIVE_NAMES = tuple(OBJECTIVES)


def random_intervals(rng, size, scale=4.0):
    """Intervals of all widths, some of one number, some with ends at quarter turns or at ±1 up to rounding."""
    middle = rng.uniform(-scale, scale, size)
    special = rng.integers(-8, 9, size) * 0.5 * np.pi
    middle = np.where(rng.random(size) < 0.2, special, middle)
    middle = np.where(rng.random(size) < 0.1, np.sign(middle), middle)
    half = np.where(rng.random(size) < 0.2, 0.0, 10 ** rng.uniform(-16, 0.5, size))
    return Interval(middle - half, middle + half)


def inside(rng, interval):
    """Points of the intervals, ends among them."""
    at = rng.choice([0.0, 1.0, -1.0], size=interval.lo.shape)
    at = np.where(at < 0, rng.random(interval.lo.shape), at)
    return np.clip(interval.lo + at * (interval.hi - interval.lo), interval.lo, interval.hi)


def assert_encloses(found, exact):
    for lo, hi, value in zip(found.lo, found.hi, exact, strict=True):
        assert mpmath.mpf(float(lo)) <= value <= mpmath.mpf(float(hi))


@pytest.fixture(autouse=True)
def _forty_digits():
    with mpmath.workdps(40):
        yield


def exact(points):
    return [mpmath.mpf(float(value)) for value in points]


@pytest.mark.parametrize(
    ("operation", "reference"),
    [
        (lambda a, b: a + b, lambda x, y: x + y),
        (lambda a, b: a - b, lambda x, y: x - y),
        (lambda a, b: a * b, lambda x, y: x * y),
        (lambda a, b: a / (b.square() + 1e-3), lambda x, y: x / (y * y + mpmath.mpf(1e-3))),
        (lambda a, b: a.square(), lambda x, y: x * x),
        (lambda a, b: a.square().sqrt(), lambda x, y: abs(x)),
        (lambda a, b: a.cos(), lambda x, y: mpmath.cos(x)),
        (lambda a, b: a.sin(), lambda x, y: mpmath.sin(x)),
        (lambda a, b: a.arccos(), lambda x, y: mpmath.acos(min(max(x, -1), 1))),
    ],
)
def test_operations_enclose_the_exact_result_and_little_more(operation, reference):
    rng = np.random.default_rng(0)
    a, b = random_intervals(rng, 2_000), random_intervals(rng, 2_000)
    found = operation(a, b)
    x, y = exact(inside(rng, a)), exact(inside(rng, b))
    assert_encloses(found, [reference(one, two) for one, two in zip(x, y, strict=True)])
    points = operation(Interval.of(a.lo), Interval.of(b.lo))
    assert (points.hi - points.lo).max() < 1e-11


def test_directions_of_boxes_enclose_those_of_their_points():
    rng = np.random.default_rng(1)
    x, y = random_intervals(rng, 4_000, 2.0), random_intervals(rng, 4_000, 2.0)
    found = direction(x, y)
    a, b = inside(rng, x), inside(rng, y)
    angle = np.arctan2(b, a)
    angle += TAU * np.ceil((found.lo - 1e-14 - angle) / TAU)
    assert (angle <= found.hi + 1e-14).all()
    everywhere = (x.lo <= 0) & (x.hi >= 0) & (y.lo <= 0) & (y.hi >= 0)
    assert ((found.hi - found.lo < TAU) == ~everywhere).all()
    assert (found.hi - found.lo)[~everywhere].max() <= np.pi + 1e-12


def test_angles_of_triangles_are_enclosed():
    rng = np.random.default_rng(2)
    for _ in range(200):
        side, other = 10 ** rng.uniform(-1, 1, 2)
        other = side if rng.random() < 0.2 else other
        ends = np.sort(rng.uniform(abs(side - other), side + other, (2, 20)), axis=0)
        d = np.clip(inside(rng, Interval(*ends)), *ends)
        found = corner(side, other, Interval(*ends))
        s, o = mpmath.mpf(side), mpmath.mpf(other)
        angles = [mpmath.acos(min(max((s * s + t * t - o * o) / (2 * s * t), -1), 1)) for t in exact(d)]
        assert_encloses(found, angles)


# --- covers -----------------------------------------------------------------------------------------------------------


def postures(rng, arm, sign, x):
    """Feasible postures at x with every number of turns that the limits allow: dense in u, denser towards folds."""
    ik = Arms([arm], [sign])
    target = np.array([complex(*x)])
    u = rng.uniform(-np.pi, np.pi, 1_500)
    for side in (1, -1):
        for value in (0.0, np.pi):
            _, fold = ik.at_fold(target, np.array([value]), side)
            u = np.append(u, fold + rng.choice([-1, 1], 100) * 10 ** rng.uniform(-14, -1, 100))
    q, reach = ik.joints(target, u[None])
    q = q[0, (reach[0] >= 0).all(axis=-1), : arm.n]
    for j in np.flatnonzero(np.isfinite(arm.limits.lower)):
        turned = q[:, None, :] + TAU * np.arange(-4, 5)[:, None] * np.eye(arm.n)[j]
        q = turned.reshape(-1, arm.n)
        q = q[(q[:, j] >= arm.limits.lower[j]) & (q[:, j] <= arm.limits.upper[j])]
    return q


def holding(boxes, q, real, tolerance=1e-7):
    """Which boxes (m) hold which postures (k), shape (k, m); the oracle's own rounding near folds is forgiven."""
    middle, half = 0.5 * (boxes.lo + boxes.hi), 0.5 * (boxes.hi - boxes.lo)
    off = np.abs(q[:, None] - middle)
    off = np.where(real, off, np.abs(off - TAU * np.rint(off / TAU)))
    return (off <= half + tolerance).all(axis=-1)


def random_line(rng, arm):
    """A line between two points that the links reach."""
    center, inner, outer = arm.annulus
    radius = inner + (outer - inner) * rng.uniform(0.1, 0.9, (2, 1))
    angle = rng.uniform(-np.pi, np.pi) + np.array([[0.0], [rng.uniform(-1.5, 1.5)]])
    return sm.Line(*(center + radius * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)))


def arcs_of(count):
    edges = np.linspace(-np.pi, np.pi, count + 1)
    return Interval(edges[:-1] - 1e-13, edges[1:] + 1e-13)


def test_covers_hold_every_feasible_posture():
    seen = 0
    for seed in range(150):
        rng = np.random.default_rng(seed)
        arm = random_arm(rng, widest=11.0)
        x = random_path(rng, arm)(rng.random())
        count = int(rng.integers(20, 300))
        for sign in (1, -1):
            boxes = cover(arm, x, arcs_of(count), np.full(count, sign))
            q = postures(rng, arm, sign, x)
            q = q[rng.permutation(len(q))[:600]]
            assert holding(boxes, q, arm.limits.limited).any(axis=1).all()
            assert (boxes.lo >= arm.limits.lower - 1e-12).all() or not len(boxes)
            assert (boxes.hi <= arm.limits.upper + 1e-12).all() or not len(boxes)
            seen += len(q)
    assert seen > 50_000


def test_covers_hold_the_line_of_postures_whose_wrist_is_on_the_base():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        length, last = rng.uniform(0.3, 2, 2)
        arm = sm.PlanarArm([length, length, last], [None, (-4.0, 4.0), (-8.0, 7.0)])
        u = rng.uniform(-np.pi, np.pi)
        theta1 = np.linspace(-np.pi, np.pi, 500)
        count = int(rng.integers(20, 500))
        for sign in (1, -1):
            boxes = cover(arm, last * np.array([np.cos(u), np.sin(u)]), arcs_of(count), np.full(count, sign))
            for turns in (-1, 0, 1):
                theta3 = u - theta1 - sign * np.pi + TAU * turns
                q = np.stack([theta1, np.full(500, sign * np.pi), theta3], axis=-1)
                q = q[(theta3 >= -8) & (theta3 <= 7)]
                assert holding(boxes, q, arm.limits.limited).any(axis=1).all()


def test_halved_slices_still_cover_with_narrower_boxes(seed_problem):
    rng = np.random.default_rng(0)
    slice_ = Slice(seed_problem, 0.4, 4096, 64)
    widest = (slice_.boxes.hi - slice_.boxes.lo).max()
    q = np.concatenate([postures(rng, seed_problem.arm, sign, seed_problem.path(0.4)) for sign in (1, -1)])
    for _ in range(6):
        assert slice_.halve(rng.random(len(slice_.boxes)) < 0.7)
        assert holding(slice_.boxes, q, seed_problem.arm.limits.limited).any(axis=1).all()
    while slice_.halve(np.ones(len(slice_.boxes), bool)):
        pass
    assert (slice_.last - slice_.first == 1)[slice_.boxes.arc].all()
    # Near a fold widths fall like the square root of the arcs' length.
    assert (slice_.boxes.hi - slice_.boxes.lo).max() < 1.5 * widest / 8


# --- chords -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("objective", OBJECTIVE_NAMES)
def test_chords_of_boxes_cost_no_more_than_those_of_postures_in_them(objective):
    for seed in range(40):
        rng = np.random.default_rng(seed)
        arm = random_arm(rng, widest=9.0)
        path = random_line(rng, arm)
        problem = sm.Problem(arm, path, objective=objective, weights=rng.uniform(0.1, 2, arm.n))
        sides = []
        for r in (0.0, 1.0):
            boxes = cover(arm, path(r), arcs_of(60), np.ones(60))
            sides.append((boxes, postures(rng, arm, 1, path(r))[:100]))
        (one, p), (two, q) = sides
        if not (len(p) and len(q)):
            continue
        least = chords(one, two, 0.3, problem)
        held, holds = holding(one, p, arm.limits.limited, 0), holding(two, q, arm.limits.limited, 0)
        steps = arm.limits.steps(p[:, None], q)
        true = problem.objective.chord(steps, np.full(steps.shape[:2], 0.3), problem.weights)
        for i in range(len(p)):
            for j in range(0, len(q), 7):
                assert (least[np.ix_(held[i], holds[j])] <= true[i, j]).all()


# --- bounds -----------------------------------------------------------------------------------------------------------


def seed_case(seed_arm, seed_path, objective="joint_travel"):
    return sm.Problem(seed_arm, seed_path, start=[0.3], elbow="positive", objective=objective)


def test_the_bound_rises_to_the_best_known_motion(seed_arm, seed_path):
    problem = seed_case(seed_arm, seed_path)
    best = 4.889446604
    bounds = [interval_bound(problem, slices, arcs) for slices, arcs in ((10, 256), (20, 2048), (20, 16384))]
    assert bounds == pytest.approx([4.635452978, 4.823132, 4.871993], abs=2e-3)
    assert max(bounds) < best
    assert bounds == sorted(bounds)


def test_finer_arcs_never_lower_the_bound(seed_arm, seed_path):
    problem = seed_case(seed_arm, seed_path)
    bounds = np.array([interval_bound(problem, 12, 64 * 2**k) for k in range(6)])
    assert (np.diff(bounds) > 0).all()
    assert bounds[-1] < 4.889447
    # What is lost halves with the arcs.
    assert 1.5 < (bounds[4] - bounds[3]) / (bounds[5] - bounds[4]) < 2.5


@pytest.mark.parametrize("objective", OBJECTIVE_NAMES)
def test_halving_where_cheap_chains_pass_gives_the_bound_of_uniform_arcs(seed_arm, seed_path, objective):
    problem = seed_case(seed_arm, seed_path, objective)
    assert interval_bound(problem, 8, 512) == pytest.approx(uniform_bound(problem, 8, 512), rel=1e-10)
    free = sm.Problem(sm.PlanarArm([1.9, 0.6, 1.7], [None, (2.8, 10.1), (2, 10)]), sm.Line([3, -2], [3, 1]))
    assert interval_bound(free, 6, 512) == pytest.approx(uniform_bound(free, 6, 512), rel=1e-10)


@pytest.mark.parametrize(("objective", "least"), [("joint_travel", 0.99), ("l1", 0.97), ("l2", 0.98)])
def test_refined_motions_of_the_seed_cost_more(seed_arm, seed_path, objective, least):
    problem = seed_case(seed_arm, seed_path, objective)
    cost = sm.plan(problem, sm.Refine(starts=4)).cost
    assert least * cost < interval_bound(problem, 16, 4096) < cost


def test_motions_of_random_problems_cost_more():
    compared = 0
    for seed in range(16):
        rng = np.random.default_rng(seed)
        arm, objective = random_arm(rng, widest=9.0), OBJECTIVE_NAMES[seed % 3]
        path = random_line(rng, arm)
        problem = sm.Problem(arm, path, objective=objective, weights=rng.uniform(0.5, 2, arm.n))
        bound = interval_bound(problem, 8, 512)
        try:
            cost = sm.plan(problem, sm.Refine(starts=1, tolerance=1e-3, time_limit=2.0)).cost
        except sm.InfeasibleError:
            continue  # most bounds are infinite here, but a chord may also leap where no motion can
        except sm.NothingFeasibleError:
            continue
        assert bound < cost * (1 + 1e-9)
        compared += 1
    assert compared > 9


def test_an_empty_cover_proves_that_there_is_no_motion():
    arm = sm.PlanarArm([1, 1, 1], [(-1, 1), (-0.5, 0.5), (-0.5, 0.5)])
    assert interval_bound(sm.Problem(arm, sm.Line([2.9, 0], [1.0, 0])), 10, 1024) == np.inf
    assert interval_bound(sm.Problem(arm, sm.Line([2.95, 0], [2.8, 0])), 10, 1024) < np.inf


def test_given_ends_stand_in_their_boxes(seed_arm, seed_path):
    plan = sm.plan(seed_case(seed_arm, seed_path), sm.Refine(starts=2))
    q = plan.motion(np.array([0.0, 1.0]))
    for name, r, posture in (("start", 0.0, q[0]), ("end", 1.0, q[1])):
        for given in ({"q": posture}, {"u": seed_arm.u_of(posture)}):
            problem = sm.Problem(seed_arm, seed_path, **{name: given})
            end = GivenEnd(problem, r, getattr(problem, name))
            assert holding(end.boxes, posture[None], seed_arm.limits.limited, 0).any()
            assert (end.boxes.hi - end.boxes.lo).max() < 1e-6
    both = sm.Problem(seed_arm, seed_path, start={"q": q[0]}, end={"q": q[1]})
    assert interval_bound(both, 12, 1024) < plan.cost


# --- planted optima ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("objective", "best"), [("joint_travel", np.sqrt(1 + 1.3**2) + 2), ("l1", 1.3), ("l2", 1.3)])
def test_an_arc_about_the_base_between_two_given_postures(objective, best):
    """Turning θ1 alone is a straight line in joint space, and no motion between its ends costs less than their chord.

    Both ends must be given. Else turning θ2 and θ3 a little takes some of the arc from θ1, which saves joint travel in
    the first order and costs it in the second only.
    """
    arm = sm.PlanarArm([1.0, 0.8, 0.6])
    q = np.array([[0.2, 0.9, -0.4], [1.5, 0.9, -0.4]])
    radius, angle = np.hypot(*arm.forward(q[0])), np.arctan2(*arm.forward(q[0])[::-1])
    path = sm.Arc([0, 0], radius, angle, 1.3)
    problem = sm.Problem(arm, path, start={"q": q[0]}, end={"q": q[1]}, objective=objective)
    bounds = [interval_bound(problem, 8, arcs) for arcs in (256, 2048, 8192)]
    assert bounds == sorted(bounds)
    assert best * 0.985 < bounds[-1] < best
    assert best - 1e-8 < interval_bound(problem, 1, 1) < best


@pytest.mark.parametrize(("objective", "best"), [("joint_travel", np.sqrt(1 + 1.3**2) + 2), ("l1", 1.3), ("l2", 1.3)])
def test_a_locked_joint_leaves_one_motion(objective, best):
    """θ2 stands between limits 2e-9 apart: what is left is a two-link arm, and about the base θ1 turns alone."""
    arm = sm.PlanarArm([1.0, 0.8, 0.6], [None, (0.9 - 1e-9, 0.9 + 1e-9), (-2.0, -0.1)])
    start = arm.forward([0.2, 0.9, -0.4])
    path = sm.Arc([0, 0], np.hypot(*start), np.arctan2(*start[::-1]), 1.3)
    problem = sm.Problem(arm, path, objective=objective)
    losses = [best - interval_bound(problem, 8, 64 * 4**k) for k in range(5)]
    assert min(losses) > 0
    assert losses[-1] < 0.02 * best
    assert losses == sorted(losses, reverse=True)


def test_a_stretched_arm_has_one_motion():
    """At full reach every posture is a fold, where enclosures narrow only like the square root of the arcs."""
    arm = sm.PlanarArm([1.0, 0.8, 0.6])
    problem = sm.Problem(arm, sm.Arc([0, 0], 2.4 * (1 - 1e-12), 0.3, 1.3))
    best = np.sqrt(1 + 1.3**2) + 2
    bounds = [interval_bound(problem, 4, 64 * 16**k) for k in range(4)]
    assert bounds == sorted(bounds)
    assert 0.99 * best < bounds[-1] < best
