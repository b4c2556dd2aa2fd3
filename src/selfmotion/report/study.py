"""The study's results, each computed when it is first asked for: a figure that needs no optimizer runs none."""

from __future__ import annotations

from selfmotion.optimizers import Progress
from selfmotion.report import seed_runs
from selfmotion.report.case_study import CaseStudy
from selfmotion.report.study_3r import Study3R
from selfmotion.report.study_6r import Study6R
from selfmotion.report.study_shortest import StudyShortest


class Study:
    """The paper's study: of the 3R arm, of the optimizers on every case, of the 6R arm, and what the least F is.

    Parameters
    ----------
    seed : int
        Seed of the single runs, and the first of the many.
    seeds : int
        Number of seeds of the comparison.
    workers : int
        Processes that share its runs; they change no bit of the outcome.
    progress : callable, optional
        Called with (done, total, best so far), stage by stage.

    Attributes
    ----------
    cases : dict
        Name to `CaseStudy`: the optimizers over many seeds.
    three : Study3R
    six : Study6R
    shortest : StudyShortest
    """

    def __init__(self, seed: int = 1, seeds: int = 30, workers: int = 1, progress: Progress | None = None) -> None:
        self.seed = seed
        self.seeds = seeds
        self.cases = {name: CaseStudy(name, seed, seeds, workers, progress) for name in seed_runs.CASES}
        self.three = Study3R(seed, progress)
        self.six = Study6R(seed, progress)
        self.shortest = StudyShortest(self.cases, seed, progress)
