"""The shortest motions of the paper's cases, each computed when it is first asked for."""

from __future__ import annotations

from functools import cached_property

from selfmotion.optimizers import Progress
from selfmotion.planners import Plan
from selfmotion.report import seed_shortest
from selfmotion.report.case_study import CaseStudy
from selfmotion.report.seed_shortest import Answer


class StudyShortest:
    """How good the paper's sinusoids are.

    Parameters
    ----------
    cases : dict
        Name to `CaseStudy`, of which the best sinusoids are taken.
    seed : int
        Of every search.
    progress : callable, optional
    """

    def __init__(self, cases: dict[str, CaseStudy], seed: int, progress: Progress | None = None) -> None:
        self._cases = cases
        self._seed = seed
        self._progress = progress

    @cached_property
    def answers(self) -> dict[str, Answer]:
        """Motions of each case, by name."""
        return {
            name: seed_shortest.answer(name, self._cases[name].scan.f, self._seed, self._progress)
            for name in seed_shortest.QUESTIONS
        }

    @cached_property
    def without_limits(self) -> Plan:
        """The shortest motion of the 3R arm without limits, from the same start on either elbow."""
        return seed_shortest.shortest(seed_shortest.WITHOUT_LIMITS, self._progress)
