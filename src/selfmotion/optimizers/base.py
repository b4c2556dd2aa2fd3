"""The one loop that every optimizer runs in, and what an optimizer is.

An optimizer minimises a function on a box and knows nothing of robots. Native ones are ask/tell: `start` makes a state,
`ask` the next population, `tell` takes its values. Counting, best so far, history and NaN live here, once.
"""

from __future__ import annotations

import copy
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np

from selfmotion._checks import finite_array, integer
from selfmotion._types import BoolArray, Box, FloatArray
from selfmotion.errors import InvalidInputError

BatchFunction = Callable[[FloatArray], FloatArray]
Progress = Callable[[int, int, float], None]

DEFAULT_BOUNDS = (0.0, 15.0)
"""The box of an optimizer that is given none: the frequencies of the seed's study."""
INFEASIBLE = 1e100
"""Values from here on mean "infeasible by value / INFEASIBLE − 1": ordered by violation, above every cost."""
MOST_EVALUATIONS = 20_000_000
"""Largest budget of one run; all candidates are kept."""
_WORST = 1e30  # as a violation; squares of values must not overflow in other people's optimizers


def penalised(cost: FloatArray, violation: FloatArray) -> FloatArray:
    """Return values, shape (p,), that rank feasible candidates by `cost`, below infeasible ones by `violation`."""
    worst = np.minimum(np.nan_to_num(violation, nan=_WORST), _WORST)
    return np.where(worst > 0, INFEASIBLE * (1.0 + worst), cost)


def violation_of(value: float) -> float:
    """Return the violation that :func:`penalised` ranked by, zero for a feasible candidate's value."""
    return max(value / INFEASIBLE - 1.0, 0.0)


def counting(progress: Progress | None, before: int, total: int) -> Progress | None:
    """Return `progress` counting on from `before` towards `total`, for one of several runs in a row."""
    if progress is None:
        return None
    return lambda done, _, best: progress(before + done, total, best)


@dataclass
class History:
    """What happened, generation by generation.

    Attributes
    ----------
    best : list of float
        Best cost so far; NaN while nothing feasible was met.
    mean : list of float
        Mean value of the generation's feasible candidates; NaN without any. Where values of candidates that did not
        matter are lower bounds (`Judged`), so is this.
    feasible : list of int
        Number of feasible candidates in the generation.
    evaluations : list of int
        Evaluations so far.
    time_s : list of float
        Wall time so far [s].
    """

    best: list[float] = field(default_factory=list)
    mean: list[float] = field(default_factory=list)
    feasible: list[int] = field(default_factory=list)
    evaluations: list[int] = field(default_factory=list)
    time_s: list[float] = field(default_factory=list)


class Judged(NamedTuple):
    """Candidates with their values.

    Attributes
    ----------
    population : array, shape (..., p, d)
    values : array, shape (..., p)
    exact : array of bool, shape (..., p)
        Whether a value is that of the function. If not, it is a lower bound on it, above what could have changed the
        search.
    """

    population: FloatArray
    values: FloatArray
    exact: BoolArray


@dataclass(frozen=True)
class Result:
    """Outcome of a minimisation.

    Attributes
    ----------
    x : array, shape (d,)
        Best candidate met.
    value : float
        Its value; from `INFEASIBLE` on nothing feasible was met.
    history : History
    judged : Judged
        Every candidate that was judged, in order.
    """

    x: FloatArray
    value: float
    history: History
    judged: Judged

    @property
    def population(self) -> FloatArray:
        """Every candidate, shape (evaluations, d)."""
        return self.judged.population

    @property
    def values(self) -> FloatArray:
        """Their values, shape (evaluations,); see `Judged`."""
        return self.judged.values

    @property
    def evaluations(self) -> int:
        """Number of candidates judged."""
        return len(self.values)


class Recorder:
    """The objective as optimizers see it: evaluates whole generations and keeps the books.

    Attributes
    ----------
    function : callable
        What is minimised.
    is_watched : bool
        Whether somebody wants to hear of progress.
    """

    def __init__(self, function: BatchFunction, generations: int, progress: Progress | None = None) -> None:
        self.function = function
        self.is_watched = progress is not None
        self._generations = generations
        self._progress = progress
        self._began = self._told = time.perf_counter()
        self.history = History()
        self._judged: list[Judged] = []
        self._best_x: FloatArray | None = None
        self._best_value = np.inf

    def __call__(self, population: FloatArray) -> FloatArray:
        """Evaluate a population, shape (p, d); NaN counts as the worst possible value."""
        candidates = np.array(population, dtype=float)
        values = np.asarray(self.function(candidates), dtype=float)
        values = np.where(np.isnan(values), INFEASIBLE * _WORST, values)
        self.book(Judged(candidates[None], values[None], np.ones((1, len(values)), dtype=bool)))
        return values

    def book(self, judged: Judged) -> None:
        """Take down generations that were judged, shapes (g, p, …); their time is shared among them evenly."""
        population, values, _ = judged
        least = np.unravel_index(int(np.argmin(values)), values.shape)
        before = self._best_value
        if self._best_x is None or values[least] < before:
            self._best_x, self._best_value = population[least], float(values[least])
        best = np.minimum(np.minimum.accumulate(values.min(axis=1)), before)
        feasible = values < INFEASIBLE
        counts = feasible.sum(axis=1)
        with np.errstate(invalid="ignore"):
            means = np.where(feasible, values, 0.0).sum(axis=1) / counts
        now, history = time.perf_counter(), self.history
        told = self._told - self._began + (now - self._told) * np.arange(1, len(values) + 1) / len(values)
        done = history.evaluations[-1] if history.evaluations else 0
        history.best += np.where(best < INFEASIBLE, best, np.nan).tolist()
        history.mean += means.tolist()
        history.feasible += counts.tolist()
        history.evaluations += (done + values.shape[1] * np.arange(1, len(values) + 1)).tolist()
        history.time_s += told.tolist()
        self._told = now
        self._judged.append(judged)
        if self._progress is not None:
            self._progress(len(history.best), self._generations, history.best[-1])

    def result(self) -> Result:
        """Return the outcome so far."""
        assert self._best_x is not None
        flat = [Judged(x.reshape(-1, x.shape[-1]), values.ravel(), exact.ravel()) for x, values, exact in self._judged]
        population, values, exact = (np.concatenate(part) for part in zip(*flat, strict=True))
        return Result(self._best_x, self._best_value, self.history, Judged(population, values, exact))


class Optimizer(ABC):
    """A minimiser on a box with a fixed budget of ``population × iterations`` evaluations.

    Parameters
    ----------
    population : int
        Candidates per generation.
    iterations : int
        Generations; each is one batch evaluation.
    bounds : array_like, shape (2,) or (d, 2)
        ``(lower, upper)`` for every variable, or one pair per variable.
    seed : int
        Seed of the random numbers; the same seed gives the same bits on the same machine.

    Raises
    ------
    InvalidInputError
        If a parameter is out of its range.
    """

    kind: ClassVar[str]
    smallest_population: ClassVar[int] = 1

    def __init__(
        self, population: int = 20, iterations: int = 100, bounds: Box = DEFAULT_BOUNDS, seed: int = 0
    ) -> None:
        self.population = integer("population", population, self.smallest_population, 100_000)
        self.iterations = integer("iterations", iterations, 1, 1_000_000)
        if self.population * self.iterations > MOST_EVALUATIONS:
            raise InvalidInputError(
                "iterations",
                f"times population exceeds {MOST_EVALUATIONS}",
                "lower one of them",
                iterations,
            )
        self.bounds = _bounds(bounds)
        self.seed = _seed(seed)

    def __repr__(self) -> str:
        inner = ", ".join(f"{name}={value!r}" for name, value in self.settings().items())
        return f"{type(self).__name__}({inner})"

    @property
    def has_own_bounds(self) -> bool:
        """Whether the box is another than the default one."""
        return not np.array_equal(self.bounds, DEFAULT_BOUNDS)

    def settings(self) -> dict[str, Any]:
        """Return what a reader must know to repeat the run."""
        return {
            "population": self.population,
            "iterations": self.iterations,
            "bounds": self.bounds.tolist(),
            "seed": self.seed,
        }

    def with_seed(self, seed: int) -> Self:
        """Return the same optimizer with another seed."""
        other = copy.copy(self)
        other.seed = _seed(seed)
        return other

    def with_bounds(self, bounds: Box) -> Self:
        """Return the same optimizer on another box."""
        other = copy.copy(self)
        other.bounds = _bounds(bounds)
        return other

    def box(self, dimension: int) -> tuple[FloatArray, FloatArray]:
        """Return lower and upper bounds, shape (d,) each."""
        if self.bounds.ndim == 2 and len(self.bounds) != dimension:
            raise InvalidInputError(
                "bounds", f"has {len(self.bounds)} pairs", f"give one pair, or {dimension}", self.bounds.tolist()
            )
        box = np.broadcast_to(self.bounds, (dimension, 2))
        return box[:, 0].copy(), box[:, 1].copy()

    def minimize(self, function: BatchFunction, dimension: int, progress: Progress | None = None) -> Result:
        """Minimise a function of `dimension` variables.

        Parameters
        ----------
        function : callable
            Maps a population, shape (p, d), to values, shape (p,).
        dimension : int
        progress : callable, optional
            Called after each generation with (done, total, best cost so far).

        Returns
        -------
        Result
        """
        recorder = Recorder(function, self.iterations, progress)
        lower, upper = self.box(dimension)
        self._drive(recorder, lower, upper, np.random.default_rng(self.seed))
        return recorder.result()

    @abstractmethod
    def _drive(self, evaluate: Recorder, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> None:
        """Spend the budget."""


def _bounds(bounds: Any) -> FloatArray:
    rows = bounds if isinstance(bounds, list | tuple | np.ndarray) else ()
    one_pair = not any(isinstance(row, list | tuple | np.ndarray) for row in rows)
    result = finite_array("bounds", bounds, 1 if one_pair else 2, 2)
    if not (result[..., 0] < result[..., 1]).all():
        raise InvalidInputError("bounds", "has lower not below upper", "write [lower, upper]", bounds)
    return result


def _seed(seed: Any) -> int:
    return integer("seed", seed, 0, 2**63 - 1)


@dataclass
class State:
    """What an ask/tell optimizer knows between generations.

    Attributes
    ----------
    lower, upper : array, shape (d,)
        The box.
    rng : numpy.random.Generator
    x : array, shape (population, d)
        The population to evaluate next.
    """

    lower: FloatArray
    upper: FloatArray
    rng: np.random.Generator
    x: FloatArray


EVALUATE = "evaluate F of the whole population; keep the best so far"
"""What the loop does between `ask` and `tell`, as one of the `steps` of an ask/tell optimizer."""


class AskTell(Optimizer):
    """An optimizer with explicit state.

    Parameters
    ----------
    population, iterations, bounds, seed
        See :class:`Optimizer`.

    Attributes
    ----------
    steps : tuple of str
        What `start`, `ask`, the evaluation and `tell` do, in the order and with the symbols of the code, one box of a
        flow chart each, with line breaks where they read well. The first runs once, the others in every generation.
    """

    steps: ClassVar[tuple[str, ...]]

    def start(self, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> Any:
        """Return the state before the first generation: a population uniform in the box."""
        return State(lower, upper, rng, uniform(rng, lower, upper, self.population))

    def ask(self, state: Any) -> FloatArray:
        """Return the population to evaluate next, shape (population, d), inside the box."""
        return np.asarray(state.x)

    @abstractmethod
    def tell(self, state: Any, values: FloatArray) -> None:
        """Take the values of the population last asked for and move on, changing `state`."""

    def _drive(self, evaluate: Recorder, lower: FloatArray, upper: FloatArray, rng: np.random.Generator) -> None:
        state = self.start(lower, upper, rng)
        for _ in range(self.iterations):
            self.tell(state, evaluate(self.ask(state)))


def uniform(rng: np.random.Generator, lower: FloatArray, upper: FloatArray, rows: int) -> FloatArray:
    """Return `rows` points uniform in the box, shape (rows, d)."""
    return lower + (upper - lower) * rng.random((rows, len(lower)))
