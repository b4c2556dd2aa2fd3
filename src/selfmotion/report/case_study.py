"""What is computed of one case of the paper, when it is first asked for."""

from __future__ import annotations

from functools import cached_property

from selfmotion.optimizers import Progress
from selfmotion.report import seed_runs
from selfmotion.report.cases import DenseScan


class CaseStudy:
    """The yardstick of a case and its optimizers over many seeds.

    Parameters
    ----------
    name : str
        One of `seed_runs.CASES`.
    seed, seeds : int
        First seed and number of seeds.
    workers : int
        Processes that share the runs.
    progress : callable, optional
    """

    def __init__(self, name: str, seed: int, seeds: int, workers: int = 1, progress: Progress | None = None) -> None:
        self.case = seed_runs.CASES[name]
        self._settings = (name, seed, seeds, workers, progress)

    @cached_property
    def scan(self) -> DenseScan:
        """The least F there is, from a dense scan."""
        return self.case.dense_scan()

    @cached_property
    def runs(self) -> dict[str, dict[str, seed_runs.Runs]]:
        """The runs of all seeds: copy of the problem to label to runs."""
        return seed_runs.many_seeds(*self._settings)
