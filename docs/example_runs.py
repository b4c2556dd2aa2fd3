"""The examples as the docs show them: what each says, its code, what it prints and draws, all from a run."""

import ast
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from digest import digest

ROOT = Path(__file__).parents[1]
_PARALLEL = 2


def write_examples(folder: Path):
    """Write ``examples.md``, and beside it the picture of each example."""
    folder.mkdir(exist_ok=True)
    examples = sorted((ROOT / "examples").glob("[0-9]*.py"))
    with ThreadPoolExecutor(_PARALLEL) as pool:
        printed = pool.map(lambda example: run(example, folder), examples)
        pages = [page(example, text) for example, text in zip(examples, printed, strict=True)]
    file, text = folder / "examples.md", "\n".join(pages)
    if not file.exists() or file.read_text(encoding="utf-8") != text:
        file.write_text(text, encoding="utf-8")


def run(example: Path, folder: Path):
    """Run an example and keep its picture; return what it prints. While no code changes the last run is good."""
    record, key = folder / f"{example.stem}.txt", f"{digest(example)}\n"
    known = record.read_text(encoding="utf-8") if record.exists() else ""
    if known.startswith(key):
        return known.removeprefix(key)
    with tempfile.TemporaryDirectory() as made:
        pictures = Path(made) / "pictures"  # which the example makes
        command = [sys.executable, "-X", "utf8", str(example), str(pictures)]
        done = subprocess.run(command, stdout=subprocess.PIPE, encoding="utf-8", check=True)
        (picture,) = pictures.iterdir()
        (folder / f"{example.stem}.png").write_bytes(picture.read_bytes())
    record.write_text(key + done.stdout, encoding="utf-8")
    return done.stdout


def page(example: Path, printed: str):
    """Return an example's section: its docstring as heading and text, its code, what it prints, its picture."""
    module = ast.parse(example.read_text(encoding="utf-8"))
    title, idea = ast.get_docstring(module).split("\n\n", 1)
    return f"""## {title.rstrip(".")}

{idea}

```{{literalinclude}} ../examples/{example.name}
:language: python
:lines: {module.body[1].lineno}-
```

It prints

```text
{printed.rstrip()}
```

![The picture that {example.name} saves](_generated/{example.stem}.png)
"""
