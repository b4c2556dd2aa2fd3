"""The form of plan files: what types their fields have."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictInt, StrictStr

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
AnyNumber = Annotated[float, Field(strict=True)]  # infinite ones and NaN too
Row = list[Number]
OpenRow = list[Number | None]


class _Form(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)


class HistoryForm(_Form):
    """One :class:`~selfmotion.optimizers.History`."""

    best: list[AnyNumber]
    mean: list[AnyNumber]
    feasible: list[StrictInt]
    evaluations: list[StrictInt]
    time_s: list[AnyNumber]


class PlanForm(_Form):
    """A plan file, its version left out."""

    version: StrictStr
    problem: dict[str, Any]
    planner: StrictStr
    parameters: dict[str, Any]
    evaluations: StrictInt
    wall_time_s: AnyNumber
    reconfigurations: StrictInt
    history: list[HistoryForm]
    motion: dict[str, Any]
    lower_bound: AnyNumber | None
    gap: AnyNumber | None
    estimated_bound: AnyNumber | None
    estimated_gap: AnyNumber | None
    certificate: dict[str, Any] | None
    result: dict[str, Any]


class CertificateForm(_Form):
    """The proof of a bound, in figures."""

    bound: AnyNumber
    argument: StrictStr
    rigorous: StrictBool
    levels: list[Annotated[list[StrictInt | AnyNumber], Field(min_length=5, max_length=5)]]
    tube: list[Annotated[list[Any], Field(min_length=3, max_length=3)]]


class ProblemForm(_Form):
    """A problem; arms of a chain are written out, and all else is as problem files have it."""

    arm: dict[str, Any]
    path: dict[str, Any]
    start: dict[str, Row] | None
    end: dict[str, Row] | None
    elbow: StrictStr
    cyclic: Literal[False, "exact", "modulo"]
    weights: Row
    objective: StrictStr
    samples: StrictInt
    obstacles: list[dict[str, Any]] = []
    clearance: Number = 0.0
    self_collision: StrictBool = False
    least_singular_value: Number | None = None


class TrianglesForm(_Form):
    """The triangles of a mesh, and its vertices."""

    vertices: list[Row]
    triangles: list[Annotated[list[StrictInt], Field(min_length=3, max_length=3)]]


class MeshForm(_Form):
    """A mesh as an obstacle; all others are as problem files have them."""

    mesh: TrianglesForm
    name: StrictStr | None = None


class CapsuleForm(_Form):
    """A :class:`~selfmotion.arms.shapes.Capsule`."""

    link: StrictStr
    frame: StrictInt
    ends: list[Row]
    radius: Number


class ShapesForm(_Form):
    """The :class:`~selfmotion.arms.shapes.Shapes` of a chain."""

    capsules: list[CapsuleForm]
    unread: dict[str, StrictStr]
    loose: list[StrictStr]
    apart: list[Annotated[list[StrictStr], Field(min_length=2, max_length=2)]]


class ChainForm(_Form):
    """An arm in space by its chain: all numbers, since files and catalogues may change."""

    kind: Literal["chain"]
    solved: Literal["spatial", "roll", "rail", "locked"]
    names: list[StrictStr]
    offsets: list[list[Row]]
    limits: list[OpenRow | None]
    velocity: OpenRow
    base: StrictStr
    tip: StrictStr
    locked_joint: StrictInt | None = None
    shapes: ShapesForm | None = None


class SectionForm(_Form):
    """A part of a path."""

    kind: Literal["section"]
    path: dict[str, Any]
    r_range: Row


class SplineForm(_Form):
    """A :class:`~selfmotion.refinement.ClosedSpline`."""

    kind: Literal["spline"]
    knots: Row
    coefficients: list[Row]
    lower: OpenRow
    upper: OpenRow


class CurveForm(_Form):
    """A :class:`~selfmotion.motion.Motion`."""

    kind: Literal["curve"]
    branch: StrictInt
    nodes: StrictInt
    start: Row | None
    curve: dict[str, Any]


class ProfileForm(_Form):
    """A curve of a profile family."""

    kind: Literal["profile"]
    family: StrictStr
    settings: dict[str, Any]
    a: Row


class WaveForm(_Form):
    """One sinusoid."""

    kind: Literal["wave"]
    offset: Row
    amplitude: Row
    frequency: Row


class ModulesForm(_Form):
    """Modules on moving bases."""

    kind: Literal["modules"]
    moving_bases: list[dict[str, Any]]
    motions: list[dict[str, Any]]
