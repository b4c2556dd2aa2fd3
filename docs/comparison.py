"""Tables of the comparison of the optimizers, from the committed report of its study."""

import csv
import math
from pathlib import Path

KEPT = Path(__file__).parents[1] / "benchmarks" / "optimizers_sinusoid"
COPIES = ("plain", "shifted")
SEED = "seed 3R"
_ROUNDING = 1e-12  # an excess below is none


def rows(name):
    """Return the rows of one of the report's tables."""
    with (KEPT / f"{name}.csv").open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def optimizers():
    """Return the names of the optimizers, in the study's order."""
    return [row["optimizer"] for row in rows("methods") if row["planner"] == COPIES[0]]


def shown(value):
    """Return an excess or a share as a table shows it."""
    number = float(value)
    if math.isinf(number):
        return "no motion"
    return "0" if number < _ROUNDING else f"{number:.1e}"


def share(row):
    """Return how many of a method's runs reached the best search, in per cent."""
    return f"{100 * int(row['reached']) / int(row['runs']):.0f} %"


def methods_table():
    """Return all optimizers on both copies: quartiles over all runs, share of runs at the best, mean rank."""
    found = {(row["planner"], row["optimizer"]): row for row in rows("methods")}
    lines = [
        "| optimizer | copy | lower quartile | median | upper quartile | at the best sinusoid | mean rank |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in optimizers():
        for copy in COPIES:
            row = found[copy, name]
            quartiles = " | ".join(
                shown(row[f"behind_{part}"]) for part in ("lower_quartile", "median", "upper_quartile")
            )
            rank = f"{float(row['mean_rank']):.2f}"
            lines.append(f"| {name if copy == COPIES[0] else ''} | {copy} | {quartiles} | {share(row)} | {rank} |")
    return "\n".join(lines) + "\n"


def seed_table():
    """Return the medians on the paper's own case."""
    (row,) = [row for row in rows("problems") if row["problem"] == SEED]
    lines = ["| optimizer | plain | shifted |", "|---|---|---|"]
    lines += [f"| {name} | {' | '.join(shown(row[f'{copy}, {name}']) for copy in COPIES)} |" for name in optimizers()]
    return "\n".join(lines) + "\n"


def write_comparison(folder: Path):
    """Write the tables."""
    folder.mkdir(exist_ok=True)
    for name, text in (("optimizers_compared", methods_table()), ("optimizers_seed_3r", seed_table())):
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
