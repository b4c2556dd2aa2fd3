"""What is fuzzed, and the law.

A reader succeeds or raises SelfMotionError in one line, soon, within bounded memory, and writes nothing.
"""

import json
import os
import signal
import time
import traceback
import warnings
from collections.abc import Callable
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import fuzz_samples as samples
import numpy as np
from fuzz_mutations import altered, mutated

import selfmotion as sm
from selfmotion.exchange import load_waypoints, read_dxf, read_gcode, read_svg, read_trajectory
from selfmotion.exchange.drawings import read_drawing
from selfmotion.exchange.timed_file import FORMS

SECONDS = 5.0
"""Of the processor, so that a busy machine makes no findings."""
ROOM = 2 << 30
"""Of memory, in bytes."""


class Case(NamedTuple):
    """One input: what is in the file, how its name ends, and how it is to be read."""

    kind: str
    data: bytes
    suffix: str
    options: dict[str, Any] = {}  # noqa: RUF012


class Kind(NamedTuple):
    """What is fuzzed: how an input is made of dice, and how it is read."""

    made: Callable[[Any], Case]
    read: Callable[[Path, dict[str, Any]], Any]


class Finding(NamedTuple):
    """What broke the law."""

    what: str
    where: str
    detail: str


class TooSlow(BaseException):
    """Not an Exception, which readers of foreign formats catch."""


@contextmanager
def at_most(seconds):
    def stop(*_):
        raise TooSlow

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


@contextmanager
def with_room(room):
    """Let no more than so many bytes be taken beyond those that are; beyond, there is a MemoryError."""
    if not Path("/proc/self/statm").exists():  # elsewhere than on Linux nobody keeps to limits
        yield
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    most = taken + room
    resource.setrlimit(resource.RLIMIT_AS, (most if hard == resource.RLIM_INFINITY else min(most, hard), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def judged(case, folder):
    """Return what breaks the law when a case is read in a folder that holds `companions`; None if nothing does."""
    file = folder / f"input{case.suffix}"
    file.write_bytes(case.data)
    before, begun, here = _listing(folder), time.process_time(), Path.cwd()
    os.chdir(folder)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with at_most(SECONDS), with_room(ROOM):
                KINDS[case.kind].read(file, case.options)
    except sm.SelfMotionError as error:
        if len(str(error).splitlines()) > 1 or len(str(error)) > 20_000:
            return Finding("message", "", f"is not one line that can be read: {str(error)[:2000]!r}")
    except TooSlow as error:
        return Finding("TooSlow", _where(error), "".join(traceback.format_exception(error)[-6:]))
    except Exception as error:
        return Finding(type(error).__name__, _where(error), "".join(traceback.format_exception(error)[-8:]))
    finally:
        os.chdir(here)
        after = _listing(folder)
        file.unlink(missing_ok=True)
    if after != before:
        return Finding("wrote", "", f"{sorted(set(after) ^ set(before))}")
    if time.process_time() - begun > SECONDS:
        return Finding("TooSlow", "", f"{time.process_time() - begun:.1f} s")
    return None


def _listing(folder):
    return [(entry.name, entry.stat().st_size, entry.stat().st_mtime_ns) for entry in os.scandir(folder)]


def _where(error):
    """Return the last place in selfmotion's own source."""
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if "/selfmotion/" in frame.filename]
    return f"{Path(frames[-1].filename).name}:{frames[-1].name}" if frames else ""


def _json(data):
    try:
        return json.dumps(data)
    except RecursionError:
        return "[" * 5000


def _structured(kind, sources, suffix, text):
    def made(dice):
        others = sources()
        return Case(kind, text(dice, mutated(dice, dice.choice(others), others)), suffix)

    return made


def _yaml(dice, data):
    """Return a problem's data as JSON, which is YAML as well, now and then with its text made wrong too."""
    text = _json(data).replace("NaN", ".nan").replace("Infinity", ".inf").encode()
    return text if dice.randrange(12) else altered(dice, text)


def _checksummed(dice, data):
    """Return the text of a plan file, as a rule with its checksum right again, so that what is in it is read."""
    try:
        return (
            samples.checksummed(data) if isinstance(data, dict) and dice.randrange(20) else json.dumps(data)
        ).encode()
    except (RecursionError, TypeError):
        return b"[" * 5000


@cache
def _problems():
    return samples.problems()


@cache
def _plans():
    return [json.loads(file.read_text()) for file in sorted(samples.SEEDS.glob("plan-*.json"))]


@cache
def _plan_texts():
    return [file.read_bytes() for file in sorted(samples.SEEDS.glob("plan-*.json"))]


@cache
def _yaml_texts():
    import yaml

    return [yaml.safe_dump(data).encode() for data in _problems()]


def _texts(kind, sources, suffix, options=lambda dice: {}, tokens=True):
    def made(dice):
        others = sources()
        return Case(kind, altered(dice, dice.choice(others), others, tokens), suffix, options(dice))

    return made


_OPTIONS = {
    "unit": [None, "mm", "mm", "inch", "px", "m"],
    "gaps": ["line"],
    "lift": [None, None, None, None, 5.0, -1e-3],
    "scale": [1.0, 1.0, 1e-9, 1e9, 1e200],
    "tolerance": [None, None, 1e-12, 0.1, 1e9],
    "subpath": [None, None, None, 0, 1],
    "arm_unit": ["m", "mm"],
}
_PROGRAM = {name: values for name, values in _OPTIONS.items() if name not in ("gaps", "lift")}


def _reading(dice, known=_OPTIONS):
    """Return options of readers of drawings, most of them left out."""
    return {name: dice.choice(values) for name, values in known.items() if not dice.randrange(5)}


def _reading_gcode(dice):
    """Return options of G-code: of a program in space, or with its depth dropped."""
    if dice.randrange(2):
        return {"dimension": 2, "gaps": "line", **_reading(dice, _PROGRAM)}
    return _reading(dice, _PROGRAM)


def _drawn(read):
    """Read a drawing, and look at all that it says."""

    def looked_at(file, options):
        found = read(file, **options)
        found.summary()
        path = found.path
        path(np.linspace(0.0, 1.0, 33))

    return looked_at


def _plan(file, _):
    plan = sm.load_plan(file)
    plan(np.linspace(0.0, 1.0, 17))


def _urdf(file, _):
    from selfmotion.arms.catalogue import urdf_arm

    urdf_arm(str(file))


KINDS = {
    "problem": Kind(_structured("problem", _problems, ".yaml", _yaml), lambda file, _: sm.load_problem(file)),
    "yaml": Kind(_texts("yaml", _yaml_texts, ".yaml"), lambda file, _: sm.load_problem(file)),
    "svg": Kind(_texts("svg", lambda: samples.SVG, ".svg", _reading), _drawn(read_svg)),
    "dxf": Kind(_texts("dxf", lambda: samples.DXF, ".dxf", _reading), _drawn(read_dxf)),
    "gcode": Kind(_texts("gcode", lambda: samples.GCODE, ".nc", _reading_gcode), _drawn(read_gcode)),
    "csv": Kind(_texts("csv", lambda: samples.CSV, ".csv", _reading), _drawn(read_drawing)),
    "waypoints": Kind(
        _structured("waypoints", lambda: samples.POINTS_JSON, ".json", lambda _, data: _json(data).encode()),
        lambda file, _: load_waypoints(file),
    ),
    "npy": Kind(_texts("npy", samples.points_npy, ".npy", tokens=False), lambda file, _: load_waypoints(file)),
    "motion": Kind(_texts("motion", lambda: samples.MOTION_CSV, ".csv"), lambda file, _: read_trajectory(file, 3)),
    "urdf": Kind(_texts("urdf", lambda: samples.URDFS, ".urdf"), _urdf),
    "plan": Kind(_structured("plan", _plans, ".json", _checksummed), _plan),
    "plan_text": Kind(_texts("plan_text", _plan_texts, ".json"), _plan),
    **{
        f"timed_{form}": Kind(
            _texts(
                f"timed_{form}",
                cache(lambda form=form: [(samples.SEEDS / f"trajectory.{form}").read_bytes()]),
                f".{form}",
                tokens=form not in ("npz", "mcap"),
            ),
            lambda file, _: sm.load_trajectory(file),
        )
        for form in FORMS
    },
}
"""By name."""
