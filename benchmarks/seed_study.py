"""One run of 20 candidates for 100 generations, by our optimizers and by others', framework and kernel apart."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from measuring import by_turns
from peers import all_peers
from seed_case import AMPLITUDE, BOUNDS, GENERATIONS, OFFSET, POPULATION, PROBLEM, candidates, optimum

import selfmotion as sm

OURS = "PSO, the seed's"
RESTARTS = 30


def _ours():
    integral, samples = candidates("integral"), candidates("samples")
    budget = {"population": POPULATION, "iterations": GENERATIONS, "bounds": BOUNDS}

    def search(optimizer, judge):
        return lambda seed: float(optimizer.with_seed(seed).minimize(judge, 1).x[0])

    def plan(seed):
        pso = sm.PSO(**budget, variant="seed", seed=seed)
        planned = sm.plan(PROBLEM, sm.Sinusoid([OFFSET], amplitude=[AMPLITUDE], optimizer=pso))
        assert planned.verification.holds
        return planned.parameters["f"]

    return {
        OURS: search(sm.PSO(**budget, variant="seed"), integral),
        "PSO, canonical": search(sm.PSO(**budget), integral),
        "GWO": search(sm.GWO(**budget), integral),
        "GA": search(sm.GA(**budget), integral),
        "differential_evolution (scipy's, adapted)": search(sm.DifferentialEvolution(**budget), integral),
        "PSO, the seed's, by its 1000 samples": search(sm.PSO(**budget, variant="seed"), samples),
        "PSO, canonical, by 1000 samples": search(sm.PSO(**budget), samples),
        "whole plan by the seed's PSO, verified": plan,
    }


def restarts(threads):
    """Return a function that makes 30 runs of the seed's PSO in so many threads."""
    judge, pso = candidates("integral"), sm.PSO(POPULATION, GENERATIONS, BOUNDS, variant="seed")

    def run(_):
        with ThreadPoolExecutor(threads) as pool:
            return list(pool.map(lambda seed: pso.with_seed(seed).minimize(judge, 1).value, range(RESTARTS)))

    return run


def run(quick):
    """Return the table's rows and what they are measured against."""
    rounds = 2 if quick else 15
    ours, others = _ours(), all_peers()
    there = {name: call for name, call in others.items() if call is not None}
    times = by_turns({**ours, **there}, rounds)
    best, judge = optimum(), candidates("integral")
    together = by_turns({f"{n}": restarts(n) for n in (1, 2)}, rounds)
    rows = []
    for name in (*ours, *others):
        row = {"name": name, "ours": name in ours, "missing": name not in times}
        if not row["missing"]:
            excess = judge(np.array(times[name].results)[:, None]) - best
            row |= {
                "ms": 1e3 * times[name].median,
                "ratio": times[name].over(times[OURS]),
                "ratio_to_canonical": times[name].over(times["PSO, canonical"]),
                "median_excess": float(np.median(excess)),
                "worst_excess": float(np.max(excess)),
            }
        rows.append(row)
    return {
        "rows": rows, "rounds": rounds, "optimum": best, "against": OURS,
        "restarts": {"ms": 1e3 * together["1"].median, "two_threads": together["1"].over(together["2"])},
    }  # fmt: skip


def text(result):
    """Return the section of the report."""
    lines = [
        f"One run of {POPULATION} × {GENERATIONS} on the seed's 3R case, warm, called from Python; medians of "
        f"{result['rounds']} rounds, a new seed in each. The ratio is that of times to *{result['against']}*, with its "
        "quartiles. *Excess* is what the frequency found costs above the least integral, "
        f"{result['optimum']:.10f}: median and worst of the seeds.",
        "",
        "| run | ms | × ours | quartiles | × ours, canonical | excess: median | worst |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in result["rows"]:
        name = f"**{row['name']}**" if row["ours"] else row["name"]
        if row["missing"]:
            lines.append(f"| {name} | missing here | | | | | |")
            continue
        ratio, low, high = row["ratio"]
        lines.append(
            f"| {name} | {row['ms']:.2f} | {ratio:.1f} | {low:.1f}–{high:.1f} | {row['ratio_to_canonical'][0]:.1f} | "
            f"{row['median_excess']:.1e} | {row['worst_excess']:.1e} |"
        )
    restarts = result["restarts"]
    lines += [
        "",
        f"{RESTARTS} restarts of *{result['against']}* take {restarts['ms']:.0f} ms in one thread; two threads are "
        f"{restarts['two_threads'][0]:.2f} times as fast ({restarts['two_threads'][1]:.2f}–"
        f"{restarts['two_threads'][2]:.2f}), and find the same to the last bit.",
        "",
        "Ours rank by the integral unless it says otherwise: every candidate as accurately as its rank needs. "
        "`our kernel` is that integral, computed to the end for every candidate, since its caller's thresholds are not "
        "known; `numpy` is the chord sum over 1000 samples. pygmo's `pso` and `gwo` judge candidates one by one, "
        "`pso_gen` a generation per call. CMA-ES wants two variables; the second does nothing.",
    ]
    return lines
