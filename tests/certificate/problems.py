"""The 3R case of the paper."""

import numpy as np

import selfmotion as sm

SEED_PATH = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]


def seed_problem(elbow="positive", start=0.3):
    """The 3R case of the paper, whose best costs are known: 4.88945, free start 4.65015581, negative 4.31504555."""
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi) if elbow == "positive" else None, None])
    return sm.Problem(arm, sm.Bezier(SEED_PATH), start=None if start is None else {"u": [start]}, elbow=elbow)
