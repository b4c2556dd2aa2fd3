"""Look at every posture that the arm could take along a path.

At each point of the path the directions u of the last link that the arm can hold are a few intervals, exact and per
elbow. All of them along the path are the angle domain. A joint limit cuts a part of it away.
"""

import sys
from pathlib import Path

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
free = sm.angle_domain(sm.PlanarArm([30, 30, 20]), path)
limited = sm.angle_domain(sm.PlanarArm([30, 30, 20], limits=[None, (0.3, 2.5), (-1.2, 1.2)]), path)

for r in (0.0, 0.5, 1.0):
    print(f"r = {r}: free    {free(r, 'positive')}")
    print(f"         limited {limited(r, 'positive')}")
half = limited(0.5, "positive")
print(f"half-way the limits leave {half.measure:.4f} of {free(0.5, 'positive').measure:.4f} rad")
print("is u = 0.3 among it?", 0.3 in half, "- and u = -1.5?", -1.5 in half)

with plot.figure(width=7, height=3.2, columns=2) as (canvas, (left, right)):
    plot.draw_domain(left, free, 0, causes=True)
    plot.draw_domain(right, limited, 0, causes=True)
    left.set_title("without joint limits")
    right.set_title("θ2 in [0.3, 2.5], θ3 in [−1.2, 1.2]")
    right.set_ylim(left.get_ylim())
    canvas.savefig(folder / "02_the_angle_domain.png", dpi=200)
