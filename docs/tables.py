"""Tables of every part that a problem file can name, and its JSON Schema, from the registries and signatures."""

import inspect
import json
from pathlib import Path

from selfmotion.arms import ARMS
from selfmotion.exchange.path_kinds import FILE_PATHS
from selfmotion.exchange.schema import json_schema
from selfmotion.objectives import OBJECTIVES
from selfmotion.optimizers import OPTIMIZERS
from selfmotion.paths import PATHS
from selfmotion.planners import PLANNERS
from selfmotion.scene import OBSTACLES

REGISTRIES = {
    "arms": ARMS,
    "paths": {**PATHS, **FILE_PATHS},
    "planners": PLANNERS,
    "optimizers": OPTIMIZERS,
    "objectives": OBJECTIVES,
    "obstacles": OBSTACLES,
}


def table(registry):
    """Return a Markdown table: kind, fields with their defaults, what it is."""
    rows = ["| kind | fields | what it is |", "|---|---|---|"]
    for kind, part in registry.items():
        parameters = list(inspect.signature(part).parameters.values())
        written = getattr(part, "fields", {})  # where a problem file calls a parameter otherwise
        fields = [
            f"`{written.get(p.name) or p.name}`"
            + ("" if p.default is inspect.Parameter.empty else f" = {shown(p.default)}")
            for p in parameters
            if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)
        ]
        summary = inspect.getdoc(part).split("\n\n")[0].replace("\n", " ").replace("|", "\\|")
        rows.append(f"| `{kind}` | {', '.join(fields) or '–'} | {summary} |")
    return "\n".join(rows) + "\n"


def shown(value):
    """Return a default as a problem file writes it."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return "[" + ", ".join(f"{v:g}" for v in value) + "]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def write_tables(folder: Path):
    """Write one file per registry; untouched files keep their time, so builds stay incremental."""
    folder.mkdir(exist_ok=True)
    for name, registry in REGISTRIES.items():
        file, text = folder / f"{name}.md", table(registry)
        if not file.exists() or file.read_text(encoding="utf-8") != text:
            file.write_text(text, encoding="utf-8")


def write_schema(folder: Path):
    """Write the JSON Schema of problem files."""
    (folder / "problem.schema.json").write_text(json.dumps(json_schema(), indent=1) + "\n", encoding="utf-8")
