"""A plan as one page that can be sent: the studio's pictures with all that they need inside."""

from __future__ import annotations

import base64
import html
import json
import re
from pathlib import Path
from typing import Any

from selfmotion._version import __version__
from selfmotion.plans import Plan
from selfmotion.plot import plan_figures
from selfmotion.studio.motions import plan_object
from selfmotion.studio.panels import Around, domain
from selfmotion.studio.scene import scene

_PAGE = Path(__file__).parent / "page"
_MODULES = (
    "arm", "domain", "evolution", "hover", "joints", "looks", "numbers", "obstacles", "player", "plot", "pointer",
    "report", "space", "spline", "svg", "verdict",
)  # fmt: skip
_MOST_STORED = 1_000_000  # characters of a plan file that goes along
_PLACEHOLDER = re.compile(r"\{\{(\w+)\}\}")


def report_page(plan: Plan, data: dict[str, Any], text: str, title: str) -> bytes:
    """Return a plan as a page of HTML.

    Parameters
    ----------
    plan : Plan
    data : dict
        The problem as its file has it.
    text : str
        The problem file itself.
    title : str
        What the page is called.

    Returns
    -------
    bytes
        UTF-8. The page loads nothing: scripts, styles and numbers are inside. Where scripts are not run it shows the
        figures of :func:`~selfmotion.plot.plan_figures`.
    """
    made = plan_object(plan)
    stored = made.pop("plan")
    shown = {
        "scene": scene(plan.problem, data),
        "domain": domain(plan.problem, _around(plan)),
        "plan": made,
        "problem": text,
        "stored": stored if len(stored) <= _MOST_STORED else None,
    }
    values = {
        "title": html.escape(title),
        "version": html.escape(__version__),
        "style": (_PAGE / "studio.css").read_text("utf-8") + (_PAGE / "report.css").read_text("utf-8"),
        "importmap": json.dumps({"imports": {f"selfmotion/{name}": _address(name) for name in _MODULES}}),
        "data": json.dumps(shown, allow_nan=False).replace("<", "\\u003c"),
        "pictures": _pictures(plan),
    }
    page = (_PAGE / "report.html").read_text("utf-8")
    return _PLACEHOLDER.sub(lambda found: values[found[1]], page).encode()


def _around(plan: Plan) -> Around | None:
    """Return the plan's own curve, about which components are varied where there are several."""
    problem = plan.problem
    if problem.arm.n_u == 1:
        return None
    return Around(problem.grid, plan.u(problem.grid), int(problem.arm.branch_of(plan(0.0))))


def _address(name: str) -> str:
    """Return a module of the page as an address that holds it."""
    return f"data:text/javascript;base64,{base64.b64encode((_PAGE / f'{name}.js').read_bytes()).decode()}"


def _pictures(plan: Plan) -> str:
    """Return the plan's figures, for readers whose programs run no scripts."""
    figures = {Path(name).stem: image for name, image in plan_figures(plan).items() if name.endswith(".png")}
    return "".join(
        f'<img alt="{html.escape(name)}" src="data:image/png;base64,{base64.b64encode(image).decode()}">'
        for name, image in figures.items()
    )
