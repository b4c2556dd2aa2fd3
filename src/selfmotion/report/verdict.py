"""What the numbers say, in words: every sentence is chosen by the results, none is written beforehand."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, Decimal
from typing import Any

from selfmotion.certificate.verdict import verdict as proved
from selfmotion.plot.evolution import FLOOR
from selfmotion.report.cases import RIVALS
from selfmotion.report.seed_shortest import QUESTIONS, Answer

_FOUR = 10**4
_AS_PRINTED = 1e-4
"""Printed values have four decimals or more: what differs by more does not follow from the same data."""


def on_printed_values(results: dict[str, Any], name: str) -> str:
    """Return whether what the paper prints of a case follows from the printed data."""
    case = results["cases"][name]
    lines = {label: line for label, line in case["table"].items() if line["printed"]}
    off = sorted(abs(line["computed_at_printed_f"] - line["printed"]["fitness"]) for line in lines.values())
    if off[-1] <= _AS_PRINTED:
        return f"**The printed values follow from the printed data**, to {off[-1]:.0e}."
    least, printed = case["scan"]["fitness"], {label: line["printed"]["fitness"] for label, line in lines.items()}
    low = [label for label, fitness in printed.items() if fitness < least]
    beyond = f" No frequency gives as little as is printed for {_and(low)}." if low else ""
    if min(printed.values()) - least > _AS_PRINTED:
        beyond = f" The least F is lower than the least printed one, by {min(printed.values()) - least:.3f}."
    return (
        "**The printed values do not follow from the printed data.** At the printed frequencies, the printed arm, "
        "path, limits, offset and amplitude give an F that differs from the printed one by "
        f"{off[0]:.3f} to {off[-1]:.3f}.{beyond}"
    )


def on_seeds(results: dict[str, Any], name: str) -> list[str]:
    """Return the verdict on the comparison of one case, a sentence or two per entry."""
    case = results["cases"][name]
    return [_found(results, case), _ranking(results, case), _against_chance(case), _shifted(results, case)]


def on_modules(results: dict[str, Any]) -> str:
    """Return what the modular scheme costs against motions of the whole arm."""
    six = results["six"]
    modules, floor = six["motion"]["cost"], six["arm"]["joints"]
    moving, start, free = (six["whole_arm"][name]["cost"] for name in ("moving", "from_start", "free"))
    least = min(moving, start, free)
    if least >= modules:
        return f"**Nothing shorter was found** than the modules' motion, {modules:.4f}."
    return (
        f"**The modules on the printed moving base cost {modules / least:.2f} times** what the whole arm was found to "
        f"need: {modules:.4f} against {least:.4f}. Even where nothing moves F is {floor}, one per joint; beyond that "
        f"the modules pay {modules - floor:.4f}, and {start - floor:.4f} would do from the same start posture, "
        f"{free - floor:.4f} from the best one. Modules whose moving base is chosen too pay {moving - floor:.4f}."
    )


def least_printed(results: dict[str, Any], name: str) -> float:
    """Return the least F that the paper prints of a case."""
    lines = results["cases"][name]["table"].values()
    return min(line["printed"]["fitness"] for line in lines if line["printed"])


def on_shortest(results: dict[str, Any], name: str) -> str:
    """Return how good the best sinusoid of a case is, and whether a motion can cost what is printed."""
    found, printed = results["shortest"][name], least_printed(results, name)
    sinusoid, best, free = found["sinusoid"]["cost"], found["shortest"], found["free"]
    said = proved(best["cost"], best["cost_error"], best["lower_bound"], sinusoid)
    above = f"{100 * (sinusoid / best['cost'] - 1):.1f} %"
    answer = f"**{name}: {said}.** The best sinusoid costs {above} more than the shortest motion from its start. "
    if best["lower_bound"] > printed:
        answer += (
            f"**The printed F = {printed:.6g} cannot be attained from the printed data:** every continuous motion that "
            f"starts at u = {found['start']:g} costs at least {_down(best['lower_bound'])} as an integral, which is "
            f"more by {best['lower_bound'] - printed:.3f}; chord sums over the samples, as printed, are less than "
            f"integrals by {_chords([found])} at most for these motions."
        )
        if free["cost"] < printed:
            answer += f" From another start it could: the shortest motion of all costs {free['cost']:.4f}."
        elif free["lower_bound"] > printed:
            answer += f" Nor from any other start: there nothing costs less than {_down(free['lower_bound'])}."
        return answer
    answer += f"The bound does not rule out the printed F = {printed:.6g}: there are motions that cost less."
    if (least := results["cases"][name]["scan"]["fitness"]) - printed > _AS_PRINTED:
        answer += f" But none of the paper's sinusoids does: by the dense scan they cost at least {least:.4f}."
    return answer


def on_chords(results: dict[str, Any]) -> str:
    """Return how far the chord sums that the paper prints may be from the integrals that are bounded."""
    most = _chords([results["shortest"][name] for name in QUESTIONS])
    return (
        "Costs and bounds here are those of F as an integral. The paper's F is a chord sum over its samples, which for "
        f"these motions is less by {most} at most."
    )


def _chords(answers: Sequence[Mapping[str, Any]]) -> str:
    """Return by how much chord sums are less than integrals at most, rounded up."""
    motions = [found[kind] for found in answers for kind in Answer._fields]
    most = Decimal(max(motion["cost"] - motion["cost_sampled"] for motion in motions))
    return f"{float(most.quantize(Decimal(1).scaleb(most.adjusted()), ROUND_CEILING)):.0e}"


def _down(bound: float) -> str:
    """Return a lower bound with four decimals, never too large."""
    return f"{math.floor(bound * _FOUR) / _FOUR:.4f}"


def _found(results: dict[str, Any], case: dict[str, Any]) -> str:
    """Say who finds the optimum, and how often, and whether the wall of the box helps."""
    seeds, plain = results["seeds"], case["comparison"]["plain"]
    groups: dict[int, list[str]] = {}
    for label, numbers in plain.items():
        groups.setdefault(numbers["found"], []).append(label)
    parts = [f"{_and(groups[count])} {_times(count, seeds)}" for count in sorted(groups, reverse=True)]
    wall = ""
    if case["scan"]["f"] in (results["low"], results["high"]):
        wall = f" The optimum lies on the wall of the box, f = {case['scan']['f']:g}: whatever stops there finds it."
    return (
        f"**Within {results['tolerance']:g} of the dense-scan optimum** on the plain problem end: "
        f"{'; '.join(parts)}.{wall}"
    )


def _ranking(results: dict[str, Any], case: dict[str, Any]) -> str:
    """Compare the ranking of the paper's three with the printed one."""
    plain, seeds = case["comparison"]["plain"], results["seeds"]
    printed = {label: line["printed"]["fitness"] for label, line in case["table"].items() if line["printed"]}
    order = sorted(printed, key=lambda label: printed[label])
    rank = "".join(
        label if k == 0 else f"{' = ' if printed[label] == printed[order[k - 1]] else ', '}{label}"
        for k, label in enumerate(order)
    )
    median = {label: max(plain[label]["median"], FLOOR) for label in order}
    missed = {label: -plain[label]["found"] for label in order}
    medians = ", ".join(f"{label} ({excess(median[label])})" for label in sorted(order, key=lambda one: median[one]))
    counts = ", ".join(f"{label} ({-missed[label]})" for label in sorted(order, key=lambda one: missed[one]))
    by_median, by_count = _keeps(printed, median), _keeps(printed, missed)
    verdict = "holds" if by_median and by_count else "does not hold"
    if by_median != by_count:
        verdict = f"holds by the {'median' if by_median else 'count'} only"
    wins = _and([f"{other} {_times(case['lower_than'][other], seeds)}" for other in RIVALS])
    return (
        f"**The paper ranks** {rank}, from one run each. By the median excess the order is {medians}; by "
        f"how often the optimum is found, {counts}: the printed order {verdict}. With equal seeds, the paper's PSO "
        f"ends lower than {wins}."
    )


def _keeps(printed: Mapping[str, float], values: Mapping[str, float]) -> bool:
    """Return whether `values` rank nothing against the printed order."""
    pairs = itertools.permutations(printed, 2)
    return all(values[one] <= values[other] for one, other in pairs if printed[one] < printed[other])


def _against_chance(case: dict[str, Any]) -> str:
    """Compare every optimizer with random search."""
    plain = case["comparison"]["plain"]
    order = sorted(plain, key=lambda label: max(plain[label]["median"], FLOOR))
    place = order.index("random search")
    worse = order[place + 1 :]
    verdict = f"{_and(worse)} did worse by the median" if worse else "every optimizer did better by the median"
    return (
        f"**Against chance:** random search at equal evaluations has a median excess of "
        f"{excess(plain['random search']['median'])}; {verdict}. All by the median: {', '.join(order)}."
    )


def _shifted(results: dict[str, Any], case: dict[str, Any]) -> str:
    """Say what the shifted variable does to GWO, and to the others."""
    seeds, plain, shifted = results["seeds"], case["comparison"]["plain"], case["comparison"]["shifted"]
    before, after = plain["GWO"], shifted["GWO"]
    change = f"{excess(after['median'])}, no more and no less than before"
    if abs(after["median"] - before["median"]) > FLOOR:
        more = after["median"] > before["median"]
        change = "more" if more else "less"
        if min(before["median"], after["median"]) > FLOOR:
            large, small = max(before["median"], after["median"]), min(before["median"], after["median"])
            change = f"{float(f'{large / small:.2g}'):g} times {'as much' if more else 'less'}"
        change = f"{excess(after['median'])} instead of {excess(before['median'])}, {change}"
    found = f"{_times(after['found'], seeds)} instead of {_times(before['found'], seeds)}"
    if after["found"] == before["found"]:
        found = f"{_times(after['found'], seeds)}, as before"
    others = [label for label in plain if label != "GWO"]
    most = max(abs(shifted[label]["median"] - plain[label]["median"]) for label in others)
    moved = [label for label in others if shifted[label]["found"] != plain[label]["found"]]
    rest = f"as often as before, except {_and(moved)}" if moved else "exactly as often as before"
    little = f"less than {FLOOR:.0e}" if most < FLOOR else f"{most:.1e} at most"
    return (
        f"**With the variable shifted** by {results['shift']:g}, GWO's median excess is {change}; it finds the optimum "
        f"{found}. The medians of the others change by {little}, and they find the "
        f"optimum {rest}."
    )


def excess(value: float) -> str:
    """Return an excess over the optimum for a reader; below `FLOOR` it is rounding."""
    return f"< {FLOOR:.0e}" if abs(value) <= FLOOR else f"{value:.1e}"


def _times(count: int, seeds: int) -> str:
    return "with every seed" if count == seeds else "with no seed" if count == 0 else f"with {count} of {seeds} seeds"


def _and(names: list[str]) -> str:
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
