"""The seed's 3R case, 20 candidates for 100 generations, 1000 samples: in numpy as users would write it, and ours."""

import numpy as np

import selfmotion as sm
from selfmotion.planners import PlanarCandidates
from selfmotion.profiles import SinusoidProfile

OFFSET, AMPLITUDE, BOUNDS, SAMPLES, POPULATION, GENERATIONS = 0.3, 0.4, (0.0, 15.0), 1000, 20, 100
LINKS = (30.0, 30.0, 20.0)
PATH = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
PROBLEM = sm.Problem(sm.PlanarArm(LINKS, [None, (0, np.pi), None]), PATH, elbow="positive", samples=SAMPLES)
WORST = 1e3  # what a candidate out of reach is given in numpy

_R = np.linspace(0.0, 1.0, SAMPLES)
_X, _Y = np.ascontiguousarray(PATH(_R).T)
_PHASE, _STEP = 2.0 * np.pi * _R, (_R[1] - _R[0]) ** 2


def in_numpy(f):
    """Return the chord sum of one frequency, the fastest way that was found in numpy.

    It uses what its writer knows of this case: no joint crosses ±π, so nothing need be unwrapped.
    """
    l1, l2, l3 = LINKS
    u = OFFSET + AMPLITUDE * np.sin(f * _PHASE)
    wx, wy = _X - l3 * np.cos(u), _Y - l3 * np.sin(u)
    cosine = (wx * wx + wy * wy - (l1 * l1 + l2 * l2)) * (0.5 / (l1 * l2))
    if cosine.max() > 1.0 or cosine.min() < -1.0:
        return WORST
    q = np.empty((3, SAMPLES))
    q[1] = np.arccos(cosine)
    q[0] = np.arctan2(wy, wx) - np.arctan2(l2 * np.sqrt(1.0 - cosine * cosine), l1 + l2 * cosine)
    q[2] = u - q[0] - q[1]
    step = q[:, 1:] - q[:, :-1]
    step *= step
    step += _STEP
    return float(np.sqrt(step, out=step).sum())


def population_in_numpy(f):
    """Return the same for frequencies (p,): one by one, which is faster than arrays that leave the cache."""
    return np.array([in_numpy(value) for value in f])


def candidates(ranking):
    """Return our objective."""
    return PlanarCandidates(PROBLEM, SinusoidProfile([OFFSET], [AMPLITUDE]), 0, ranking=ranking)


def optimum():
    """Return the least integral over the frequencies, by a scan that is zoomed in to 1e-12."""
    judge, (low, high) = candidates("integral"), BOUNDS
    while high - low > 1e-12:
        grid = np.linspace(low, high, 3001)
        k = int(np.argmin(judge(grid[:, None])))
        low, high = grid[max(k - 1, 0)], grid[min(k + 1, 3000)]
        best = grid[k]
    return float(judge(np.array([[best]]))[0])
