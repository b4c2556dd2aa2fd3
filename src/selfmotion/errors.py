"""The errors of selfmotion: each carries its data and says what to do.

Every error that a user can cause is a :class:`SelfMotionError`; ``exit_code`` is what the
command line returns for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any


class SelfMotionError(Exception):
    """Anything selfmotion refuses or cannot do.

    Parameters
    ----------
    message : str
        What is wrong, in one line.
    remedy : str, optional
        What to do about it, in one line.
    """

    status = "unknown"
    exit_code = 4

    def __init__(self, message: str, remedy: str = "") -> None:
        self.message = message
        self.remedy = remedy
        super().__init__(message)

    def __str__(self) -> str:
        return f"{self.message}; {self.remedy}" if self.remedy else self.message


class InvalidInputError(SelfMotionError, ValueError):
    """A value that cannot mean what was asked.

    Parameters
    ----------
    field : str
        Dotted name of the offending field, such as ``path.control_points``.
    reason : str
        What is wrong with it.
    remedy : str
        What to write instead.
    value : object, optional
        The offending value; shown shortened.
    source : str, optional
        The file it came from.
    """

    status = "error"
    exit_code = 2

    def __init__(self, field: str, reason: str, remedy: str = "", value: Any = None, source: str | None = None) -> None:
        self.field = field
        self.reason = reason
        self.value = value
        self.source = source
        shown = "" if value is None else f" (got {shorten(value)})"
        where = ": ".join(part for part in (source, field) if part)
        super().__init__(f"{where}: {reason}{shown}" if where else f"{reason}{shown}", remedy)

    def inside(self, prefix: str = "", source: str | None = None) -> InvalidInputError:
        """Return the same error one level further out: below field `prefix`, in file `source`."""
        field = ".".join(part for part in (prefix, self.field) if part)
        return type(self)(field, self.reason, self.remedy, self.value, source or self.source)


class MissingExtraError(InvalidInputError):
    """A feature whose optional dependency is not installed.

    Parameters
    ----------
    field, reason, remedy, value, source
        See :class:`InvalidInputError`; the remedy says what to install.
    """


@dataclass(frozen=True)
class Blocked:
    """A stretch of the path on which no posture exists.

    Attributes
    ----------
    r : tuple of float
        First and last path parameter of the stretch.
    cause : str
        ``"out of reach"``, ``"joint limits"``, ``"singular postures"`` or ``"obstacles"``, the arm itself included.
    short_by : float or None
        Largest distance by which the reach falls short there, in the arm's length unit.
    limits : tuple of str
        What ends the last part of the self-motion that leads on from the start, such as ``"upper limit of θ1"`` or
        ``"link 3 against obstacle 2"``.

    Notes
    -----
    Where postures exist all along the path and yet no motion does, the stretch is where it must break: from the first r
    that some part leading to the end reaches back to, to the last one that some part leading on from the start gets to.
    Its cause is then ``"joint limits"``, ``"limit of reach"`` or ``"start and end"``, which no part joins.
    """

    r: tuple[float, float]
    cause: str
    short_by: float | None = None
    limits: tuple[str, ...] = ()


@dataclass(frozen=True)
class Need:
    """By how much one joint limit would have to give for a motion to exist.

    Attributes
    ----------
    joint : int
        Counted from 1.
    side : str
        ``"lower"`` or ``"upper"``.
    by : float
        In the unit.
    r : float or None
        Where along the path, if it could be told.
    unit : str
        ``"rad"``, or ``"m"`` of a joint that slides.
    """

    joint: int
    side: str
    by: float
    r: float | None = None
    unit: str = "rad"

    def __str__(self) -> str:
        where = "" if self.r is None else f" at r = {self.r:.3g}"
        way = "below its lower" if self.side == "lower" else "above its upper"
        name = "θ" if self.unit == "rad" else "q"
        return f"{name}{self.joint} needs {self.by:.3g} {self.unit} more {way} limit{where}"


class InfeasibleError(SelfMotionError):
    """Proved: no continuous motion exists, because the path is blocked.

    Parameters
    ----------
    blocked : sequence of Blocked
        The blocked stretches, in the order of the path.
    needs : sequence of Need, optional
        Which limits would have to give, and by how much each of them alone, the least first.
    proof : optional
        What was proved, and how finely; a :class:`~selfmotion.certificate.infeasibility.InfeasibilityProof`.
    reconfigured : optional
        The motion with the fewest reconfigurations; a :class:`~selfmotion.planners.reconfiguration.Reconfigured`.
    """

    status = "infeasible"
    exit_code = 3

    def __init__(
        self, blocked: Sequence[Blocked], needs: Sequence[Need] = (), proof: Any = None, reconfigured: Any = None
    ) -> None:
        self.blocked, self.needs = tuple(blocked), tuple(needs)
        self.proof, self.reconfigured = proof, reconfigured
        worst = max(self.blocked, key=lambda part: part.r[1] - part.r[0])
        by = "" if worst.short_by is None else f" by up to {worst.short_by:.6g}"
        more = "" if len(self.blocked) == 1 else f" (the longest of {len(self.blocked)} such stretches)"
        limits = f" ({' and '.join(worst.limits)})" if worst.limits else ""
        remedy = "widen the limits or move the path"
        if self.needs:
            remedy = f"{self.needs[0]}: widen it, or move the path"
        elif worst.cause == "out of reach":
            remedy = "move the path or the base"
        elif worst.cause == "start and end":
            remedy = "ask for another start or end"
        elif worst.cause == "singular postures":
            remedy = "ask for a smaller least singular value, or move the path"
        elif worst.cause == "obstacles":
            remedy = "move the obstacles or the path, or ask for less clearance"
        super().__init__(
            f"no continuous motion exists: {worst.cause}{by}{limits} for r in "
            f"[{worst.r[0]:.6g}, {worst.r[1]:.6g}]{more}",
            remedy,
        )


class UndecidedError(SelfMotionError):
    """Neither a motion was found nor a proof that there is none.

    Parameters
    ----------
    message : str
        What was tried and how it ended.
    remedy : str
    why : str
        ``"budget"``: time or memory ended before the proof did; ``"tangency"``: with limits wider by 1e-7 rad a motion
        exists, and no computation that rounds can tell; ``"estimate"``: the arm is one of which nothing can be proved
        by what was not found.
    """

    def __init__(self, message: str, remedy: str, why: str) -> None:
        self.why = why
        super().__init__(message, remedy)


class UnrepairableError(SelfMotionError):
    """A sampled motion that could not be made continuous by self-motion.

    Parameters
    ----------
    message : str
        Where the last connected part of the self-motion ends and what ends it, or what was tried.
    remedy : str
    r : float
        The place.
    proved : bool
        Whether no continuous motion exists at all, not even with limits wider by 1e-7 rad, so that rounding is not to
        blame. Without it nothing is proved.
    """

    def __init__(self, message: str, remedy: str, r: float, proved: bool) -> None:
        self.r = r
        self.proved = proved
        if proved:
            self.status, self.exit_code = "infeasible", 3
        super().__init__(message, remedy)


class NothingFeasibleError(SelfMotionError):
    """A search ended without a feasible candidate; this proves nothing.

    Parameters
    ----------
    message : str
        What was searched and how it ended.
    remedy : str
        What to change.
    evaluations : int
        Candidates that were judged, or iterations that were made.
    least_violation : float
        How far the best of them left the angle domain; of starts that were led along the path, the part of it that was
        left.
    """

    def __init__(self, message: str, remedy: str, evaluations: int, least_violation: float) -> None:
        self.evaluations = evaluations
        self.least_violation = least_violation
        super().__init__(message, remedy)


def shorten(value: object, width: int = 60) -> str:
    """Return `value` as text of at most `width` characters on one line.

    Parameters
    ----------
    value : object
    width : int

    Returns
    -------
    str
    """
    try:
        text = " ".join(repr(value)[: 40 * width].split())
    except ValueError:  # an int too long to print
        text = "a number of several thousand digits"
    return text if len(text) <= width else text[: width - 1] + "…"
