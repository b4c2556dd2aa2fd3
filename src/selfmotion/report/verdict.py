"""What the numbers say, in words: every sentence is chosen by the results, none is written beforehand."""

from __future__ import annotations

from typing import Any

from selfmotion.plot.evolution import FLOOR
from selfmotion.report import seed_study

_AS_PRINTED = 1e-4
"""Printed values have four decimals or more: what differs by more does not follow from the same data."""


def on_printed_values(results: dict[str, Any]) -> str:
    """Return whether Table II follows from the printed data."""
    lines = {label: results["table"][label] for label in seed_study.PRINTED}
    off = sorted(abs(line["computed_at_printed_f"] - line["printed"]["fitness"]) for line in lines.values())
    low = [label for label, line in lines.items() if line["printed"]["fitness"] < results["scan"]["fitness"]]
    if off[-1] <= _AS_PRINTED:
        return f"**The printed values follow from the printed data**, to {off[-1]:.0e}."
    below = " No frequency gives as little as is printed for " + _and(low) + "." if low else ""
    return (
        "**The printed values do not follow from the printed data.** At the printed frequencies, the printed arm, "
        "path, limits, offset and amplitude give an F that differs from the printed one by "
        f"{off[0]:.3f} to {off[-1]:.3f}.{below} Nothing was changed to make the figures agree. What can be compared is "
        "how the optimizers rank, over many seeds."
    )


def on_seeds(results: dict[str, Any]) -> list[str]:
    """Return the verdict on the comparison, a sentence or two per entry."""
    return [_found(results), _ranking(results), _against_chance(results), _shifted(results)]


def _found(results: dict[str, Any]) -> str:
    """Say who finds the optimum, and how often."""
    seeds, plain = results["seeds"], results["comparison"]["plain"]
    groups: dict[int, list[str]] = {}
    for label, numbers in plain.items():
        groups.setdefault(numbers["found"], []).append(label)
    parts = [f"{_and(groups[count])} {_times(count, seeds)}" for count in sorted(groups, reverse=True)]
    return (
        f"**Within {results['tolerance']:g} of the dense-scan optimum** on the plain problem end: {'; '.join(parts)}."
    )


def _ranking(results: dict[str, Any]) -> str:
    """Compare the ranking of the paper's three with the printed one."""
    plain, seeds = results["comparison"]["plain"], results["seeds"]
    printed = sorted(seed_study.PRINTED, key=lambda label: results["table"][label]["printed"]["fitness"])
    by_median = sorted(printed, key=lambda label: plain[label]["median"])
    by_found = sorted(printed, key=lambda label: -plain[label]["found"])
    medians = ", ".join(f"{label} ({excess(plain[label]['median'])})" for label in by_median)
    counts = ", ".join(f"{label} ({plain[label]['found']})" for label in by_found)
    verdict = "holds" if printed == by_median == by_found else "does not hold"
    if (printed == by_median) != (printed == by_found):
        verdict = f"holds by the {'median' if printed == by_median else 'count'} only"
    wins = _and([f"{other} {_times(results['lower_than'][other], seeds)}" for other in seed_study.RIVALS])
    return (
        f"**The paper ranks** {', '.join(printed)}, from one run each. By the median excess the order is {medians}; by "
        f"how often the optimum is found, {counts}: the printed order {verdict}. With equal seeds, the paper's PSO "
        f"ends lower than {wins}."
    )


def _against_chance(results: dict[str, Any]) -> str:
    """Compare every optimizer with random search."""
    plain = results["comparison"]["plain"]
    order = sorted(plain, key=lambda label: plain[label]["median"])
    place = order.index("random search")
    worse = order[place + 1 :]
    verdict = f"{_and(worse)} did worse by the median" if worse else "every optimizer did better by the median"
    return (
        f"**Against chance:** random search at equal evaluations has a median excess of "
        f"{excess(plain['random search']['median'])}; {verdict}. All by the median: {', '.join(order)}."
    )


def _shifted(results: dict[str, Any]) -> str:
    """Say what the shifted variable does to GWO, and to the others."""
    seeds, plain, shifted = results["seeds"], results["comparison"]["plain"], results["comparison"]["shifted"]
    before, after = plain["GWO"], shifted["GWO"]
    change = "no more and no less"
    if abs(after["median"] - before["median"]) > FLOOR:
        change = "more" if after["median"] > before["median"] else "less"
        if min(before["median"], after["median"]) > FLOOR:
            large, small = max(before["median"], after["median"]), min(before["median"], after["median"])
            change = f"{float(f'{large / small:.2g}'):g} times {'as much' if change == 'more' else 'less'}"
    others = [label for label in plain if label != "GWO"]
    most = max(abs(shifted[label]["median"] - plain[label]["median"]) for label in others)
    moved = [label for label in others if shifted[label]["found"] != plain[label]["found"]]
    rest = f"as often as before, except {_and(moved)}" if moved else "exactly as often as before"
    little = f"less than {FLOOR:.0e}" if most < FLOOR else f"{most:.1e} at most"
    return (
        f"**With the variable shifted** by {results['shift']:g}, GWO's median excess is {excess(after['median'])} "
        f"instead of {excess(before['median'])}, {change}; it finds the optimum {_times(after['found'], seeds)} "
        f"instead of {_times(before['found'], seeds)}. The medians of the others change by {little}, and they find the "
        f"optimum {rest}."
    )


def excess(value: float) -> str:
    """Return an excess over the optimum for a reader; below `FLOOR` it is rounding."""
    return f"< {FLOOR:.0e}" if abs(value) < FLOOR else f"{value:.1e}"


def _times(count: int, seeds: int) -> str:
    return "with every seed" if count == seeds else "with no seed" if count == 0 else f"with {count} of {seeds} seeds"


def _and(names: list[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
