"""The page: needs nothing else, and says what the Markdown says."""

import json
import re
from html.parser import HTMLParser

import pytest

from selfmotion.report import seed_runs, verdict
from selfmotion.report.figures import FIGURES
from selfmotion.report.page import html_page


class _Page(HTMLParser):
    def __init__(self):
        super().__init__()
        self.tags, self.cells, self.text = [], [], []
        self._in_cell = False

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag in ("td", "th"):
            self.cells.append("")
            self._in_cell = True

    def handle_endtag(self, tag):
        if tag in ("td", "th"):
            self._in_cell = False

    def handle_data(self, data):
        self.text.append(data)
        if self._in_cell:
            self.cells[-1] += data


@pytest.fixture
def page(files):
    parsed = _Page()
    parsed.feed(files["report.html"].decode())
    return parsed


def test_the_page_needs_nothing_else(page, files):
    for tag, attributes in page.tags:
        assert tag not in ("script", "link", "iframe", "object")
        for name in ("src", "href", "srcset", "data", "poster"):
            assert attributes.get(name, "data:").startswith("data:")
    style = files["report.html"].decode().split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style
    assert "prefers-color-scheme: dark" in style


def test_the_page_shows_every_figure_with_words_for_it(page):
    images = [attributes for tag, attributes in page.tags if tag == "img"]
    assert [image["alt"] for image in images] == [figure.alt for figure in FIGURES.values()]
    assert all(image["src"].startswith("data:image/svg+xml;base64,") for image in images)
    assert ("meta", {"name": "viewport", "content": "width=device-width, initial-scale=1"}) in page.tags


def test_the_page_says_what_the_markdown_says(page, files):
    rows = [line for line in files["report.md"].decode().splitlines() if line.startswith("| ")]
    cells = [cell.strip().replace("\\|", "|") for row in rows for cell in re.split(r"(?<!\\)\|", row)[1:-1]]
    assert page.cells == cells
    shown = " ".join("".join(page.text).split())
    results = json.loads(files["results.json"])
    sentences = [sentence for name in seed_runs.CASES for sentence in verdict.on_seeds(results, name)]
    shortest = [verdict.on_chords(results), *(verdict.on_shortest(results, name) for name in results["shortest"])]
    for sentence in [*sentences, verdict.on_modules(results), *shortest]:
        assert " ".join(sentence.replace("**", "").split()) in shown


def test_a_page_without_one_of_its_pictures_is_an_error(files):
    pictures = {name: data for name, data in files.items() if name != "seeds_spread.svg"}
    with pytest.raises(KeyError):
        html_page(files["report.md"].decode(), pictures)
