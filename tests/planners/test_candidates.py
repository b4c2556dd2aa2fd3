"""Compiled candidates against numpy ones: the chord sum, the integral that it tends to, and what is left uncomputed."""

from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import numpy as np
import pytest
from searches import box_of, random_search

import selfmotion as sm
from selfmotion.arms._motion_kernels import blank_sheet
from selfmotion.motion import Motion
from selfmotion.optimizers import INFEASIBLE, RunsSwarms, violation_of
from selfmotion.planners._candidate_kernels import integral
from selfmotion.planners.candidates import Candidates, Carrier, PlanarCandidates, candidates_of
from selfmotion.planners.parametric import _Search
from selfmotion.profiles import SinusoidProfile
from selfmotion.report import seed_3r

FAMILIES = ("sinusoid", "harmonics", "bspline")
SWARMS = {"pso": sm.PSO, "gwo": sm.GWO, "random": sm.RandomSearch}


def population(profile, rng, size=12):
    low, high = sm.PSO(bounds=box_of(profile)).box(len(profile.parameter_names))
    return low + (high - low) * rng.random((size, len(low)))


def errors_of(judge, a):
    """The estimates of the integrals' errors, which the search compares values by."""
    search, sheet = judge._search, blank_sheet(judge.problem.arm.n)
    return np.array([integral(search.family, row, search.nodes, search.panels, 1e-8, np.inf, sheet)[1] for row in a])


def carried(rng, arm):
    """Something that turns below the arm."""
    swing, rate = rng.uniform(-1, 1), rng.uniform(0.5, 4)
    turn = lambda r, order: swing * (np.sin(rate * r) if order == 0 else rate * np.cos(rate * r))  # noqa: E731
    return Carrier(arm.limits, turn, bool(rng.integers(2)))


@pytest.mark.parametrize("seed", range(60))
def test_the_chord_sum_is_that_of_numpy(seed):
    problem, profile, branch = random_search(seed, FAMILIES)
    rng = np.random.default_rng(seed)
    carrier = carried(rng, problem.arm) if seed % 3 == 0 else None
    a = population(profile, rng)
    wanted = Candidates(problem, profile, branch, carrier)(a)
    found = PlanarCandidates(problem, profile, branch, carrier)(a)
    assert ((found < INFEASIBLE) == (wanted < INFEASIBLE)).all()
    inside = wanted < INFEASIBLE
    np.testing.assert_allclose(found[inside], wanted[inside], rtol=1e-13)
    np.testing.assert_allclose(found[~inside] / INFEASIBLE - 1, wanted[~inside] / INFEASIBLE - 1, rtol=1e-9, atol=1e-13)


@pytest.mark.parametrize("seed", range(40))
def test_the_integral_is_what_the_chord_sum_tends_to(seed):
    """A chord sum never exceeds the integral, and where halving h moves it little, it has little left to go."""
    problem, profile, branch = random_search(seed, FAMILIES)
    rng = np.random.default_rng(seed)
    carrier = carried(rng, problem.arm) if seed % 3 == 0 else None
    a = population(profile, rng)
    judge = PlanarCandidates(problem, profile, branch, carrier, ranking="integral")
    # At a kink two rules may agree by chance: the search leaves four times the estimate.
    found, errors = judge(a), (4 if problem.objective.has_kinks else 1) * errors_of(judge, a)
    sums = []
    for samples in (4001, 8001):
        finer = sm.Problem(
            problem.arm, problem.path, None if problem.start is None else {"q": problem.start.q},
            weights=problem.weights, objective=problem.objective.kind, samples=samples,
        )  # fmt: skip
        sums.append(PlanarCandidates(finer, profile, branch, carrier)(a))
    both = (sums[0] < INFEASIBLE) & (sums[1] < INFEASIBLE) & (found < INFEASIBLE)
    left = (found - sums[1])[both]
    assert (left >= -(errors + 1e-12 * found)[both]).all()
    if not len(problem.path.breaks):  # chords cut corners, by how much depends on where the samples are
        assert (left <= (4 * (sums[1] - sums[0]) + errors + 1e-12 * found)[both]).all()


@pytest.mark.parametrize("seed", range(40))
def test_what_is_feasible_by_the_integral_is_so_at_all_samples(seed):
    """And nearly the other way round: a node may be out of reach between two samples."""
    problem, profile, branch = random_search(seed, FAMILIES)
    a = population(profile, np.random.default_rng(seed), 300)
    by_integral = PlanarCandidates(problem, profile, branch, ranking="integral")(a) < INFEASIBLE
    at_samples = PlanarCandidates(problem, profile, branch)(a) < INFEASIBLE
    assert not (by_integral & ~at_samples).any()
    assert (at_samples & ~by_integral).mean() < 0.05


def test_an_excursion_between_the_few_samples_is_seen():
    """The path has a spike whose tip alone is out of reach, between two of the 32 samples that are looked at first."""
    arm, profile, f = sm.PlanarArm([1, 1, 1]), SinusoidProfile([0.0], [1e-6]), np.array([[0.3], [0.7]])
    path = sm.Waypoints([[2.9, -0.5], [2.9, 0.4], [2.963, 0.405], [2.9, 0.41], [2.9, 0.5]], "linear")
    problem, few = (sm.Problem(arm, path, samples=samples) for samples in (31 * 40 + 1, 32))
    assert (PlanarCandidates(few, profile, 0)(f) < INFEASIBLE).all()
    chords, integral = (PlanarCandidates(problem, profile, 0, ranking=name)(f) for name in ("samples", "integral"))
    assert (chords > INFEASIBLE).all()
    np.testing.assert_array_equal(chords, integral)


@pytest.mark.parametrize("seed", range(12))
def test_the_integral_is_that_of_the_motion(seed):
    """The oracle integrates rates in numpy, adaptively by Gauss and Kronrod, as plans do."""
    problem, profile, branch = random_search(200 + seed, FAMILIES)
    a = population(profile, np.random.default_rng(seed), 6)
    judge = PlanarCandidates(problem, profile, branch, ranking="integral")
    found = judge(a)
    for row, value in zip(a, found, strict=True):
        if value < INFEASIBLE:
            motion = Motion(problem.arm, problem.path, lambda r, order, row=row: profile(row, r, order), branch, 4000)
            exact = problem.objective.integral(motion.rates, problem.path.grid(64), problem.weights)
            assert value == pytest.approx(exact.value, rel=1e-12, abs=errors_of(judge, row[None])[0] + exact.error)


@pytest.mark.parametrize("seed", range(40))
def test_what_is_not_exact_lies_between_its_threshold_and_the_truth(seed):
    problem, profile, branch = random_search(seed, FAMILIES)
    judge = PlanarCandidates(problem, profile, branch, ranking="integral")
    a = population(profile, np.random.default_rng(seed), 30)
    truth = judge(a)
    for threshold in (np.quantile(truth, 0.3), np.median(truth)):
        _, values, exact = judge.judge(a, threshold)
        np.testing.assert_array_equal(values[exact], truth[exact])
        assert (values[~exact] > threshold).all()
        assert (values[~exact] <= truth[~exact] * (1 + 1e-8)).all()


@pytest.mark.parametrize("kind", SWARMS)
@pytest.mark.parametrize("ranking", ["samples", "integral"])
def test_a_compiled_run_is_the_run_from_python(kind, ranking):
    """The same candidates to the last bit, whether the interpreter asks and tells or the kernel does."""
    problem, profile, branch = random_search(3)
    optimizer = SWARMS[kind](9, 14, box_of(profile), seed=4)
    function = PlanarCandidates(problem, profile, branch, ranking=ranking)
    assert isinstance(function, RunsSwarms)
    compiled = optimizer.minimize(function, len(profile.parameter_names))
    told = []
    watched = optimizer.minimize(function, len(profile.parameter_names), lambda *done: told.append(done))
    asked = optimizer.minimize(lambda a: function(a), len(profile.parameter_names))
    assert told[-1][0] == 14
    for other in (watched, asked):
        np.testing.assert_array_equal(other.population, compiled.population)
        assert other.value == compiled.value
        np.testing.assert_array_equal(other.history.best, compiled.history.best)
    exact = compiled.judged.exact
    np.testing.assert_array_equal(asked.values[exact], compiled.values[exact])
    assert exact.all() == (ranking == "samples")


def test_the_winner_is_that_of_full_accuracy_on_a_thousand_problems():
    """Judging as accurately as ranking needs changes no candidate and no winner."""
    families, feasible, spared = ("sinusoid", "sinusoid", "harmonics", "bspline"), 0, 0
    for seed in range(1000):
        problem, profile, branch = random_search(10_000 + seed, families)
        function = PlanarCandidates(problem, profile, branch, ranking="integral")
        optimizer = tuple(SWARMS.values())[seed % 3](8, 12, box_of(profile), seed=seed)
        lazy = optimizer.minimize(function, len(profile.parameter_names))
        full = optimizer.minimize(lambda a, f=function: f(a), len(profile.parameter_names))
        np.testing.assert_array_equal(lazy.population, full.population)
        assert lazy.value == full.value
        feasible += lazy.value < INFEASIBLE
        spared += int((~lazy.judged.exact).sum())
    assert feasible > 500
    assert spared > 20_000


@pytest.mark.parametrize("seed", range(4))
def test_candidates_come_in_the_order_of_their_true_values(seed):
    """Whoever passes over the best ones must meet all others, judged when their turn comes."""
    problem, profile, branch = random_search(seed, FAMILIES)
    function = PlanarCandidates(problem, profile, branch, ranking="integral")
    result = sm.PSO(9, 14, box_of(profile), seed=4).minimize(function, len(profile.parameter_names))
    assert not result.judged.exact.all()
    truth = function(result.population)
    met = list(_Search(branch, function, result).ascending())
    values = [found.value for found in met]
    assert values == sorted(values)
    np.testing.assert_array_equal(values, np.sort(truth[truth < INFEASIBLE]))
    np.testing.assert_array_equal([found.a for found in met], [result.population[found.number] for found in met])


def test_threads_give_the_same_bits():
    problem, profile, branch = random_search(3)
    function = PlanarCandidates(problem, profile, branch, ranking="integral")

    def best(seed):
        return sm.PSO(9, 30, box_of(profile), seed=seed).minimize(function, len(profile.parameter_names)).x

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(best, range(16)))
    np.testing.assert_array_equal(together, [best(seed) for seed in range(16)])


def test_a_shift_is_added_to_every_coefficient():
    changed = []
    for seed in range(8):
        problem, profile, branch = random_search(seed, FAMILIES)
        a, judge = population(profile, np.random.default_rng(0)), PlanarCandidates(problem, profile, branch)
        np.testing.assert_allclose(judge.shifted(2.3).shifted(-0.3)(a - 2.0), judge(a), rtol=1e-12)
        changed.append(not np.allclose(judge(a - 2.0), judge(a), rtol=1e-6))
    assert sum(changed) > 4


def test_a_candidate_out_of_reach_between_the_samples_is_no_candidate():
    """A fold is crossed between two of 16 samples, and at nodes of the quadrature."""
    arm, path = sm.PlanarArm([1, 1, 1]), sm.Line([2.0, -0.5], [2.0, 0.5])
    problem = sm.Problem(arm, path, samples=16)
    profile = SinusoidProfile([0.0], [1.5])
    f = np.array([[15.0]])  # zero at every sample
    assert PlanarCandidates(problem, profile, 0)(f)[0] < INFEASIBLE
    assert INFEASIBLE < PlanarCandidates(problem, profile, 0, ranking="integral")(f)[0] < INFEASIBLE * 1.001


def test_arms_without_kernels_are_judged_in_numpy():
    class Mirrored(sm.PlanarArm):
        """An arm whose elbows are named the other way round."""

        def solve_with_margin(self, x, u, branch=0):
            return super().solve_with_margin(x, u, 1 - branch)

    problem, profile, branch = random_search(3)
    assert type(candidates_of(problem, profile, branch, "integral")) is PlanarCandidates
    mirrored = sm.Problem(
        Mirrored(problem.arm.links, problem.arm.limits.as_list(), problem.arm.direction), problem.path,
        weights=problem.weights, objective=problem.objective.kind, samples=problem.samples,
    )  # fmt: skip
    a = population(profile, np.random.default_rng(0))
    np.testing.assert_allclose(
        candidates_of(mirrored, profile, 1 - branch, "samples")(a),
        candidates_of(problem, profile, branch, "samples")(a),
        rtol=1e-9,
    )


def test_a_long_run_is_cut_so_that_it_can_be_stopped():
    problem, profile, branch = random_search(3)
    function, asked = PlanarCandidates(problem, profile, branch, ranking="integral"), []
    whole = function.run
    function.run = lambda swarm, state, generations: asked.append(generations) or whole(swarm, state, generations)
    sm.RandomSearch(1000, 45, box_of(profile)).minimize(function, len(profile.parameter_names))
    assert asked == [20, 20, 5]


def test_both_rankings_find_the_same_motion():
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
    path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
    problem = sm.Problem(arm, path, elbow="positive")
    plans = [
        sm.plan(problem, sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(bounds=(0, 15), seed=1), ranking=ranking))
        for ranking in ("integral", "samples")
    ]
    assert plans[0].cost == pytest.approx(plans[1].cost, abs=1e-8)
    assert plans[0].cost == pytest.approx(min(plans[0].history[0].best), rel=1e-8)
    assert plans[1].cost_sampled == pytest.approx(min(plans[1].history[0].best), rel=1e-13)


def test_an_unknown_ranking_is_refused():
    with pytest.raises(sm.InvalidInputError, match="ranking"):
        sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(), ranking="guess")


def test_candidates_rank_by_how_deep_a_link_is_in_an_obstacle():
    given = seed_3r.problem()
    center, radius = np.array([45.0, -10.0]), 6.0
    problem = sm.Problem(
        given.arm, given.path, start={"u": [0.3]}, samples=200, obstacles=[sm.CircleObstacle(center, radius)]
    )
    profile = SinusoidProfile([0.3], [0.4])
    frequencies = np.array([[0.1], [0.5], [1.0]])
    values = candidates_of(problem, profile, 0, "samples")(frequencies)
    q, ok = given.arm.solve(problem.points, profile(frequencies, problem.grid), 0)
    assert ok.all()
    ends = given.arm.joint_positions(q)
    part = np.linspace(0.0, 1.0, 2001)[:, None]
    deepest = [
        max(
            radius - np.linalg.norm(a + part * (b - a) - center, axis=-1).min()
            for posture in motion for a, b in pairwise(posture)
        )
        for motion in ends
    ]  # fmt: skip
    assert min(deepest) > 0.1
    assert [violation_of(value) for value in values] == pytest.approx(np.array(deepest) / 80.0, abs=1e-5)
