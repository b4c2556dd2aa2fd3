"""The shape of the house: what is public, what it costs to import, and that every part is documented."""

import ast
import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import selfmotion as sm
from selfmotion import plot
from selfmotion.arms import ARMS
from selfmotion.objectives import OBJECTIVES
from selfmotion.optimizers import OPTIMIZERS
from selfmotion.paths import PATHS
from selfmotion.planners import PLANNERS
from selfmotion.profiles import PROFILES
from selfmotion.scene import OBSTACLES

REGISTRIES = {
    "paths": PATHS,
    "arms": ARMS,
    "profiles": PROFILES,
    "objectives": OBJECTIVES,
    "optimizers": OPTIMIZERS,
    "planners": PLANNERS,
    "obstacles": OBSTACLES,
}
PARTS = [(name, kind) for name, registry in REGISTRIES.items() for kind in registry]


@pytest.mark.parametrize("name", sm.__all__)
def test_every_public_name_is_there(name):
    assert getattr(sm, name) is not None
    assert name in dir(sm)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'Plam'"):
        sm.Plam  # noqa: B018


def test_import_is_nearly_free():
    heavy = "{'numpy', 'scipy', 'matplotlib', 'pydantic', 'typer', 'rich', 'yaml'} & set(sys.modules)"
    code = f"import sys, selfmotion; heavy = {heavy}; sys.exit(str(heavy) if heavy else 0)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(("registry", "kind"), PARTS)
def test_every_part_is_documented_under_its_kind(registry, kind):
    part = REGISTRIES[registry][kind]
    assert part.kind == kind
    text = inspect.getdoc(part)
    assert text
    parameters = list(inspect.signature(part).parameters)
    if parameters not in (["args", "kwargs"], []):
        assert "Parameters" in text
        for name in parameters:
            assert name in text, f"{part.__name__} does not document {name}"


@pytest.mark.parametrize("registry", [name for name in REGISTRIES if name != "profiles"])
def test_the_docs_have_a_table_of_every_registry(registry, tmp_path):
    docs = Path(__file__).parents[1] / "docs"
    assert f"_generated/{registry}.md" in (docs / "problem-file.md").read_text(encoding="utf-8")
    sys.path.insert(0, str(docs))
    try:
        from tables import write_tables
    finally:
        sys.path.remove(str(docs))
    write_tables(tmp_path / "t")
    table = (tmp_path / "t" / f"{registry}.md").read_text(encoding="utf-8")
    for kind in REGISTRIES[registry]:
        assert f"| `{kind}` |" in table


EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.py"))
PROBLEMS = sorted(file for file in EXAMPLES[0].parent.glob("*.yaml") if not file.stem.startswith("study"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_every_example_runs_and_leaves_its_picture(example, tmp_path):
    folder = tmp_path / "pictures"
    done = subprocess.run([sys.executable, str(example), str(folder)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert [file.name for file in folder.iterdir()] == [f"{example.stem}.png"]
    assert (folder / f"{example.stem}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_every_example_imports_public_names_only(example):
    tree = ast.parse(example.read_text(encoding="utf-8"))
    used = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and is_name(node.value, "sm")}
    drawn = {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute) and is_name(node.value, "plot")}
    imported = {
        node.module: [name.name for name in node.names] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
    }
    assert used <= set(sm.__all__)
    assert drawn <= set(plot.__all__)
    assert imported == {"pathlib": ["Path"], "selfmotion": ["plot"]}


def is_name(node, name):
    return isinstance(node, ast.Name) and node.id == name


@pytest.mark.parametrize("problem", PROBLEMS, ids=lambda path: path.name)
def test_every_example_problem_is_solved(problem):
    loaded = sm.load_problem(problem)
    assert sm.plan(loaded.problem, loaded.planner).verification.holds


def test_the_readme_s_code_runs_and_prints_what_it_says():
    readme = (EXAMPLES[0].parents[1] / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"^```python\n(.*?)^```", readme, re.S | re.M)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("5.2775214")
    assert "IntervalSet([-2.06678, 1.67199]; period 6.28319)" in done.stdout
    assert "solved: cost 5.27752142 " in readme


def test_all_is_every_extra_but_the_developers():
    pyproject = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    extras = pyproject["project"]["optional-dependencies"]
    (everything,) = extras["all"]
    named = set(everything.removeprefix("selfmotion[").removesuffix("]").split(","))
    assert named == set(extras) - {"all", "bench", "docs", "test", "dev"}


def test_what_is_to_be_installed_is_quoted_for_the_shell():
    for file in Path(sm.__file__).parent.rglob("*.py"):
        for line in file.read_text(encoding="utf-8").splitlines():
            assert not re.search(r"pip install [^'\s]+\[", line), f"{file.name}: {line}"
