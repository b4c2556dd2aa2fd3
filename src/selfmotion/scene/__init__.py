"""What stands around an arm: obstacles, and how far they are."""

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
