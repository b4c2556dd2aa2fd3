"""Study files: which runs a study consists of."""

from __future__ import annotations

import hashlib
import itertools
import os
from collections.abc import Iterator
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, ConfigDict, Field, StrictBool, StrictInt, create_model

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.files import read_bytes, read_text
from selfmotion.exchange.named_files import named_files
from selfmotion.exchange.problem_file import problem_from
from selfmotion.exchange.schema import SECTIONS, ProblemForm, build, checked, form, inside
from selfmotion.exchange.yaml_text import parse_yaml
from selfmotion.planners import Planner
from selfmotion.study.random_problems import KINDS
from selfmotion.study.runs import Run

TASK = "selfmotion.study.tasks:plan"
MOST_RUNS = 1_000_000
_LARGEST = 50_000_000
_NAME = r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$"
_ELSEWHERE = ("arm", "path", "planner")  # parts of a problem file that are no options


class _Form(BaseModel):
    model_config = ConfigDict(extra="forbid")


class RandomForm(_Form):
    """Problems that a generator makes of the seeds from `seed` on."""

    kind: Literal[tuple(KINDS)]  # type: ignore[valid-type]
    count: Annotated[StrictInt, Field(ge=1, le=100_000)]
    seed: Annotated[StrictInt, Field(ge=0, le=2**31)] = 0


class ProblemsForm(_Form):
    """``problems:``; every arm with every path, problem files, and what a generator makes."""

    arms: dict[str, dict[str, Any]] = {}
    paths: dict[str, dict[str, Any]] = {}
    files: list[str] = []
    random: RandomForm | None = None


class SeedsForm(_Form):
    """``seeds:`` as a range."""

    first: Annotated[StrictInt, Field(ge=0, le=2**62)] = 0
    count: Annotated[StrictInt, Field(ge=1, le=1_000_000)]


class StudyForm(_Form):
    """A study file."""

    study: Annotated[str, Field(pattern=_NAME)]
    problems: ProblemsForm
    options: dict[str, Any] = {}
    planners: dict[str, dict[str, Any]] = {}
    optimizers: dict[str, dict[str, Any]] = {}
    seeds: SeedsForm | list[Annotated[StrictInt, Field(ge=0, le=2**62)]] | None = None
    history: StrictBool = True


_OPTIONS: dict[str, Any] = {
    name: (field.annotation, field) for name, field in ProblemForm.model_fields.items() if name not in _ELSEWHERE
}
OptionsForm = create_model("OptionsForm", __base__=_Form, __doc__="``options:`` of all arms with paths.", **_OPTIONS)


class _Case(NamedTuple):
    """A problem: its name, its plain data, the planner that its file names, and the folder that files are in."""

    name: str
    data: dict[str, Any]
    planner: dict[str, Any] | None
    folder: str


class _Method(NamedTuple):
    """A planner with its optimizer: their names, the planner's data, and whether a seed matters."""

    planner: str
    optimizer: str
    data: dict[str, Any]
    seeded: bool


def read_study(file: str | os.PathLike[str]) -> tuple[str, list[Run], str]:
    """Return the name of a study file, its runs and its text; see :meth:`Study.load`."""
    source = os.fspath(file)
    text = read_text(source, _LARGEST)
    data = parse_yaml(text, source)
    try:
        name, runs = _expanded(data, os.path.dirname(os.path.abspath(source)))
    except InvalidInputError as error:
        raise error.inside(source=source) from None
    return name, runs, text


def _expanded(data: Any, folder: str) -> tuple[str, list[Run]]:
    """Return a study's name and runs."""
    given = checked(StudyForm, data)
    assert isinstance(given, StudyForm)
    cases = _cases(given, folder)
    seeds = _seeds(given)
    missing = next((case.name for case in cases if case.planner is None), None)
    if not given.planners and missing is not None:
        reason = f"is missing, and the problem {missing} names none"
        raise InvalidInputError("planners", reason, "add planners: {name: {kind: sinusoid, …}}")
    methods = _methods(given, folder, seeds != [None])
    total = len(cases) * sum(len(seeds) if method.seeded else 1 for method in methods or [_own(cases[0])])
    if total > MOST_RUNS:
        raise InvalidInputError("", f"makes {total} runs, more than {MOST_RUNS}", "split it into several studies")
    hashes: dict[str, str] = {}
    runs = []
    for case in cases:
        for method in methods or [_own(case)]:
            files = _hashes(case, method, folder, hashes)
            for seed in seeds if method.seeded else [None]:
                specification = {
                    "problem": case.data, "planner": method.data, "seed": seed, "history": given.history, **files,
                }  # fmt: skip
                runs.append(Run(TASK, specification, case.name, method.planner, method.optimizer, seed, case.folder))
    return given.study, runs


def _cases(given: StudyForm, folder: str) -> list[_Case]:
    """Return all problems, each checked by the forms of problem files."""
    problems = given.problems
    if not (problems.arms or problems.paths or problems.files or problems.random):
        remedy = "give arms and paths, files, or random: {kind: …, count: …}"
        raise InvalidInputError("problems", "names no problem", remedy)
    cases = list(_arms_by_paths(given, folder))
    for k, name in enumerate(problems.files):
        try:
            cases.append(_from_file(name, folder))
        except InvalidInputError as error:
            reason = f"{error.field}: {error.reason}" if error.field else error.reason
            raise InvalidInputError(f"problems.files.{k}", f"{name}: {reason}", error.remedy, error.value) from None
    if problems.random is not None:
        kind = problems.random.kind
        for seed in range(problems.random.seed, problems.random.seed + problems.random.count):
            cases.append(_Case(f"{kind} {seed}", {"random": {"kind": kind, "seed": seed}}, None, ""))
    return cases


def _arms_by_paths(given: StudyForm, folder: str) -> Iterator[_Case]:
    arms, paths = given.problems.arms, given.problems.paths
    for one, other, names in (("arms", "paths", arms), ("paths", "arms", paths)):
        if names and not (arms and paths):
            raise InvalidInputError(f"problems.{other}", f"is missing beside {one}", "give both")
    if given.options and not arms:
        raise InvalidInputError("options", "is for arms with paths, and there are none", "leave it out")
    if arms:
        inside("options", checked, OptionsForm, given.options)
    for name, data in arms.items():
        inside(f"problems.arms.{name}", build, "arm", data, folder)
    for (arm, arm_data), (path, path_data) in itertools.product(arms.items(), paths.items()):
        data = {"arm": arm_data, "path": path_data, **given.options}
        try:
            problem_from(data, folder)
        except InvalidInputError as error:
            raise _placed(error, arm, path) from None
        yield _Case(f"{arm} {path}", data, None, folder)


def _placed(error: InvalidInputError, arm: str, path: str) -> InvalidInputError:
    """Return an error of a problem with the field that it has in the study."""
    first, _, rest = error.field.partition(".")
    field = {"arm": f"problems.arms.{arm}", "path": f"problems.paths.{path}"}.get(first, f"options.{first}")
    where = ".".join(part for part in (field, rest) if part)
    return InvalidInputError(where, f"{error.reason} (arm {arm}, path {path})", error.remedy, error.value)


def _from_file(name: str, folder: str) -> _Case:
    file = os.path.join(folder, name)
    data = parse_yaml(read_text(file, _LARGEST), name)
    around = os.path.dirname(file)
    problem_from(data, around)
    return _Case(name, {k: v for k, v in data.items() if k != "planner"}, data.get("planner"), around)


def _seeds(given: StudyForm) -> list[int | None]:
    seeds = given.seeds
    if seeds is None:
        return [None]
    if isinstance(seeds, SeedsForm):
        return list(range(seeds.first, seeds.first + seeds.count))
    if len(set(seeds)) < len(seeds) or not seeds:
        raise InvalidInputError("seeds", "is empty or names one twice", "give whole numbers, each once", seeds)
    return list(seeds)


def _methods(given: StudyForm, folder: str, seeded: bool) -> list[_Method]:
    """Return every planner with every optimizer that it needs."""
    for name, data in given.optimizers.items():
        inside(f"optimizers.{name}", build, "optimizer", data, folder)
        _refuse_seed(f"optimizers.{name}", data, seeded)
    methods = []
    used = False
    for name, data in given.planners.items():
        field = f"planners.{name}"
        _refuse_seed(field, data, seeded)
        options = [
            (label, whole)
            for label, chosen in given.optimizers.items()
            if (whole := _completed("planner", data, chosen)) is not None
        ]
        used = used or bool(options)
        for label, whole in options or [(_optimizer_of(data), data)]:
            planner = inside(field, build, "planner", whole, folder)
            methods.append(_Method(name, label, whole, _depends_on_seed(planner)))
    if given.optimizers and not used:
        reason = "is of no use: no planner lacks an optimizer"
        raise InvalidInputError("optimizers", reason, "leave it out, or the planners' own", list(given.optimizers))
    return methods


def _completed(section: str, data: dict[str, Any], chosen: dict[str, Any]) -> dict[str, Any] | None:
    """Return a planner, or an optimizer around another one, with the optimizer that it lacks; None if it lacks none."""
    kind = data.get("kind")
    known = isinstance(kind, str) and kind in SECTIONS[section]
    if not known or "optimizer" not in form(section, kind).model_fields:
        return None
    if "optimizer" not in data:
        return {**data, "optimizer": chosen}
    inner = data["optimizer"]
    completed = _completed("optimizer", inner, chosen) if isinstance(inner, dict) else None
    return None if completed is None else {**data, "optimizer": completed}


def _optimizer_of(data: dict[str, Any]) -> str:
    inner = data.get("optimizer")
    return str(inner.get("kind", "")) if isinstance(inner, dict) else ""


def _own(case: _Case) -> _Method:
    """Return the planner of a problem file."""
    data = case.planner
    assert data is not None
    return _Method(data["kind"], _optimizer_of(data), data, _depends_on_seed(build("planner", data, case.folder)))


def _depends_on_seed(planner: Planner) -> bool:
    return planner.with_seed(0) is not planner


def _refuse_seed(field: str, data: dict[str, Any], seeded: bool) -> None:
    """Refuse a seed beside the study's."""
    if not seeded:
        return
    if "seed" in data:
        raise InvalidInputError(f"{field}.seed", "is given beside the study's seeds", "leave it out", data["seed"])
    for name in ("optimizer", "initial"):
        if isinstance(data.get(name), dict):
            _refuse_seed(f"{field}.{name}", data[name], seeded)


def _hashes(case: _Case, method: _Method, folder: str, known: dict[str, str]) -> dict[str, Any]:
    """Return what identifies the files that a problem and its planner are read from besides their own."""
    names = [name for field, name in named_files(case.data) if not field.startswith("planner")]
    found = {}
    for name in names:
        file = os.path.join(case.folder, name)
        if file not in known:
            known[file] = fingerprint(file)
        found[name] = known[file]
    return {"files": found} if found else {}


def fingerprint(file: str) -> str:
    """Return a hash of a file's contents."""
    return hashlib.sha256(read_bytes(file)).hexdigest()
