"""What stands around an arm, and the shapes of its links: obstacles, how far they are, and what must keep clear of what."""

from __future__ import annotations

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
    "SphereObstacle",
]
