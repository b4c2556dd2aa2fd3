"""Plan for a six-axis arm on a rail.

A KUKA KR 6 welds a straight seam of 2 m, longer than it reaches, its torch keeping its orientation. Where the base is
on its rail is the one redundant degree. How much a metre of rail is worth in radians is for the process to say: that is
the weight of joint 1.
"""

import numpy as np

import selfmotion as sm

TORCH = {"translation": [0.0, 0.0, 0.25]}

arm = sm.named_arm("kr6r900", tool=TORCH, rail={"axis": [0, 1, 0], "limits": [-1.2, 1.2]})
seam = sm.PosePath(sm.Line([0.6, -1.0, 0.3], [0.6, 1.0, 0.3]), [0.0, 0.980067, 0.0, 0.198669])

for worth in (0.1, 0.5, 2.0):  # rad/m
    problem = sm.Problem(arm, seam, objective="l2", weights=[worth, 1, 1, 1, 1, 1, 1])
    plan = sm.plan(problem, sm.Global(gap=1e-3))
    rail = plan(np.linspace(0, 1, 501))[:, 0]
    print(
        f"{worth} rad/m: the rail goes {np.abs(np.diff(rail)).sum():.3f} m; "
        f"cost {plan.cost:.4f}, none below {plan.lower_bound:.4f}"
    )

try:
    short = sm.named_arm("kr6r900", tool=TORCH, rail={"axis": [0, 1, 0], "limits": [-0.2, 1.2]})
    sm.plan(sm.Problem(short, seam, objective="l2"), sm.Global(gap=1e-3))
except sm.InfeasibleError as error:
    print(error)
