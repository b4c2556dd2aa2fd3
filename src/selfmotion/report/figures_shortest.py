"""The figures of the shortest motions. A new one is one entry in `FIGURES_SHORTEST`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from selfmotion import plot
from selfmotion.plot.style import COLUMN
from selfmotion.report import seed_3r
from selfmotion.report.figure import ReportFigure
from selfmotion.report.study import Study

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_FREE = f"{seed_3r.CASE.name} without limits"


def _motions(study: Study, *panels: Axes) -> None:
    answers = study.shortest.answers
    shown = {name: (answer.shortest, answer.sinusoid) for name, answer in answers.items()}
    shown[_FREE] = study.shortest.without_limits, answers[seed_3r.CASE.name].sinusoid
    for (name, (shortest, sinusoid)), axes in zip(shown.items(), panels, strict=True):
        plot.draw_optimum(axes, shortest, {"best sinusoid": sinusoid})
        axes.set_title(f"{name}: {axes.get_title()}")


def _proof(study: Study, tube: Axes, rounds: Axes) -> None:
    answers = study.shortest.answers
    plot.draw_tube(tube, answers[seed_3r.CASE.name].shortest)
    tube.set_title(seed_3r.CASE.name)
    proofs = {
        f"{name}{start}": plan.certificate
        for name, answer in answers.items()
        for start, plan in (("", answer.shortest), (", any start", answer.free))
        if plan.certificate is not None
    }
    plot.draw_proof(rounds, proofs)


FIGURES_SHORTEST = (
    ReportFigure(
        "shortest_motions",
        "",
        "The shortest motion of each case beside its best sinusoid, from the same start, and the tube in which a "
        "shorter one would have to stay, often no wider than the line: the next figure enlarges it. "
        "In the last panel the arm may use both elbows, unfolded along the "
        "self-motion: they meet at the dotted folds.",
        "Four regions of feasible postures along the path, in each the best sinusoid and beside it the shortest "
        "motion with a narrow band around it",
        _motions,
        width=2 * COLUMN,
        height=6.4,
        columns=2,
        rows=2,
    ),
    ReportFigure(
        "shortest_proof",
        "",
        "Left the tube of the smaller arm, straightened and enlarged. Right how far the shortest motion known lies "
        "above the lower bound after each round of the proof, against the cells that were looked at.",
        "Left a band around a straight line, as wide as the room for a better motion; right lines that fall on "
        "logarithmic axes",
        _proof,
        width=2 * COLUMN,
        height=3.0,
        columns=2,
    ),
)
"""In the order of the report."""
