"""What the rows of a study say of its planners and optimizers: medians, quartiles, and whether they differ."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from selfmotion._types import FloatArray

FOUND = 1e-3
"""Excess over what a run is held against, up to which it has found it."""
FEWEST = 6
"""Problems below which no signed-rank test can say anything at 5 %."""
_UNSOLVED = 1e12  # stands for the excess of a run without a motion: beyond all others


class Method(NamedTuple):
    """A planner with its optimizer, by their names in the study."""

    planner: str
    optimizer: str

    def __str__(self) -> str:
        return f"{self.planner}, {self.optimizer}" if self.optimizer else self.planner


@dataclass(frozen=True)
class Summary:
    """What is said of a method.

    Attributes
    ----------
    runs, failed, solved, found, timed_out : int
        Found: within `FOUND` of the reference.
    quartiles : tuple of float
        Lower quartile, median and upper quartile of the excess over the reference, runs without a motion counted as
        the worst; infinite where one of those is met, NaN without runs.
    seconds : float
        Median time of a run.
    rank : float
        Mean rank among the methods compared, from 1; NaN if it is not compared.
    """

    method: Method
    runs: int
    failed: int
    solved: int
    found: int
    timed_out: int
    quartiles: tuple[float, float, float]
    seconds: float
    rank: float


@dataclass(frozen=True)
class Difference:
    """Two methods compared over all problems.

    Attributes
    ----------
    first, second : Method
    wins, losses, ties : int
        Problems on which the first's median is less, more, the same.
    p, corrected : float
        Of Wilcoxon's signed-rank test, two-sided; and by Holm's correction.
    """

    first: Method
    second: Method
    wins: int
    losses: int
    ties: int
    p: float
    corrected: float


@dataclass(frozen=True)
class Comparison:
    """The statistics of a study.

    Attributes
    ----------
    summaries : list of Summary
    problems, proved : int
        Problems with any motion, and those of them whose optimum is bounded from below.
    friedman : float or None
        p-value that all methods compared are equal.
    differences : list of Difference
    compared : int
        Problems in the rank tests.
    bands : dict
        Method to the excess of the best so far after each iteration, shape (runs, k); NaN while nothing was found.
    """

    summaries: list[Summary]
    problems: int
    proved: int
    friedman: float | None
    differences: list[Difference]
    compared: int
    bands: dict[Method, FloatArray]


def compared(table: Sequence[Mapping[str, Any]]) -> Comparison:
    """Return the statistics of the rows of :func:`study_table`, with histories.

    The reference of a problem is the largest proved lower bound on its optimum, if a planner of the study proves one;
    else the best cost known. The methods that have seeds are compared by their medians over the seeds, problem by
    problem: by Friedman's test, and in pairs by Wilcoxon's signed-rank test with Holm's correction (Demšar 2006).
    """
    rows: dict[Method, dict[str, list[Mapping[str, Any]]]] = {}
    for row in table:
        of_method = rows.setdefault(Method(row["planner"], row["optimizer"]), {})
        of_method.setdefault(row["problem"], []).append(row)
    references, proved = _references(table)
    excess = {
        method: {name: [_excess(row, references) for row in of if row["run"] == "done"] for name, of in by.items()}
        for method, by in rows.items()
    }
    seeded = [method for method, by in rows.items() if any(row["seed"] is not None for of in by.values() for row in of)]
    medians = _medians([excess[method] for method in seeded], references)
    ranks = dict(zip(seeded, _mean_ranks(medians), strict=True))
    summaries = [
        _summary(method, [row for of in by.values() for row in of], excess[method], ranks.get(method, np.nan))
        for method, by in rows.items()
    ]
    enough = len(medians) >= FEWEST and len(seeded) > 1
    return Comparison(
        summaries,
        len(references),
        len(proved),
        _friedman(medians) if enough and len(seeded) > 2 else None,
        _differences(seeded, medians) if enough else [],
        len(medians),
        _bands(rows, references, proved),
    )


def holm(p: Sequence[float]) -> list[float]:
    """Return p-values corrected for being many (Holm 1979)."""
    corrected, largest = [0.0] * len(p), 0.0
    for rank, k in enumerate(np.argsort(p, kind="stable")):
        largest = max(largest, min(1.0, (len(p) - rank) * p[k]))
        corrected[int(k)] = largest
    return corrected


def _references(table: Sequence[Mapping[str, Any]]) -> tuple[dict[str, float], set[str]]:
    """Return what costs are held against, by problem; and the problems for which that is proved."""
    best: dict[str, float] = {}
    bound: dict[str, float] = {}
    for row in table:
        name, cost, proved = row["problem"], row["cost"], row["lower_bound"]
        if row["status"] == "solved" and cost is not None:
            best[name] = min(cost, best.get(name, np.inf))
        if proved is not None and proved > 0.0:
            bound[name] = max(proved, bound.get(name, 0.0))
    proved = bound.keys() & best.keys()
    return {name: bound.get(name, cost) for name, cost in best.items()}, set(proved)


def _excess(row: Mapping[str, Any], references: Mapping[str, float]) -> float:
    reference = references.get(row["problem"])
    if reference is None or row["status"] != "solved" or row["cost"] is None:
        return np.inf
    return _relative(row["cost"], reference)


def _relative(cost: float, reference: float) -> float:
    return max(cost / reference - 1.0, 0.0) if reference > 0.0 else (0.0 if cost <= 0.0 else np.inf)


def _summary(method: Method, rows: list[Mapping[str, Any]], excess: Mapping[str, list[float]], rank: float) -> Summary:
    values = np.array([value for of in excess.values() for value in of])
    done = [row for row in rows if row["run"] == "done"]
    low, middle, high = _quartiles(values)
    return Summary(
        method, len(rows), len(rows) - len(done), sum(row["status"] == "solved" for row in done),
        int(np.sum(values <= FOUND)), sum(bool(row["timed_out"]) for row in done), (low, middle, high),
        float(np.median([row["seconds"] for row in done])) if done else np.nan, rank,
    )  # fmt: skip


def _quartiles(values: FloatArray) -> tuple[float, float, float]:
    if not len(values):
        return np.nan, np.nan, np.nan
    found = np.percentile(np.minimum(values, _UNSOLVED), [25, 50, 75])
    low, middle, high = (float(value) if value < 0.01 * _UNSOLVED else np.inf for value in found)
    return low, middle, high


def _medians(excess: Sequence[Mapping[str, list[float]]], references: Mapping[str, float]) -> FloatArray:
    """Return medians over the seeds, shape (problems, methods), of problems that all have done and one has solved."""
    common = [name for name in references if excess and all(of.get(name) for of in excess)]
    values = [[np.median(np.minimum(of[name], _UNSOLVED)) for of in excess] for name in common]
    return np.array(values, dtype=float).reshape(len(common), len(excess))


def _mean_ranks(medians: FloatArray) -> list[float]:
    from scipy.stats import rankdata

    if not len(medians) or medians.shape[1] < 2:
        return [np.nan] * medians.shape[1]
    return list(rankdata(medians, axis=1).mean(axis=0).tolist())


def _friedman(medians: FloatArray) -> float:
    from scipy.stats import friedmanchisquare

    if (medians == medians[:, :1]).all():
        return 1.0
    return float(friedmanchisquare(*medians.T).pvalue)


def _differences(methods: Sequence[Method], medians: FloatArray) -> list[Difference]:
    from scipy.stats import wilcoxon

    pairs, p = list(itertools.combinations(range(len(methods)), 2)), []
    for i, j in pairs:
        apart = medians[:, i] - medians[:, j]
        apart = apart[apart != 0.0]
        p.append(float(wilcoxon(apart).pvalue) if len(apart) else 1.0)
    found = []
    for (i, j), one, corrected in zip(pairs, p, holm(p), strict=True):
        less, more = int((medians[:, i] < medians[:, j]).sum()), int((medians[:, i] > medians[:, j]).sum())
        found.append(Difference(methods[i], methods[j], less, more, len(medians) - less - more, one, corrected))
    return found


def _bands(
    rows: Mapping[Method, Mapping[str, list[Mapping[str, Any]]]], references: Mapping[str, float], proved: set[str]
) -> dict[Method, FloatArray]:
    """Return how searches went, each relative to its problem's reference."""
    curves: dict[Method, list[tuple[str, FloatArray]]] = {}
    for method, by in rows.items():
        for name, of in by.items():
            for row in of:
                if row.get("history") and name in references:
                    curves.setdefault(method, []).append((name, _curve(row["history"])))
    floors = dict(references)
    for name, curve in (pair for of in curves.values() for pair in of):
        if name not in proved:  # what is ranked may be a chord sum, which is below the cost
            floors[name] = float(np.nanmin([floors[name], curve[-1]]))
    found = {}
    for method, searches in curves.items():
        longest = max(len(curve) for _, curve in searches)
        band = np.full((len(searches), longest), np.nan)
        for k, (name, curve) in enumerate(searches):
            band[k] = np.append(curve, np.full(longest - len(curve), curve[-1])) / max(floors[name], 1e-300) - 1.0
        found[method] = band
    return found


def _curve(history: Sequence[Mapping[str, Any]]) -> FloatArray:
    """Return the best so far over a run's searches, one after the other."""
    best = np.concatenate([np.array(part["best"], dtype=float) for part in history])
    return np.fmin.accumulate(best)
