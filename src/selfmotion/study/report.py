"""The report of a study: tables in Markdown and CSV, figures, and the rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from selfmotion._types import FloatArray
from selfmotion._version import __version__
from selfmotion.plot import draw_evolution, draw_spread, figure, image_files
from selfmotion.plot.evolution import FLOOR
from selfmotion.study.runs import Study
from selfmotion.study.statistics import FEWEST, FOUND, REACHED, Comparison, Difference, Group, Method, compared
from selfmotion.study.store import Store
from selfmotion.study.tables import csv_bytes, lines_as_csv, study_status, study_table

FILES = (
    "report.md", "methods.csv", "problems.csv", "runs.csv", "convergence.png", "convergence.svg", "spread.png",
    "spread.svg",
)  # fmt: skip
"""Names of all files that a report may have."""


def report_files(study: Study, store: Store) -> dict[str, bytes]:
    """Return the report of what is done of a study, as file name to bytes.

    Raises
    ------
    InvalidInputError
        If the store is none, or damaged.
    """
    table = study_table(study, store, histories=True)
    found = compared(table)
    files = {"methods.csv": _methods_csv(found), "problems.csv": _problems_csv(found), "runs.csv": csv_bytes(table)}
    if found.bands:
        files |= _convergence(found)
    if found.groups:
        files |= _spread(found)
    return {"report.md": _text(study, store, found, files).encode(), **files}


def _convergence(found: Comparison) -> dict[str, bytes]:
    """Draw the searches of each planner in axes of their own, all to the same scale."""
    planners = list(dict.fromkeys(method.planner for method in found.bands))
    drawn = found.bands
    if _many(found):
        drawn = {method: _median(band) for method, band in found.bands.items()}
    with figure(width=3.2 * len(planners) + 1.6, height=3.2, columns=len(planners)) as (canvas, every):
        for axes, planner in zip(every, planners, strict=True):
            own = {method: band for method, band in drawn.items() if method.planner == planner}
            draw_evolution(axes, {_label(method): band for method, band in own.items()}, 0.0)
            axes.set_title(planner if len(planners) > 1 else "")
            axes.set_ylabel("")
            axes.sharey(every[0])
        every[0].set_ylabel("excess over the best search")
        every[-1].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
        return image_files("convergence", canvas)


def _many(found: Comparison) -> bool:
    """Return whether the bands of a planner's optimizers would hide each other."""
    planners = [method.planner for method in found.bands]
    return max(map(planners.count, planners)) > _MOST_BANDS


def _median(band: FloatArray) -> FloatArray:
    """Return the median after each iteration, NaN while half of the runs have found nothing."""
    middle = np.median(np.where(np.isnan(band), np.inf, band), axis=0)
    return np.where(np.isinf(middle), np.nan, middle)


def _spread(found: Comparison) -> dict[str, bytes]:
    """Draw where each search ends, problem by problem; planners with the same optimizers below each other."""
    first = found.groups[0]
    ends = {group.name: dict(_ends(found, group)) for group in found.groups if _labels(group) == _labels(first)}
    known = [name for name in _labels(first) if all(values[name] for values in ends.values())]
    if not known:
        return {}
    with figure(width=5.5, height=0.6 + (0.14 + 0.2 * len(ends)) * len(known)) as (canvas, (axes,)):
        draw_spread(axes, {group: {name: values[name] for name in known} for group, values in ends.items()})
        axes.set_xlabel("excess over the best search, median of the seeds")
        if len(ends) == 1:
            axes.get_legend().set_visible(False)  # type: ignore[union-attr]
        return image_files("spread", canvas)


def _labels(group: Group) -> list[str]:
    return [_label(method) for method in group.methods]


def _label(method: Method) -> str:
    return method.optimizer or method.planner


def _ends(found: Comparison, group: Group) -> Iterator[tuple[str, list[float]]]:
    """Yield each method with its medians, those of problems that it does not solve at the end of the axis."""
    for method in group.methods:
        values = [case.behind[method] for case in found.cases if method in case.behind]
        yield _label(method), [min(value, _FAR) for value in values]


_MOST_BANDS = 4
_FAR = 10.0  # where an excess is drawn that is infinite


def _reference(found: Comparison) -> str:
    if not found.proved:
        return "best known"
    return "lower bound" if found.proved == found.problems else "lower bound or best known"


def _text(study: Study, store: Store, found: Comparison, files: dict[str, bytes]) -> str:
    status = study_status(study, store)
    unsearched = found.problems - found.searched
    searched = f" No search solved {unsearched} of them; of searches the table leaves those out." if unsearched else ""
    lines = [
        f"# Study {study.name}",
        "",
        f"{status['done']} of {status['runs']} runs are done, {status['failed']} failed, {status['left']} are left. "
        f"{found.problems} problems have a motion; of {found.proved} of them the optimum is bounded from below."
        f"{searched}",
        "",
        "## Methods",
        "",
        f"The excess is that of the cost, relative, over the {_reference(found)} of its problem, and over the best "
        "that any search found, of all methods and seeds: lower quartile, median and upper quartile of all runs, one "
        f"without a motion counted as the worst. Found: at most {FOUND:g} over the {_reference(found)}. Reached: at "
        f"most {REACHED:g} over the best search.",
        "",
        *_table(
            (
                "method", "runs", "failed", "solved", "found", "lower quartile", "median", "upper quartile", "reached",
                "over the best search", "median", "upper quartile", "seconds",
            ),
            [
                (
                    str(one.method), str(one.runs), str(one.failed), str(one.solved), str(one.found),
                    *(_number(value) for value in one.quartiles), str(one.reached),
                    *(_number(value) for value in one.behind), _number(one.seconds),
                )
                for one in found.summaries
            ],
        ),
        "",
        *_tests(found),
    ]  # fmt: skip
    hit = sum(one.timed_out for one in found.summaries)
    if hit:
        lines += [f"{hit} runs were ended by a time limit: another machine may find something else.", ""]
    if "spread.png" in files:
        lines += [
            "## Problem by problem",
            "",
            "Dots: the median over the seeds of each problem. Mark: the median of these; bar: quartiles.",
            "",
            "![Spread](spread.png)",
            "",
        ]
    if "convergence.png" in files:
        lines += [
            "## Convergence",
            "",
            f"{'Median' if _many(found) else 'Median and quartiles'} of the best so far, over all problems and seeds.",
            "",
            "![Convergence](convergence.png)",
            "",
        ]
    if status["others"]:
        lines += [f"The store has {status['others']} more runs, of earlier versions of the study.", ""]
    tail = "every run is a line of `runs.csv`, every problem of `problems.csv`, every method of `methods.csv`."
    return "\n".join([*lines, f"selfmotion {__version__}; {tail}", ""])


def _tests(found: Comparison) -> list[str]:
    if not found.groups:
        return []
    ranks = {one.method: one.rank for one in found.summaries}
    lines = ["## Do they differ?", ""]
    for group in found.groups:
        if len(found.groups) > 1:
            lines += [f"### {group.name or 'the others'}", ""]
        lines += [
            f"Medians over the seeds, problem by problem: {group.problems} problems that every method has done and one "
            "has solved. What differs by less than 1e-8 does not differ.",
            "",
        ]
        if group.problems:
            lines += [
                *_table(("method", "mean rank"), [(_name(one, group), f"{ranks[one]:.2f}") for one in group.methods]),
                "",
            ]
        if group.problems < FEWEST:
            lines += [f"Tests need {FEWEST} problems at least: with fewer none can tell methods apart.", ""]
            continue
        if group.friedman is not None:
            lines += [f"Friedman's test, that all are equal: p = {group.friedman:.3g}.", ""]
        lines += _pairs(group.differences, lambda method, group=group: _name(method, group))  # type: ignore[misc]
    if found.across:
        lines += ["### The same optimizer with other planners", "", *_pairs(found.across, str)]
    return lines


def _name(method: Method, group: Group) -> str:
    """Return what a method is called among those of its group."""
    return _label(method) if group.name else str(method)


def _pairs(differences: Sequence[Difference], name: Callable[[Method], str]) -> list[str]:
    return [
        "In pairs, by Wilcoxon's signed-rank test, corrected by Holm's method:",
        "",
        *_table(
            ("better on", "than", "on the others", "ties", "p", "p corrected"),
            [
                (
                    f"{name(one.first)}: {one.wins}", name(one.second), str(one.losses), str(one.ties), f"{one.p:.3g}",
                    f"{one.corrected:.3g}",
                )
                for one in differences
            ],
        ),
        "",
    ]  # fmt: skip


def _methods_csv(found: Comparison) -> bytes:
    """Return the summaries as CSV, numbers in full."""
    quartiles = ("lower_quartile", "median", "upper_quartile")
    header = (
        "planner", "optimizer", "runs", "failed", "solved", "found", "reached", "timed_out",
        *(f"excess_{name}" for name in quartiles), *(f"behind_{name}" for name in quartiles), "mean_rank", "seconds",
    )  # fmt: skip
    rows = [
        (
            *one.method, one.runs, one.failed, one.solved, one.found, one.reached, one.timed_out, *one.quartiles,
            *one.behind, one.rank, one.seconds,
        )
        for one in found.summaries
    ]  # fmt: skip
    return lines_as_csv(header, rows)


def _problems_csv(found: Comparison) -> bytes:
    """Return problem by problem what is proved, what was found, and how far the medians of the searches are off."""
    methods = list(dict.fromkeys(method for case in found.cases for method in case.behind))
    rows = []
    for case in found.cases:
        behind = [f"{case.behind[method]:.3g}" if method in case.behind else None for method in methods]
        at = " ".join(f"{name}={value:.6g}" for name, value in case.at.items())
        rows.append([case.name, case.lower_bound, case.best, case.searched, at, *behind])
    return lines_as_csv(("problem", "lower_bound", "best", "best_search", "at", *map(str, methods)), rows)


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    cells = [[cell.replace("|", "\\|") for cell in row] for row in (header, ["---"] * len(header), *rows)]
    return ["| " + " | ".join(row) + " |" for row in cells]


def _number(value: float) -> str:
    if math.isnan(value):
        return "–"
    if value < FLOOR:
        return "0"
    return "no motion" if math.isinf(value) else f"{value:.3g}"
