"""The optimizers over many seeds on a case of the paper, and on a copy of it whose variable is shifted.

The shifted copy searches y = f − c, c the middle of the box, for the same F. A method that does not care where the
origin lies does as well on both; one that is drawn to the origin does not. In each case the best f lies near it, in a
box from 0 to 15: at 0.54 for the 3R arm, at 0.59 for the module on the fixed base, at 0 for that on the moving base.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers import Progress
from selfmotion.report import cases, seed_3r, seed_6r

CASES = {case.name: case for case in (seed_3r.CASE, seed_6r.FIXED, seed_6r.MOVING)}
"""The cases on which the optimizers are compared, by name."""
SHIFT = 0.5 * (cases.BOUNDS[0] + cases.BOUNDS[1])
COPIES = {"plain": 0.0, "shifted": SHIFT}
"""The copies of the problem: name to what is subtracted from f."""
TOLERANCE = 1e-6
"""A run whose F exceeds the dense-scan optimum by at most this has found it."""


@dataclass(frozen=True)
class Runs:
    """The runs of one optimizer on one copy.

    Attributes
    ----------
    f, fitness : array, shape (s,)
        Frequency found with each seed, and F there.
    best : array, shape (s, k)
        Least F so far after each of k iterations, NaN before anything feasible was found.
    evaluations : array, shape (s,)
        Candidates judged.
    """

    f: FloatArray
    fitness: FloatArray
    best: FloatArray
    evaluations: FloatArray


class _Task(NamedTuple):
    case: str
    copy: str
    label: str
    seed: int


class _Outcome(NamedTuple):
    f: float
    best: FloatArray
    evaluations: int


def _one(task: _Task) -> _Outcome:
    shift = COPIES[task.copy]
    low, high = cases.BOUNDS
    optimizer = cases.optimizers(task.seed, (low - shift, high - shift))[task.label]
    result = optimizer.minimize(CASES[task.case].candidates(shift), 1)
    return _Outcome(float(result.x[0]) + shift, np.array(result.history.best), result.evaluations)


def many_seeds(
    case: str, seed: int, seeds: int, workers: int = 1, progress: Progress | None = None
) -> dict[str, dict[str, Runs]]:
    """Run every optimizer on both copies of a case with `seeds` seeds from `seed` on.

    Parameters
    ----------
    case : str
        One of `CASES`.
    seed, seeds : int
    workers : int
        Threads that share the runs: a swarm's whole run is compiled and does not ask for the interpreter's lock. The
        outcome is the same to the last bit whatever their number.
    progress : callable, optional
        Called after each run with (done, total, least F so far).

    Returns
    -------
    dict
        Copy to label to `Runs`.
    """
    tasks = [_Task(case, copy, label, seed + k) for copy in COPIES for label in cases.COMPARED for k in range(seeds)]
    outcomes: list[_Outcome] = []
    least = np.inf
    with ThreadPoolExecutor(max(1, workers)) as pool:
        for outcome in pool.map(_one, tasks):
            outcomes.append(outcome)
            least = min(least, float(outcome.best[-1]))
            if progress is not None:
                progress(len(outcomes), len(tasks), least)
    found: dict[str, dict[str, Runs]] = {copy: {} for copy in COPIES}
    for k in range(0, len(tasks), seeds):
        some = outcomes[k : k + seeds]
        best = np.array([outcome.best for outcome in some])
        found[tasks[k].copy][tasks[k].label] = Runs(
            np.array([outcome.f for outcome in some]),
            best[:, -1],
            best,
            np.array([outcome.evaluations for outcome in some]),
        )
    return found
