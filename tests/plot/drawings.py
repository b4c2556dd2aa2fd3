"""The table of drawings whose look is tested: a new drawing function is one more row in `DRAWINGS`.

After a row is added or a picture changed on purpose, look at the picture, then renew the baseline:

    .venv/bin/python tests/plot/drawings.py            # writes thumbnails.json
    .venv/bin/python tests/plot/drawings.py look DIR   # writes each picture as DIR/name.png, to look at
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache, cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import selfmotion as sm
from selfmotion import plot
from selfmotion.certificate.result import Certificate, Level, TubeSlice
from selfmotion.domain import SampledDomain
from selfmotion.optimizers import OPTIMIZERS
from selfmotion.scene import CircleObstacle, HalfPlaneObstacle, PolygonObstacle

EXAMPLES = Path(__file__).parents[2] / "examples"
BASELINE = Path(__file__).with_name("thumbnails.json")
ROWS, COLUMNS = 24, 32


class Case:
    """What the drawings show: the seed's 3R case, computed when it is first asked for."""

    path = sm.Bezier([[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]])
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
    free = sm.PlanarArm([30, 30, 20])

    @cached_property
    def problem(self):
        return sm.Problem(self.arm, self.path)

    @cached_property
    def free_problem(self):
        return sm.Problem(self.free, self.path)

    @cached_property
    def gap_problem(self):
        """A limit on θ2 cuts the middle out of the interval."""
        return sm.Problem(sm.PlanarArm([30, 30, 20], [None, (-1.5, 1.5), None]), self.path)

    @cached_property
    def corner(self):
        """A point with a larger ψ than the path has."""
        return sm.Problem(self.free, sm.Line([45, 45], [46, 45]))

    @cached_property
    def plan(self):
        return sm.plan(self.problem, sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(seed=1, bounds=(0, 2))))

    base = sm.Bezier([[80, 30], [70, 30], [70, 10], [80, -21]])

    @cached_property
    def modules(self):
        """The seed's 6R case, hardly searched."""
        path = sm.Clothoid(center=[110, 20], scale=25, coefficients=[0, -4, 0, 0.33], t_range=[-4.712, 0])
        arm = sm.PlanarArm([30] * 6, [None, (0, np.pi), None] * 2)
        search = sm.PSO(seed=1, bounds=(0, 1), population=6, iterations=4)
        return sm.plan(sm.Problem(arm, path), sm.Modules([self.base], [0.35, 0], [0.4, 0.4], search))

    @cached_property
    def many(self):
        """An arm of twelve links, two of them limited where the motion comes near."""
        limits = [None, (-0.3, 0.3), *[None] * 9, (-0.2, 2.0)]
        path = sm.Line((8, -2), (6, 5))
        return sm.plan(sm.Problem(sm.PlanarArm([1] * 12, limits), path), sm.Refine(starts=1))

    @cached_property
    def cornered(self):
        """A plan round two corners."""
        path = sm.Waypoints([[50, -10], [60, 30], [40, 40], [30, 50]])
        return sm.plan(sm.Problem(self.arm, path, samples=100), sm.Refine(starts=1))

    def timed(self, velocity):
        return sm.time_law(self.cornered, 8.0, velocity)

    @cached_property
    def searches(self):
        """Made-up courses of 9 searches each, (9, 40), falling towards 1 at different speeds."""
        rng, k = np.random.default_rng(3), np.arange(40)
        return {
            name: 1 + rng.uniform(0.5, 2, (9, 1)) * 10 ** (-speed * k * rng.uniform(0.6, 1.4, (9, 1)))
            for name, speed in (("GA", 0.05), ("PSO", 0.1), ("GWO", 0.2))
        }

    @cached_property
    def ends(self):
        return {name: best[:, -1] - 1 for name, best in self.searches.items()}

    @cached_property
    def broken(self):
        """A sampled motion (r, q) on the other elbow for a while, and its breaks."""
        r = np.linspace(0, 1, 121)
        q = self.free.solve(self.path(r), 0.3 + 0.4 * np.sin(3.4 * r)[:, None], 0)[0]
        q[50:62] = self.free.solve(self.path(r[50:62]), [0.6], 1)[0]
        return r, q, sm.connectivity(self.free_problem, r, q).breaks

    @cached_property
    def proved(self):
        return with_proof(self.plan, 1.001, [0.97, 0.99])

    @cached_property
    def rival(self):
        return sm.plan(
            self.problem, sm.Sinusoid([0.3], amplitude=[0.4], optimizer=sm.PSO(bounds=(1.4, 1.5), iterations=1))
        )

    @cached_property
    def through_folds(self):
        """Limits that part the elbows for a while, and a proof that leaves a second way."""
        arm = sm.PlanarArm([1, 1, 1], [(-2.2, 2.2)] * 3)
        problem = sm.Problem(arm, sm.Line([1.5, -2.5], [1.5, 2.5]))
        return with_proof(sm.plan(problem, sm.Refine(starts=4)), 1.01, [0.9, 0.99], mirrored=True)

    @cached_property
    def proofs(self):
        return {"one": self.proved.certificate, "another": self.through_folds.certificate}

    @cached_property
    def without_folds(self):
        """An arm that never stretches on its path: its elbows are not connected."""
        problem = sm.Problem(sm.PlanarArm([1, 1, 0.6]), sm.Line([0.5, -0.3], [0.9, 0.6]), elbow="negative")
        return with_proof(sm.plan(problem, sm.Refine(starts=1)), 1.01, [0.9, 0.99])

    @cached_property
    def domain(self):
        return sm.angle_domain(self.arm, self.path)

    @cached_property
    def eventful(self):
        """Intervals that open, close and merge, bounded by limits of all joints."""
        arm = sm.PlanarArm([7, 7, 4, 1.5], [(-2, 2), None, (-1.6, 1.6), (-1, 2.5)], direction=-np.pi / 3)
        return sm.angle_domain(arm, sm.Circle([6, 4], 4))

    @cached_property
    def in_space(self):
        """A spatial arm's domain with limits, folds and a hole, and a made-up motion through it."""
        problem, _ = sm.load_problem(EXAMPLES / "panda_line.yaml")
        sampled = SampledDomain(sm.angle_domain(problem.arm, problem.path), [2], 60)
        r = np.linspace(0, 1, 50)
        u = np.array([sampled.domain(x, 2).intervals[0].mean() for x in r])
        return sampled, 2, (r, u, r < 0.8)

    @cached_property
    def between(self):
        """The seed's arm with thick links between a disc, a polygon that is not convex, and a wall."""
        arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None], thickness=3)
        corners = [[36, -20], [44, -20], [44, -12], [40, -16], [36, -12]]
        obstacles = [
            CircleObstacle([30, 24], 4),
            PolygonObstacle(corners, name="clamp"),
            HalfPlaneObstacle([0, -24], [0.1, 1]),
        ]
        return sm.Problem(arm, self.path, obstacles=obstacles, clearance=1.0)

    @cached_property
    def round_them(self):
        return sm.plan(self.between, sm.Refine(starts=2))

    @cached_property
    def holed(self):
        return sm.angle_domain(self.between.arm, self.path)

    @cached_property
    def parted(self):
        """Limits and folds, and no connection between start and end."""
        return sm.angle_domain(sm.PlanarArm([1, 1, 1], [(-1.45, 1.45)] * 3), sm.Line([1.5, -2.5], [1.5, 2.5]))

    @cached_property
    def curve(self):
        r = np.linspace(0, 1, 201)
        return {"this plan": (r, self.plan.u(r)[:, 0])}


def with_proof(plan, bound, rounds, mirrored=False):
    """Return a plan with a made-up proof: its cost over `bound`, parts of that in `rounds`, and a tube.

    On a path that is its own mirror image the mirrored motion costs the same, so that it is left as well.
    """
    arm, cost = plan.problem.arm, plan.cost
    levels = [
        Level(25 * 2**k, 3000 * 3**k, part * cost / bound, cost, 0.4 * 3**k) for k, part in enumerate([*rounds, 1])
    ]
    tube = []
    for r in np.linspace(0, 1, 41):
        ways = [plan([r])[0], -plan([1 - r])[0]][: 1 + mirrored]
        along = [np.linalg.svd(arm.jacobian(q))[2][-1] for q in ways]
        a, b = (np.array([q + side * t for q, t in zip(ways, along, strict=True)]) for side in (-0.1, 0.1))
        tube.append(TubeSlice(float(r), a, b))
    plan.certify(Certificate(cost / bound, "made up", tuple(levels), tuple(tube)))
    return plan


class Drawing(NamedTuple):
    """One row: what is drawn, from which part of the case, and how large.

    Attributes
    ----------
    draw : callable
        Takes an Axes and the arguments.
    arguments : callable
        Case to a tuple of arguments.
    height : float
        Of the figure [inch]; its width is one column.
    ink : tuple of float
        Least and largest part of the picture that is not white.
    """

    draw: Callable[..., None]
    arguments: Callable[[Case], tuple[Any, ...]]
    height: float = 2.6
    ink: tuple[float, float] = (0.02, 0.5)


def each_joint(axes: Any, plan: sm.planners.Plan) -> None:
    """Draw every joint into one and the same panel."""
    plot.draw_each_joint([axes] * plan.problem.arm.n, plan)


each_joint.func = plot.draw_each_joint  # what the table of drawing functions is compared with


def obstacles(axes: Any, arm: Any) -> None:
    """Draw obstacles in a frame that shows them."""
    axes.set_xlim(-10, 60)
    axes.set_ylim(-35, 35)
    axes.set_aspect("equal")
    plot.draw_obstacles(axes, arm)


def links(axes: Any, plan: sm.planners.Plan) -> None:
    """Draw the links of the first posture of a plan."""
    arm = plan.problem.arm
    axes.set_xlim(-10, 80)
    axes.set_ylim(-40, 50)
    axes.set_aspect("equal")
    plot.draw_links(axes, arm, arm.joint_positions(plan(0.0)))


obstacles.func, links.func = plot.draw_obstacles, plot.draw_links
DRAWINGS = {
    "path": Drawing(plot.draw_path, lambda case: (case.problem,)),
    "postures": Drawing(plot.draw_postures, lambda case: (case.plan,), height=3.2),
    "obstacles": Drawing(obstacles, lambda case: (case.between.arm,), height=3.2),
    "links": Drawing(links, lambda case: (case.round_them,), height=3.2),
    "path_between_obstacles": Drawing(plot.draw_path, lambda case: (case.between,), height=3.2),
    "postures_between_obstacles": Drawing(plot.draw_postures, lambda case: (case.round_them,), height=3.2),
    "domain_with_holes": Drawing(
        partial(plot.draw_domain, causes=True), lambda case: (case.holed, 0), height=3.6, ink=(0.2, 0.8)
    ),
    "drawing": Drawing(
        plot.draw_drawing,
        lambda _: (sm.read_svg(EXAMPLES / "drawings" / "letter.svg", arm_unit="mm", gaps="line"),),
        height=3.2,
    ),
    "drawing_gaps": Drawing(
        plot.draw_drawing, lambda _: (sm.read_dxf(EXAMPLES / "drawings" / "bracket.dxf", arm_unit="mm"),), height=3.2
    ),
    "drawing_in_space": Drawing(
        plot.draw_drawing, lambda _: (sm.read_svg(EXAMPLES / "drawings" / "letter.svg", lift=0.02),), height=3.2
    ),
    "joints": Drawing(plot.draw_joints, lambda case: (case.plan,)),
    "joints_many": Drawing(plot.draw_joints, lambda case: (case.many,)),
    "postures_six": Drawing(plot.draw_postures, lambda case: (case.modules,)),
    "each_joint": Drawing(each_joint, lambda case: (case.plan,)),
    "parameter": Drawing(plot.draw_parameter, lambda case: (case.plan,)),
    "joints_absolute": Drawing(plot.draw_joints, lambda case: (case.modules, range(3, 6), [3])),
    "modules": Drawing(plot.draw_modules, lambda case: (case.modules, [case.base])),
    "modules_end": Drawing(plot.draw_modules, lambda case: (case.modules, [case.base], 1.0)),
    "domain": Drawing(plot.draw_domain, lambda case: (case.domain, 0), ink=(0.2, 0.7)),
    "motion_in_domain": Drawing(plot.draw_domain, lambda case: (case.domain, 0, case.curve), ink=(0.2, 0.7)),
    **{
        f"domain_causes_{name}_{branch}": Drawing(
            partial(plot.draw_domain, causes=True),
            lambda case, name=name, branch=branch: (getattr(case, name), branch),
            height=3.6,
            ink=(0.1, 0.6),
        )
        for name in ("eventful", "parted")
        for branch in (0, 1)
    },
    "sampled_domain": Drawing(plot.draw_sampled_domain, lambda case: case.in_space, height=3.4, ink=(0.1, 0.6)),
    "optimum": Drawing(
        plot.draw_optimum, lambda case: (case.proved, {"another": case.rival}), height=3.2, ink=(0.2, 0.7)
    ),
    "optimum_unfolded": Drawing(plot.draw_optimum, lambda case: (case.through_folds,), height=3.2, ink=(0.2, 0.7)),
    "optimum_apart": Drawing(plot.draw_optimum, lambda case: (case.without_folds,), height=3.2, ink=(0.2, 0.7)),
    "tube": Drawing(plot.draw_tube, lambda case: (case.proved,), ink=(0.1, 0.7)),
    "proof": Drawing(
        plot.draw_proof, lambda case: ({"one": case.proved.certificate, "two": case.through_folds.certificate},)
    ),
    "proof_time": Drawing(
        partial(plot.draw_proof, against="seconds"), lambda case: ({"one": case.proved.certificate},)
    ),
    "velocities": Drawing(plot.draw_velocities, lambda case: (case.timed(2.0),)),
    "velocities_unlimited": Drawing(plot.draw_velocities, lambda case: (case.timed(None),)),
    "samples_broken": Drawing(plot.draw_samples, lambda case: (case.free_problem, *case.broken), height=3.2),
    "samples_connected": Drawing(plot.draw_samples, lambda case: (case.free_problem, *case.broken[:2]), height=3.2),
    "sampled_joints": Drawing(plot.draw_sampled_joints, lambda case: (case.free_problem, *case.broken)),
    "evolution": Drawing(plot.draw_evolution, lambda case: ({"PSO": case.searches["PSO"][0]},)),
    "evolution_quartiles": Drawing(plot.draw_evolution, lambda case: (case.searches, 1.0)),
    "spread": Drawing(plot.draw_spread, lambda case: ({"plain": case.ends, "shifted": case.ends},)),
    "workspace": Drawing(plot.draw_workspace, lambda case: (case.free, case.path), ink=(0.1, 0.5)),
    "workspace_all_radii": Drawing(plot.draw_workspace, lambda _: (sm.PlanarArm([30, 17, 26]),), ink=(0.1, 0.5)),
    "workspace_without_nearest": Drawing(plot.draw_workspace, lambda _: (sm.PlanarArm([1, 1, 3]),)),
    "extreme_postures": Drawing(plot.draw_extreme_postures, lambda case: (case.free_problem,), height=3.2),
    "extreme_postures_corner": Drawing(plot.draw_extreme_postures, lambda case: (case.corner,), height=3.2),
    "posture_interval": Drawing(plot.draw_posture_interval, lambda case: (case.free_problem,), ink=(0.2, 0.8)),
    "posture_interval_gap": Drawing(plot.draw_posture_interval, lambda case: (case.gap_problem,), ink=(0.1, 0.6)),
    "sweep_positive": Drawing(plot.draw_sweep, lambda case: (case.free_problem, 0.0, 0), height=3.0),
    "sweep_negative": Drawing(plot.draw_sweep, lambda case: (case.free_problem, 0.0, 1), height=3.0),
    **{
        f"flow_{kind}": Drawing(
            plot.draw_flow,
            lambda _, optimizer=OPTIMIZERS[kind]: (optimizer,),
            height=plot.flow_height(OPTIMIZERS[kind]),
            ink=(0.05, 0.5),
        )
        for kind in ("ga", "pso", "gwo", "random")
    },
}

_case = cache(Case)


@contextmanager
def drawn(name: str) -> Iterator[Any]:
    """Give the finished figure of one row, at the width of a column."""
    row = DRAWINGS[name]
    with plot.figure(height=row.height) as (canvas, (axes,)):
        row.draw(axes, *row.arguments(_case()))
        yield canvas


def luminance(canvas: Any) -> np.ndarray:
    """Return the picture's grey levels, 0 black to 1 white, shape (height, width)."""
    canvas.canvas.draw()
    rgb = np.asarray(canvas.canvas.buffer_rgba())[..., :3] / 255.0
    return rgb @ [0.2126, 0.7152, 0.0722]


def thumbnail(canvas: Any) -> np.ndarray:
    """Return the mean grey level of ROWS × COLUMNS parts of the picture."""
    grey = luminance(canvas)
    bands = np.array_split(grey, ROWS, axis=0)
    return np.array([[block.mean() for block in np.array_split(band, COLUMNS, axis=1)] for band in bands])


def write_thumbnails() -> None:
    """Write the baseline: per picture one string per row, two hexadecimal digits per grey level."""
    found = {}
    for name in DRAWINGS:
        with drawn(name) as canvas:
            levels = np.rint(255 * thumbnail(canvas)).astype(np.uint8)
        found[name] = [row.tobytes().hex() for row in levels]
    BASELINE.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def read_thumbnails() -> dict[str, np.ndarray]:
    """Return the baseline, name to array."""
    stored = json.loads(BASELINE.read_text(encoding="utf-8"))
    return {name: np.array([list(bytes.fromhex(row)) for row in rows]) / 255.0 for name, rows in stored.items()}


if __name__ == "__main__":
    if sys.argv[1:2] == ["look"]:
        folder = Path(sys.argv[2])
        folder.mkdir(parents=True, exist_ok=True)
        for name in DRAWINGS:
            with drawn(name) as canvas:
                (folder / f"{name}.png").write_bytes(plot.image_files(name, canvas)[f"{name}.png"])
    else:
        write_thumbnails()
