"""What stands around an arm, and the shapes of its links: obstacles, and what must keep clear of what."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from selfmotion.scene.mesh import MeshObstacle
from selfmotion.scene.obstacle import Obstacle
from selfmotion.scene.obstacles import (
    OBSTACLES,
    BoxObstacle,
    CapsuleObstacle,
    CircleObstacle,
    HalfPlaneObstacle,
    HalfSpaceObstacle,
    SphereObstacle,
)
from selfmotion.scene.polygon import PolygonObstacle

if TYPE_CHECKING:
    from selfmotion.scene.scene import Scene

__all__ = [
    "OBSTACLES",
    "BoxObstacle",
    "CapsuleObstacle",
    "CircleObstacle",
    "HalfPlaneObstacle",
    "HalfSpaceObstacle",
    "MeshObstacle",
    "Obstacle",
    "PolygonObstacle",
    "Scene",
    "SphereObstacle",
]


def __getattr__(name: str) -> Any:
    """Import the scene when it is asked for: its kernels are compiled, which reading obstacles does without."""
    if name != "Scene":
        raise AttributeError(f"module 'selfmotion.scene' has no attribute {name!r}")
    from selfmotion.scene.scene import Scene

    return Scene
