"""The report of a study: tables in Markdown, a figure, and the rows."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from selfmotion._version import __version__
from selfmotion.plot import draw_evolution, rendered
from selfmotion.study.runs import Study
from selfmotion.study.statistics import FEWEST, FOUND, Comparison, Method, compared
from selfmotion.study.store import Store
from selfmotion.study.tables import csv_bytes, study_status, study_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FILES = ("report.md", "runs.csv", "convergence.png", "convergence.svg")
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
    files = {"runs.csv": csv_bytes(table)}
    if found.bands:
        files |= rendered("convergence", _draw_bands, found, width=5.0, height=3.2)
    return {"report.md": _text(study, store, found).encode(), **files}


def _draw_bands(axes: Axes, found: Comparison) -> None:
    labels = _short({summary.method for summary in found.summaries})
    draw_evolution(axes, {labels[method]: band for method, band in found.bands.items()}, 0.0)
    axes.set_ylabel(f"excess over the {_reference(found)}")
    axes.legend()


def _short(methods: set[Method]) -> dict[Method, str]:
    """Return what methods are called where there is little room: their optimizers, if that is enough."""
    alone = {method: sum(other.optimizer == method.optimizer for other in methods) == 1 for method in methods}
    return {method: method.optimizer if method.optimizer and alone[method] else str(method) for method in methods}


def _reference(found: Comparison) -> str:
    if not found.proved:
        return "best known"
    return "lower bound" if found.proved == found.problems else "lower bound or best known"


def _text(study: Study, store: Store, found: Comparison) -> str:
    status = study_status(study, store)
    lines = [
        f"# Study {study.name}",
        "",
        f"{status['done']} of {status['runs']} runs are done, {status['failed']} failed, {status['left']} are left. "
        f"{found.problems} problems have a motion; of {found.proved} of them the optimum is bounded from below.",
        "",
        "## Methods",
        "",
        f"The excess is that of the cost, relative, over the {_reference(found)} of its problem; a run without a "
        f"motion counts as the worst. Found: excess of at most {FOUND:g}.",
        "",
        *_table(
            ("method", "runs", "failed", "solved", "found", "lower quartile", "median", "upper quartile", "seconds"),
            [
                (
                    str(one.method), str(one.runs), str(one.failed), str(one.solved), str(one.found),
                    *(_number(value) for value in one.quartiles), _number(one.seconds),
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
    if found.bands:
        lines += [
            "## Convergence",
            "",
            "Median and quartiles of the best so far, over all problems and seeds.",
            "",
            "![Convergence](convergence.png)",
            "",
        ]
    if status["others"]:
        lines += [f"The store has {status['others']} more runs, of earlier versions of the study.", ""]
    return "\n".join([*lines, f"selfmotion {__version__}; every run is a line of `runs.csv`.", ""])


def _tests(found: Comparison) -> list[str]:
    ranked = [one for one in found.summaries if not math.isnan(one.rank)]
    if len(ranked) < 2:
        return []
    lines = [
        "## Do they differ?",
        "",
        f"Medians over the seeds, problem by problem: {found.compared} problems that every method has done.",
        "",
        *_table(("method", "mean rank"), [(str(one.method), f"{one.rank:.2f}") for one in ranked]),
        "",
    ]
    if found.compared < FEWEST:
        return [*lines, f"Tests need {FEWEST} problems at least: with fewer none can tell methods apart.", ""]
    if found.friedman is not None:
        lines += [f"Friedman's test, that all are equal: p = {found.friedman:.3g}.", ""]
    lines += [
        "In pairs, by Wilcoxon's signed-rank test, corrected by Holm's method:",
        "",
        *_table(
            ("better on", "than", "on the others", "ties", "p", "p corrected"),
            [
                (
                    f"{one.first}: {one.wins}", str(one.second), str(one.losses), str(one.ties), f"{one.p:.3g}",
                    f"{one.corrected:.3g}",
                )
                for one in found.differences
            ],
        ),
        "",
    ]  # fmt: skip
    return lines


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    cells = [[cell.replace("|", "\\|") for cell in row] for row in (header, ["---"] * len(header), *rows)]
    return ["| " + " | ".join(row) + " |" for row in cells]


def _number(value: float) -> str:
    if math.isnan(value):
        return "–"
    return "no motion" if math.isinf(value) else f"{value:.3g}"
