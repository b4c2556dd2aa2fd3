"""The report as Markdown, filled from the results: a number that was not computed is a KeyError, never a stale one."""

from __future__ import annotations

from importlib import resources
from typing import Any

from selfmotion.report import seed_runs, seed_study, verdict
from selfmotion.report.figures import FIGURES, ReportFigure
from selfmotion.report.results import PACKAGES


def report_text(results: dict[str, Any]) -> str:
    """Return the report.

    Parameters
    ----------
    results : dict
        As :func:`~selfmotion.report.results.results_of` returns it, with ``run``: its command, options and wall time.

    Raises
    ------
    KeyError
        If a number that the report shows is missing.
    """
    template = resources.files(__package__).joinpath("report.md.in").read_text(encoding="utf-8")
    return template.format(
        **results,
        on_printed_values=verdict.on_printed_values(results),
        table_rows="\n".join(_table_row(label, results["table"][label]) for label in seed_study.IN_TABLE),
        misprint_rows="\n".join(_row(*misprint) for misprint in seed_study.MISPRINTS),
        comparison_rows="\n".join(_comparison_rows(results)),
        verdict="\n".join(f"- {sentence}" for sentence in verdict.on_seeds(results)),
        motion=results["table"][results["best"]],
        figures="\n\n".join(_figure(figure, results) for figure in FIGURES.values()),
        versions_line=", ".join(f"{name} {results['versions'][name]}" for name in PACKAGES),
    )


def _table_row(label: str, line: dict[str, Any]) -> str:
    printed, cells = line["printed"], ["–", "–", "–"]
    if printed is not None:
        cells = [f"{printed['fitness']:.9g}", f"{printed['f']:.4f}", f"{line['computed_at_printed_f']:.6f}"]
    computed = [f"{line['cost_sampled']:.8f}", f"{line['parameters']['f']:.4f}", verdict.excess(line["excess"])]
    return _row(label, *cells, *computed)


def _comparison_rows(results: dict[str, Any]) -> list[str]:
    keys = ("best", "lower_quartile", "median", "upper_quartile", "worst")
    return [
        _row(
            label,
            copy,
            *(verdict.excess(numbers[key]) for key in keys),
            f"{numbers['found']} of {results['seeds']}",
            f"{numbers['median_f_error']:.1e}",
        )
        for label in seed_study.COMPARED
        for copy, numbers in ((copy, results["comparison"][copy][label]) for copy in seed_runs.COPIES)
    ]


def _figure(figure: ReportFigure, results: dict[str, Any]) -> str:
    origin = f"{figure.number} of the paper." if figure.number else "Not in the paper."
    caption = figure.caption.format(**results)
    command = f"selfmotion reproduce --only {figure.name} {results['run']['options']}"
    return f"![{figure.alt}]({figure.name}.png)\n\n**{origin}** {caption}\n\n```sh\n{command}\n```"


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
