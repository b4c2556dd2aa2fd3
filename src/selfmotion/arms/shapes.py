"""The shapes of a chain's links for collision checking: capsules, each in the frame of a joint."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from selfmotion._checks import finite_array, integer, positive, read_only
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError

BASE = -1
"""The frame of what does not move: the chain's base frame."""
_LAST = 10**6  # no chain has as many joints
_ROUNDING = 1e-9  # of a radius, by which what is inside another capsule may stick out


@dataclass(frozen=True, eq=False, init=False)
class Capsule:
    """All points within a radius of a segment, which moves with a frame of a chain.

    Parameters
    ----------
    link : str
        Name of the link that it is a part of.
    frame : int
        Joint j after whose Z(q_j) the frame is, counted from 0; −1 for the chain's base frame.
    ends : array_like, shape (2, 3)
        Ends of the segment in that frame [m]; the same twice for a sphere.
    radius : float
        [m]

    Raises
    ------
    InvalidInputError
        If a number is none, or the radius is not positive.
    """

    link: str
    frame: int
    ends: FloatArray
    radius: float

    def __init__(self, link: str, frame: int, ends: ArrayLike, radius: float) -> None:
        given = finite_array("ends", ends, 2, 3)
        if len(given) != 2:
            raise InvalidInputError("ends", f"has {len(given)} points", "give two", ends)
        values = {"link": link, "frame": integer("frame", frame, BASE, _LAST), "ends": read_only(given)}
        for name, value in {**values, "radius": positive("radius", radius)}.items():
            object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Capsule):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[object, ...]:
        return self.link, self.frame, self.radius, *self.ends.ravel().tolist()

    @property
    def volume(self) -> float:
        """``π r² (|p − q| + 4 r / 3)`` [m³]."""
        length = float(np.linalg.norm(self.ends[1] - self.ends[0]))
        return np.pi * self.radius**2 * (length + 4.0 * self.radius / 3.0)

    def moved(self, transform: FloatArray, frame: int) -> Capsule:
        """Return the capsule in another frame, in which its own has the pose `transform` (4, 4)."""
        return Capsule(self.link, frame, self.ends @ transform[:3, :3].T + transform[:3, 3], self.radius)

    def counted(self, frame: int) -> Capsule:
        """Return the capsule with another number of its frame."""
        return Capsule(self.link, frame, self.ends, self.radius)

    def holds(self, other: Capsule) -> bool:
        """Return whether another capsule of the same frame is inside, to rounding."""
        start, along = self.ends[0], self.ends[1] - self.ends[0]
        square = float(along @ along)
        # No point of a segment is farther from a convex set than both its ends are.
        part = np.clip((other.ends - start) @ along / square, 0.0, 1.0) if square > 0 else np.zeros(2)
        away = np.linalg.norm(other.ends - start - part[:, None] * along, axis=1).max()
        return bool(away + other.radius <= self.radius * (1.0 + _ROUNDING))


@dataclass(frozen=True)
class Shapes:
    """What is known of the shapes of a chain's links.

    Attributes
    ----------
    capsules : tuple of Capsule
    unread : mapping
        Links that have a shape which is not read, such as a mesh, and why.
    loose : tuple of str
        Links with a shape that hang on the chain by joints of their own, such as fingers: nobody says where they are.
    apart : tuple of pairs of str
        Links that never meet, whatever their capsules do, which are thicker.
    """

    capsules: tuple[Capsule, ...] = ()
    unread: Mapping[str, str] = field(default_factory=dict)
    loose: tuple[str, ...] = ()
    apart: tuple[tuple[str, str], ...] = ()

    def on_rail(self, turn: FloatArray) -> Shapes:
        """Return the shapes with a joint before all others, which slides along the z-axis of `turn` (4, 4)."""
        return self._each(lambda part: part.moved(turn.T, 0) if part.frame == BASE else part.counted(part.frame + 1))

    def locked(self, joint: int, pose: FloatArray) -> Shapes:
        """Return the shapes with a joint held, the frame after it having the pose `pose` (4, 4) in the one before."""

        def held(part: Capsule) -> Capsule:
            return part.moved(pose, joint - 1) if part.frame == joint else part.counted(part.frame - 1)

        return self._each(lambda part: held(part) if part.frame >= joint else part)

    def _each(self, change: Callable[[Capsule], Capsule]) -> Shapes:
        return replace(self, capsules=tuple(change(part) for part in self.capsules))


def without_hidden(capsules: Iterable[Capsule]) -> tuple[Capsule, ...]:
    """Return those capsules of one frame that are not inside another one."""
    kept: list[Capsule] = []
    for part in capsules:
        if not any(other.holds(part) for other in kept):
            kept = [*(other for other in kept if not part.holds(other)), part]
    return tuple(kept)
