"""What drawings are made of: lines, arcs, ellipses and Bezier curves, each as it was drawn, or flattened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from selfmotion._checks import LARGEST
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError
from selfmotion.exchange.reading import CURVE_WEIGHT
from selfmotion.paths import Arc, Bezier, Concatenation, Ellipse, Line, Path, Placed, Waypoints
from selfmotion.paths.base import PLANE, SPACE, distance

MOST_CURVES = 2_000
"""More curves than these are flattened: each costs time whenever the path is asked for a point."""
# A joint open by less than this part of its neighbours' extent is closed as far as paths are concerned.
_SHUT = 5e-10
# Radii that differ by less than this part are those of a circle.
_ROUND = 1e-12


@dataclass(frozen=True)
class Piece:
    """One part of a stroke.

    Attributes
    ----------
    kind : {"line", "arc", "ellipse", "bezier", "flattened", "gap"}
        A gap is what was not drawn: it joins two strokes.
    points : array, shape (k, 2) or (k, 3)
        The corners of lines; of a curve its two ends.
    curve : Path or None
        None for lines.
    """

    kind: str
    points: FloatArray
    curve: Path | None = None

    @property
    def start(self) -> FloatArray:
        """Its first point."""
        return self.points[0]

    @property
    def end(self) -> FloatArray:
        """Its last point."""
        return self.points[-1]

    @property
    def count(self) -> int:
        """How many segments of its kind it is."""
        return 1 if self.curve is not None or self.kind == "flattened" else len(self.points) - 1

    @property
    def weight(self) -> int:
        """How many lines cost as much to read."""
        return self.count if self.curve is None else CURVE_WEIGHT

    @property
    def length(self) -> float:
        """Its arc length."""
        if self.curve is not None:
            return self.curve.length
        return float(distance(np.diff(self.points, axis=0)).sum())

    @property
    def path(self) -> Path:
        """It as a path."""
        if self.curve is not None:
            return self.curve
        return Line(*self.points) if len(self.points) == 2 else Waypoints(self.points)

    @property
    def bounds(self) -> FloatArray:
        """Least and largest coordinates, shape (2, d)."""
        points = self.points if self.curve is None else _turning_points(self.curve)
        return np.stack([points.min(axis=0), points.max(axis=0)])

    @property
    def reach(self) -> float:
        """About how far it extends, and not farther."""
        points = self.points if self.curve is None else self.curve(np.linspace(0.0, 1.0, 5))
        return float(np.ptp(points, axis=0).max())

    def reversed(self) -> Piece:
        """Return it run backwards."""
        curve = self.curve
        if isinstance(curve, Bezier):
            curve = Bezier(curve.control_points[::-1])
        elif isinstance(curve, Ellipse):
            end = np.remainder(curve.start_angle + curve.sweep, 2 * np.pi)
            curve = _ellipse(curve.center, curve.radii, curve.rotation, end, -curve.sweep)
        return Piece(self.kind, self.points[::-1], curve)

    def raised(self) -> Piece:
        """Return a plane piece in the plane z = 0 of space."""
        curve = None if self.curve is None else Placed(self.curve)
        return Piece(self.kind, np.pad(self.points, ((0, 0), (0, 1))), curve)

    def with_ends(self, start: FloatArray | None = None, end: FloatArray | None = None) -> Piece | None:
        """Return it with an end moved a little; None for arcs and ellipses, which have no end to be moved alone."""
        if self.curve is not None and not isinstance(self.curve, Bezier):
            return None
        moved = np.array(self.points if self.curve is None else self.curve.control_points)
        if start is not None:
            moved[0] = start
        if end is not None:
            moved[-1] = end
        if self.curve is None:
            return Piece(self.kind, moved)
        return Piece(self.kind, moved[[0, -1]], Bezier(moved))


def line(points: FloatArray, kind: str = "line") -> Piece | None:
    """Return lines through points, shape (k, d); None if they have no length."""
    steps = distance(np.diff(points, axis=0))
    keep = np.concatenate([[True], steps > 1e-13 * steps.sum()])
    # The end is what the next piece starts at.
    kept = points[keep]
    if len(kept) < 2:
        return None
    kept[-1] = points[-1]
    return Piece(kind, kept)


def bezier(control_points: FloatArray) -> Piece | None:
    """Return a Bezier curve, a line if it has two control points; None if it has no length."""
    if np.ptp(control_points, axis=0).max() == 0:
        return None
    if len(control_points) == 2:
        return line(control_points)
    return Piece("bezier", control_points[[0, -1]], Bezier(control_points))


def elliptic(center: FloatArray, matrix: FloatArray, start: float, sweep: float) -> Piece | None:
    """Return the arc ``center + matrix (cos φ, sin φ)`` from φ = `start` over `sweep` [rad]; None if it has no length.

    Whatever an affine map makes of a circle is an ellipse: its semi-axes are the matrix's singular values.
    """
    if not np.abs(matrix).max() <= LARGEST:
        raise InvalidInputError("radius", f"exceeds {LARGEST:g} in magnitude", "correct it")
    turn, radii, back = np.linalg.svd(matrix)
    if not radii[0] > 0 or sweep == 0:
        return None
    if radii[1] <= 1e-12 * radii[0]:  # seen edge-on
        r = np.linspace(start, start + sweep, 1025)
        return line(center + np.stack([np.cos(r), np.sin(r)], axis=1) @ matrix.T, "flattened")
    if np.linalg.det(turn) < 0:
        turn, back = turn * [1.0, -1.0], back * [[1.0], [-1.0]]
    # What remains on the side of φ turns it by an angle, or mirrors it first.
    shift = np.arctan2(back[1, 0], back[0, 0])
    if np.linalg.det(back) < 0:
        start, sweep = -start, -sweep
    rotation = float(np.arctan2(turn[1, 0], turn[0, 0]))
    if radii[0] - radii[1] <= _ROUND * radii[0]:
        start, rotation = start + rotation, 0.0
    begin = float(np.remainder(start + shift, 2 * np.pi))
    curve = _ellipse(center, radii, rotation, begin, float(sweep))
    return Piece("arc" if isinstance(curve, Arc) else "ellipse", curve([0.0, 1.0]), curve)


def _ellipse(center: FloatArray, radii: FloatArray, rotation: float, start: float, sweep: float) -> Ellipse:
    if radii[0] - radii[1] <= _ROUND * radii[0]:
        return Arc(center, float(radii.mean()), start + rotation, sweep)
    return Ellipse(center, radii, rotation, start, sweep)


def flattened(curve: Path, tolerance: float) -> tuple[FloatArray, float]:
    """Return points on a curve whose polyline stays within `tolerance` of it, and the bound on how far it strays.

    Of n equal parts of r none strays by more than ``max|x''| / (8 n²)``.
    """
    bending = curve.bending(0.0, 1.0) / 8
    count = int(np.clip(np.ceil(np.sqrt(bending / tolerance)), 1, 1_000_000))
    return curve(np.linspace(0.0, 1.0, count + 1)), bending / count**2


@dataclass(frozen=True)
class Fitted:
    """A stroke whose pieces meet.

    Attributes
    ----------
    pieces : tuple of Piece
    joints : tuple of float
        By how much joints were open that had to be closed.
    chord_error : float
        How far flattened pieces may be from what was drawn.
    """

    pieces: tuple[Piece, ...]
    joints: tuple[float, ...] = ()
    chord_error: float = 0.0


def fitted(pieces: Sequence[Piece], tolerance: float) -> Fitted:
    """Return pieces that meet: joints open by no more than `tolerance` are closed, and the last one with the first.

    A line or a Bezier curve moves its end to where its neighbour's is; between two arcs goes a straight line.
    """
    done: list[Piece] = []
    joints: list[float] = []
    for piece in pieces:
        if done:
            _join(done, piece, joints)
        else:
            done.append(piece)
    gap = float(distance(done[0].start - done[-1].end))
    if 0 < gap <= tolerance and sum(piece.length for piece in done) > 4 * gap:
        if gap > _SHUT * max(piece.reach for piece in done):
            joints.append(gap)
        _close(done)
    return Fitted(tuple(_merged(done)), tuple(joints))


def _join(done: list[Piece], piece: Piece, joints: list[float]) -> None:
    """Append `piece` to what is done so that it starts there."""
    last = done[-1]
    gap = float(distance(piece.start - last.end))
    reach = max(last.reach, piece.reach) if gap else 0.0
    if gap > _SHUT * reach:
        joints.append(gap)
    if gap == 0:
        done.append(piece)
    elif (moved := piece.with_ends(start=last.end)) is not None:
        if moved.length > 0:
            done.append(moved)
    elif (moved := last.with_ends(end=piece.start)) is not None:
        done[-1:] = [moved, piece] if moved.length > 0 else [piece]
    elif gap > _SHUT * reach:
        done += [Piece("line", np.stack([last.end, piece.start])), piece]
    else:
        done.append(piece)


def _close(done: list[Piece]) -> None:
    """Let the last piece end where the first one starts."""
    start = done[0].start
    if (moved := done[-1].with_ends(end=start)) is not None and moved.length > 0:
        done[-1] = moved
    elif len(done) > 1 and (moved := done[0].with_ends(start=done[-1].end)) is not None and moved.length > 0:
        done[0] = moved
    elif distance(start - done[-1].end) > _SHUT * max(piece.reach for piece in done):
        done.append(Piece("line", np.stack([done[-1].end, start])))


def _merged(pieces: Sequence[Piece]) -> list[Piece]:
    """Return pieces of which no two neighbours are lines of one kind."""
    done: list[list[Piece]] = []
    for piece in pieces:
        if done and piece.kind == done[-1][-1].kind == "line" and (piece.start == done[-1][-1].end).all():
            done[-1].append(piece)
        else:
            done.append([piece])
    merged = []
    for run in done:
        points = [run[0].points, *(piece.points[1:] for piece in run[1:])]
        merged.append(run[0] if len(run) == 1 else Piece("line", np.concatenate(points)))
    return merged


def without_curves(stroke: Fitted, tolerance: float) -> Fitted:
    """Return a stroke whose curves are flattened."""
    pieces, worst = [], stroke.chord_error
    for piece in stroke.pieces:
        if piece.curve is None:
            pieces.append(piece)
            continue
        points, error = flattened(piece.curve, tolerance)
        points[0], points[-1] = piece.points
        worst = max(worst, error)
        flat = line(points, "flattened")
        pieces += [] if flat is None else [flat]
    return Fitted(tuple(pieces), stroke.joints, worst)


def path_of(pieces: Sequence[Piece]) -> Path:
    """Return the path along pieces that meet."""
    runs: list[list[FloatArray] | Path] = []
    for piece in pieces:
        if piece.curve is not None:
            runs.append(piece.curve)
        elif runs and isinstance(runs[-1], list):
            runs[-1].append(piece.points[1:])
        else:
            runs.append([piece.points])
    parts: list[Path] = []
    for run in runs:
        if isinstance(run, Path):
            parts.append(run)
            continue
        joined = line(np.concatenate(run))
        parts += [] if joined is None else [joined.path]
    return parts[0] if len(parts) == 1 else Concatenation(parts)


def bounds_of(pieces: Sequence[Piece]) -> FloatArray:
    """Return the least and largest coordinates of pieces, shape (2, d)."""
    stacked = np.stack([piece.bounds for piece in pieces])
    return np.stack([stacked[:, 0].min(axis=0), stacked[:, 1].max(axis=0)])


def _turning_points(curve: Path) -> FloatArray:
    """Return points of a curve among which are those where a coordinate turns back."""
    if isinstance(curve, Ellipse):
        (a, b), c, s = curve.radii, np.cos(curve.rotation), np.sin(curve.rotation)
        turns = np.arctan2([-b * s, b * c], [a * c, a * s])[:, None] + np.pi * np.arange(2)
        ahead = np.remainder(np.sign(curve.sweep) * (turns.ravel() - curve.start_angle), 2 * np.pi)
        inside = ahead[ahead < abs(curve.sweep)] / abs(curve.sweep)
        return curve(np.concatenate([[0.0, 1.0], inside]))
    r = np.linspace(0.0, 1.0, 65)
    rates, found = curve(r, 1), [r]
    for axis in range(PLANE if curve.dimension == PLANE else SPACE):
        turn = np.flatnonzero(rates[:-1, axis] * rates[1:, axis] < 0)
        if not len(turn):
            continue
        low, high, before = r[turn], r[turn + 1], np.sign(rates[turn, axis])
        for _ in range(24):  # at a turning point an error counts by its square
            middle = 0.5 * (low + high)
            same = np.sign(curve(middle, 1)[:, axis]) == before
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        found.append(low)
    return curve(np.concatenate(found))
