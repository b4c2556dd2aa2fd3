"""Whatever is in a file, reading it succeeds or says in one line what is wrong; and each finding stays mended."""

import json
import random
import signal
from pathlib import Path

import fuzz_kinds
import fuzz_samples
import pytest
from fuzz_kinds import KINDS, Case, Kind, judged
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

FOUND = sorted(file for file in (Path(__file__).parent / "found").rglob("*.*") if file.suffix != ".options")
COUNT = 120

pytestmark = pytest.mark.skipif(not hasattr(signal, "SIGPROF"), reason="no clock of the processor's time")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    for package in ("ezdxf", "svgpathtools", "rosbags"):
        pytest.importorskip(package)
    made = tmp_path_factory.mktemp("fuzz")
    fuzz_samples.companions(made)
    return made


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_wrong_is_said(kind, folder):
    for k in range(COUNT):
        case = KINDS[kind].made(random.Random(f"{kind} 0 {k}"))
        assert judged(case, folder) is None, f"fuzz.py --kind {kind} --seed 0, input {k}"


@pytest.mark.parametrize("kind", ["problem", "waypoints", "plan"])
def test_what_is_wrong_with_the_structure_is_said(kind, folder):
    """By hypothesis, which makes what it finds small."""

    @settings(max_examples=100, suppress_health_check=list(HealthCheck))
    @given(st.randoms(use_true_random=False))
    def check(dice):
        case = KINDS[kind].made(dice)
        assert judged(case, folder) is None, case.data

    check()


@pytest.mark.parametrize("file", FOUND, ids=lambda file: f"{file.parent.name}/{file.name}")
def test_what_was_found_stays_mended(file, folder):
    options = file.with_name(f"{file.name}.options")
    given = json.loads(options.read_text()) if options.exists() else {}
    assert judged(Case(file.parent.name, file.read_bytes(), file.suffix, given), folder) is None


ARM = b'{"arm": {"kind": "planar", "links": [3, 3, 2]}, "path": '
LONG = {
    "yaml of megabytes": ("problem", ".yaml", b"{a: [" + b"1, " * 430_000 + b"1]}"),
    "yaml of megabytes, by lines": ("problem", ".yaml", b"a:\n" + b"- [[[[1], 2]]]\n" * 100_000),
    "yaml of brackets": ("problem", ".yaml", b"a: [" + (b"[" * 300 + b"]" * 300 + b", ") * 600 + b"1]"),
    "json of megabytes": ("problem", ".json", b'{"a": [' + b"1, " * 430_000 + b"1]}"),
    "a file without end": ("problem", ".json", ARM + b'{"kind": "file", "file": "/dev/zero"}}'),
}


@pytest.mark.parametrize("name", LONG)
def test_what_is_long_is_read_or_refused_soon(name, folder):
    kind, suffix, data = LONG[name]
    assert judged(Case(kind, data, suffix), folder) is None


def reading(function, monkeypatch):
    monkeypatch.setitem(KINDS, "broken", Kind(None, lambda file, _: function(file)))
    return Case("broken", b"x", ".txt")


def test_the_law_sees_what_breaks_it(folder, monkeypatch):
    def endless(_):
        while True:
            pass

    def writes(file):
        file.with_name("left.txt").write_text("x")

    def hoards(_):
        return "x" * 10**10

    def divides(_):
        return 1 // 0

    monkeypatch.setattr(fuzz_kinds, "SECONDS", 0.2)
    broken = {"TooSlow": endless, "MemoryError": hoards, "ZeroDivisionError": divides, "wrote": writes}
    for what, function in broken.items():
        assert judged(reading(function, monkeypatch), folder).what == what
    (folder / "left.txt").unlink()
    assert judged(reading(lambda _: None, monkeypatch), folder) is None
