"""A time law along a finished plan: when its motion is where; the motion itself is never altered."""

from __future__ import annotations

from selfmotion.timing.law import Law, Moved
from selfmotion.timing.planned import time_law
from selfmotion.timing.trajectory import Slow, TimedTrajectory

__all__ = ["Law", "Moved", "Slow", "TimedTrajectory", "time_law"]
