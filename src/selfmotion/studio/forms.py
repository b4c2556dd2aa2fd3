"""The forms of what a page may send with each task; problems and arrays inside are checked by whoever takes them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictStr

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Array = list[Any] | dict[str, Any]
"""Nested lists of numbers, or packed; whoever takes it unpacks and checks it."""


class _Form(BaseModel):
    model_config = ConfigDict(extra="forbid")


class HandForm(_Form):
    """A curve moved by hand."""

    branch: StrictStr
    coefficients: Array


class AroundForm(_Form):
    """The motion on which the panels of an arm with several components stand."""

    r: Array
    u: Array
    branch: Any = 0


class LookForm(_Form):
    """What is shown of a problem at once."""

    problem: dict[str, Any]
    hand: HandForm | None = None
    frequency: list[Number] | None = None
    want: list[Literal["scene", "domain", "motion"]] = ["scene", "domain", "motion"]
    settled: StrictBool = True
    around: AroundForm | None = None


class ProblemOnly(_Form):
    """A problem."""

    problem: dict[str, Any]


class FitForm(_Form):
    """Samples that a curve is to follow."""

    problem: dict[str, Any]
    r: Array
    u: Array
    branch: StrictStr


class ExportForm(_Form):
    """A plan, or a motion moved by hand, to be written to a file."""

    format: Literal["csv", "plan", "png", "gif", "json"]
    problem: dict[str, Any] | None = None
    plan: StrictStr | None = None
    hand: HandForm | None = None


class ReadForm(_Form):
    """The text of a problem file."""

    text: StrictStr


class FileForm(_Form):
    """The name of a file in the studio's folder."""

    file: StrictStr


class CheckForm(FileForm):
    """A problem file that was named on the command line."""

    path: StrictStr


class SaveForm(_Form):
    """A problem and the name of its file."""

    file: StrictStr
    problem: dict[str, Any]
    force: StrictBool = False


class NothingForm(_Form):
    """Nothing."""


FORMS: dict[str, type[BaseModel]] = {
    "look": LookForm,
    "plan": ProblemOnly,
    "fit": FitForm,
    "export": ExportForm,
    "read": ReadForm,
    "write": ProblemOnly,
    "files": NothingForm,
    "open": FileForm,
    "save": SaveForm,
    "schema": NothingForm,
    "examples": NothingForm,
    "check": CheckForm,
}
