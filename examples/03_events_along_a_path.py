"""Ask whether a continuous motion exists, and if not, where it ends and why.

Every point of this straight path can be reached inside the joint limits. Yet no motion gets through: the part of the
angle domain that the arm starts on dies before the end of the path. Events say where, and which joints do it.
"""

import sys
from pathlib import Path

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
arm = sm.PlanarArm([1, 1, 1], limits=[(-1.45, 1.45)] * 3)
path = sm.Line([1.5, -2.5], [1.5, 2.5])
structure = (domain := sm.angle_domain(arm, path)).structure

print(len(structure.events), "events; those in which connected parts come and go:")
for event in structure.events:
    if event.kind.startswith("component"):
        print(" ", event.text(arm.branches))
print("connected parts of the whole domain:", structure.n_components)
print("is there a continuous motion?", structure.is_connected)

starts = [k for k, sheet in enumerate(structure.sheets) if sheet.r[0] == 0]
last = max(structure.sheets[j].r[1] for k in starts for j in structure.reachable[k])
print(f"from the start a motion gets to r = {last:.10f}, y = {path(last)[1]:.6f}, and no further")

with plot.figure(width=7, height=4, columns=2) as (canvas, panels):
    for branch, axes in enumerate(panels):
        plot.draw_domain(axes, domain, branch, causes=True)
        axes.axvline(last, color="black", linestyle=":")
        axes.set_title(f"{arm.branches[branch]} elbow; dotted: where it ends")
    canvas.savefig(folder / "03_events_along_a_path.png", dpi=200)
