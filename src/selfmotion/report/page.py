"""The report as one HTML page that needs nothing else: no network, no second file."""

from __future__ import annotations

import base64
import re
from collections.abc import Mapping
from html import escape
from importlib import resources


def html_page(markdown: str, pictures: Mapping[str, bytes]) -> str:
    """Return a Markdown report as a page with its pictures inside.

    Parameters
    ----------
    markdown : str
        Starts with its title as a heading.
    pictures : mapping
        File name to bytes; a picture ``NAME.png`` of the text is shown as ``NAME.svg``.

    Raises
    ------
    KeyError
        If the text shows a picture that is not given.
    """
    from markdown_it import MarkdownIt

    parser = MarkdownIt("commonmark").enable("table")
    parser.add_render_rule("table_open", lambda *_: '<div class="scroll" tabindex="0"><table>\n')
    parser.add_render_rule("table_close", lambda *_: "</table></div>\n")
    tokens = parser.parse(markdown)
    for image in (child for token in tokens for child in token.children or () if child.type == "image"):
        drawing = pictures[str(image.attrs["src"]).removesuffix("png") + "svg"]
        image.attrs["src"] = "data:image/svg+xml;base64," + base64.b64encode(drawing).decode("ascii")
    body = parser.renderer.render(tokens, parser.options, {})
    # A line may break after a hyphen, but not inside 1e-6. (The pictures' base64 has no hyphen.)
    body = re.sub(r"\d[\d.]*e-\d+", r'<span class="number">\g<0></span>', body)
    style = resources.files(__package__).joinpath("report.css").read_text(encoding="utf-8")
    title = escape(markdown.splitlines()[0].lstrip("# "))
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}</title>\n<style>\n{style}</style>\n</head>\n<body>\n<main>\n{body}</main>\n</body>\n</html>\n"
    )
