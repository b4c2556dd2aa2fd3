"""One figure of the report: what it shows, how it is drawn, and its files."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from selfmotion import plot
from selfmotion.plot.style import COLUMN
from selfmotion.report.study import Study


@dataclass(frozen=True)
class ReportFigure:
    """A figure of the report.

    Attributes
    ----------
    name : str
        Of its files, and of ``selfmotion reproduce --only``.
    number : str
        The paper's, such as ``Fig. 10a``; empty where the paper has no such figure.
    caption : str
        What it shows; may use fields of the results, such as ``{seeds}``.
    alt : str
        What a reader who cannot see it should know.
    draw : callable
        Takes the `Study` and as many Axes as `columns` times `rows`. It computes what it asks the study for, no more.
    width, height : float
        [inch]
    columns, rows : int
    """

    name: str
    number: str
    caption: str
    alt: str
    draw: Callable[..., None]
    width: float = COLUMN
    height: float = 2.6
    columns: int = 1
    rows: int = 1

    def files(self, study: Study) -> dict[str, bytes]:
        """Return ``name.png``, ``name.svg`` and ``name.json``, the data that the picture shows."""
        size = {"width": self.width, "height": self.height, "columns": self.columns, "rows": self.rows}
        with plot.figure(**size) as (canvas, axes):  # type: ignore[arg-type]
            self.draw(study, *axes)
            return plot.image_files(self.name, canvas, data=True)
