"""How swarms move, on plain arrays, strictly: the same draws give the same bits whoever calls.

A swarm is its candidates x (p, d), their velocities v (p, d), and the positions with their values that it remembers:
each particle's best for PSO, the leaders for GWO, the best for random search. A generation takes one row of draws,
uniform in [0, 1).
"""

from __future__ import annotations

import numpy as np

from selfmotion._compiled import kernel

PSO, GWO, RANDOM = 0, 1, 2


@kernel
def threshold(code, i, remembered_values):  # type: ignore[no-untyped-def]
    """Return the value above which candidate i changes nothing that the swarm does."""
    if code == PSO:
        return remembered_values[i]
    return remembered_values[-1]


@kernel
def move(code, x, v, remembered, remembered_values, values, draws, t, constants, lower, upper):  # type: ignore[no-untyped-def]
    """Take the values of generation t and make the next one, in place."""
    if code == PSO:
        _fly(x, v, remembered, remembered_values, values, draws, constants, lower, upper)
    elif code == GWO:
        _hunt(x, remembered, remembered_values, values, draws, t, constants, lower, upper)
    else:
        _draw_again(x, remembered, remembered_values, values, draws, lower, upper)


@kernel
def _fly(x, v, p, p_values, values, draws, constants, lower, upper):  # type: ignore[no-untyped-def]
    """v ← χ(ωv + φ1 β1 (p − x) + φ2 β2 (g − x)), x ← x + v, equation (23)."""
    chi, omega, phi1, phi2, absorb = constants[0], constants[1], constants[2], constants[3], constants[4] > 0.0
    rows, dimension = x.shape
    for i in range(rows):
        if values[i] < p_values[i]:
            p_values[i] = values[i]
            p[i] = x[i]
    g = p[np.argmin(p_values)]
    for i in range(rows):
        for j in range(dimension):
            beta1, beta2 = draws[i * dimension + j], draws[(rows + i) * dimension + j]
            v[i, j] = chi * (omega * v[i, j] + phi1 * beta1 * (p[i, j] - x[i, j]) + phi2 * beta2 * (g[j] - x[i, j]))
            moved = x[i, j] + v[i, j]
            x[i, j] = min(max(moved, lower[j]), upper[j])
            if absorb and x[i, j] != moved:
                v[i, j] = 0.0


@kernel
def _hunt(x, leaders, best, values, draws, t, constants, lower, upper):  # type: ignore[no-untyped-def]
    """Update the leaders wolf by wolf, then X ← the mean of X_k = X_leader − A |C X_leader − X|, (24)–(26)."""
    rows, dimension = x.shape
    for i in range(rows):
        if values[i] < best[0]:
            leaders[0], best[0] = x[i], values[i]
        elif best[0] < values[i] < best[1]:
            leaders[1], best[1] = x[i], values[i]
        elif best[1] < values[i] < best[2]:
            leaders[2], best[2] = x[i], values[i]
    a = 2.0 - 2.0 * t / constants[0]
    size = rows * dimension
    for i in range(rows):
        for j in range(dimension):
            total = 0.0
            for k in range(3):
                at = k * size + i * dimension + j
                big_a, big_c = 2.0 * a * draws[at] - a, 2.0 * draws[3 * size + at]
                total += leaders[k, j] - big_a * abs(big_c * leaders[k, j] - x[i, j])
            x[i, j] = min(max(total / 3.0, lower[j]), upper[j])


@kernel
def _draw_again(x, best, best_value, values, draws, lower, upper):  # type: ignore[no-untyped-def]
    """Remember the best, draw the next ones."""
    rows, dimension = x.shape
    for i in range(rows):
        if values[i] < best_value[0]:
            best[0], best_value[0] = x[i], values[i]
    for i in range(rows):
        for j in range(dimension):
            x[i, j] = lower[j] + (upper[j] - lower[j]) * draws[i * dimension + j]
