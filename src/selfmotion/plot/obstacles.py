"""What stands around a planar arm: obstacles, what must stay clear about them, and links as wide as they are."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import RedundantArm
from selfmotion.constrained.arm import constraints_of, unconstrained
from selfmotion.paths.base import PLANE
from selfmotion.plot.plane import draw_circle, ray
from selfmotion.plot.style import INK, OBSTACLES, literal, tinted
from selfmotion.scene import CircleObstacle, HalfPlaneObstacle, Obstacle, PolygonObstacle

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from selfmotion.scene import Scene

_FAR = 50.0  # reaches, as far as half-planes are drawn
_NEAR = 1.05  # of the reach: what is farther away need not be in the picture
_CENTRAL = 0.2  # depth that a place gives for being nearer to the middle, as a part of how much nearer
_GRID = 300  # of the distance from a polygon, per side


def scene_of(arm: RedundantArm) -> Scene | None:
    """Return the scene that an arm works in, None if there is none."""
    from selfmotion.scene import Scene

    return next((part for part in constraints_of(arm) if isinstance(part, Scene)), None)


def draw_obstacles(axes: Axes, arm: RedundantArm) -> None:
    """Draw the obstacles of a planar arm, each with its name or number, and dashed what is to stay clear about it.

    Parameters
    ----------
    axes : Axes
    arm : RedundantArm
        Of a problem with obstacles; of any other nothing is drawn.
    """
    from matplotlib.patheffects import withStroke

    scene = scene_of(arm)
    if scene is None or arm.dimension != PLANE:
        return
    for k, obstacle in enumerate(scene.obstacles):
        color = OBSTACLES[k % len(OBSTACLES)]
        order = 2.1 if isinstance(obstacle, HalfPlaneObstacle) else 2.2  # what stands in one is seen
        look = {"facecolor": tinted(color), "edgecolor": color, "linewidth": 0.9, "zorder": order}
        _draw_shape(axes, obstacle, _FAR * arm.reach, look)
        if scene.clearance:
            _draw_outline(axes, obstacle, scene.clearance, _FAR * arm.reach, color)
        axes.annotate(
            literal(obstacle.name or str(k + 1)), _middle(obstacle, arm.reach), ha="center", va="center", fontsize=7.0,
            color=INK, zorder=2.4, annotation_clip=True,  # of obstacles outside of the picture nothing is written
            path_effects=[withStroke(linewidth=1.8, foreground=tinted(color))],
        )  # fmt: skip


def in_view(arm: RedundantArm) -> FloatArray:
    """Return points (k, 2) that a picture of the arm must show for its obstacles to be seen."""
    scene, found = scene_of(arm), [np.empty((0, 2))]
    if scene is not None and arm.dimension == PLANE:
        for obstacle in scene.obstacles:
            corners = _corners(obstacle) + np.zeros(2)
            found.append(corners[np.linalg.norm(corners, axis=1) <= _NEAR * arm.reach])
    return np.vstack(found)


def draw_links(axes: Axes, arm: RedundantArm, points: FloatArray, **look: Any) -> None:
    """Draw the links of a planar arm as wide as they are; nothing of an arm of thin lines.

    Parameters
    ----------
    axes : Axes
    arm : RedundantArm
    points : array, shape (n + 1, 2)
        From its base to its tool.
    **look
        Of the patches.
    """
    from matplotlib.patches import Polygon

    half = 0.5 * np.asarray(getattr(unconstrained(arm), "thickness", np.zeros(len(points) - 1)))
    for a, b, radius in zip(points[:-1], points[1:], half, strict=True):
        if radius > 0.0:
            along = float(np.arctan2(*(b - a)[::-1]))
            turn = np.linspace(0.5 * np.pi, 1.5 * np.pi, 25)
            outline = np.vstack([ray(a, along + turn, radius), ray(b, along + turn + np.pi, radius)])
            axes.add_patch(Polygon(outline, closed=True, **{"alpha": 0.25, "linewidth": 0.0, "zorder": 2.0, **look}))


def _draw_shape(axes: Axes, obstacle: Obstacle, far: float, look: dict[str, Any]) -> None:
    from matplotlib.patches import Circle, Polygon

    if isinstance(obstacle, CircleObstacle):
        axes.add_artist(Circle(tuple(obstacle.center), obstacle.radius, **look))
    elif isinstance(obstacle, PolygonObstacle):
        axes.add_artist(Polygon(obstacle.corners, closed=True, **look))
    elif isinstance(obstacle, HalfPlaneObstacle):
        axes.add_artist(Polygon(_half_plane(obstacle, 0.0, far), closed=True, hatch="////", **look))


def _half_plane(obstacle: HalfPlaneObstacle, clearance: float, far: float) -> FloatArray:
    """Return corners of a large part of a half-plane, moved by what is to stay clear, its edge first."""
    normal = obstacle.normal / np.linalg.norm(obstacle.normal)
    along = np.array([-normal[1], normal[0]])
    point = obstacle.point + clearance * normal
    one, two = point - far * along, point + far * along
    return np.array([one, two, two - far * normal, one - far * normal])


def _draw_outline(axes: Axes, obstacle: Obstacle, clearance: float, far: float, color: str) -> None:
    look: dict[str, Any] = {"color": color, "linewidth": 0.6, "linestyle": (0, (3, 2)), "zorder": 2.2}
    if isinstance(obstacle, CircleObstacle):
        draw_circle(axes, obstacle.center, obstacle.radius + clearance, **look)
    elif isinstance(obstacle, HalfPlaneObstacle):
        edge = _half_plane(obstacle, clearance, far)[:2]
        axes.axline(edge[0], edge[1], **look)
    elif isinstance(obstacle, PolygonObstacle):
        low, high = obstacle.corners.min(axis=0) - 1.5 * clearance, obstacle.corners.max(axis=0) + 1.5 * clearance
        x, y = (np.linspace(a, b, _GRID) for a, b in zip(low, high, strict=True))
        away = _away(np.stack(np.meshgrid(x, y), axis=-1), obstacle.corners)
        axes.contour(
            x, y, away, [clearance], colors=color, linewidths=look["linewidth"], linestyles=[look["linestyle"]],
            zorder=look["zorder"],
        )  # fmt: skip


def _away(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Return how far points (..., 2) are from the edges of a polygon, and 0 of those inside it."""
    found = np.full(points.shape[:-1], np.inf)
    crossings = np.zeros(points.shape[:-1], int)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        edge, way = b - a, points - a
        part = np.clip((way @ edge) / (edge @ edge), 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(way - part[..., None] * edge, axis=-1))
        between = (a[1] > points[..., 1]) != (b[1] > points[..., 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            crossings += between & (points[..., 0] < a[0] + edge[0] * (points[..., 1] - a[1]) / edge[1])
    return np.where(crossings % 2 == 1, 0.0, found)


def _corners(obstacle: Obstacle) -> FloatArray:
    """Return points that an obstacle lies between, shape (k, 2)."""
    if isinstance(obstacle, CircleObstacle):
        return np.asarray(obstacle.center + obstacle.radius * np.array([[-1, -1], [1, 1]]))
    return np.asarray(obstacle.corners if isinstance(obstacle, PolygonObstacle) else np.empty((0, 2)))


def _middle(obstacle: Obstacle, reach: float) -> tuple[float, float]:
    """Return where the name of an obstacle stands."""
    if isinstance(obstacle, CircleObstacle):
        x, y = obstacle.center
    elif isinstance(obstacle, PolygonObstacle):
        x, y = _inside(obstacle.corners)
    else:
        assert isinstance(obstacle, HalfPlaneObstacle)
        normal = obstacle.normal / np.linalg.norm(obstacle.normal)
        x, y = obstacle.point - 0.04 * reach * normal
    return float(x), float(y)


def _inside(corners: FloatArray) -> FloatArray:
    """Return a place inside a polygon, far from its edges."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    grid = np.stack(np.meshgrid(*(np.linspace(a, b, 41) for a, b in zip(low, high, strict=True))), axis=-1).reshape(
        -1, 2
    )
    inside = grid[_away(grid, corners) == 0.0]
    if not len(inside):
        return np.asarray(corners.mean(axis=0))
    edges = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    depth = np.min([_from_segment(inside, a, b) for a, b in edges], axis=0)
    return np.asarray(inside[(depth - _CENTRAL * np.linalg.norm(inside - 0.5 * (low + high), axis=1)).argmax()])


def _from_segment(points: FloatArray, a: FloatArray, b: FloatArray) -> FloatArray:
    edge = b - a
    part = np.clip(((points - a) @ edge) / (edge @ edge), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - a - part[:, None] * edge, axis=-1))
