"""What fuzzing starts from: small valid inputs of every kind.

Plans and timed trajectories take seconds to make, and are kept in `seeds`; ``python tests/fuzz/fuzz_samples.py`` makes
them anew.
"""

import json
import sys
from pathlib import Path

import numpy as np

SEEDS = Path(__file__).parent / "seeds"
ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"

POINTS = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]
LINE = {"kind": "line", "start": [50, 0], "end": [40, 30]}
SPACE_LINE = {"kind": "line", "start": [0.4, -0.1, 0.3], "end": [0.4, 0.1, 0.4]}
PLANAR = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3.14], None]}
PLACED = {**PLANAR, "placement": {"unit": "mm", "plane": "xz", "base": [0, 0, 1], "joints": ["a", "b", "c"]}}
PANDA = {"kind": "named", "name": "panda", "tool": {"translation": [0, 0, 0.1], "rpy": [0, 0, 1]}}
RAIL = {"kind": "named", "name": "irb120", "rail": {"axis": [0.1, 1, 0], "limits": [-0.5, 0.5]}}
URDF = {"kind": "urdf", "file": "arm.urdf", "base": "panda_link0", "tip": "panda_link8"}
PSO = {"kind": "pso", "variant": "seed", "population": 20, "iterations": 100, "bounds": [0, 15], "seed": 1}

PLANE_PATHS = [
    {"kind": "bezier", "control_points": POINTS},
    {"kind": "clothoid", "center": [60, 0], "scale": 5, "coefficients": [0, -4, 0, 0.33], "t_range": [-4.712, 0]},
    {"kind": "line", "start": [40, 0], "end": [40, 30]},
    {"kind": "arc", "center": [50, 0], "radius": 5, "start_angle": 0, "sweep": 1},
    {"kind": "circle", "center": [50, 0], "radius": 5, "start_angle": 0.5, "clockwise": True},
    {"kind": "ellipse", "center": [50, 0], "radii": [5, 3], "rotation": 0.1, "start_angle": 0, "sweep": 6.28},
    {"kind": "lissajous", "center": [50, 0], "radii": [5, 3], "frequencies": [3, 2], "phase": 0.1},
    {"kind": "rose", "center": [50, 0], "radius": 5, "petals": 3, "sweep": 3.14, "rotation": 0.1},
    {"kind": "waypoints", "points": [[50, 0], [60, 0], [60, 5]], "interpolation": "spline"},
    {"kind": "reversed", "path": LINE},
    {"kind": "arc_length", "path": {"kind": "bezier", "control_points": [[50, 0], [60, 10], [50, 20]]}},
    {"kind": "concatenation", "parts": [LINE, {"kind": "line", "start": [40, 30], "end": [30, 30]}]},
    {"kind": "transformed", "path": LINE, "scale": 1.1, "rotation": 0.1, "translation": [1, 2]},
    {"kind": "file", "file": "points.csv", "interpolation": "spline", "unit": "m", "scale": 1.0},
    {"kind": "svg", "file": "letter.svg", "arm_unit": "mm", "gaps": "line"},
    {"kind": "dxf", "file": "bracket.dxf", "arm_unit": "mm", "subpath": 0, "tolerance": 0.1},
    {"kind": "gcode", "file": "pocket.nc", "arm_unit": "mm", "dimension": 2, "gaps": "line"},
]
SPACE_PATHS = [
    {"kind": "pose", "position": SPACE_LINE, "orientation": [0, 1, 0, 0]},
    {"kind": "pose", "position": SPACE_LINE, "orientations": [[1, 0, 0, 0], [0, 1, 0, 0]], "at": [0, 1]},
    {"kind": "pose", "position": SPACE_LINE, "follow": {"axis": "x", "up": [0, 0, -1]}},
    {
        "kind": "pose_waypoints",
        "poses": [[0.4, 0, 0.3, 1, 0, 0, 0], [0.4, 0.1, 0.3, 0, 1, 0, 0]],
        "parameter": "length",
    },
    {
        "kind": "placed",
        "path": {"kind": "pose", "position": SPACE_LINE, "orientation": [[1, 0, 0], [0, -1, 0], [0, 0, -1]]},
        "frame": {"normal": [1, 0, 0], "x_axis": [0, 1, 0], "translation": [0.1, 0, 0]},
        "tool": {"translation": [0, 0, 0.1], "quaternion": [1, 0, 0, 0]},
    },
]
PLANNERS = [
    {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4], "optimizer": PSO, "ranking": "integral"},
    {"kind": "harmonics", "span": [0.5], "harmonics": 3, "optimizer": {"kind": "cma", "seed": 3}},
    {"kind": "bspline", "offset": None, "span": [0.5], "coefficients": 6, "optimizer": {"kind": "ga"}},
    {"kind": "modules", "moving_bases": [LINE], "offset": [0.4, 0.5], "amplitude": [0.1, 0.1], "optimizer": PSO},
    {"kind": "moving_base", "optimizer": {"kind": "gwo"}, "control_points": 4, "around": [LINE], "spread": 0.5},
    {"kind": "refine", "starts": 3, "seed": 1, "tolerance": 1e-3, "time_limit": 5, "initial": None},
    {"kind": "global", "gap": 1e-3, "time_limit": 5},
    {"kind": "widest", "margin": "clearance", "tolerance": 0.1, "gap": 1e-2, "time_limit": 5},
    None,
]
PLANE_OBSTACLES = [
    {"circle": {"center": [30, -30], "radius": 4}},
    {"name": "clamp", "polygon": [[40, -20], [44, -20], [44, -12], [42, -16]]},
    {"half_plane": {"point": [0, -60], "normal": [0.1, 1]}},
]
SPACE_OBSTACLES = [
    {"sphere": {"center": [0.4, 0.4, 0.1], "radius": 0.05}},
    {"name": "crate", "box": {"center": [0, 0.5, 0.3], "size": [0.1, 0.2, 0.3], "rpy": [0, 0, 0.3]}},
    {"capsule": {"from": [0.5, 0.5, 0], "to": [0.5, 0.5, 1], "radius": 0.03}},
    {"half_space": {"point": [0, 0, -0.5], "normal": [0, 0, 1]}},
]
OPTIONS = {
    "start": {"u": [0.3]}, "end": None, "elbow": "any", "cyclic": False, "weights": [1, 2, 3],
    "objective": "joint_travel", "samples": 100, "obstacles": [],
}  # fmt: skip


def problems():
    """Return problems as plain data: every kind of path, every kind of planner, arms of the plane and in space."""
    plane = [
        {"arm": (PLANAR, PLACED)[k % 2], "path": path, "planner": PLANNERS[k % len(PLANNERS)], **OPTIONS}
        for k, path in enumerate(PLANE_PATHS)
    ]
    long = {"kind": "planar", "links": [30, 30, 20, 5]}
    plane.append({"arm": long, "path": {**LINE, "direction": 0.3}, "branch": "positive"})
    around = {"clearance": 0.5, "self_collision": True, "least_singular_value": 0.01}
    plane.append({"arm": {**PLANAR, "thickness": [1, 2, 1]}, "path": LINE, "obstacles": PLANE_OBSTACLES, **around})
    space = [{"arm": (PANDA, RAIL, URDF)[k % 3], "path": path, "samples": 50} for k, path in enumerate(SPACE_PATHS)]
    space.append({"arm": PANDA, "path": SPACE_PATHS[0], "obstacles": SPACE_OBSTACLES, **around, "clearance": 0.01})
    return [*plane, *space]


def companions(folder):
    """Put the files that the problems name into a folder."""
    drawings = EXAMPLES / "drawings"
    for name in ("letter.svg", "bracket.dxf", "pocket.nc"):
        (folder / name).write_bytes((drawings / name).read_bytes())
    (folder / "arm.urdf").write_bytes((ROOT / "src/selfmotion/arms/data/panda.urdf").read_bytes())
    (folder / "points.csv").write_text("x,y\n50,0\n60,0\n60,5\n")


_NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
SVG = [
    (EXAMPLES / "drawings/letter.svg").read_bytes(),
    f"""<svg {_NS} width="100mm" height="100mm" viewBox="0 0 100 100">
<style>.a {{ stroke: red; display: inline }} .b {{ display: none }}</style>
<defs><g id="g"><rect x="1" y="2" width="30" height="20" rx="3" ry="2"/></g><symbol id="s"><path d="M0 0h5"/></symbol>
</defs><use xlink:href="#g" x="5" y="5" transform="rotate(30 5 5) skewX(10)"/><use href="#s"/>
<circle cx="50" cy="50" r="25" class="a"/><ellipse cx="50" cy="50" rx="20" ry="10"/><line x1="0" y1="0" x2="9" y2="9"/>
<polyline points="0,0 10,0 10,10"/><polygon points="0 0 10 0 10 10" style="stroke:blue;visibility:hidden"/>
<path d="m 10 10 c 1,2 3,4 5,6 s 1 2 3 4 q 1 1 2 2 t 3 3 a 5 6 30 1 0 9 9 z" transform="matrix(1 0 0 1 2 3)"/>
<text x="3" y="4">A</text><image href="x.png"/></svg>""".encode(),
    f'<svg {_NS} width="4cm" height="4cm" viewBox="0 0 4 4"><svg x="1" y="1" width="2" height="2" viewBox="0 0 8 8">'
    f'<path d="M1e0-1.5.5.5L3 3V2H1Z"/></svg></svg>'.encode(),
]


def _dxf(*entities, header="9\n$INSUNITS\n70\n4\n", blocks="", version="AC1009"):
    text = f"0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\n{version}\n{header}0\nENDSEC\n"
    text += f"0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n" if blocks else ""
    return (text + "0\nSECTION\n2\nENTITIES\n" + "".join(entities) + "0\nENDSEC\n0\nEOF\n").encode()


def _tags(name, **values):
    return f"0\n{name}\n8\n0\n" + "".join(f"{code[1:]}\n{value}\n" for code, value in values.items())


_POLY = "0\nLWPOLYLINE\n100\nAcDbEntity\n8\n0\n100\nAcDbPolyline\n90\n3\n70\n1\n10\n0\n20\n0\n42\n0.5\n10\n9\n20\n0\n10\n9\n20\n9\n"  # noqa: E501
_SPLINE = (
    "0\nSPLINE\n100\nAcDbEntity\n8\n0\n100\nAcDbSpline\n70\n8\n71\n3\n72\n8\n73\n4\n74\n0\n"
    + "".join(f"40\n{k}\n" for k in (0, 0, 0, 0, 1, 1, 1, 1))
    + "".join(f"10\n{x}\n20\n{y}\n30\n0\n" for x, y in ((0, 0), (1, 2), (3, 2), (4, 0)))
)
_ELLIPSE = "0\nELLIPSE\n100\nAcDbEntity\n8\n0\n100\nAcDbEllipse\n10\n0\n20\n0\n30\n0\n11\n4\n21\n0\n31\n0\n40\n0.5\n41\n0\n42\n3\n"  # noqa: E501
_BLOCK = (
    "0\nBLOCK\n8\n0\n2\nB\n70\n0\n10\n0\n20\n0\n30\n0\n3\nB\n"
    + _tags("LINE", c10=0, c20=0, c11=5, c21=5)
    + "0\nENDBLK\n8\n0\n"
)
DXF = [
    (EXAMPLES / "drawings/bracket.dxf").read_bytes(),
    _dxf(_POLY, _tags("CIRCLE", c10=5, c20=5, c40=2), version="AC1015"),
    _dxf(_SPLINE, _ELLIPSE, version="AC1015"),
    _dxf(_tags("INSERT", c2="B", c10=1, c20=2, c41=2, c42=-1, c50=30, c70=2, c71=2, c44=10, c45=10), blocks=_BLOCK),
    _dxf(_tags("ARC", c10=0, c20=0, c40=5, c50=0, c51=90, c210=0, c220=0, c230=-1), _tags("TEXT", c1="A", c40=2)),
]
GCODE = [
    (EXAMPLES / "drawings/pocket.nc").read_bytes(),
    b"G21 G90 G17\nG0 X0 Y0 Z1\nG1 Z-1 F100\nG2 X10 Y0 I5 J0\nG3 X0 Y0 R5\nG18 G2 X4 Z-1 I2 K0\nG17\nG91 G1 X1 Y1\nM30\n",  # noqa: E501
    b"; comment\nG20 G90.1\nT1 M6\nG54\nG0 X0 Y0\nG1 X1 Y1\nG4 P1\nG2 X3 Y1 I2 J1\nG91.1 G61\nG1 X1.5 F5. S3\nM9 M2\n",
]
CSV = [
    b"x,y\n50,0\n60,0\n60,5\n",
    b"r;x;y;z;qx;qy;qz;qw\n0;0.4;0;0.3;0;0;0;1 # comment\n1;0.4;0.1;0.3;1;0;0;0\n",
    b'"x"\t"y"\t"z"\n1\t2\t3\n4\t5\t6e-1\n',
]
POINTS_JSON = [
    [[0, 0], [1, 1], [2, 0]],
    [{"x": 0, "y": 0, "z": 1}, {"x": 1, "y": 1, "z": 1}],
    {
        "unit": "mm",
        "columns": ["x", "y", "z", "qx", "qy", "qz", "qw"],
        "points": [[1, 2, 3, 0, 0, 0, 1], [2, 2, 3, 0, 0, 1, 0]],
    },
]
MOTION_CSV = [b"r,q1,q2,q3,u1\n0,0.1,0.2,0.3,0.5\n0.5,0.2,0.2,0.3,0.5\n1,0.3,0.2,0.3,0.5\n"]
URDFS = [
    (ROOT / "src/selfmotion/arms/data/panda.urdf").read_bytes(),
    (ROOT / "src/selfmotion/arms/data/ur5e.urdf").read_bytes(),
]


def points_npy():
    """Return tables of points as NumPy writes them."""
    import io

    found = []
    named = np.zeros(3, dtype=[("x", "f8"), ("y", "f4")])
    named["x"] = [1, 2, 3]
    for array in (np.arange(6.0).reshape(3, 2), np.arange(9).reshape(3, 3), named):
        stream = io.BytesIO()
        np.save(stream, array)
        found.append(stream.getvalue())
    return found


def checksummed(data):
    """Return the text of a plan file, its checksum right again."""
    from selfmotion.exchange.plan_file import _checksum

    rest = {key: value for key, value in data.items() if key != "checksum"}
    return json.dumps({**rest, "checksum": _checksum(rest)})


def write_seeds():
    """Make the plans and timed trajectories."""
    import selfmotion as sm
    from selfmotion.exchange.plan_file import plan_bytes
    from selfmotion.exchange.timed_file import FORMS

    arm = sm.PlanarArm([0.5, 0.4, 0.3], [None, (0, np.pi), None])
    path = sm.Bezier([[0.7, -0.3], [0.9, 0.2], [0.4, 0.5], [0.2, 0.7]])
    problem = sm.Problem(arm, path, samples=20)
    spanned = sm.PSO(population=8, iterations=4, seed=1)
    slow = sm.PSO(population=8, iterations=4, bounds=(0, 2), seed=1)
    short = sm.Problem(sm.named_arm("panda"), sm.PosePath(sm.Line([0.45, 0, 0.4], [0.45, 0.02, 0.4]), [0, 1, 0, 0]))
    six = sm.Problem(sm.PlanarArm([30, 30, 20, 15, 15, 10]), sm.Line([75, 10], [70, 30]), samples=20)
    optimizer = sm.PSO(population=8, iterations=4, bounds=(0, 1), seed=1)
    modules = sm.Modules([sm.Line([55, 5], [50, 20])], offset=[0.4, 0.5], amplitude=[0.1, 0.1], optimizer=optimizer)
    plans = {
        "sinusoid": sm.plan(problem, sm.Sinusoid([0.3], amplitude=[0.4], optimizer=slow)),
        "bspline": sm.plan(problem, sm.BSpline([0.3], span=[0.5], coefficients=5, optimizer=spanned)),
        "spline": sm.plan(problem, sm.Refine(starts=1, time_limit=5, tolerance=1e-2)),
        "global": sm.plan(sm.Problem(arm, sm.Line([0.7, 0], [0.7, 0.1]), samples=20), sm.Global(gap=0.5, time_limit=5)),
        "panda": sm.plan(short, sm.Refine(starts=1, time_limit=5, tolerance=1e-2)),
        "modules": sm.plan(six, modules),
    }
    SEEDS.mkdir(exist_ok=True)
    for name, plan in plans.items():
        data = json.loads(plan_bytes(plan))
        if data["certificate"] is not None:  # of which a little says all
            data["certificate"]["tube"] = data["certificate"]["tube"][:3]
        (SEEDS / f"plan-{name}.json").write_text(checksummed(data))
    timed = sm.time_law(plans["spline"], 5.0, 1.0, rate=4.0)
    for form, made in FORMS.items():
        (SEEDS / f"trajectory.{form}").write_bytes(made(timed))


if __name__ == "__main__":
    sys.exit(write_seeds())
