"""A planar arm of 3k links as k modules of three, each on the moving base that the one before it carries (Fig. 13)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from selfmotion._types import FloatArray
from selfmotion.arms import PlanarArm
from selfmotion.arms.limits import JointBox
from selfmotion.constrained import constraints_of, unconstrained
from selfmotion.errors import Blocked, InfeasibleError, InvalidInputError
from selfmotion.motion import Motion
from selfmotion.paths import Path, Relative
from selfmotion.problem import Problem

_SHOWN = 3  # blocked stretches that a message names
_FOLD = 1e-9  # |sin θ2| of a fold up to rounding


@dataclass(frozen=True, eq=False)
class ChainCurve:
    """The redundancy vector of an arm of modules, a callable of (r, order).

    Attributes
    ----------
    moving_bases : tuple of Path
    motions : tuple of Motion
        Of each module in its own frame.
    """

    moving_bases: tuple[Path, ...]
    motions: tuple[Motion, ...]

    def __call__(self, r: FloatArray, order: int) -> FloatArray:
        """Return u or du/dr, shape (k, n_u)."""
        first, *later = self.motions
        columns = [first.u(r, order)]
        for motion in later:
            turned = motion(r) if order == 0 else motion.rates(r)
            with np.errstate(invalid="ignore"):  # rates are infinite at folds
                columns += [np.cumsum(turned, axis=-1)[:, :2], motion.u(r, order)]
        return np.concatenate(columns, axis=-1)


class Chain:
    """A problem of 3k links as k modules of three.

    Parameters
    ----------
    problem : Problem
        Its arm is planar, with 3k links and no fixed direction, and nothing to keep beyond joint limits.
    moving_bases : sequence of Path
        k − 1 paths at the same r as the tool's: of the end of module 1, 2, …, k − 1, where the next one begins.

    Attributes
    ----------
    problem : Problem
    count : int
        Number k of modules.
    ends : tuple of Path
        Where each module ends: the moving bases, then the tool's path.
    limits : tuple of JointLimits
        Of the true joints of each module.

    Raises
    ------
    InvalidInputError
        If the arm cannot be split, or the number of moving bases is wrong.
    """

    def __init__(self, problem: Problem, moving_bases: Sequence[Path]) -> None:
        arm = splittable(problem)
        self.problem = problem
        self.count = arm.n // 3
        self.ends = (*moving_bases, problem.path)
        if len(self.ends) != self.count:
            reason = f"has {len(moving_bases)} paths for {self.count} modules of three links"
            remedy = f"give {self.count - 1}, one for each module but the last"
            raise InvalidInputError("planner.moving_bases", reason, remedy)
        self._links = arm.links.reshape(-1, 3)
        self._pairs = arm.limits.as_list()
        self.limits = tuple(part.limits for part in module_arms(arm))

    @cached_property
    def modules(self) -> tuple[Problem, ...]:
        """The problem of each module in the frame of its base; see :func:`module_problems`."""
        return tuple(self._module(i, None) for i in range(self.count))

    def _module(self, i: int, first: list[float | None] | None) -> Problem:
        """Return the problem of module i, from the second on with limits `first` of its absolute first joint."""
        whole, rows = self.problem, slice(3 * i, 3 * i + 3)
        pairs = self._pairs[rows] if i == 0 else [first, *self._pairs[rows][1:]]
        if not whole.weights[rows].any():
            reason = f"is zero for all joints of module {i + 1}, whose motion would not matter"
            raise InvalidInputError("weights", reason, "give one of them a weight")
        try:
            return Problem(
                PlanarArm(self._links[i], pairs),
                self.ends[0] if i == 0 else Relative(self.ends[i], self.ends[i - 1]),
                elbow=whole.elbow if i == 0 else "any",
                weights=whole.weights[rows],
                objective=whole.objective.kind,
                samples=whole.samples,
            )
        except InvalidInputError as error:
            raise InvalidInputError(*self._blame(i, f"at any r: its path {error.reason}"), error.remedy) from None

    def _blame(self, i: int, where: str) -> tuple[str, str]:
        """Return field and reason if module i cannot follow its path."""
        if i == self.count - 1:
            what = f"is no base from which module {i + 1} reaches the tool's path"
        else:
            what = f"leaves the workspace of module {i + 1}" + (f" as seen from moving base {i}" if i else "")
        return f"planner.moving_bases.{min(i, self.count - 2)}", f"{what}, {where}"

    def refuse_blocked(self) -> None:
        """Refuse a moving base that a module cannot follow, or from which the next one cannot reach its path.

        Raises
        ------
        InvalidInputError
            Naming the moving base, where along the path it is wrong, and by how much if it is out of reach.
        """
        for i, module in enumerate(self.modules):
            blocked = module.blocked
            if not blocked:
                continue
            remedy = f"move it, or widen the limits of joints {3 * i + 1} to {3 * i + 3}"
            if any(part.cause == "out of reach" for part in blocked):
                longest, total = float(self._links[i].max()), float(self._links[i].sum())
                near = f"{max(0.0, 2 * longest - total):.6g} to {total:.6g}"
                other = "the arm's base" if i == 0 else "the tool" if i == self.count - 1 else f"moving base {i}"
                remedy = f"keep it at a distance of {near} from {other}"
            raise InvalidInputError(*self._blame(i, _places(blocked)), remedy)

    def starting_branches(self, offset: FloatArray) -> list[list[int]]:
        """Return on which branches each module may start, with its last link's direction at `offset`, shape (k,).

        Raises
        ------
        InvalidInputError
            If there is none: the offset is outside the angle domain at r = 0, with the limits of the true first joint.
        """
        found = []
        for i in range(self.count):
            pair = self._pairs[3 * i] or [None, None]
            turned = [None if end is None else end + float(offset[i - 1]) for end in pair]
            module = self._module(i, turned)
            branches = [b for b in module.elbow_branches if module.may_start_at(offset[i : i + 1], b)]
            if not branches:
                reason = f"is outside the angle domain of module {i + 1} at r = 0"
                if i and self.limits[i].limited[0]:
                    reason += f" and of its joint {3 * i + 1}, carried at offset {offset[i - 1]:.6g}"
                raise InvalidInputError(f"planner.offset.{i}", reason, module.feasible_at(0.0), float(offset[i]))
            found.append(branches)
        return found

    def first(self, count: int) -> Problem:
        """Return the problem of the first `count` modules together."""
        whole, n = self.problem, 3 * count
        if count == self.count:
            return whole
        return Problem(
            PlanarArm(self._links[:count].ravel(), self._pairs[:n]),
            self.ends[count - 1],
            elbow=whole.elbow,
            weights=whole.weights[:n],
            objective=whole.objective.kind,
            samples=whole.samples,
        )

    def motion(self, motions: Sequence[Motion]) -> Motion:
        """Return the motion of the arm of the first modules, each of which moves in its own frame as in `motions`.

        Parameters
        ----------
        motions : sequence of Motion

        Returns
        -------
        Motion
            Of true joints. Its redundancy vector holds the directions of link 3 and of all links of later modules.
        """
        part = self.first(len(motions))
        curve = ChainCurve(self.ends[: len(motions) - 1], tuple(motions))
        # Samples resolve each module's sinusoid, and a true joint turns at most as fast as two of them together.
        return Motion(part.arm, part.path, curve, motions[0].branch, 4 * part.samples)


def module_problems(problem: Problem, moving_bases: Sequence[Path]) -> tuple[Problem, ...]:
    """Split a problem of 3k links into one problem for each module of three.

    Parameters
    ----------
    problem : Problem
        Its arm is planar, with 3k links and no fixed direction.
    moving_bases : sequence of Path
        k − 1 paths at the same r as the tool's: of the end of module 1, 2, …, k − 1, where the next one begins.

    Returns
    -------
    tuple of Problem
        Module i is a 3R arm in a frame that moves with its base, axes parallel to the world's, and follows
        ``b_i(r) − b_{i−1}(r)``, b_0 the arm's base and b_k the tool's path. From module 2 on its first joint counts
        as an absolute angle: limits of that joint hold for the true one, which the module before decides, and are left
        out here. The elbow asked for is that of module 1. ``angle_domain(module.arm, module.path)`` is the angle domain
        of a module, Fig. 14.

    Raises
    ------
    InvalidInputError
        If the arm cannot be split, the number of moving bases is wrong, the weights of a module are all zero, or a
        module reaches no point of its path.
    """
    return Chain(problem, moving_bases).modules


def splittable(problem: Problem) -> PlanarArm:
    """Return the arm of a problem if it splits into modules and is not constrained; else raise an InvalidInputError."""
    arm = unconstrained(problem.arm)
    refuse_constraints(problem)
    if not isinstance(arm, PlanarArm):
        raise InvalidInputError("planner", "is for planar arms, which split into modules", "use planner global")
    if arm.direction is not None:
        raise InvalidInputError("arm", "is not a planar arm whose last link is free", "use 3k links and no direction")
    if arm.n % 3:
        raise InvalidInputError("arm.links", f"has {arm.n} entries", "modules of three need 3, 6, 9, … links")
    return arm


def refuse_constraints(problem: Problem) -> None:
    """Refuse what an arm is asked to keep beyond joint limits, which its modules by themselves cannot tell.

    Raises
    ------
    InvalidInputError
        Naming the field that asks for it.
    """
    if not constraints_of(problem.arm):
        return
    scene = problem.scene
    fields = {
        "obstacles": scene is not None and len(scene.obstacles) > 0,
        "self_collision": scene is not None and scene.self_collision,
        "least_singular_value": problem.least_singular_value is not None,
    }
    field = next((name for name, asked in fields.items() if asked), "arm")
    raise InvalidInputError(field, "cannot be kept by planners of modules", "leave it out, or use planner: refine")


def module_arms(arm: PlanarArm) -> tuple[PlanarArm, ...]:
    """Return each module of an arm of 3k links as an arm of its own, with the limits of its true joints."""
    links, pairs = arm.links.reshape(-1, 3), arm.limits.as_list()
    return tuple(PlanarArm(some, pairs[3 * i : 3 * i + 3]) for i, some in enumerate(links))


def refuse_what_modules_cannot_keep(problem: Problem, kind: str) -> None:
    """Refuse start, end and cyclic, and a path that the whole arm does not reach.

    Raises
    ------
    InvalidInputError, InfeasibleError
    """
    for name, value in (("start", problem.start), ("end", problem.end), ("cyclic", problem.cyclic or None)):
        if value is not None:
            raise InvalidInputError(name, f"cannot be kept by planner {kind}", "leave it out, or use planner: refine")
    blocked = problem.blocked
    if blocked:
        raise InfeasibleError(blocked)


def allowed_elbows(module: PlanarArm) -> list[int]:
    """Return the branches that the limits of a module's middle joint leave more of than a fold."""

    def has_more_than_a_fold(box: JointBox) -> bool:
        return bool(abs(np.sin(0.5 * (box.lower[1] + box.upper[1]))) > _FOLD)

    return [b for b, elbow in enumerate(module.branches) if any(map(has_more_than_a_fold, module.boxes(elbow)))]


def _places(blocked: Sequence[Blocked]) -> str:
    words = [
        f"{part.cause}{'' if part.short_by is None else f' by up to {part.short_by:.6g}'} "
        f"for r in [{part.r[0]:.6g}, {part.r[1]:.6g}]"
        for part in blocked[:_SHOWN]
    ]
    more = len(blocked) - len(words)
    return " and ".join(words) + (f" and {more} more stretches" if more else "")
