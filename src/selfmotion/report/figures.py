"""Every figure of the report. A new one is one entry in the `FIGURES_…` of its study."""

from __future__ import annotations

from collections.abc import Iterable

from selfmotion.errors import InvalidInputError
from selfmotion.report.figure import ReportFigure
from selfmotion.report.figures_3r import FIGURES_3R
from selfmotion.report.figures_6r import FIGURES_6R
from selfmotion.report.figures_shortest import FIGURES_SHORTEST

FIGURES = {figure.name: figure for figure in (*FIGURES_3R, *FIGURES_6R, *FIGURES_SHORTEST)}
"""The report's figures by name, in its order."""


def chosen(only: Iterable[str] = ()) -> list[ReportFigure]:
    """Return the figures of these names, all of them if none is given.

    Raises
    ------
    InvalidInputError
        If there is no figure of a name.
    """
    for name in (names := list(dict.fromkeys(only))):
        if name not in FIGURES:
            raise InvalidInputError("--only", "is no figure of the report", f"one of {', '.join(FIGURES)}", name)
    return [FIGURES[name] for name in names or FIGURES]
