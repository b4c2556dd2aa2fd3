"""The animation of the page on many links: the same path, followed in two of the ways that the page compares."""

from pathlib import Path

import numpy as np
from digest import digest

import selfmotion as sm
from selfmotion.plot import figure
from selfmotion.plot.animation import Animation
from selfmotion.plot.plane import draw_base, draw_chain, frame
from selfmotion.plot.style import COLORS, GREY, INK

EXAMPLES = Path(__file__).parents[1] / "examples"
WAYS = {"modules on a given moving base": "seed_6r.yaml", "the whole arm as one": "seed_6r_refine.yaml"}
_SIZE = {"width": 7.4, "height": 2.9, "columns": 2}
_DPI = 100
_SECONDS, _FPS = 6.0, 15


def write_many_links(folder: Path):
    """Write the animation, unless neither it nor the package nor a problem changed."""
    folder.mkdir(exist_ok=True)
    key = folder / "many-links.key"
    now = digest(Path(__file__)) + "".join(digest(EXAMPLES / file) for file in WAYS.values())
    if key.exists() and key.read_text() == now:
        return
    plans = {}
    for name, file in WAYS.items():
        loaded = sm.load_problem(EXAMPLES / file)
        plans[name] = sm.plan(loaded.problem, loaded.planner)
    (folder / "many_links.gif").write_bytes(SideBySide(plans).gif())
    key.write_text(now)


class SideBySide(Animation):
    """Several plans of one path, each with the curve that the end of its third link draws, its moving base."""

    def __init__(self, plans):
        first = next(iter(plans.values()))
        r = first.problem.grid
        super().__init__(first.problem, r, first(r), _SECONDS, _FPS)
        self.plans = plans

    def frames(self, chosen=None):
        """Yield the chosen frames, or all."""
        shown = range(self.count) if chosen is None else chosen
        r = np.linspace(0.0, 1.0, self.count)
        chains = {name: plan.problem.arm.joint_positions(plan(r)) for name, plan in self.plans.items()}
        x = self.problem.path(self.problem.path.grid(800))
        everything = np.vstack([*(chain.reshape(-1, 2) for chain in chains.values()), x])
        for k in shown:
            with figure(**_SIZE) as (canvas, panels):
                canvas.set_dpi(_DPI)
                for axes, (name, chain) in zip(panels, chains.items(), strict=True):
                    axes.plot(*x.T, color=GREY, linewidth=0.9)
                    axes.plot(*chain[:, 3].T, color=COLORS[0], linewidth=0.9, linestyle="--")
                    draw_base(axes)
                    draw_chain(axes, chain[k], color=INK, linewidth=2.2, markersize=4.0)
                    axes.plot(*chain[k, 3], "o", color=COLORS[0], markersize=6.0, zorder=4)
                    axes.plot(*chain[k, -1], "o", color=COLORS[1], markersize=6.0, zorder=5)
                    frame(axes, everything, margin=0.08)
                    axes.set_title(f"{name}: F = {self.plans[name].cost:.2f}")
                panels[0].text(0.02, 0.98, f"r = {r[k]:.2f}", transform=panels[0].transAxes, va="top")
                canvas.canvas.draw()
                yield np.asarray(canvas.canvas.buffer_rgba())[..., :3].copy()
