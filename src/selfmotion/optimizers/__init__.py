"""Optimizers on a box; they know nothing of robots.

A new optimizer is one file and one line in `OPTIMIZERS`.
"""

from __future__ import annotations

from selfmotion.optimizers.adapters import CMAES, DifferentialEvolution
from selfmotion.optimizers.base import (
    INFEASIBLE,
    AskTell,
    History,
    Judged,
    Optimizer,
    Progress,
    Result,
    counting,
    penalised,
    violation_of,
)
from selfmotion.optimizers.ga import GA
from selfmotion.optimizers.gwo import GWO
from selfmotion.optimizers.pso import PSO
from selfmotion.optimizers.random_search import RandomSearch
from selfmotion.optimizers.shifted import Shifted
from selfmotion.optimizers.swarm import RunsSwarms, Swarm, SwarmState

OPTIMIZERS: dict[str, type[Optimizer]] = {
    optimizer.kind: optimizer for optimizer in (GA, PSO, GWO, RandomSearch, DifferentialEvolution, CMAES, Shifted)
}
"""Every optimizer by the ``kind`` of a problem file."""

__all__ = [
    "CMAES",
    "GA",
    "GWO",
    "INFEASIBLE",
    "OPTIMIZERS",
    "PSO",
    "AskTell",
    "DifferentialEvolution",
    "History",
    "Judged",
    "Optimizer",
    "Progress",
    "RandomSearch",
    "Result",
    "RunsSwarms",
    "Shifted",
    "Swarm",
    "SwarmState",
    "counting",
    "penalised",
    "violation_of",
]
