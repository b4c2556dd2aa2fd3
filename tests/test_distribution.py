"""What is published: an sdist and a wheel with all they need and nothing else; the wheel works where nothing else is.

Both are built by the hatchling that is installed; what the wheel depends on is installed in the versions that are here.
"""

import ast
import json
import os
import subprocess
import sys
import tarfile
import zipfile
from importlib.metadata import packages_distributions, version
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from test_licences import CORE, OPTIONAL, PROJECT

ROOT = Path(__file__).parents[1]
OURS = ("bench", "docs", "test", "dev")  # extras of those who work on it
PIP = ["-m", "pip", "--quiet", "--disable-pip-version-check", "install"]
EVERYTHING = """
import importlib, pkgutil, selfmotion
for module in pkgutil.walk_packages(selfmotion.__path__, "selfmotion."):
    if not module.name.endswith("__main__"):
        importlib.import_module(module.name)
print(selfmotion.__file__)
"""


def done(*command, **options):
    """Return what a command that must succeed prints."""
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, **options)
    assert result.returncode == 0, result.stdout + result.stderr
    return result.stdout


def files(folder="."):
    """Return the files of the checkout that git keeps, or would."""
    return set(done("git", "ls-files", "--cached", "--others", "--exclude-standard", folder, cwd=ROOT).splitlines())


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The sdist, and the wheel made from it."""
    folder = tmp_path_factory.mktemp("dist")
    done(sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, ROOT)
    (sdist,), (wheel,) = folder.glob("*.tar.gz"), folder.glob("*.whl")
    return sdist, wheel


def test_the_wheel_holds_every_file_of_the_package_and_no_other(built):
    names = set(zipfile.ZipFile(built[1]).namelist())
    kept = files("src/selfmotion")
    package = {name for name in names if ".dist-info/" not in name}
    assert package == {name.removeprefix("src/") for name in kept}
    assert {"selfmotion/py.typed", "selfmotion/report/report.css", "selfmotion/arms/data/panda.urdf"} <= package
    described = {name.partition(".dist-info/")[2] for name in names - package}
    assert described == {"METADATA", "WHEEL", "RECORD", "entry_points.txt", "licenses/LICENSE"}


def test_the_sdist_holds_what_git_keeps_but_for_what_only_we_need(built):
    with tarfile.open(built[0]) as archive:
        names = {member.name.partition("/")[2] for member in archive if member.isfile()}
    kept = files()
    assert names - kept == {"PKG-INFO"}
    assert {name.partition("/")[0] for name in kept - names} == {".ci", ".pre-commit-config.yaml"}


def test_the_sdist_makes_the_same_wheel_as_the_checkout(built, tmp_path):
    done(sys.executable, "-m", "build", "--no-isolation", "--wheel", "--outdir", tmp_path, ROOT)
    (wheel,) = tmp_path.iterdir()
    assert wheel.read_bytes() == built[1].read_bytes()


def test_the_wheel_works_where_nothing_else_is_installed(built, tmp_path):
    python = tmp_path / "venv" / "bin" / "python"
    pinned = tmp_path / "here.txt"
    pinned.write_text("".join(f"{name}=={found.version}\n" for name, found in CORE.items()))
    done(sys.executable, "-m", "venv", python.parents[1])
    try:
        done(python, *PIP, "--constraint", pinned, built[1])
    except AssertionError as error:
        if "CI" in os.environ or "connection" not in str(error):
            raise
        pytest.skip("no package index is in reach")
    done(python, "-m", "pip", "check")

    command = python.with_name("selfmotion")
    assert done(command, "--version", cwd=tmp_path).split()[-1] == version("selfmotion")
    assert "panda" in done(command, "arms", cwd=tmp_path)
    problem = ROOT / "examples" / "seed_3r.yaml"
    plan = json.loads(done(command, "plan", problem, "--json", cwd=tmp_path))
    assert (plan["status"], f"{plan['cost']:.7f}") == ("solved", "5.2775214")
    assert Path(done(python, "-c", EVERYTHING, cwd=tmp_path).strip()).is_relative_to(tmp_path)


def test_every_extra_is_satisfied_by_the_versions_that_are_here(built):
    report = done(sys.executable, *PIP, "--dry-run", "--no-index", "--report", "-", f"{built[1]}[all]")
    assert [each["metadata"]["name"] for each in json.loads(report)["install"]] == ["selfmotion"]


def imported():
    """Return the packages that the code imports, wherever in it."""
    for file in (ROOT / "src").rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                yield from (alias.name.partition(".")[0] for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                yield node.module.partition(".")[0]


def test_what_the_code_imports_is_asked_for():
    owners = packages_distributions()
    lines = PROJECT["dependencies"] + [line for extra in OPTIONAL if extra not in OURS for line in OPTIONAL[extra]]
    asked = {canonicalize_name(Requirement(line).name) for line in lines}
    others = set(imported()) - sys.stdlib_module_names - {"selfmotion"}
    assert [name for name in sorted(others) if asked.isdisjoint(map(canonicalize_name, owners.get(name, [])))] == []
