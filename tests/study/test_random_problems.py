"""Random problems: each follows from its seed, today and in later versions, and is of every kind."""

import hashlib
import json

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.exchange.plan_parts import problem_object
from selfmotion.study.random_problems import KINDS, many_link_problem

# Studies name problems by generator and seed: what these mean must not change. A new law is a new kind.
KNOWN = {
    "random": "0fbcf841ff4a51c8", "reachable": "022142b15e535691", "sinusoid": "2bc861497296ad39",
    "nR": "e7bae728fc1fe6f0",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_a_seed_means_the_same_problem_for_ever(kind):
    problems = [KINDS[kind](seed) for seed in range(10)]
    data = [None if problem is None else rounded(problem_object(problem)) for problem in problems]
    assert hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()[:16] == KNOWN[kind]
    assert repr(KINDS[kind](3)) == repr(problems[3])


def rounded(value):
    """Data with numbers of eight digits: the last ones are the machine's."""
    if isinstance(value, dict):
        return {key: rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [rounded(item) for item in value]
    return float(f"{value:.8g}") if isinstance(value, float) else value


def test_problems_of_many_links_begin_in_their_limits_and_most_have_motions():
    links = set()
    for seed in range(60):
        problem = many_link_problem(seed)
        links.add(problem.arm.n)
        q = problem.start.q
        assert ((problem.arm.limits.lower <= q) & (q <= problem.arm.limits.upper)).all()
        assert np.abs(problem.arm.forward(q) - problem.path(0.0)).max() < 1e-9
    assert links == set(range(3, 13))
    solved = 0
    for seed in range(6):
        try:
            solved += sm.plan(many_link_problem(seed), sm.Refine(starts=2, time_limit=20)).verification.holds
        except sm.SelfMotionError:
            continue
    assert solved >= 4


def test_problems_for_sinusoids_are_solved_by_one():
    planner = sm.Sinusoid(amplitude=[0.4], optimizer=sm.RandomSearch(100, 10, seed=1))
    for seed in range(8):
        problem = KINDS["sinusoid"](seed)
        assert problem.end is None
        assert sm.plan(problem, planner).verification.holds
