"""No chain of boxes, no motion: proofs that there is none, against dense sampling and planted cases."""

import time

import numpy as np
import pytest
from brute_force import brute_force_connected, limit_cut_problem

import selfmotion as sm
from selfmotion.arms.planar_slabs import PlanarSlabs
from selfmotion.certificate.chains import Chains, Ends
from selfmotion.study.random_problems import random_problem

STRIP = sm.Line([1.5, -2.5], [1.5, 2.5])
# Unit links, all joints limited alike, along STRIP: below this limit there is no motion, above it there is one [rad].
CRITICAL = 1.5202645672


def strip_problem(limit):
    return sm.Problem(sm.PlanarArm([1, 1, 1], [(-limit, limit)] * 3), STRIP)


def chains(problem, **ends):
    return Chains(PlanarSlabs(problem.arm, problem.path, problem.elbow), **ends)


@pytest.mark.parametrize("below", [0.0702645672, 1e-2, 1e-3, 1e-4])
def test_the_strip_is_blocked_below_its_critical_limit(below):
    proof = chains(strip_problem(CRITICAL - below)).prove()
    assert proof.proved
    assert proof.stopped == "proved"
    # The last part that leads on from the start ends at 0.5823 with limits of 1.45, and no earlier with wider ones.
    assert proof.latest >= 0.5822
    assert proof.earliest <= 1 - 0.5822
    assert proof.boxes < 100_000


@pytest.mark.parametrize("above", [1e-6, 1e-3, 0.1, 0.68])
def test_nothing_is_proved_where_the_strip_has_a_motion(above):
    proof = chains(strip_problem(CRITICAL + above)).prove(time.perf_counter() + 1.0, 200_000)
    assert not proof.proved
    assert proof.stopped in ("time", "budget", "clear")


def test_what_stopped_it_is_said():
    assert chains(strip_problem(2.2)).prove().stopped == "clear"
    assert chains(strip_problem(CRITICAL + 1e-9)).prove(budget=10_000).stopped == "budget"
    assert chains(strip_problem(CRITICAL + 1e-9)).prove(time.perf_counter() - 1.0).stopped == "time"


@pytest.mark.parametrize("seed", range(30))
def test_limit_cut_problems_agree_with_dense_sampling(seed):
    problem = limit_cut_problem(seed)
    proof = chains(problem).prove(time.perf_counter() + 10.0)
    assert proof.proved == (not brute_force_connected(problem)[0])


def test_nothing_is_proved_of_random_problems_that_have_motions():
    blocked = 0
    for seed in (*range(100, 114), 41, 143, 165):
        problem = random_problem(seed)
        if problem is None:
            continue
        connected = problem.structure.is_connected
        proof = chains(problem).prove(time.perf_counter() + (0.3 if connected else 10.0))
        assert proof.proved == (not connected), seed
        blocked += proof.proved
    assert blocked >= 3


def test_ends_that_no_motion_joins():
    """Elbow positive and negative are two parts of the self-motion where the limits of joint 2 keep them apart."""
    arm = sm.PlanarArm([1, 1, 1], [None, (0.1, 6.1), None])
    path = sm.Line([1.0, 0.3], [1.2, 0.8])
    q = [[arm.solve(path(r), [u], branch)[0] for branch in (0, 1)] for r, u in ((0.0, 0.5), (1.0, 0.8))]
    one, other = (np.mod(posture, 2 * np.pi) for posture in q[0])
    end = np.mod(q[1][0], 2 * np.pi)
    slabs = PlanarSlabs(sm.PlanarArm([1, 1, 1], [None, (0.1, np.pi - 0.1), None]), path)
    assert not Chains(slabs, start=Ends(one[None]), end=Ends(end[None])).prove(time.perf_counter() + 1).proved
    assert Chains(slabs, start=Ends(other[None]), end=Ends(end[None])).prove().proved


def test_an_end_inside_the_path_is_where_the_proof_ends():
    """Up to r = 0.58 the strip can be followed with limits of 1.45, from 0.6 on not."""
    problem = strip_problem(1.45)
    assert not chains(problem, high=0.58).prove(time.perf_counter() + 1).proved
    assert chains(problem, high=0.5825).prove().proved


def test_a_lost_box_would_be_noticed():
    """Where the way is narrow and boxes are lost there seems to be none: the comparisons above hang on every box."""

    class Leaky(PlanarSlabs):
        def split(self, low, high, boxes, size):
            found = super().split(low, high, boxes, size)
            return found[np.arange(len(found)) % 5 != 1]

    problem = strip_problem(CRITICAL + 1e-4)
    assert Chains(Leaky(problem.arm, problem.path)).prove(time.perf_counter() + 5).proved
