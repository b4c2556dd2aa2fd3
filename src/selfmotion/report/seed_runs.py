"""The optimizers over many seeds on a case of the paper, and on a copy of it whose variable is shifted.

The shifted copy searches y = f − c, c the middle of the box, for the same F. A method that does not care where the
origin lies does as well on both; one that is drawn to the origin does not. In each case the best f lies near it, in a
box from 0 to 15: at 0.54 for the 3R arm, at 0.59 for the module on the fixed base, at 0 for that on the moving base.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.optimizers import Progress, Shifted
from selfmotion.report import cases, seed_3r, seed_6r
from selfmotion.study import InProcess, Run, Step, Study, run_study

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


def search(specification: dict[str, Any]) -> dict[str, Any]:
    """Do one run: a task of a study, given ``case``, ``copy``, ``label`` and ``seed``."""
    shift = COPIES[specification["copy"]]
    optimizer = Shifted(cases.optimizers(specification["seed"])[specification["label"]], shift)
    result = optimizer.minimize(CASES[specification["case"]].candidates(), 1)
    best = [None if np.isnan(value) else value for value in result.history.best]
    return {"f": float(result.x[0]), "best": best, "evaluations": result.evaluations}


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
    runs = [
        Run(f"{__name__}:search", {"case": case, "copy": copy, "label": label, "seed": seed + k}, case, copy, label, k)
        for copy in COPIES for label in cases.COMPARED for k in range(seeds)
    ]  # fmt: skip
    least = np.inf

    def told(step: Step) -> None:
        nonlocal least
        if step.outcome.failure is not None:
            raise RuntimeError(json.loads(step.outcome.failure)["traceback"])
        last = json.loads(step.outcome.result or "")["best"][-1]
        least = least if last is None else min(least, last)
        if progress is not None:
            progress(step.done, step.total, least)

    # Nothing that a report draws may be of another version's making: its runs are kept in memory only.
    store = run_study(Study("reproduce", tuple(runs)), engine=InProcess(max(1, workers)), progress=told)
    outcomes = {row.id: row.result for row in store.rows() if row.result is not None}
    found: dict[str, dict[str, Runs]] = {copy: {} for copy in COPIES}
    for k in range(0, len(runs), seeds):
        some = [outcomes[run.id] for run in runs[k : k + seeds]]
        best = np.array([outcome["best"] for outcome in some], dtype=float)
        found[runs[k].planner][runs[k].optimizer] = Runs(
            np.array([outcome["f"] for outcome in some]),
            best[:, -1],
            best,
            np.array([outcome["evaluations"] for outcome in some]),
        )
    return found
