"""Where arm and path meet: the feasible self-motion at a task point and along a path."""

from __future__ import annotations

from selfmotion.domain.angle_domain import (
    AngleDomain,
    angle_domain,
    blocked_at,
    blocked_by,
    blocked_stretches,
    cause_of,
    out_of_reach,
)
from selfmotion.domain.events import Event
from selfmotion.domain.feasible import FeasibleArcs, Run, feasible_arcs
from selfmotion.domain.fibre import Fibre, Interval, fibres
from selfmotion.domain.sampled import SampledDomain
from selfmotion.domain.structure import Cell, DomainStructure, Sheet
from selfmotion.domain.sweep import Sweep

__all__ = [
    "AngleDomain",
    "Cell",
    "DomainStructure",
    "Event",
    "FeasibleArcs",
    "Fibre",
    "Interval",
    "Run",
    "SampledDomain",
    "Sheet",
    "Sweep",
    "angle_domain",
    "blocked_at",
    "blocked_by",
    "blocked_stretches",
    "cause_of",
    "feasible_arcs",
    "fibres",
    "out_of_reach",
]
