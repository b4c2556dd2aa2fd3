"""The docs say what the code does: names resolve, commands and snippets print what is shown beside them."""

import contextlib
import doctest
import importlib
import inspect
import io
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

import selfmotion
from selfmotion.cli import app
from selfmotion.report.figures import FIGURES

ROOT = Path(__file__).parents[1]
RUN = (
    "ten-minutes.md",
    "many-links.md",
    "shortest.md",
    "paths-from-files.md",
    "studies.md",
)  # pages whose snippets and commands are run
PAGES = {page.name: page.read_text("utf-8") for page in (ROOT / "docs").glob("*.md")}
SCRIPTS = sorted(name for name, page in PAGES.items() if "```python" in page and name not in RUN)  # only Python is run
EXAMPLES = sorted(file for file in (ROOT / "src").rglob("*.py") if ">>> " in file.read_text("utf-8"))


def text(page):
    return (ROOT / "docs" / page).read_text(encoding="utf-8")


def resolve(name):
    """Import what can be imported of a dotted name below the package, then go on by attributes."""
    found, parts = selfmotion, name.split(".")
    for k, part in enumerate(parts):
        if inspect.isclass(found) and not hasattr(found, part):
            # A field, or an attribute that the constructor sets.
            assert k == len(parts) - 1
            assert part in found.__annotations__ or f"self.{part} =" in inspect.getsource(found), name
            return
        try:
            found = getattr(found, part)
        except AttributeError:
            found = importlib.import_module(f"{found.__name__}.{part}")


TABLE = [
    [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
    for line in text("symbols.md").splitlines()
    if line.startswith("| ")
]
NAMES = sorted({name for row in TABLE for name in re.findall("`([^`]+)`", row[2])})
FIGURE_NAMES = {name for row in TABLE if len(row) == 4 for name in re.findall("`([^`]+)`", row[3])}


@pytest.mark.parametrize("name", NAMES)
def test_every_name_of_the_symbol_table_is_there(name):
    resolve(name)


def test_every_figure_of_the_symbol_table_is_one_of_the_report_s_and_none_of_the_paper_s_is_left_out():
    assert set(FIGURES) >= FIGURE_NAMES
    assert {name for name, figure in FIGURES.items() if figure.number} <= FIGURE_NAMES


def test_a_name_that_is_not_there_is_found_out():
    for wrong in ("Plam", "Plan.prise", "PlanarArm.lynx", "plot.draw_nothing", "Radii.nearest"):
        with pytest.raises((ImportError, AssertionError)):
            resolve(wrong)


def blocks(page):
    """Return (language, code, output) of a page's code blocks; the output is the text block that follows."""
    found = re.findall(r"^```(\w+)\n(.*?)^```\n(?:\n```text\n(.*?)^```\n)?", text(page), re.S | re.M)
    return [block for block in found if block[0] in ("python", "sh")]


def settled(printed):
    """Return `printed` without times and rounding errors, which differ from run to run or machine to machine."""
    return re.sub(r"in \d+\.\d+ s|\b[\d.]+e-1\d\b", "…", printed)


@pytest.mark.parametrize("page", RUN)
def test_a_page_s_snippets_print_what_it_shows(page, tmp_path, monkeypatch):
    names, shown = {}, blocks(page)
    assert {language for language, _, _ in shown} == {"python", "sh"}
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    for language, code, output in shown:
        if language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as stdout:
                exec(code, names)
            assert stdout.getvalue() == output
        else:
            printed = "".join(command(line) for line in code.splitlines())
            assert not output or settled(printed) == settled(output)


@pytest.mark.parametrize("page", SCRIPTS)
def test_a_page_s_python_runs(page, tmp_path, monkeypatch, capsys):
    names = {}
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    for language, code, _ in blocks(page):
        if language == "python":
            exec(code, names)
    assert names
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_an_example_in_a_docstring_prints_what_it_shows(file):
    name = ".".join(file.relative_to(ROOT / "src").with_suffix("").parts).removesuffix(".__init__")
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted
    assert result.failed == 0


def command(line):
    words = shlex.split(line, comments=True)
    assert words.pop(0) == "selfmotion"
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return done.stdout


@pytest.mark.parametrize("page", RUN)
def test_every_number_in_a_page_s_prose_is_one_that_was_printed(page):
    prose = re.sub(r"^```.*?^```$", "", text(page), flags=re.S | re.M)
    printed = "".join(code + output for _, code, output in blocks(page))
    numbers = re.findall(r"\d+\.\d+", prose)
    assert numbers
    assert [number for number in numbers if number not in printed] == []
