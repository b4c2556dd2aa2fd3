"""What moving bases and the modules on them cost together: the objective of :class:`.moving_base.MovingBase`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from selfmotion._blocks import in_blocks
from selfmotion._types import FloatArray
from selfmotion.angles import TAU
from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import penalised
from selfmotion.paths import Path
from selfmotion.planners.candidates import candidates_at_once, true_joints
from selfmotion.planners.chain import module_arms, splittable
from selfmotion.problem import Problem

PLACES = 200
"""Places at which the search looks at a candidate: its chord sum ranks, the answer is measured anew."""
_FIT = 200  # points to which the first guess of a moving base is fitted


class Choice(NamedTuple):
    """What candidates choose.

    Attributes
    ----------
    points : array, shape (p, k − 1, m, 2)
        Control points of the moving bases.
    offset, amplitude, frequency : array, shape (p, k)
        Of the sinusoid (22) of each module.
    """

    points: FloatArray
    offset: FloatArray
    amplitude: FloatArray
    frequency: FloatArray


class ChainCandidates:
    """What moving bases and modules cost together, in true joints of the whole arm.

    Parameters
    ----------
    problem : Problem
    guess : array, shape (k − 1, m, 2)
        Control points in the middle of the box.
    spread : float
        Half the box's width in each coordinate of a control point.
    amplitude : float
        Largest amplitude [rad].
    frequency : float
        Largest frequency.
    elbows : sequence of int
        The branch of each module.
    places : int
        Number of path parameters looked at, besides the path's breaks.

    Notes
    -----
    The box is [−1, 1] in every variable: control points, then for each module its offset, amplitude and frequency. The
    offset is measured from the direction of the module's target at r = 0, in parts of the half-width of the arc on
    which that target is in reach: without joint limits every candidate starts inside its angle domain.
    """

    def __init__(
        self,
        problem: Problem,
        guess: FloatArray,
        spread: float,
        amplitude: float,
        frequency: float,
        elbows: Sequence[int],
        places: int,
    ) -> None:
        arm = splittable(problem)
        self.problem = problem
        self.guess = guess
        self.elbows = tuple(elbows)
        self._spread, self._amplitude, self._frequency = spread, amplitude, frequency
        self._arms = module_arms(arm)
        self._r = np.union1d(np.linspace(0.0, 1.0, places), problem.path.breaks)
        self._x = problem.path(self._r)
        self._basis = bernstein(guess.shape[1], self._r)

    @property
    def dimension(self) -> int:
        """Number of variables."""
        return self.guess.size + 3 * len(self._arms)

    def choice(self, population: FloatArray) -> Choice:
        """Return what a population, shape (p, d), chooses."""
        p, size, k = len(population), self.guess.size, len(self._arms)
        points = self.guess + self._spread * population[:, :size].reshape(p, *self.guess.shape)
        offset, amplitude, frequency = np.moveaxis(population[:, size:].reshape(p, k, 3), 2, 0)
        starts = np.concatenate([np.zeros((p, 1, 2)), points[:, :, 0], np.broadcast_to(self._x[0], (p, 1, 2))], axis=1)
        target = np.diff(starts, axis=1)
        return Choice(
            points,
            np.arctan2(target[..., 1], target[..., 0]) + offset * self._half_width(target),
            self._amplitude * amplitude,
            0.5 * self._frequency * (frequency + 1.0),
        )

    def _half_width(self, target: FloatArray) -> FloatArray:
        """Return arccos((R² + l3² − (l1 + l2)²)/(2 R l3)), π where the whole circle is in reach."""
        l1, l2, l3 = np.array([arm.links for arm in self._arms]).T
        distance = np.maximum(np.hypot(target[..., 0], target[..., 1]), 1e-300)
        return np.arccos(np.clip((distance**2 + l3**2 - (l1 + l2) ** 2) / (2 * distance * l3), -1.0, 1.0))

    def __call__(self, population: FloatArray) -> FloatArray:
        """Return the values of a population, shape (p, d), as the optimizers rank them."""
        return in_blocks(self._block, population, candidates_at_once(len(self._r) * self.problem.arm.n))

    def _block(self, population: FloatArray) -> FloatArray:
        chosen = self.choice(population)
        bases = self._basis @ chosen.points  # (p, k − 1, places, 2)
        ends = [0.0, *np.moveaxis(bases, 1, 0), self._x]
        turn = np.sin(TAU * chosen.frequency[..., None] * self._r)
        u = chosen.offset[..., None] + chosen.amplitude[..., None] * turn
        joints, violation = [], np.zeros(len(population))
        for i, arm in enumerate(self._arms):
            x, behind = ends[i + 1] - ends[i], u[:, i - 1] if i else 0.0
            q, left = true_joints(arm, arm.limits, x, u[:, i, :, None], self.elbows[i], behind)
            joints.append(q)
            violation += left
        cost = self.problem.objective.sampled(np.concatenate(joints, axis=-1), self._r, self.problem.weights)
        return penalised(cost, violation)


def bernstein(count: int, r: FloatArray) -> FloatArray:
    """Return the Bernstein polynomials of degree count − 1 at r (k,), shape (k, count)."""
    degree = count - 1
    j = np.arange(count)
    binomial = np.array([math.comb(degree, i) for i in j], dtype=float)
    return np.asarray(binomial * r[:, None] ** j * (1.0 - r[:, None]) ** (degree - j))


def first_guess(problem: Problem, control_points: int, around: Sequence[Path] = ()) -> FloatArray:
    """Return control points fitted to `around`, or else to moving bases that modules of three equal links reach.

    Moving base i is the tool's path drawn towards the arm's base, ``x(r) (L_1 + … + L_i)/(L_1 + … + L_k)`` with L_i the
    length of module i, so that each module has its share of the way; a Bezier curve is fitted to it.

    Returns
    -------
    array, shape (k − 1, control_points, 2)
    """
    lengths = splittable(problem).links.reshape(-1, 3).sum(axis=1)
    share = np.cumsum(lengths)[:-1] / lengths.sum()
    r = np.linspace(0.0, 1.0, _FIT)
    if around and len(around) != len(share):
        reason = f"has {len(around)} paths for {len(lengths)} modules of three links"
        raise InvalidInputError("planner.around", reason, f"give {len(share)}, one for each module but the last")
    wanted = [path(r) for path in around] or [part * problem.path(r) for part in share]
    fits = [np.linalg.lstsq(bernstein(control_points, r), points, rcond=None)[0] for points in wanted]
    return np.stack(fits)
