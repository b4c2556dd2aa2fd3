"""What the rows of a study say of its planners and optimizers: medians, quartiles, and whether they differ."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from selfmotion._types import FloatArray

FOUND = 1e-3
"""Excess over what a run is held against, up to which it has found it."""
REACHED = 1e-6
"""Excess over the best that any search of the study found, up to which a run has reached it."""
FEWEST = 6
"""Problems below which no signed-rank test can say anything at 5 %."""
_TIE = 8  # decimals of an excess: costs are integrals known to 1e-8, and what differs by less does not differ
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
    runs, failed, solved, found, reached, timed_out : int
        Found: within `FOUND` of the reference. Reached: within `REACHED` of the best search.
    quartiles, behind : tuple of float
        Lower quartile, median and upper quartile of the excess over the reference, and over the best search. A search
        is asked about problems only that some search has solved, and a run of it without a motion counts as the worst;
        infinite where one of those is met, NaN without runs.
    seconds : float
        Median time of a run.
    rank : float
        Mean rank among the methods of its group, from 1; NaN if it is not compared.
    """

    method: Method
    runs: int
    failed: int
    solved: int
    found: int
    reached: int
    timed_out: int
    quartiles: tuple[float, float, float]
    behind: tuple[float, float, float]
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
class Group:
    """Methods that are compared with each other: the optimizers of a planner.

    Attributes
    ----------
    name : str
        The planner's; empty for planners with one optimizer each.
    methods : list of Method
    problems : int
        Problems in the rank tests.
    friedman : float or None
        p-value that all methods are equal.
    differences : list of Difference
    """

    name: str
    methods: list[Method]
    problems: int
    friedman: float | None
    differences: list[Difference]


@dataclass(frozen=True)
class Case:
    """What is known of a problem.

    Attributes
    ----------
    name : str
    lower_bound : float or None
        The largest that was proved.
    best, searched : float
        The least cost of all runs, and of all searches; infinite if none solved it.
    at : dict
        The numbers among the parameters of the best search, such as the frequency of a sinusoid.
    behind : dict
        Method to the median over its seeds of the excess over `searched`, infinite if less than half of them solved it;
        methods that are no searches, or have not done the problem, are left out.
    """

    name: str
    lower_bound: float | None
    best: float
    searched: float
    at: dict[str, float]
    behind: dict[Method, float]


@dataclass(frozen=True)
class Comparison:
    """The statistics of a study.

    Attributes
    ----------
    summaries : list of Summary
    problems, proved, searched : int
        Problems with any motion; those of them whose optimum is bounded from below; those that a search solved.
    groups : list of Group
    across : list of Difference
        Of methods with the same optimizer and different planners.
    cases : list of Case
        Problem by problem.
    bands : dict
        Method to the excess of the best so far after each iteration over the best search, shape (runs, k); NaN while
        nothing was found.
    """

    summaries: list[Summary]
    problems: int
    proved: int
    searched: int
    groups: list[Group]
    across: list[Difference]
    cases: list[Case]
    bands: dict[Method, FloatArray]


def compared(table: Sequence[Mapping[str, Any]]) -> Comparison:
    """Return the statistics of the rows of :func:`study_table`, with histories.

    The reference of a problem is the largest proved lower bound on its optimum, if a planner of the study proves one;
    else the best cost known. Searches are the methods that have seeds; they are held against the best that any of them
    found too. Those of a planner are compared by their medians over the seeds, problem by problem: by Friedman's test,
    and in pairs by Wilcoxon's signed-rank test with Holm's correction (Demšar 2006); so are planners with the same
    optimizer. Problems that none of them solved are left out there.
    """
    rows: dict[Method, dict[str, list[Mapping[str, Any]]]] = {}
    for row in table:
        of_method = rows.setdefault(Method(row["planner"], row["optimizer"]), {})
        of_method.setdefault(row["problem"], []).append(row)
    searches = [
        method for method, by in rows.items() if any(row["seed"] is not None for of in by.values() for row in of)
    ]
    bounds = _bounds(table)
    best = _least(table)
    of_searches = [row for method in searches for of in rows[method].values() for row in of]
    searched = _least(of_searches)
    references = {name: bounds.get(name, cost) for name, cost in best.items()}
    excess = {method: _excesses(by, references) for method, by in rows.items()}
    behind = {method: _excesses(rows[method], searched) for method in searches}
    medians = {method: _medians(behind[method], searched) for method in searches}
    groups: list[Group] = []
    ranks: dict[Method, float] = {}
    for name, methods in _grouped(searches).items():
        common = _common(medians, methods)
        ranks.update(zip(methods, _mean_ranks(common), strict=True))
        groups.append(_group(name, methods, common))
    summaries = []
    for method, by in rows.items():
        asked = searched if method in searches else references
        summaries.append(_summary(method, by, asked, excess[method], behind.get(method, {}), ranks.get(method, np.nan)))
    places = _places(of_searches, searched)
    cases = [
        Case(
            name, bounds.get(name), best.get(name, np.inf), searched.get(name, np.inf), places.get(name, {}),
            {method: medians[method][name] for method in searches if name in medians[method]},
        )
        for name in dict.fromkeys(row["problem"] for row in table)
    ]  # fmt: skip
    return Comparison(
        summaries, len(references), len(bounds.keys() & best.keys()), len(searched), groups,
        _across(searches, medians), cases, _bands(rows, searched),
    )  # fmt: skip


def holm(p: Sequence[float]) -> list[float]:
    """Return p-values corrected for being many (Holm 1979)."""
    corrected, largest = [0.0] * len(p), 0.0
    for rank, k in enumerate(np.argsort(p, kind="stable")):
        largest = max(largest, min(1.0, (len(p) - rank) * p[k]))
        corrected[int(k)] = largest
    return corrected


def _least(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the least cost of each problem that was solved."""
    least: dict[str, float] = {}
    for row in rows:
        if row["status"] == "solved" and row["cost"] is not None:
            least[row["problem"]] = min(row["cost"], least.get(row["problem"], np.inf))
    return least


def _places(rows: Sequence[Mapping[str, Any]], least: Mapping[str, float]) -> dict[str, dict[str, float]]:
    """Return the numbers among the parameters of the first run of each problem that has its least cost."""
    places: dict[str, dict[str, float]] = {}
    for row in rows:
        if row["problem"] not in places and row["cost"] is not None and row["cost"] == least.get(row["problem"]):
            known = row.get("parameters") or {}
            places[row["problem"]] = {name: value for name, value in known.items() if isinstance(value, float)}
    return places


def _bounds(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the largest lower bound of each problem that has one."""
    bounds: dict[str, float] = {}
    for row in rows:
        proved = row["lower_bound"]
        if proved is not None and proved > 0.0:
            bounds[row["problem"]] = max(proved, bounds.get(row["problem"], 0.0))
    return bounds


def _excesses(by: Mapping[str, Sequence[Mapping[str, Any]]], references: Mapping[str, float]) -> dict[str, list[float]]:
    """Return the excess of every run over its problem's reference, by problem."""
    return {name: [_excess(row, references) for row in of if row["run"] == "done"] for name, of in by.items()}


def _excess(row: Mapping[str, Any], references: Mapping[str, float]) -> float:
    reference = references.get(row["problem"])
    if reference is None or row["status"] != "solved" or row["cost"] is None:
        return np.inf
    return _relative(row["cost"], reference)


def _relative(cost: float, reference: float) -> float:
    return max(cost / reference - 1.0, 0.0) if reference > 0.0 else (0.0 if cost <= 0.0 else np.inf)


def _summary(
    method: Method,
    by: Mapping[str, Sequence[Mapping[str, Any]]],
    asked: Mapping[str, float],
    excess: Mapping[str, list[float]],
    behind: Mapping[str, list[float]],
    rank: float,
) -> Summary:
    rows = [row for of in by.values() for row in of]
    done = [row for row in rows if row["run"] == "done"]
    values, late = (
        np.array([v for name, some in of.items() if name in asked for v in some]) for of in (excess, behind)
    )
    return Summary(
        method, len(rows), len(rows) - len(done), sum(row["status"] == "solved" for row in done),
        int(np.sum(values <= FOUND)), int(np.sum(late <= REACHED)), sum(bool(row["timed_out"]) for row in done),
        _quartiles(values), _quartiles(late), float(np.median([row["seconds"] for row in done] or [np.nan])), rank,
    )  # fmt: skip


def _quartiles(values: FloatArray) -> tuple[float, float, float]:
    if not len(values):
        return np.nan, np.nan, np.nan
    low, middle, high = (_told(value) for value in np.percentile(np.minimum(values, _UNSOLVED), [25, 50, 75]))
    return low, middle, high


def _told(value: float) -> float:
    """Return a percentile as a number, infinite if runs without a motion are part of it."""
    return float(value) if value < 0.01 * _UNSOLVED else np.inf


def _medians(behind: Mapping[str, list[float]], searched: Mapping[str, float]) -> dict[str, float]:
    """Return medians over the seeds of problems that a search has solved."""
    return {
        name: _told(float(np.median(np.minimum(values, _UNSOLVED))))
        for name, values in behind.items()
        if values and name in searched
    }


def _grouped(searches: Sequence[Method]) -> dict[str, list[Method]]:
    """Return the methods of each planner with several optimizers; the others together, if there are several."""
    planners = [method.planner for method in searches]
    groups: dict[str, list[Method]] = {}
    for method in searches:
        groups.setdefault(method.planner if planners.count(method.planner) > 1 else "", []).append(method)
    return {name: methods for name, methods in groups.items() if len(methods) > 1}


def _common(medians: Mapping[Method, Mapping[str, float]], methods: Sequence[Method]) -> FloatArray:
    """Return medians over the seeds, shape (problems, methods), of problems that all have done and one has solved.

    They are rounded, so that what differs by rounding is a tie.
    """
    first, *others = (medians[method] for method in methods)
    names = [name for name in first if all(name in other for other in others)]
    values = np.array([[medians[method][name] for method in methods] for name in names], dtype=float)
    values = values.reshape(len(names), len(methods))
    return np.minimum(np.round(values[np.isfinite(values).any(axis=1)], _TIE), _UNSOLVED)


def _group(name: str, methods: list[Method], medians: FloatArray) -> Group:
    enough = len(medians) >= FEWEST
    friedman = _friedman(medians) if enough and len(methods) > 2 else None
    pairs = list(itertools.combinations(range(len(methods)), 2)) if enough else []
    differences = _corrected([_difference(methods[i], methods[j], medians[:, [i, j]]) for i, j in pairs])
    return Group(name, methods, len(medians), friedman, differences)


def _mean_ranks(medians: FloatArray) -> list[float]:
    from scipy.stats import rankdata

    if not len(medians):
        return [np.nan] * medians.shape[1]
    return list(rankdata(medians, axis=1).mean(axis=0).tolist())


def _friedman(medians: FloatArray) -> float:
    from scipy.stats import friedmanchisquare

    if (medians == medians[:, :1]).all():
        return 1.0
    return float(friedmanchisquare(*medians.T).pvalue)


def _across(searches: Sequence[Method], medians: Mapping[Method, Mapping[str, float]]) -> list[Difference]:
    """Return how planners with the same optimizer differ."""
    pairs = [pair for pair in itertools.combinations(searches, 2) if pair[0].optimizer == pair[1].optimizer != ""]
    common = [(pair, _common(medians, pair)) for pair in pairs]
    return _corrected([_difference(*pair, values) for pair, values in common if len(values) >= FEWEST])


def _difference(first: Method, second: Method, medians: FloatArray) -> Difference:
    """Return how two methods differ, their medians in columns; not yet corrected for being one of many pairs."""
    from scipy.stats import wilcoxon

    apart = medians[:, 0] - medians[:, 1]
    differing = apart[apart != 0.0]
    p = float(wilcoxon(differing).pvalue) if len(differing) else 1.0
    less, more = int((apart < 0.0).sum()), int((apart > 0.0).sum())
    return Difference(first, second, less, more, len(apart) - less - more, p, p)


def _corrected(differences: Sequence[Difference]) -> list[Difference]:
    corrected = holm([one.p for one in differences])
    return [replace(one, corrected=p) for one, p in zip(differences, corrected, strict=True)]


def _bands(
    rows: Mapping[Method, Mapping[str, list[Mapping[str, Any]]]], searched: Mapping[str, float]
) -> dict[Method, FloatArray]:
    """Return how searches went, each relative to the best one of its problem."""
    curves: dict[Method, list[tuple[str, FloatArray]]] = {}
    for method, by in rows.items():
        for name, of in by.items():
            for row in of:
                if row.get("history") and name in searched:
                    curves.setdefault(method, []).append((name, _curve(row["history"])))
    floors = dict(searched)
    for name, curve in (pair for of in curves.values() for pair in of):
        floors[name] = float(np.nanmin([floors[name], curve[-1]]))  # what is ranked may be a chord sum, below the cost
    found = {}
    for method, searches in curves.items():
        longest = max(len(curve) for _, curve in searches)
        band = np.full((len(searches), longest), np.nan)
        for k, (name, curve) in enumerate(searches):
            band[k] = np.append(curve, np.full(longest - len(curve), curve[-1])) / max(floors[name], 1e-300) - 1.0
        found[method] = band
    return found


def _curve(history: Sequence[Mapping[str, Any]]) -> FloatArray:
    """Return the best so far of a run's searches, one per branch, after each has made so many iterations."""
    longest = max(len(part["best"]) for part in history)
    best = np.full((len(history), longest), np.nan)
    for row, part in zip(best, history, strict=True):
        row[: len(part["best"])] = part["best"]
    return np.fmin.accumulate(np.fmin.reduce(best))
