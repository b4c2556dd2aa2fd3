"""The page's colours have contrast enough, and joints are told apart by the colour-blind; no browser is needed."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import selfmotion

PAGE = Path(selfmotion.__file__).parent / "studio" / "page"
CSS = (PAGE / "studio.css").read_text(encoding="utf-8")
DASHES = re.findall(r'"([^"]*)"', re.search(r"const DASHES = \[(.*?)\]", (PAGE / "looks.js").read_text("utf-8"))[1])

# Text, and what it stands on.
TEXTS = [
    ("ink", "panel"), ("ink", "ground"), ("ink", "soft"), ("ink", "region"), ("muted", "panel"), ("muted", "ground"),
    ("accent", "panel"), ("accent", "soft"), ("on-accent", "accent"), ("wrong", "panel"), ("good", "good-ground"),
    ("warn", "warn-ground"), ("wrong", "wrong-ground"), *((f"joint-{k}", "panel") for k in range(8)),
    *((f"obstacle-{k}", "panel") for k in range(6)),
]  # fmt: skip
# Lines, handles and edges that mean something.
MARKS = [
    ("ink", "region"), ("curve", "region"), ("curve", "panel"), ("rival", "region"), ("rival", "panel"),
    ("wrong", "region"), ("wrong", "panel"), ("accent", "panel"), ("accent", "region"), ("control", "panel"),
    ("good", "panel"), ("ink", "grid"), ("accent", "grid"), ("link", "link-core", 1.5),
    *((f"joint-{k}", "region") for k in range(8)), *((f"obstacle-{k}", "region") for k in range(6)),
]  # fmt: skip

# Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB.
BLIND = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
}


def colours(scheme):
    """Return the custom properties of a scheme as RGB from 0 to 1."""
    light, _, rest = CSS.partition("@media (prefers-color-scheme: dark)")
    text = light.partition(":root {")[2]
    found = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", text))
    if scheme == "dark":
        dark = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", rest.partition(":root {")[2].partition("}")[0]))
        assert set(dark) == set(found)
        found = dark
    return {name: np.array([int(value[k : k + 2], 16) / 255 for k in (1, 3, 5)]) for name, value in found.items()}


def linear(rgb):
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    """Return the contrast of two colours as WCAG 2 has it."""
    a, b = sorted(float(linear(colour) @ [0.2126, 0.7152, 0.0722]) for colour in (one, other))
    return (b + 0.05) / (a + 0.05)


def lab(rgb):
    """Return CIE L*a*b* of linear RGB."""
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ rgb
    f = np.cbrt(np.maximum(xyz / [0.9505, 1.0, 1.089], 1e-6))
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_the_computation_is_wcag_s():
    assert contrast(np.zeros(3), np.ones(3)) == pytest.approx(21)
    assert contrast(np.full(3, 0x76 / 255), np.ones(3)) == pytest.approx(4.54, abs=0.01)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_contrast(scheme):
    known = colours(scheme)
    low = {(a, b): contrast(known[a], known[b]) for a, b in TEXTS if contrast(known[a], known[b]) < 4.5}
    assert not low


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_marks_have_contrast(scheme):
    known = colours(scheme)
    low = {}
    for a, b, *least in MARKS:
        found = contrast(known[a], known[b])
        if found < (least[0] if least else 3.0):
            low[a, b] = found
    assert not low


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("sight", BLIND)
def test_joints_are_told_apart_by_the_colour_blind(scheme, sight):
    known = colours(scheme)
    seen = [lab(np.clip(np.array(BLIND[sight]) @ linear(known[f"joint-{k}"]), 0, 1)) for k in range(7)]
    alike = [
        (a, b)
        for a, b in itertools.combinations(range(7), 2)
        if np.linalg.norm(seen[a] - seen[b]) < 12 and DASHES[a] == DASHES[b]
    ]
    assert not alike


def test_joints_have_dashes_of_their_own():
    assert len(DASHES) == 8
    assert len(set(DASHES)) == 8


def test_every_colour_used_is_one_of_the_scheme():
    rules = CSS.partition("* { box-sizing")[2]
    assert not re.findall(r"#[0-9a-fA-F]{3,8}\b(?![^{]*\{)", rules)
    used = set(re.findall(r"var\(--([\w-]+)\)", CSS)) - {"c", "o", "shadow"}
    assert used <= set(colours("light"))
