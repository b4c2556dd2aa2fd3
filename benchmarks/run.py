"""Everything side by side: ``make bench``, or ``python benchmarks/run.py [--quick] [--only NAME] [--out FOLDER]``.

Writes RESULTS.md and the results.json behind it. Peers come with the extra ``bench``; what is not installed is reported
as missing. With ``--quick`` few rounds are run and nothing is written unless a folder is given: it shows that the
benchmarks work.
"""

import argparse
import datetime
import importlib
from pathlib import Path

from measuring import machine, write_json

SECTIONS = {
    "seed_study": "The seed's study: optimizers and frameworks",
    "kernels": "The objective's kernel",
    "ladders": "The global planner and ladders",
    "growth": "Growth",
}
PACKAGES = ("selfmotion", "numpy", "scipy", "numba", "pygmo", "cma", "pymoo", "tesseract-robotics")


def report(results):
    """Return RESULTS.md as text."""
    about = results["machine"]
    packages = ", ".join(f"{name} {version or 'missing'}" for name, version in about["packages"].items())
    lines = [
        "# Results",
        "",
        f"Made by `make bench` on {results['date']}, all in one run, by turns. {about['processor']}, {about['cores']} "
        f"cores, {about['system']}, Python {about['python']}; {packages}. Every call is warm: compiled code is loaded, "
        "the problem's own tables are made. The numbers behind this page are in `results.json`.",
    ]
    for name, title in SECTIONS.items():
        if name in results:
            lines += ["", f"## {title}", "", *importlib.import_module(name).text(results[name])]
    return "\n".join(lines) + "\n"


def main():
    """Run the sections asked for, print them, and write them down."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="few rounds; shows that everything works")
    parser.add_argument("--only", choices=SECTIONS, action="append", help="a section; may be given again")
    parser.add_argument("--out", type=Path, help="folder for RESULTS.md and results.json; by default this one")
    given = parser.parse_args()
    results = {"date": datetime.date.today().isoformat(), "quick": given.quick, "machine": machine(PACKAGES)}
    for name in given.only or SECTIONS:
        results[name] = importlib.import_module(name).run(given.quick)
        print(f"## {SECTIONS[name]}\n", *importlib.import_module(name).text(results[name]), "", sep="\n", flush=True)
    folder = given.out or (None if given.quick or given.only else Path(__file__).parent)
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        write_json(folder / "results.json", results)
        (folder / "RESULTS.md").write_text(report(results), encoding="utf-8")


if __name__ == "__main__":
    main()
