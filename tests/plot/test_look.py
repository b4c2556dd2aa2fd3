"""How pictures look at the width of a printed column; the table of pictures is in drawings.py."""

import itertools

import numpy as np
import pytest
from drawings import DRAWINGS, drawn, luminance, read_thumbnails, thumbnail
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from selfmotion import plot
from selfmotion.plot.style import COLORS, COLUMN, DASHES

PAIRS = list(itertools.combinations(range(len(COLORS)), 2))
LEAST_FONT = 6.0
# Grey levels of thumbnails: another machine's fonts may move a label by a pixel, not more.
MEAN_DIFFERENCE, LARGEST_DIFFERENCE = 0.004, 0.1

# Simulation of colour blindness, severity 1.0, on linear RGB: Machado, Oliveira, Fernandes, "A Physiologically-based
# Model for Simulation of Color Vision Deficiency", IEEE TVCG 15 (2009) 1291–1298.
VISION = {
    "normal": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
}


@pytest.fixture
def written(monkeypatch):
    """Collect the texts that are really drawn: matplotlib itself drops ticks that are out of view."""
    found = []
    original = Text.draw

    def draw(self, renderer, *args, **kwargs):
        if self.get_visible() and self.get_text().strip():
            found.append((self, Text.get_window_extent(self, renderer)))
        return original(self, renderer, *args, **kwargs)

    monkeypatch.setattr(Text, "draw", draw)

    def texts(canvas):
        canvas.canvas.draw()
        found.clear()  # the first drawing still lays out
        canvas.canvas.draw()
        return list(found)

    return texts


@pytest.mark.parametrize("name", DRAWINGS)
def test_texts_are_large_enough_apart_and_inside(name, written):
    with drawn(name) as canvas:
        assert canvas.get_figwidth() == COLUMN
        texts = written(canvas)
        assert texts
        for text, box in texts:
            assert text.get_fontsize() >= LEAST_FONT, text
            assert box.x0 >= -0.5, text
            assert box.y0 >= -0.5, text
            assert box.x1 <= canvas.bbox.x1 + 0.5, text
            assert box.y1 <= canvas.bbox.y1 + 0.5, text
        for (one, a), (other, b) in itertools.combinations(texts, 2):
            across = min(a.x1, b.x1) - max(a.x0, b.x0)
            along = min(a.y1, b.y1) - max(a.y0, b.y0)
            assert min(across, along) <= 0.5, (one, other)


@pytest.mark.parametrize("name", DRAWINGS)
def test_something_is_drawn_but_not_everything(name):
    with drawn(name) as canvas:
        ink = (luminance(canvas) < 0.97).mean()
    low, high = DRAWINGS[name].ink
    assert low <= ink <= high


@pytest.mark.parametrize("name", DRAWINGS)
def test_the_picture_looks_as_it_did(name):
    """See drawings.py for how to renew the baseline after a change on purpose."""
    with drawn(name) as canvas:
        difference = np.abs(thumbnail(canvas) - read_thumbnails()[name])
    assert difference.mean() <= MEAN_DIFFERENCE
    assert difference.max() <= LARGEST_DIFFERENCE


def test_the_baseline_holds_nothing_else():
    assert set(read_thumbnails()) == set(DRAWINGS)


def test_every_drawing_function_is_in_the_table():
    public = {name for name in plot.__all__ if name.startswith("draw_")}
    assert public - {getattr(drawing.draw, "func", drawing.draw).__name__ for drawing in DRAWINGS.values()} == set(), (
        "add a row to drawings.py"
    )


def test_simulated_vision_keeps_greys():
    """The matrices' rows add up to one: what has no colour looks the same to everybody."""
    for matrix in VISION.values():
        np.testing.assert_allclose(matrix @ np.ones(3), 1.0, atol=2e-6)


def linear(color):
    """Return linear RGB of an sRGB colour (IEC 61966-2-1)."""
    rgb = np.array(to_rgb(color))
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(rgb):
    """Return CIE L*a*b* (D65) of linear RGB."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    t = to_xyz @ np.clip(rgb, 0, 1) / (to_xyz @ np.ones(3))
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize(("one", "other"), PAIRS)
def test_colours_are_told_apart(vision, one, other):
    """ΔE*ab of 2.3 is just noticeable; thin lines need several times that."""
    a, b = (lab(VISION[vision] @ linear(COLORS[k])) for k in (one, other))
    assert np.linalg.norm(a - b) >= 15


def pattern(dash, length=60.0, steps=1200):
    """Return where a line of some points' length is inked."""
    if dash == "-":
        return np.ones(steps, dtype=bool)
    ends = np.cumsum(dash[1])
    place = np.linspace(0, length, steps, endpoint=False) % ends[-1]
    return np.searchsorted(ends, place, side="right") % 2 == 0


@pytest.mark.parametrize(("one", "other"), PAIRS)
def test_lines_are_told_apart_in_grey(one, other):
    """By lightness, by how much of the line is inked, or by how many dashes there are."""
    lightness = [lab(np.full(3, linear(COLORS[k]) @ [0.2126, 0.7152, 0.0722]))[0] for k in (one, other)]
    inked = [pattern(DASHES[k]) for k in (one, other)]
    fraction = [p.mean() for p in inked]
    dashes = [max(np.count_nonzero(np.diff(p.astype(int))), 1) for p in inked]
    different = [
        abs(lightness[0] - lightness[1]) >= 15,
        abs(fraction[0] - fraction[1]) >= 0.1,
        max(dashes) >= 1.25 * min(dashes),
    ]
    assert any(different)


def test_each_colour_is_seen_on_paper():
    for color in COLORS:
        contrast = 1.05 / (linear(color) @ [0.2126, 0.7152, 0.0722] + 0.05)
        assert contrast >= 2.0, color
