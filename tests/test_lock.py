"""The locked requirements are in step with pyproject.toml, whole, and say nothing of where they were made."""

import re
import tomllib
from pathlib import Path

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCK = (ROOT / "requirements" / "dev.txt").read_text(encoding="utf-8")
PYTHONS = ("3.11.2", "3.12.0", "3.13.0")
ENTRY = re.compile(r"^([\w.-]+)==(\S+)(?: ; (.+))? \\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", re.M)
ENTRIES = [(name, version, marker) for name, version, marker, _ in ENTRY.findall(LOCK)]


def wanted(extra):
    """Return the direct requirements of an extra, and of the extras that it takes in."""
    for line in PROJECT["optional-dependencies"][extra]:
        requirement = Requirement(line)
        if requirement.name == PROJECT["name"]:
            yield from (further for each in requirement.extras for further in wanted(each))
        else:
            yield requirement


DIRECT = sorted({*map(Requirement, PROJECT["dependencies"]), *wanted("dev")}, key=str)


@pytest.mark.parametrize("python", PYTHONS)
@pytest.mark.parametrize("requirement", DIRECT, ids=str)
def test_every_requirement_is_locked_to_one_version_that_it_allows(requirement, python):
    here = {"python_version": python.rpartition(".")[0], "python_full_version": python, "sys_platform": "linux"}
    here |= {"platform_python_implementation": "CPython", "platform_machine": "x86_64", "platform_system": "Linux"}
    versions = [
        version
        for name, version, marker in ENTRIES
        if name == canonicalize_name(requirement.name) and (not marker or Marker(marker).evaluate(here))
    ]
    assert [requirement.specifier.contains(version, prereleases=True) for version in versions] == [True], (
        f"{requirement} is locked to {versions}: run `make lock`"
    )


def test_every_entry_has_hashes_and_nothing_else_is_there():
    left = re.sub(r"^ *#.*\n", "", ENTRY.sub("", LOCK), flags=re.M)
    assert left == ""
    assert "://" not in LOCK


def test_nothing_is_locked_for_our_sake_that_we_no_longer_ask_for():
    reasons = re.findall(r"^([\w.-]+)==[^#]*((?:    # .*\n)+)", LOCK, re.M)
    ours = {name for name, reason in reasons if f"{PROJECT['name']} (pyproject.toml)" in reason}
    assert ours == {canonicalize_name(requirement.name) for requirement in DIRECT}
