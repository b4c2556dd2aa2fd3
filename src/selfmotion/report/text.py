"""The report as Markdown, filled from the results: a number that was not computed is a KeyError, never a stale one."""

from __future__ import annotations

import math
from importlib import resources
from typing import Any

from selfmotion.certificate.verdict import percent, proved_within
from selfmotion.report import seed_3r, seed_6r, seed_runs, verdict
from selfmotion.report.cases import COMPARED, IN_TABLE
from selfmotion.report.figure import ReportFigure
from selfmotion.report.figures import FIGURES
from selfmotion.report.results import PACKAGES
from selfmotion.report.seed_shortest import QUESTIONS

_SCALE = 10**6  # bounds are rounded down to six decimals


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
    six = results["six"]
    return template.format(
        **results,
        printed={name: verdict.on_printed_values(results, name) for name in results["cases"]},
        rows={name: "\n".join(_table_rows(name, case)) for name, case in results["cases"].items()},
        compared={name: "\n".join(_comparison_rows(results, name)) for name in seed_runs.CASES},
        verdicts={name: _bullets(verdict.on_seeds(results, name)) for name in seed_runs.CASES},
        misprint_rows="\n".join(_row(*misprint) for misprint in seed_3r.MISPRINTS),
        motion=results["cases"][seed_3r.CASE.name]["table"][results["best"]],
        sum_rows="\n".join(_sum_rows(results)),
        motion_rows="\n".join(_motion_rows(six)),
        on_modules=verdict.on_modules(results),
        shortest_rows="\n".join(_shortest_rows(results)),
        on_shortest=_bullets([verdict.on_shortest(results, name) for name in QUESTIONS]),
        on_chords=verdict.on_chords(results),
        figures="\n\n".join(_figure(figure, results) for figure in FIGURES.values()),
        versions_line=", ".join(f"{name} {results['versions'][name]}" for name in PACKAGES),
    )


def _table_rows(name: str, case: dict[str, Any]) -> list[str]:
    """Return a case's lines of the paper's table, with the case in front if the table has several."""
    front = [] if name == seed_3r.CASE.name else [name]
    return [_row(*front, label, *_cells(case["table"][label])) for label in IN_TABLE]


def _cells(line: dict[str, Any]) -> list[str]:
    printed, cells = line["printed"], ["–", "–", "–"]
    if printed is not None:
        cells = [f"{printed['fitness']:.9g}", f"{printed['f']:.4f}", f"{line['computed_at_printed_f']:.6f}"]
    return [*cells, f"{line['fitness']:.8f}", f"{line['f']:.4f}", verdict.excess(line["excess"])]


def _comparison_rows(results: dict[str, Any], name: str) -> list[str]:
    keys = ("best", "lower_quartile", "median", "upper_quartile", "worst")
    comparison = results["cases"][name]["comparison"]
    return [
        _row(
            label,
            copy,
            *(verdict.excess(numbers[key]) for key in keys),
            f"{numbers['found']} of {results['seeds']}",
            f"{numbers['median_f_error']:.1e}",
        )
        for label in COMPARED
        for copy, numbers in ((copy, comparison[copy][label]) for copy in seed_runs.COPIES)
    ]


def _sum_rows(results: dict[str, Any]) -> list[str]:
    """Return what both modules cost together: a row per optimizer and per way in which it counted the fourth joint."""
    fixed, *moving = (results["cases"][name]["scan"]["fitness"] for name in seed_6r.NAMES)
    least = [cell for one in moving for cell in (f"{fixed + one:.6f}", "–")]
    rows = [_row("dense scans", "–", "–", *least)]
    sums = results["six"]["sums"]
    for reading in seed_6r.READINGS:
        for label in IN_TABLE:
            line = sums[reading][label]
            printed = "–" if line["printed"] is None else f"{line['printed']:.9g}"
            values = (f"{line[counted][kind]:.6f}" for counted in seed_6r.READINGS for kind in ("sampled", "integral"))
            rows.append(_row(label, reading, printed, *values))
    return rows


def _motion_rows(six: dict[str, Any]) -> list[str]:
    """Return what motions of the whole arm cost: the best of the modules', and those less bound."""
    motions = {
        "modules on the printed moving base": six["motion"],
        "modules on a moving base that is chosen too": six["whole_arm"]["moving"],
        "no modules, from the same start posture": six["whole_arm"]["from_start"],
        "no modules, start posture free": six["whole_arm"]["free"],
    }
    return [
        _row(
            name,
            f"{motion['cost']:.6f}",
            f"{motion['cost_error']:.0e}",
            f"{motion['l1_travel']:.4f}",
            f"{motion['max_tracking_error']:.1e}",
            f"{motion['min_limit_margin']:.4f}",
        )
        for name, motion in motions.items()
    ]


def _shortest_rows(results: dict[str, Any]) -> list[str]:
    """Return what the shortest motions cost, and the best of some families: from the printed start, and from any."""
    rows = []
    for name in QUESTIONS:
        found = results["shortest"][name]
        printed = f"{verdict.least_printed(results, name):.6g}"
        families = [f"{found[kind]['cost']:.6f}" for kind in ("sinusoid", "harmonics", "spline")]
        rows.append(_row(name, f"u = {found['start']:g}", printed, *families, *_proved(found["shortest"])))
        rows.append(_row(name, "any", *["–"] * (1 + len(families)), *_proved(found["free"])))
    return rows


def _proved(motion: dict[str, Any]) -> list[str]:
    cost, error, bound = motion["cost"], motion["cost_error"], motion["lower_bound"]
    return [f"{cost:.6f}", f"{math.floor(bound * _SCALE) / _SCALE:.6f}", percent(proved_within(cost, error, bound))]


def _bullets(sentences: list[str]) -> str:
    return "\n".join(f"- {sentence}" for sentence in sentences)


def _figure(figure: ReportFigure, results: dict[str, Any]) -> str:
    origin = f"{figure.number} of the paper." if figure.number else "Not in the paper."
    caption = figure.caption.format(**results)
    command = f"selfmotion reproduce --only {figure.name} {results['run']['options']}"
    return f"![{figure.alt}]({figure.name}.png)\n\n**{origin}** {caption}\n\n```sh\n{command}\n```"


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
