"""A walk through the elements of an SVG drawing: what is drawn, what is used, what is hidden or passed by."""

from __future__ import annotations

import re
from collections.abc import Iterator

import numpy as np

from selfmotion.exchange.ledger import Ledger
from selfmotion.exchange.pieces import Piece
from selfmotion.exchange.reading import Budget
from selfmotion.exchange.svg_page import Affine, inner_page
from selfmotion.exchange.svg_shapes import LARGEST, SHAPES, Parse, after, shape_strokes, transform_of, wrong
from selfmotion.exchange.svg_xml import Element

_GROUPS = ("svg", "g", "a", "switch")
# Elements that draw nothing themselves; what stands in them is drawn where something refers to it.
_SILENT = (
    "", "defs", "symbol", "title", "desc", "metadata", "clipPath", "mask", "marker", "pattern", "linearGradient",
    "radialGradient", "filter", "script", "style", "view", "animate", "animateTransform", "animateMotion", "set",
)  # fmt: skip
_UNSEEN = ("hidden", "collapse")
_HIDDEN = re.compile(r"(?:^|[;{])\s*(?:display\s*:\s*none|visibility\s*:\s*(?:hidden|collapse))")
_MOVED = re.compile(r"(?:^|[;{])\s*(?:transform(?:-origin|-box)?|translate|rotate|scale|zoom|offset(?:-\w+)?)\s*:")
_SHAPED = re.compile(r"(?:^|[;{])\s*(?:d|cx|cy|rx|ry|r|x|y|width|height)\s*:")
_CUT = re.compile(r"(?:^|;)\s*(?:clip-path|mask)\s*:\s*(?!none)")
_ADVICE = {"text": ", not converted to paths", "image": ", a picture of pixels"}
# What makes a switch choose one of its children by who is looking.
_CONDITIONS = {"systemLanguage", "requiredExtensions", "requiredFeatures"}
_DEEPEST_USE = 20
_MOST_USES = 100_000


class Walk:
    """A walk through the tree of elements.

    Attributes
    ----------
    ledger : Ledger
        What was passed by.
    """

    def __init__(self, root: Element, parse: Parse) -> None:
        self.ledger = Ledger()
        self._root, self._parse = root, parse
        self._used_times = 0
        self._named: dict[str, Element] = {}
        self._budget = Budget()
        waiting = [root]
        while waiting:
            element = waiting.pop()
            self._named.setdefault(element.attributes.get("id", ""), element)
            waiting += reversed(element.children)
            if element.name == "style":
                self._take_rules(element)

    def _take_rules(self, element: Element) -> None:
        """Report a style sheet; one that moves or shapes elements is refused."""
        if _MOVED.search(element.text) or _SHAPED.search(element.text):
            raise wrong(element, "moves or shapes elements", "write transform and d as attributes of the elements")
        hides = ", though they hide something" if _HIDDEN.search(element.text) else ""
        self.ledger.note(f"<style>, whose rules are not read{hides}", element.line)

    def strokes(self, element: Element, above: Affine, uses: int = 0) -> Iterator[list[Piece]]:
        """Yield the strokes of an element and what is inside, `above` what its coordinates go through."""
        attributes, name = element.attributes, element.name
        if name in _SILENT:
            return
        style = attributes.get("style", "")
        if _HIDDEN.search(style) or attributes.get("display") == "none" or attributes.get("visibility") in _UNSEEN:
            self.ledger.note(f"<{name}> that is hidden", element.line)
            return
        if _MOVED.search(style) or (name in SHAPES and _SHAPED.search(style)):
            raise wrong(element, "is moved or shaped by its style", "write transform and d as attributes")
        cut = [key for key in ("clip-path", "mask") if element.attributes.get(key, "none") != "none"]
        if cut or _CUT.search(style):
            self.ledger.note(f"what cuts <{name}>: it is drawn whole", element.line)
        here = after(above, transform_of(element))
        if name == "use":
            yield from self._used(element, here, uses)
        elif name in _GROUPS:
            if name == "svg" and element is not self._root:
                here = after(here, inner_page(element, element))
            for child in self._chosen(element) if name == "switch" else element.children:
                yield from self.strokes(child, here, uses)
        elif name in SHAPES:
            if not max(np.abs(part).max() for part in here) <= LARGEST:
                raise wrong(element, f"is enlarged beyond {LARGEST:g}", "correct the transforms around it")
            for stroke in shape_strokes(element, here, self._parse):
                self._budget.spend(sum(piece.weight for piece in stroke))
                yield stroke
        else:
            self.ledger.note(f"<{name}>{_ADVICE.get(name, '')}", element.line)

    def _chosen(self, element: Element) -> list[Element]:
        """Return the child of a switch that everyone sees: the first one without conditions."""
        chosen = next((child for child in element.children if not _CONDITIONS & set(child.attributes)), None)
        for child in element.children:
            if child is not chosen:
                self.ledger.note(f"<{child.name}> that a switch leaves out", child.line)
        return [] if chosen is None else [chosen]

    def _used(self, element: Element, here: Affine, uses: int) -> Iterator[list[Piece]]:
        """Yield the strokes of what a use element refers to."""
        name = element.attributes.get("href", "")
        target = self._named.get(name[1:]) if name.startswith("#") and len(name) > 1 else None
        if target is None:
            raise wrong(element, "refers to nothing in the file", "name an element of the file by #id", name)
        self._used_times += 1
        if uses >= _DEEPEST_USE or self._used_times > _MOST_USES:
            raise wrong(element, "refers to itself, or too often to others", "write its shapes out")
        if target.name != "symbol":
            shift = inner_page(Element("", {}, 0), element)  # which is none, and moves by x and y
            yield from self.strokes(target, after(here, shift), uses + 1)
            return
        here = after(here, inner_page(target, element))
        for child in target.children:
            yield from self.strokes(child, here, uses + 1)
