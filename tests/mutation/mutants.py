"""Whether the tests of the angle domain, the objectives and the bound notice mistakes: mutation testing, by a sample.

    python tests/mutation/mutants.py [--each 15] [--seed 1] [--only PART …] [--keep FOLDER]

cosmic-ray's operators make the mutants (``pip install 'cosmic-ray>=8.7' 'coverage>=7.6'``). Of each module `--each`
places are drawn, and at each place one of the mutants there. A mutant meets the tests that reach its statement,
quickest first, for `--budget` seconds; it is killed if one fails or does not come to an end. Nothing is written into
the source tree: the mutated module is handed to the import system of a forked process, in which nothing of the library
is loaded yet. Those that survived are printed; `equivalent.toml` has those that were looked at and change nothing that
could be tested, and why. What is in `--keep` is not judged again: interrupted, it goes on where it stopped.
"""

import argparse
import ast
import difflib
import fnmatch
import importlib
import importlib.abc
import importlib.util
import itertools
import json
import os
import pickle
import random
import resource
import signal
import sys
import time
import tomllib
import traceback
from collections import Counter, defaultdict
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SOURCE = ROOT / "src" / "selfmotion"

PER_TEST = 3.0  # so long tests are looked at beforehand; what takes longer comes last [s of this processor]
BUDGET = 4.0  # so long a mutant meets tests, if nothing else is asked for
PATIENCE, FACTOR = 2.0, 5.0  # a test of a mutant has no end if it takes so long, and so many times as long as without
CPU, MEMORY = 60, 6 * 2**30  # s and bytes that a mutant may have at all


# Random cases in test modules that would otherwise take minutes: a mistake mostly shows in the first few.
FEWER = {"test_structure": {"PROBLEMS": 160}, "test_feasible": {"ARMS": 400}}
# Of others, what tests import: loaded once, before mutants are.
NEEDED = ("numba", "pytest", "hypothesis.strategies", "mpmath", "scipy.optimize", "scipy.interpolate", "scipy.ndimage",
          "scipy.sparse.csgraph", "scipy.special")  # fmt: skip
ENDLESS = 99  # exit code


class Part(NamedTuple):
    """Modules, the tests that are to hold them, and whether kernels are compiled meanwhile.

    Compiled code would hide mutants of kernels; where only what calls them is mutated it is quicker.
    """

    modules: tuple[str, ...]
    tests: tuple[str, ...]
    compiled: bool


PARTS = {
    "objectives": Part(("objectives.py", "_objective_kernels.py"), ("test_objectives.py",), False),
    "domain": Part(("domain/*.py",), ("domain",), True),
    "bound": Part(
        ("certificate/*.py",),
        (
            *("certificate/test_rounds.py", "certificate/test_verdict.py", "certificate/test_proof_in_figures.py"),
            *("certificate/test_tube.py", "certificate/test_planted_chains.py", "certificate/test_infeasibility.py"),
            *("certificate/test_chains.py", "planners/test_global.py"),
        ),
        True,
    ),
    "kernels": Part(
        ("certificate/_*kernels.py",),
        (
            "certificate/test_values.py",
            "certificate/test_tube.py",
            "certificate/test_chain_kernels.py",
            "certificate/test_proposals.py",
        ),
        False,
    ),
}
# Replacements that numbers do not have, or that no hand would make, die at once and would flatter the tests.
UNLIKELY = (
    "core/ReplaceBinaryOperator_*_?Shift", "core/ReplaceBinaryOperator_*_Mod", "core/ReplaceBinaryOperator_*_FloorDiv",
    "core/ReplaceBinaryOperator_*_Pow", "core/ReplaceBinaryOperator_*_BitXor", "core/ReplaceBinaryOperator_[!B]*_Bit*",
    "core/ReplaceBinaryOperator_Bit*_[!B]*", "core/ReplaceComparisonOperator_*_Is*",
    "core/ReplaceUnaryOperator_*_Invert", "core/RemoveDecorator", "core/ExceptionReplacer", "core/Variable*",
)  # fmt: skip


class Mutant(NamedTuple):
    """A module's text with one change."""

    module: str  # as Python names it
    line: int
    operator: str
    source: str
    change: str  # "old line → new line"


def modules_of(part):
    """The files of a part that no part before it mutates otherwise."""
    found = sorted(file for pattern in part.modules for file in SOURCE.glob(pattern) if file.name != "__init__.py")
    return [file for file in found if not (part.compiled and file.stem.endswith("kernels"))]


def named(file):
    return ".".join(file.relative_to(SOURCE.parent).with_suffix("").parts)


def file_of(module):
    return SOURCE.parent.joinpath(*module.split(".")).with_suffix(".py")


def annotations(tree):
    """The places of annotations, which are never evaluated."""
    for node in ast.walk(tree):
        for field in ("annotation", "returns"):
            if (found := getattr(node, field, None)) is not None:
                yield (found.lineno, found.col_offset), (found.end_lineno, found.end_col_offset)


def sample(file, each, rng):
    """Mutants of a module at `each` places drawn from all, one at each."""
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.mutating import mutate_code
    from cosmic_ray.plugins import get_operator, operator_names

    source = file.read_text(encoding="utf-8")
    nodes, idle = list(ast_nodes(get_ast(source))), list(annotations(ast.parse(source)))
    places = defaultdict(list)
    for name in sorted(operator_names()):
        if any(fnmatch.fnmatch(name, pattern) for pattern in UNLIKELY):
            continue
        operator = get_operator(name)()
        spans = (span for node in nodes for span in operator.mutation_positions(node))
        for occurrence, (start, _end) in enumerate(spans):
            if not any(low <= start < high for low, high in idle):
                places[start].append((name, occurrence))
    found = []
    for start in rng.sample(sorted(places), min(each, len(places))):
        name, occurrence = rng.choice(places[start])
        text = mutate_code(source, get_operator(name)(), occurrence)
        found.append(Mutant(named(file), start[0], name.removeprefix("core/"), text, changed(source, text)))
    return found, len(places)


def changed(before, after):
    """What differs between two texts, in one line."""
    lines = [line for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[:2] in ("- ", "+ ")]
    return " → ".join(" ".join(line[2:].strip() for line in lines if line[0] == sign) for sign in "-+")


def statement(tree, line):
    """The lines of the innermost statement at a line, without the statements in it."""
    inside = [node for node in ast.walk(tree) if isinstance(node, ast.stmt) and node.lineno <= line <= node.end_lineno]
    if not inside:
        return range(line, line + 1)
    node = max(inside, key=lambda node: node.lineno)
    body = getattr(node, "body", None)
    return range(node.lineno, max(body[0].lineno, node.lineno + 1) if body else node.end_lineno + 1)


class Mutated(importlib.abc.MetaPathFinder, importlib.abc.SourceLoader):
    """Imports one module from another text than that of its file."""

    def __init__(self, mutant):
        self.mutant = mutant
        self.file = str(file_of(mutant.module))

    def find_spec(self, name, path, target=None):
        return (
            importlib.util.spec_from_file_location(name, self.file, loader=self) if name == self.mutant.module else None
        )

    def get_filename(self, name):
        return self.file

    def get_data(self, path):
        return self.mutant.source.encode()

    def exec_module(self, module):
        exec(compile(self.mutant.source, self.file, "exec", dont_inherit=True), module.__dict__)


class TooSlow(BaseException):
    """A test that takes longer than it may."""


class Fewer:
    """Test modules with fewer random cases."""

    def pytest_collection_modifyitems(self, items):
        for module in {item.module for item in items}:
            for name, value in FEWER.get(module.__name__.rpartition(".")[2], {}).items():
                setattr(module, name, value)


class Watched(Fewer):
    """Notes of every test its time and what it reaches; breaks off slow ones."""

    def __init__(self, files):
        import coverage

        self.coverage = coverage.Coverage(data_file=None, config_file=False, include=[str(file) for file in files])
        self.files, self.seconds, self.bad, self.functions = files, {}, set(), Counter()
        self.coverage.start()

    def pytest_runtest_protocol(self, item, nextitem):
        self.running = item.nodeid
        self.coverage.switch_context(item.nodeid)
        self.seconds[item.nodeid] = -time.process_time()
        signal.setitimer(signal.ITIMER_VIRTUAL, PER_TEST)

    def pytest_runtest_setup(self, item):
        if self.functions[item.nodeid.partition("[")[0]] > PER_TEST:
            import pytest

            pytest.skip("enough of its cases")

    def too_slow(self, *_):
        self.seconds[self.running] += 1e6
        raise TooSlow

    def pytest_runtest_logfinish(self, nodeid, location):
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        self.seconds[nodeid] += time.process_time()
        self.functions[nodeid.partition("[")[0]] += self.seconds[nodeid] % 1e6
        self.coverage.switch_context("")

    def pytest_runtest_logreport(self, report):
        if not report.passed and self.seconds[report.nodeid] < 1e5:
            self.bad.add(report.nodeid)

    def reached(self):
        """The seconds of each test, 1e6 and more of slow ones, and by module and line the tests that reach it."""
        self.coverage.stop()
        good = {name: took for name, took in self.seconds.items() if name not in self.bad}
        data, lines = self.coverage.get_data(), {}
        for file in self.files:
            by_line = data.contexts_by_lineno(str(file))
            lines[named(file)] = {line: {name for name in names if name in good} for line, names in by_line.items()}
        return good, lines


class Timed(Fewer):
    """Ends the process where a test has no end, or where the budget is spent."""

    def __init__(self, seconds, budget):
        self.seconds, self.left = {str(name): took for name, took in seconds.items()}, budget

    def pytest_runtest_protocol(self, item, nextitem):
        took = self.seconds.get(item.nodeid, 1e6)
        self.endless, most = took < 1e5, min(FACTOR * took + PATIENCE, 1e5)
        signal.setitimer(signal.ITIMER_VIRTUAL, most if self.endless else max(self.left, 0.1))
        self.begun = time.process_time()

    def pytest_runtest_logfinish(self, nodeid, location):
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        self.left -= time.process_time() - self.begun

    def too_slow(self, *_):
        os._exit(ENDLESS if self.endless else 0)


def run_pytest(tests, plugins=()):
    import pytest

    quiet = ("ignore::RuntimeWarning", "ignore::pytest.PytestAssertRewriteWarning")
    options = ["-q", "-p", "no:cacheprovider", *(part for text in quiet for part in ("-W", text))]
    return pytest.main([*options, "--rootdir", str(ROOT), *map(str, tests)], list(plugins))


def in_fork(work, log):
    """Do `work` in a process of its own: its exit code, negative where a signal ended it."""
    child = os.fork()
    if child == 0:
        code = 70
        try:
            with open(log, "w") as out:
                os.dup2(out.fileno(), 1)
                os.dup2(out.fileno(), 2)
            resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
            code = int(work())
        except BaseException:
            traceback.print_exc()
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def baseline(part, notes):
    """What the tests of a part take and reach, unmutated."""
    if notes.exists():
        return pickle.loads(notes.read_bytes())

    def work():
        watched = Watched(modules_of(part))
        signal.signal(signal.SIGVTALRM, watched.too_slow)
        tests = [ROOT / "tests" / name for name in part.tests]
        run_pytest(tests, [watched])
        notes.write_bytes(pickle.dumps(watched.reached()))
        return 0

    if in_fork(work, notes.with_suffix(".log")) != 0:
        sys.exit(notes.with_suffix(".log").read_text()[-3000:])
    return pickle.loads(notes.read_bytes())


def judged(mutant, seconds, reached, log, budget):
    """How a mutant fares: "killed", "endless", "survived", or "unreached" by any test."""
    lines = reached[mutant.module]
    tree = ast.parse(file_of(mutant.module).read_text(encoding="utf-8"))
    own = set().union(*(lines.get(line, ()) for line in statement(tree, mutant.line)))
    imported = any(line in lines and not lines[line] for line in statement(tree, mutant.line))
    if not own and imported:  # what runs at import concerns whoever comes to the module
        own = set().union(*lines.values())
    tests, total = [], 0.0
    for name in sorted(own, key=lambda name: (seconds[name], name)):
        if total > budget:
            break
        tests.append(name)
        total += min(seconds[name], PER_TEST)
    if not tests:
        return "unreached", 0

    def work():
        timed = Timed(seconds, budget)
        signal.signal(signal.SIGVTALRM, timed.too_slow)
        resource.setrlimit(resource.RLIMIT_CPU, (CPU, CPU))
        sys.meta_path.insert(0, Mutated(mutant))
        return run_pytest(["-x", *(ROOT / name for name in tests)], [timed])

    code = in_fork(work, log)
    return {0: "survived", ENDLESS: "endless", -signal.SIGKILL: "endless"}.get(code, "killed"), len(tests)


def equivalents():
    """What was looked at and changes nothing, by module and change, with its reason."""
    file = HERE / "equivalent.toml"
    groups = tomllib.loads(file.read_text(encoding="utf-8"))["group"] if file.exists() else []
    return {(entry["module"], entry["change"]): group["why"] for group in groups for entry in group["mutants"]}


def run_part(name, asked, keep):
    """Judge a sample of a part's mutants, a line of JSON for each."""
    part, known, samples, places = PARTS[name], equivalents(), [], 0
    out, log = keep / "mutants.jsonl", keep / "mutant.log"
    done = {(row["module"], row["line"], row["change"]) for row in results(out)}
    os.environ["NUMBA_DISABLE_JIT"] = str(int(not part.compiled))
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    for needed in NEEDED:
        importlib.import_module(needed)
    for file in modules_of(part):
        if any(named(file).endswith(end) for end in asked.modules):
            found, count = sample(file, asked.each, random.Random(f"{asked.seed} {named(file)}"))
            samples, places = [*samples, found], places + count
    # One of each module in turn: what is done after a while is spread as evenly as all of it.
    mutants = [mutant for row in itertools.zip_longest(*samples) for mutant in row if mutant is not None]
    seconds, reached = baseline(part, keep / f"{name}.pickle")
    print(
        f"{name}: {len(seconds)} tests, {sum(seconds.values()) % 1e6:.0f} s; {len(mutants)} of {places} places",
        flush=True,
    )
    checked = set()
    for mutant in mutants:
        if (mutant.module, mutant.line, mutant.change) in done:
            continue
        if mutant.module not in checked:  # what is not changed has to survive
            checked.add(mutant.module)
            same = mutant._replace(source=file_of(mutant.module).read_text(encoding="utf-8"))
            if judged(same, seconds, reached, log, asked.budget)[0] == "killed":
                sys.exit(f"{mutant.module} fails unchanged:\n" + log.read_text()[-3000:])
        how, met = judged(mutant, seconds, reached, log, asked.budget)
        if how in ("survived", "unreached"):
            if (mutant.module, mutant.change) in known:
                how = "equivalent"
            else:
                print(f"{how}, {met} tests: {mutant.module}:{mutant.line}: {mutant.change}", flush=True)
        row = {"module": mutant.module, "line": mutant.line, "change": mutant.change, "how": how, "tests": met}
        with out.open("a", encoding="utf-8") as rows:
            rows.write(json.dumps(row, ensure_ascii=False) + "\n")


def results(out):
    return [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()] if out.exists() else []


def table(rows):
    """Counts by module, and the part that was killed of those that are not equivalent."""
    counts = defaultdict(Counter)
    for row in rows:
        for module in (row["module"].removeprefix("selfmotion."), "all"):
            counts[module][row["how"]] += 1
    kinds = ("killed", "endless", "equivalent", "survived", "unreached")
    print(f"{'module':34}" + "".join(f"{kind:>12}" for kind in kinds) + f"{'killed of those that count':>30}")
    for module, count in sorted(counts.items(), key=lambda row: (row[0] == "all", row[0])):
        dead, counted = count["killed"] + count["endless"], count.total() - count["equivalent"]
        print(f"{module:34}" + "".join(f"{count[kind]:12}" for kind in kinds) + f"{dead / max(counted, 1):29.1%}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--each", type=int, default=15, help="places in each module")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", nargs="*", choices=PARTS, default=list(PARTS))
    parser.add_argument("--modules", nargs="*", default=[""], help="ends of modules' names, such as domain.fibre")
    parser.add_argument(
        "--keep", type=Path, default=ROOT / "out" / "mutants", help="folder of results; what is there stays"
    )
    parser.add_argument("--budget", type=float, default=BUDGET, help="seconds for which a mutant meets tests")
    parser.add_argument(
        "--again", action="store_true", help="judge those that survived again, by tests as they are now"
    )
    asked = parser.parse_args()
    asked.keep.mkdir(parents=True, exist_ok=True)
    if asked.again:
        for notes in asked.keep.glob("*.pickle"):
            notes.unlink()
        rows = [row for row in results(asked.keep / "mutants.jsonl") if row["how"] in ("killed", "endless")]
        lines = [json.dumps(row, ensure_ascii=False) + "\n" for row in rows]
        (asked.keep / "mutants.jsonl").write_text("".join(lines), encoding="utf-8")
    for name in asked.only:
        child = os.fork()  # numba reads once whether it compiles
        if child == 0:
            run_part(name, asked, asked.keep)
            os._exit(0)
        if os.waitpid(child, 0)[1] != 0:
            sys.exit(f"{name} was not finished")
    table(results(asked.keep / "mutants.jsonl"))


if __name__ == "__main__":
    main()
