"""What selfmotion stands on is under permissive licences; `python tests/test_licences.py` prints all of them.

Read is what the installed distributions say of themselves: the SPDX expression, or else classifiers, or else the field
``License``. Where that names no licence, or is not all of the truth, the entry is in `READ_BY_HAND`, with the reason.
"""

import re
import tomllib
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
OPTIONAL = PROJECT["optional-dependencies"]
PERMISSIVE = {
    "0BSD", "Apache-2.0", "Apache-2.0 WITH LLVM-exception", "BSD-2-Clause", "BSD-3-Clause", "BSD", "BSL-1.0", "CC0-1.0",
    "ISC", "MIT", "MIT-CMU", "MIT-0", "PSF-2.0", "Qhull", "Unlicense", "Zlib",
}  # fmt: skip
WEAK_COPYLEFT = {"MPL-2.0", "LGPL"}  # of whole files or libraries: not in the core
NAMES = {
    "Apache Software License": "Apache-2.0",
    "BSD License": "BSD",
    "ISC License (ISCL)": "ISC",
    "MIT License": "MIT",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
    "The Unlicense (Unlicense)": "Unlicense",
    "Apache 2.0": "Apache-2.0",
    "Apache License 2.0": "Apache-2.0",
}
READ_BY_HAND = {
    "apsw": ("Zlib", "says any-OSI: its LICENSE lets anyone choose any licence that the OSI approves, such as zlib's"),
    "cmeel-qhull": (
        "Qhull",
        "says nothing in its metadata; its COPYING lets anyone copy, change and pass it on with notice",
    ),
    "docutils": ("BSD-2-Clause", "names the GPL for one Emacs file in its sources, which the wheel leaves out"),
    "eaik": ("BSD-3-Clause", "has the text of the licence in the place of its name"),
    "imageio-ffmpeg": (
        "BSD-2-Clause AND GPL-3.0-or-later",
        "says BSD of its Python part only; its wheel brings the program ffmpeg, built with --enable-gpl",
    ),
    "shapely": ("BSD-3-Clause AND LGPL", "says BSD of itself; its wheel brings the library GEOS, under the LGPL 2.1"),
    "pyglet": ("BSD-3-Clause", "says nothing in its metadata; the LICENSE in its sources is that of the BSD"),
}
# A program that is run as a process of its own and linked with nothing, where somebody asks for MP4.
GPL_BESIDE = {"imageio-ffmpeg"}


def asked_by(found: Distribution, extras):
    """Return the requirements of a distribution that hold here, with some of its extras."""
    for requirement in map(Requirement, found.requires or ()):
        marker = requirement.marker
        if marker is None or any(marker.evaluate({"extra": extra}) for extra in ("", *extras)):
            yield requirement


def pulled_in(requirements):
    """Return the distributions that requirements bring, and all that these need, by name; None where one is missing."""
    found, seen, left = {}, set(), list(requirements)
    while left:
        requirement = left.pop()
        name, extras = canonicalize_name(requirement.name), frozenset(requirement.extras)
        if (name, extras) in seen or name == PROJECT["name"]:
            left += [Requirement(line) for extra in extras if name == PROJECT["name"] for line in OPTIONAL[extra]]
            continue
        seen.add((name, extras))
        try:
            found[name] = distribution(name)
        except PackageNotFoundError:
            found[name] = None
        else:
            left += asked_by(found[name], extras)
    return dict(sorted(found.items()))


def licence(found: Distribution):
    """Return what a distribution says its licence is, as an SPDX expression where it can be told."""
    name, metadata = canonicalize_name(found.metadata["Name"]), found.metadata
    if name in READ_BY_HAND:
        return READ_BY_HAND[name][0]
    classified = [line.split(" :: ")[-1] for line in metadata.get_all("Classifier", []) if line.startswith("License")]
    named = " AND ".join(NAMES.get(one, one) for one in classified if one != "OSI Approved")
    said = metadata["License-Expression"] or named
    return said or NAMES.get(metadata["License"], metadata["License"]) or "unknown"


def is_among(expression, allowed):
    """Return whether a licence expression leaves a choice of `allowed` licences only; brackets are not read."""
    return all(any(one in allowed for one in re.split(" OR ", every)) for every in re.split(" AND ", expression))


CORE = pulled_in(map(Requirement, PROJECT["dependencies"]))
EXTRAS = {extra: pulled_in(map(Requirement, lines)) for extra, lines in OPTIONAL.items()}


@pytest.mark.parametrize("name", CORE)
def test_the_core_stands_on_permissive_licences(name):
    said = licence(CORE[name])
    assert is_among(said, PERMISSIVE), f"{name} is under {said}"


@pytest.mark.parametrize("extra", EXTRAS)
def test_no_extra_brings_the_gpl_or_what_nobody_has_read(extra):
    said = {name: licence(found) for name, found in EXTRAS[extra].items() if found and name not in GPL_BESIDE}
    assert {name: text for name, text in said.items() if not is_among(text, PERMISSIVE | WEAK_COPYLEFT)} == {}


def test_what_is_tested_is_installed():
    missing = {extra: [name for name, found in EXTRAS[extra].items() if not found] for extra in ("all", "test")}
    assert missing == {"all": [], "test": []}


def test_what_was_read_by_hand_is_still_there():
    everything = {name for packages in EXTRAS.values() for name in packages} | set(CORE)
    assert set(READ_BY_HAND) <= everything


@pytest.mark.parametrize(
    "expression", ["GPL-3.0-or-later", "MIT AND GPL-2.0-only", "LGPL-3.0-only", "", "unknown", "(MIT)"]
)
def test_what_is_not_known_to_be_permissive_is_not(expression):
    assert not is_among(expression, PERMISSIVE)
    assert is_among("Apache-2.0 OR GPL-2.0-only", PERMISSIVE)


if __name__ == "__main__":
    for kind, packages in {"core": CORE, **EXTRAS}.items():
        for name, found in packages.items():
            if kind == "core" or name not in CORE:
                print(f"{kind:10} {name:32} {f'{found.version:20} {licence(found)}' if found else 'not installed'}")
