"""``selfmotion reproduce``: the paper's study as a report, printed values beside computed ones."""

from __future__ import annotations

import json
import time
from collections.abc import Iterable

from selfmotion.report.figures import chosen
from selfmotion.report.page import html_page
from selfmotion.report.results import results_of
from selfmotion.report.study import Study
from selfmotion.report.text import report_text

_REPORT = ("report.md", "report.html", "results.json")


def file_names(only: Iterable[str] = ()) -> list[str]:
    """Return the names of the files that :func:`reproduce` makes.

    Raises
    ------
    InvalidInputError
        If `only` names no figure of the report.
    """
    only = list(only)
    pictures = [f"{figure.name}.{suffix}" for figure in chosen(only) for suffix in ("png", "svg", "json")]
    return pictures if only else [*_REPORT, *pictures]


def reproduce(study: Study, options: str = "", only: Iterable[str] = ()) -> dict[str, bytes]:
    """Run the paper's study and return its report, or some of its figures.

    Parameters
    ----------
    study : Study
    options : str
        The options of the command that is being run, for the report.
    only : iterable of str
        Names of figures: only these are made, and only what they need is run.

    Returns
    -------
    dict
        File name to bytes: ``report.md``, ``report.html``, ``results.json`` (without `only`), and each figure as PNG,
        SVG and, as JSON, the data it shows.

    Raises
    ------
    InvalidInputError
        If `only` names no figure of the report.
    """
    began, only = time.perf_counter(), list(only)
    files = {name: data for figure in chosen(only) for name, data in figure.files(study).items()}
    if only:
        return files
    results = results_of(study)
    results["run"] = {"options": options, "wall_time_s": time.perf_counter() - began}
    text = report_text(results)
    return {
        "report.md": text.encode(),
        "report.html": html_page(text, files).encode(),
        "results.json": (json.dumps(results, indent=1, allow_nan=False) + "\n").encode(),
        **files,
    }
