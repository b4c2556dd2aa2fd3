"""The long run.

``python tests/fuzz/fuzz.py --count 20000 --seed 1 [--kind svg …] [--guided]``.

Reads mutated inputs of every kind and prints what breaks the law of `fuzz_kinds`, each finding once by its kind of
error and place, with the input kept in `--keep`. ``--guided`` lets atheris choose, by which lines of the readers an
input reaches (``pip install atheris``; Python 3.11 and Linux): it takes one kind, and its corpus from `--keep`.
A finding that is mended goes to ``tests/fuzz/found``, where the tests replay it.
"""

import argparse
import json
import random
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))


class Findings:
    """Counts inputs, and prints and keeps what breaks the law."""

    def __init__(self, keep, kinds, judged):
        self.keep, self.judged = keep, judged
        self.read = Counter(dict.fromkeys(kinds, 0))
        self.found = Counter()
        self.slowest = {}
        scratch = tempfile.TemporaryDirectory(prefix="selfmotion-fuzz-")
        self._scratch, self.folder = scratch, Path(scratch.name)

    def judge(self, case):
        begun = time.process_time()
        finding = self.judged(case, self.folder)
        self.read[case.kind] += 1
        self.slowest[case.kind] = max(self.slowest.get(case.kind, 0.0), time.process_time() - begun)
        if finding is None:
            return
        key = (case.kind, finding.what, finding.where)
        self.found[key] += 1
        if self.found[key] == 1:
            name = "-".join(part.replace(":", "-").replace(".py", "") for part in key if part)
            self.keep.mkdir(parents=True, exist_ok=True)
            (self.keep / f"{name}{case.suffix}").write_bytes(case.data)
            if case.options:
                (self.keep / f"{name}{case.suffix}.options").write_text(json.dumps(case.options))
            print(f"== {' '.join(key)}: {self.keep / name}{case.suffix} {case.options}\n{finding.detail}", flush=True)

    def report(self):
        for kind, count in self.read.items():
            found = sum(times for (of, *_), times in self.found.items() if of == kind)
            print(f"{kind:12} {count:7} inputs, {found:4} findings, slowest {self.slowest.get(kind, 0):.2f} s")
        print(f"{'all':12} {self.read.total():7} inputs, {len(self.found)} findings of their own")


def _arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000, help="inputs of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", nargs="*", default=None)
    parser.add_argument("--minutes", type=float, default=float("inf"), help="stop then, wherever that is")
    parser.add_argument("--keep", type=Path, default=Path("fuzz-findings"))
    parser.add_argument("--guided", action="store_true")
    return parser.parse_args()


def _guided(arguments):
    """Let atheris choose the bytes from which the choices are drawn."""
    import atheris

    # Kernels are compiled from their bytecode, which must be as it was written: of the rest what reads.
    with atheris.instrument_imports(include=["selfmotion.exchange", "selfmotion.paths", "selfmotion.problem"]):
        import fuzz_samples
        from fuzz_kinds import KINDS, judged
        from fuzz_mutations import Drawn
    (name,) = arguments.kind
    findings = Findings(arguments.keep, [name], judged)
    fuzz_samples.companions(findings.folder)

    def one(data):
        findings.judge(KINDS[name].made(Drawn(data)))
        if findings.read.total() == arguments.count:
            findings.report()

    corpus = arguments.keep / f"corpus-{name}"
    corpus.mkdir(parents=True, exist_ok=True)
    options = [f"-runs={arguments.count}", f"-seed={arguments.seed + 1}", "-max_len=400", "-timeout=60", "-verbosity=0"]
    atheris.Setup([sys.argv[0], *options, "-rss_limit_mb=6000", str(corpus)], one)
    atheris.Fuzz()


def main():
    arguments = _arguments()
    if arguments.guided:
        return _guided(arguments)
    import fuzz_samples
    from fuzz_kinds import KINDS, judged

    kinds = arguments.kind or list(KINDS)
    findings = Findings(arguments.keep, kinds, judged)
    fuzz_samples.companions(findings.folder)
    end = time.monotonic() + 60.0 * arguments.minutes
    for k in range(arguments.count):
        for kind in kinds:
            findings.judge(KINDS[kind].made(random.Random(f"{kind} {arguments.seed} {k}")))
        if time.monotonic() > end:
            break
    findings.report()
    return bool(findings.found)


if __name__ == "__main__":
    sys.exit(main())
