"""How swarms move, on plain arrays, strictly: the same draws give the same bits whoever calls."""

from __future__ import annotations

from typing import NamedTuple

from selfmotion._compiled import kernel
from selfmotion._types import FloatArray
from selfmotion.optimizers.swarm import FLY, HUNT


class Flock(NamedTuple):
    """A swarm as kernels see it; they change its arrays.

    Attributes
    ----------
    code : int
        The move; see :class:`.swarm.Swarm`.
    constants : array
        What the move takes: χ, ω, φ1, φ2 and whether walls absorb for PSO, the number of generations for GWO.
    lower, upper : array, shape (d,)
        The box.
    x, v : array, shape (p, d)
        Candidates and their velocities.
    remembered, remembered_values : array, shape (m, d) and (m,)
        Positions and their values: each particle's best for PSO, the leaders for GWO, the best for random search.
    """

    code: int
    constants: FloatArray
    lower: FloatArray
    upper: FloatArray
    x: FloatArray
    v: FloatArray
    remembered: FloatArray
    remembered_values: FloatArray


@kernel
def threshold(flock: Flock, i: int) -> float:
    """Return the value above which candidate i changes nothing that the swarm does."""
    return float(flock.remembered_values[i if flock.code == FLY else -1])


@kernel
def learn(flock: Flock, i: int, value: float) -> None:
    """Take the value of candidate i."""
    known, place = flock.remembered_values, -1
    if flock.code == FLY:
        place = i if value < known[i] else -1
    else:
        for k in range(len(known)):
            if place < 0 and value < known[k] and (k == 0 or value > known[k - 1]):
                place = k
    if place >= 0:
        known[place] = value
        for j in range(flock.x.shape[1]):
            flock.remembered[place, j] = flock.x[i, j]


@kernel
def move(flock: Flock, draws: FloatArray, t: int) -> None:
    """Make the generation after generation t from what was learned, with one row of draws, uniform in [0, 1)."""
    if flock.code == FLY:
        _fly(flock, draws)
    elif flock.code == HUNT:
        _hunt(flock, draws, t)
    else:
        rows, dimension = flock.x.shape
        for i in range(rows):
            for j in range(dimension):
                width = flock.upper[j] - flock.lower[j]
                flock.x[i, j] = flock.lower[j] + width * draws[i * dimension + j]


@kernel
def tell(flock: Flock, values: FloatArray, draws: FloatArray, t: int) -> None:
    """Take the values of a whole generation and make the next one."""
    for i in range(len(values)):
        learn(flock, i, values[i])
    move(flock, draws, t)


@kernel
def _fly(flock: Flock, draws: FloatArray) -> None:
    """v ← χ(ωv + φ1 β1 (p − x) + φ2 β2 (g − x)), x ← x + v, equation (23)."""
    x, v, p, lower, upper = flock.x, flock.v, flock.remembered, flock.lower, flock.upper
    chi, omega, phi1, phi2 = flock.constants[0], flock.constants[1], flock.constants[2], flock.constants[3]
    absorb = flock.constants[4] > 0.0
    rows, dimension = x.shape
    best = 0
    for i in range(rows):
        best = i if flock.remembered_values[i] < flock.remembered_values[best] else best
    for i in range(rows):
        for j in range(dimension):
            beta1, beta2 = draws[i * dimension + j], draws[(rows + i) * dimension + j]
            own, all_best = p[i, j] - x[i, j], p[best, j] - x[i, j]
            v[i, j] = chi * (omega * v[i, j] + phi1 * beta1 * own + phi2 * beta2 * all_best)
            moved = x[i, j] + v[i, j]
            x[i, j] = min(max(moved, lower[j]), upper[j])
            if absorb and x[i, j] != moved:
                v[i, j] = 0.0


@kernel
def _hunt(flock: Flock, draws: FloatArray, t: int) -> None:
    """X ← the mean of X_k = X_leader − A |C X_leader − X|, (24)–(26), inside the box."""
    x, leaders, lower, upper = flock.x, flock.remembered, flock.lower, flock.upper
    rows, dimension = x.shape
    a, size = 2.0 - 2.0 * t / flock.constants[0], rows * dimension
    for i in range(rows):
        for j in range(dimension):
            total = 0.0
            for k in range(3):
                at = k * size + i * dimension + j
                big_a, big_c = 2.0 * a * draws[at] - a, 2.0 * draws[3 * size + at]
                total += leaders[k, j] - big_a * abs(big_c * leaders[k, j] - x[i, j])
            x[i, j] = min(max(total / 3.0, lower[j]), upper[j])
