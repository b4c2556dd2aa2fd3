"""How many arithmetic operations the objective takes per sample, counted by running its kernels on numbers that count.

Run by ``kernels.py`` in an interpreter in which nothing is compiled; prints JSON.
"""

import json
import os
from collections import Counter

os.environ["NUMBA_DISABLE_JIT"] = "1"

import numpy as np
from seed_case import candidates

from selfmotion.arms._motion_kernels import blank_sheet
from selfmotion.planners import _candidate_kernels as kernels

COUNTS = Counter()


class Counting:
    """A number that counts what is done with it; comparisons and selections are left out."""

    def __init__(self, value):
        self.value = value.value if isinstance(value, Counting) else float(value)

    def __float__(self):
        return self.value


def _binary(name, kind, compute):
    def operate(self, other):
        COUNTS[kind] += 1
        return Counting(compute(self.value, other.value if isinstance(other, Counting) else float(other)))

    setattr(Counting, f"__{name}__", operate)
    setattr(Counting, f"__r{name}__", lambda self, other: operate(Counting(other), self))


def _unary(name, kind, compute):
    def operate(self):
        COUNTS[kind] += 1
        return Counting(compute(self.value))

    setattr(Counting, name, operate)


def _comparison(name, compute):
    setattr(
        Counting, f"__{name}__",
        lambda self, other: compute(self.value, other.value if isinstance(other, Counting) else float(other)),
    )  # fmt: skip


for _name, _kind, _compute in (
    ("add", "add", lambda a, b: a + b), ("sub", "add", lambda a, b: a - b), ("mul", "multiply", lambda a, b: a * b),
    ("truediv", "divide", lambda a, b: a / b if b else np.inf),
):  # fmt: skip
    _binary(_name, _kind, _compute)
for _name, _kind, _compute in (
    ("sqrt", "root", lambda a: np.sqrt(a) if a > 0 else 0.0), ("rint", "round", np.rint), ("floor", "round", np.floor),
):  # fmt: skip
    _unary(_name, _kind, _compute)
for _name, _compute in (
    ("lt", lambda a, b: a < b), ("le", lambda a, b: a <= b), ("gt", lambda a, b: a > b), ("ge", lambda a, b: a >= b),
    ("eq", lambda a, b: a == b),
):  # fmt: skip
    _comparison(_name, _compute)
Counting.__neg__ = lambda self: Counting(-self.value)
Counting.__abs__ = lambda self: Counting(abs(self.value))
Counting.__pow__ = lambda self, power: self * self
Counting.__hash__ = None


def per_place(run):
    """Return the operations per place, from the difference of two lengths."""
    counts = []
    for k in (16, 32):
        COUNTS.clear()
        run(k)
        counts.append(dict(COUNTS))
    return {kind: (counts[1][kind] - counts[0][kind]) / 16 for kind in counts[1]}


def counting(table):
    """Return a table of numbers that count."""
    return np.vectorize(Counting, otypes=[object])(table)


def main():
    """Print the operations of a chord and of a node."""
    search = candidates("integral")._search
    a, sheet = np.array([Counting(0.54)], dtype=object), blank_sheet(3).astype(object)

    def chords(k):
        kernels.sampled(search.family, a, counting(search.samples[:, :k]), True, sheet)

    def nodes(k):
        sums = np.empty(k // 16, dtype=object)
        kernels._panel_sums(search.family, a, counting(search.nodes[:, :k]), search.panels, 0, sums, sheet)

    print(json.dumps({"chord": per_place(chords), "node": per_place(nodes)}))


if __name__ == "__main__":
    main()
