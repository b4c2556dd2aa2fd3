"""The question that the paper leaves open: how good its sinusoids are, and what the least F of any motion is."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from selfmotion.motion import Motion
from selfmotion.optimizers import DifferentialEvolution, Progress
from selfmotion.planners import BSpline, Global, Harmonics, Plan
from selfmotion.problem import Problem
from selfmotion.profiles import ProfileCurve, SinusoidProfile
from selfmotion.report import seed_3r, seed_6r
from selfmotion.report.cases import SAMPLES

GAP = 1e-4  # part of the least F to which questions are answered
_TIME = 600.0  # far more than it takes: a clock must not decide the result
_SPAN, _HARMONICS, _COEFFICIENTS = 1.5, 5, 8


class Question(NamedTuple):
    """One case of the question.

    Attributes
    ----------
    problem : callable
        Makes the problem, its start free.
    offset, amplitude : float
        Of the paper's sinusoids, which start at the offset.
    """

    problem: Callable[[], Problem]
    offset: float
    amplitude: float


QUESTIONS = {
    seed_3r.CASE.name: Question(seed_3r.problem, seed_3r.OFFSET, seed_3r.AMPLITUDE),
    seed_6r.FIXED.name: Question(lambda: seed_6r.modules()[0], seed_6r.OFFSET[0], seed_6r.AMPLITUDE[0]),
    seed_6r.MOVING.name: Question(lambda: seed_6r.modules()[1], seed_6r.OFFSET[1], seed_6r.AMPLITUDE[1]),
}
"""By the name of the search. On the moving base the fourth joint is absolute, as the paper has it."""
WITHOUT_LIMITS = Question(seed_3r.free_problem, seed_3r.OFFSET, seed_3r.AMPLITUDE)
"""The 3R arm with both elbows."""


class Answer(NamedTuple):
    """Motions of one case, each less bound than the one before; all but the last start as the paper's do.

    Attributes
    ----------
    sinusoid : Plan
        The best of the paper's family.
    harmonics, spline : Plan
        The best that a search found in two larger families.
    shortest : Plan
        The shortest of all, with its proof.
    free : Plan
        The same with the start posture free.
    """

    sinusoid: Plan
    harmonics: Plan
    spline: Plan
    shortest: Plan
    free: Plan


def answer(name: str, f: float, seed: int, progress: Progress | None = None) -> Answer:
    """Answer one of the `QUESTIONS`, `f` being the best frequency of its sinusoid."""
    question = QUESTIONS[name]
    bound, free = from_start(question), question.problem()
    search = DifferentialEvolution(population=40, iterations=80, seed=seed)
    return Answer(
        sinusoid(question, f),
        Harmonics(span=[_SPAN], harmonics=_HARMONICS, optimizer=search).plan(bound, progress),
        BSpline(span=[_SPAN], coefficients=_COEFFICIENTS, optimizer=search).plan(bound, progress),
        shortest(question, progress),
        Global(GAP, _TIME).plan(free, progress),
    )


def shortest(question: Question, progress: Progress | None = None) -> Plan:
    """Return the shortest of all motions that start as the paper's do."""
    return Global(GAP, _TIME).plan(from_start(question), progress)


def from_start(question: Question) -> Problem:
    """Return the problem, any elbow, with the start of the paper's sinusoids."""
    free = question.problem()
    return Problem(free.arm, free.path, start={"u": [question.offset]}, weights=free.weights, samples=SAMPLES)


def sinusoid(question: Question, f: float) -> Plan:
    """Return the sinusoid of frequency f as a checked plan."""
    problem, profile = from_start(question), SinusoidProfile([question.offset], [question.amplitude])
    motion = Motion(problem.arm, problem.path, ProfileCurve(profile, np.array([f])), 0, problem.samples)
    return Plan(problem, motion, "sinusoid", {"f": f})
