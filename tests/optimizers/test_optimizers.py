"""Every optimizer of the registry: same seed, same bits; inside the box; better than random search."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.optimizers import INFEASIBLE, OPTIMIZERS, AskTell, penalised

SEEDS = 20
# Twenty generations of 100: the same 2000 evaluations for all.
BUDGET = {"population": 100, "iterations": 20}
SHIFT = np.array([1.3, -0.7])


def rosenbrock(x):
    y = x - SHIFT + 1
    return 100 * (y[:, 1] - y[:, 0] ** 2) ** 2 + (1 - y[:, 0]) ** 2


def rastrigin(x):
    y = x - SHIFT
    return 20 + (y**2 - 10 * np.cos(2 * np.pi * y)).sum(axis=1)


PROBLEMS = {
    "sphere": (lambda x: ((x - SHIFT) ** 2).sum(axis=1), (-5.12, 5.12)),
    "rosenbrock": (rosenbrock, (-5.0, 10.0)),
    "rastrigin": (rastrigin, (-5.12, 5.12)),
}


KINDS = {**OPTIMIZERS, "shifted": lambda *args, **more: sm.Shifted(sm.PSO(*args, **more), -40.0)}


def variants():
    for kind, optimizer in KINDS.items():
        if kind == "pso":
            yield "pso seed", lambda **k: sm.PSO(variant="seed", **k)
            yield "pso canonical", lambda **k: sm.PSO(variant="canonical", **k)
        elif kind != "random":
            yield kind, optimizer


class DoNothing(AskTell):
    """Evaluates the middle of the box again and again."""

    kind = "nothing"

    def start(self, lower, upper, rng):
        return np.tile((lower + upper) / 2, (self.population, 1))

    def ask(self, state):
        return state

    def tell(self, state, values):
        pass


def median(make, problem, **budget):
    function, bounds = PROBLEMS[problem]
    runs = [make(bounds=bounds, seed=seed, **(budget or BUDGET)).minimize(function, 2) for seed in range(SEEDS)]
    assert {run.evaluations for run in runs} == {2000}
    return float(np.median([run.value for run in runs]))


@pytest.fixture(scope="module")
def random_median():
    return {problem: median(sm.RandomSearch, problem) for problem in PROBLEMS}


@pytest.mark.parametrize("problem", PROBLEMS)
@pytest.mark.parametrize(("name", "make"), list(variants()), ids=lambda v: v if isinstance(v, str) else "")
def test_beats_random_search_at_equal_evaluations(name, make, problem, random_median):
    assert median(make, problem) < random_median[problem]


@pytest.mark.parametrize("problem", PROBLEMS)
def test_doing_nothing_does_not(problem, random_median):
    assert median(DoNothing, problem) > random_median[problem]


@pytest.mark.parametrize("dimension", [1, 2, 5])
@pytest.mark.parametrize("kind", KINDS)
def test_same_seed_same_bits_inside_the_box_full_history(kind, dimension):
    seen = []

    def function(x):
        seen.append(x.copy())
        return ((x - 0.3) ** 2).sum(axis=1)

    bounds = [(-1.0, 0.5 + j) for j in range(dimension)]
    np.random.seed(99)  # noqa: NPY002 (global state must not matter)
    first = KINDS[kind](8, 12, bounds, seed=7).minimize(function, dimension)
    assert len(seen) == 12  # one batch per generation
    assert all(x.shape == (8, dimension) for x in seen)
    everything = np.vstack(seen)
    assert (everything >= -1.0).all()
    assert (everything <= np.array(bounds)[:, 1]).all()
    np.random.seed(1)  # noqa: NPY002
    again = KINDS[kind](8, 12, bounds, seed=7).minimize(function, dimension)
    np.testing.assert_array_equal(first.population, again.population)
    other = KINDS[kind](8, 12, bounds, seed=8).minimize(function, dimension)
    assert (first.population != other.population).any()
    np.testing.assert_array_equal(first.population, everything)
    assert first.value == first.values.min() == function(first.x[None])[0]
    history = first.history
    assert history.evaluations == list(range(8, 97, 8))
    assert history.best == [first.values[:k].min() for k in history.evaluations]
    assert history.mean[0] == pytest.approx(first.values[:8].mean())
    assert len(history.time_s) == 12
    assert (np.diff(history.time_s) >= 0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_nan_is_never_best(kind):
    def function(x):
        values = (x**2).sum(axis=1)
        values[::2] = np.nan
        return values

    result = KINDS[kind](8, 6, (-1, 1), seed=0).minimize(function, 2)
    assert result.value < 10
    assert not np.isnan(result.values).any()


def test_infeasible_candidates_rank_below_all_feasible_ones_and_by_violation():
    values = penalised(np.array([1e9, 1.0, 2.0, 3.0]), np.array([0.0, 1e-9, 5.0, np.nan]))
    assert np.argsort(values).tolist() == [0, 1, 2, 3]
    assert (values[1:] >= INFEASIBLE).all()
    assert values[2] / INFEASIBLE - 1 == pytest.approx(5.0)


def test_canonical_constriction_is_clerc_and_kennedy_s():
    from selfmotion.optimizers.pso import _VARIANTS

    chi, _, phi1, phi2 = _VARIANTS["canonical"]
    phi = phi1 + phi2
    assert chi == pytest.approx(2 / abs(2 - phi - np.sqrt(phi**2 - 4 * phi)), abs=1e-15)
    assert chi == pytest.approx(0.7298, abs=5e-5)


def test_pso_step_is_equation_23():
    pso = sm.PSO(population=3, bounds=(-100, 100), variant="seed")
    state = pso.start(np.full(2, -100.0), np.full(2, 100.0), np.random.default_rng(5))
    x = pso.ask(state).copy()
    pso.tell(state, np.array([3.0, 1.0, 2.0]))
    np.testing.assert_array_equal(state.v[1], 0.0)  # the best particle is at its own and the swarm's best
    x2 = pso.ask(state).copy()
    v, p, g = state.v.copy(), state.remembered.copy(), x[1]
    state.rng = np.random.default_rng(0)
    beta1, beta2 = np.random.default_rng(0).random((2, 3, 2))
    pso.tell(state, np.array([9.0, 9.0, 9.0]))
    moved = x2 + v + 1.5 * beta1 * (p - x2) + 1.5 * beta2 * (g - x2)
    np.testing.assert_allclose(pso.ask(state), np.clip(moved, -100, 100))


def test_undamped_swarm_hits_the_walls_and_walls_differ():
    function = PROBLEMS["sphere"][0]
    runs = {
        walls: sm.PSO(10, 60, (-5, 5), 0, variant="seed", walls=walls).minimize(function, 2)
        for walls in ("absorb", "clip")
    }
    assert (np.abs(runs["clip"].population) == 5).any()
    assert (runs["clip"].population != runs["absorb"].population).any()


def test_gwo_leaders_persist_and_an_old_alpha_is_not_demoted():
    gwo = sm.GWO(population=3, iterations=10, bounds=(-1, 1))
    state = gwo.start(-np.ones(1), np.ones(1), np.random.default_rng(0))
    x = gwo.ask(state).copy()
    gwo.tell(state, np.array([2.0, 1.0, 3.0]))
    # wolf 0 is α first; wolf 1 replaces it, and the old α becomes nothing; wolf 2 becomes β
    np.testing.assert_array_equal(state.remembered[0], x[1])
    np.testing.assert_array_equal(state.remembered_values, [1.0, 3.0, np.inf])


def test_gwo_is_not_shift_invariant_and_pso_is():
    def error(make, shift):
        def function(x):
            return np.abs(x[:, 0] - shift)

        runs = [make(bounds=(shift - 50, shift + 50), seed=seed).minimize(function, 1).value for seed in range(20)]
        return np.median(runs)

    assert error(sm.GWO, 100.0) > 20 * error(sm.GWO, 0.0)
    assert error(sm.PSO, 100.0) == pytest.approx(error(sm.PSO, 0.0), rel=0.5, abs=1e-6)


def test_ga_keeps_its_best_row():
    ga = sm.GA(population=10, bounds=(-1, 1))
    state = ga.start(-np.ones(3), np.ones(3), np.random.default_rng(0))
    for _ in range(30):
        x = ga.ask(state).copy()
        values = (x**2).sum(axis=1)
        ga.tell(state, values)
        np.testing.assert_array_equal(state.x[0], x[np.argmin(values)])


@pytest.mark.parametrize(
    "bad",
    [
        {"population": 0},
        {"population": 2.5},
        {"population": True},
        {"iterations": 0},
        {"iterations": 10**9},
        {"bounds": (1, 0)},
        {"bounds": (0, np.nan)},
        {"bounds": (0, 0)},
        {"bounds": "ab"},
        {"bounds": (0, 1, 2)},
        {"seed": -1},
        {"seed": 1.5},
        {"seed": None},
        {"variant": "fast"},
        {"walls": "bounce"},
    ],
)
def test_bad_settings_are_refused_by_field(bad):
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.PSO(**bad)
    assert caught.value.field in bad


def test_wrong_number_of_bounds_and_too_small_a_population():
    with pytest.raises(sm.InvalidInputError):
        sm.PSO(bounds=[(0, 1), (0, 1)]).minimize(lambda x: x[:, 0], 3)
    with pytest.raises(sm.InvalidInputError):
        sm.GA(population=3)


def test_random_search_never_looks_at_the_same_point_twice():
    points = sm.RandomSearch(10, 20, (0, 1), seed=4).minimize(lambda x: x[:, 0], 2).population
    assert len(np.unique(points, axis=0)) == 200
    assert np.abs(points.mean(axis=0) - 0.5).max() < 0.1


def bumpy(x):
    return np.cos(5 * x).sum(axis=1) + 0.1 * ((x - 0.4) ** 2).sum(axis=1)


@pytest.mark.parametrize("dimension", [1, 3])
@pytest.mark.parametrize(("name", "make"), list(variants()), ids=lambda v: v if isinstance(v, str) else "")
def test_only_to_the_grey_wolves_a_shifted_copy_is_another_problem(name, make, dimension):
    budget = {"population": 12, "iterations": 25, "bounds": (0.0, 15.0), "seed": 3}
    plain = make(**budget).minimize(bumpy, dimension)
    shifted = sm.Shifted(make(**budget), 7.5).minimize(bumpy, dimension)
    if name == "gwo":
        assert np.abs(np.subtract(shifted.history.best, plain.history.best)).max() > 1e-4
        assert np.abs(shifted.population - plain.population)[12:].max() > 0.1
    else:
        np.testing.assert_allclose(shifted.history.best, plain.history.best, rtol=0, atol=1e-6)
    assert shifted.evaluations == plain.evaluations
    np.testing.assert_array_equal(shifted.values, bumpy(shifted.population))
    assert shifted.population.min() >= 0.0
    assert shifted.population.max() <= 15.0


def test_a_shifted_optimizer_searches_the_moved_box_and_tells_what_it_is():
    seen = []

    class Spy(sm.RandomSearch):
        def start(self, lower, upper, rng):
            seen.append((lower.tolist(), upper.tolist()))
            return super().start(lower, upper, rng)

    inner = Spy(3, 2, (0, 15), seed=5)
    shifted = sm.Shifted(inner, 7.5).with_bounds([(1, 2), (3, 5)]).with_seed(8)
    plain = sm.RandomSearch(3, 2, [(1, 2), (3, 5)], seed=8)
    assert seen == []
    found = shifted.minimize(bumpy, 2)
    assert seen == [([-6.5, -4.5], [-5.5, -2.5])]
    np.testing.assert_allclose(found.population, plain.minimize(bumpy, 2).population, rtol=1e-15)
    assert shifted.settings() == {"shift": 7.5, "optimizer": {"kind": "random", **plain.settings()}}
    assert not sm.Shifted(sm.PSO()).has_own_bounds
    assert shifted.has_own_bounds


@pytest.mark.parametrize(("bad", "field"), [((1, 2.0), "optimizer"), ((sm.PSO(), float("nan")), "shift")])
def test_bad_shifts_are_refused_by_field(bad, field):
    with pytest.raises(sm.InvalidInputError) as caught:
        sm.Shifted(*bad)
    assert caught.value.field == field
