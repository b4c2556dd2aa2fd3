"""Take the path from a drawing.

A letter as SVG, an outline as DXF, a pocket as G-code: each says its unit, each is read into lines, arcs and Bezier
curves as they were drawn. What is between strokes is nobody's to guess: the letter's are joined by `gaps`, of the
bracket only the outline is taken, and the program itself says how it steps over.
"""

import sys
from pathlib import Path

import numpy as np

import selfmotion as sm
from selfmotion import plot

folder = Path(*sys.argv[1:2])  # for the picture: the first argument, or else here
folder.mkdir(parents=True, exist_ok=True)
drawings = Path(__file__).parent / "drawings"
arm = sm.PlanarArm(links=[120, 120, 80], limits=[None, (0, np.pi), None])  # mm, and so is arm_unit
letter = sm.read_svg(drawings / "letter.svg", arm_unit="mm", gaps="line")
bracket = sm.read_dxf(drawings / "bracket.dxf", arm_unit="mm", subpath=0)
pocket = sm.read_gcode(drawings / "pocket.nc", arm_unit="mm", dimension=2)

found = (letter, bracket, pocket)
with plot.figure(width=9, height=6, columns=3, rows=2) as (canvas, axes):
    for drawing, above, below in zip(found, axes[:3], axes[3:], strict=True):
        print("\n".join(drawing.lines()))
        path = sm.Transformed(drawing.path, translation=[130, -60])  # in front of the arm
        plan = sm.plan(sm.Problem(arm, path), sm.Global(gap=1e-2))
        print(f"planned: cost {plan.cost:.3f}, no motion costs less than {plan.lower_bound:.3f}\n")
        plot.draw_drawing(above, drawing)
        plot.draw_postures(below, plan)
    canvas.savefig(folder / "12_from_a_drawing.png", dpi=200)
