"""Time that `global` takes by the gap asked for, and by the length of the path.

Times are those of the plans, kernels loaded. Run alone, on a quiet machine: ``python benchmarks/time_against_gap.py``.
The last line has the most memory that the process ever held.
"""

import resource

import numpy as np

import selfmotion as sm
from selfmotion.report.seed_shortest import QUESTIONS, from_start

GAPS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
LAPS = (1, 2, 4, 8)
BEZIER = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
FREE, LIMITED = (sm.PlanarArm([30, 30, 20], limits) for limits in (None, [None, (0, np.pi), None]))
CASES = {
    "Bezier 3R, start 0.3": sm.Problem(LIMITED, BEZIER, start=[0.3], elbow="positive"),
    "Bezier 3R, free start": sm.Problem(LIMITED, BEZIER, elbow="positive"),
    "Bezier 3R, any elbow": sm.Problem(FREE, BEZIER),
    "Kazerounian–Wang 4R": sm.Problem(
        sm.PlanarArm([7, 7, 4, 1.5], direction=np.radians(-60)), sm.Circle([6, 4], 4)
    ),
    **{f"6R, {name}, start": from_start(QUESTIONS[name]) for name in ("fixed base", "moving base")},
    **{f"6R, {name}, free start": QUESTIONS[name].problem() for name in ("fixed base", "moving base")},
}  # fmt: skip


def row(name, plan):
    """Return a line of a table."""
    last = plan.certificate.levels[-1]
    return f"{name:28} {plan.gap:8.1e} {plan.wall_time_s:7.2f} s {last.slices:6d} slices {last.cells:8d} cells"


def main():
    """Print both tables."""
    for name, problem in CASES.items():
        for gap in GAPS:
            print(row(name, sm.plan(problem, sm.Global(gap, 120.0))), flush=True)
    circle = sm.Circle([40, 20], 12)
    for laps in LAPS:
        path = sm.Concatenation([circle] * laps) if laps > 1 else circle
        print(row(f"circle, {laps} laps", sm.plan(sm.Problem(LIMITED, path), sm.Global(1e-3, 120.0))), flush=True)
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB at most")


if __name__ == "__main__":
    main()
