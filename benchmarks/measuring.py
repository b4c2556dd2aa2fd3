"""Times that can be compared: everything in one run, by turns, after a warm-up, on a stated machine."""

import importlib.metadata
import json
import os
import platform
import subprocess
import sys
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np


class Times(NamedTuple):
    """Seconds of one contender, one per round, and what each round returned."""

    seconds: np.ndarray
    results: list

    @property
    def median(self):
        """Median of the seconds."""
        return float(np.median(self.seconds))

    def over(self, other):
        """Return how many times as long this took as another, round by round: median and quartiles."""
        return tuple(float(q) for q in np.quantile(self.seconds / other.seconds, (0.5, 0.25, 0.75)))


def by_turns(contenders, rounds, together=1):
    """Run contenders by turns, each once in every round; what the machine does meanwhile hits all of them alike.

    Parameters
    ----------
    contenders : mapping
        Name to a function of the round's number.
    rounds : int
    together : int
        Calls of a contender per round, whose mean counts: for what takes microseconds.

    Returns
    -------
    dict
        Name to `Times`. Each contender runs once before anything is timed.
    """
    for run in contenders.values():
        run(0)
    seconds, results = {name: [] for name in contenders}, {name: [] for name in contenders}
    order = list(contenders)
    for k in range(rounds):
        for name in order[k % len(order) :] + order[: k % len(order)]:
            run = contenders[name]
            began = time.perf_counter()
            for _ in range(together):
                result = run(k)
            seconds[name].append((time.perf_counter() - began) / together)
            results[name].append(result)
    return {name: Times(np.array(seconds[name]), results[name]) for name in contenders}


def exponent(sizes, seconds):
    """Return p of seconds ~ sizeᵖ, fitted to the larger half, where what does not grow has lost its weight."""
    half = len(sizes) // 2
    return float(np.polyfit(np.log(sizes[half:]), np.log(seconds[half:]), 1)[0])


def peak_memory(code):
    """Return the most memory that a fresh interpreter takes to run `code`, in MB, its imports included.

    Read from /proc: what `resource` tells counts the process that this one was forked from. None where there is none.
    """
    if not Path("/proc/self/status").exists():
        return None
    wrapped = f"{code}\nprint(next(line.split()[1] for line in open('/proc/self/status') if line.startswith('VmHWM')))"
    run = subprocess.run(
        [sys.executable, "-c", wrapped], capture_output=True, text=True, check=True, cwd=Path(__file__).parent
    )
    return int(run.stdout.split()[-1]) // 1024


def version_of(package):
    """Return a package's version, None where it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def machine(packages):
    """Return what a reader must know of the machine and of the packages that are compared."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "system": platform.system(),
        "python": platform.python_version(),
        "packages": {name: version_of(name) for name in packages},
    }


def _processor():
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    flags = " ".join(line for line in lines if line.startswith("flags"))
    wide = next((name for name in ("avx512f", "avx2", "neon") if name in flags), "no wide vectors known")
    return f"{names[0] if names else platform.machine()} ({wide})"


def write_json(file, content):
    """Write a JSON file whole or not at all."""
    part = file.with_suffix(".part")
    part.write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    part.replace(file)
