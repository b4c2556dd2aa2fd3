"""Flow charts: every ask/tell optimizer has one, and its texts and boxes keep their places."""

import itertools
import sys
from pathlib import Path

import pytest
from matplotlib.patches import FancyBboxPatch, Polygon

from selfmotion.errors import InvalidInputError
from selfmotion.optimizers import OPTIMIZERS, PSO, AskTell
from selfmotion.plot import draw_flow, figure, flow_height
from selfmotion.plot.flow import AFTER, QUESTION

FLOWS = {kind: optimizer for kind, optimizer in OPTIMIZERS.items() if issubclass(optimizer, AskTell)}


def inside(inner, outer, slack=0.5):
    return (
        inner.x0 >= outer.x0 - slack
        and inner.x1 <= outer.x1 + slack
        and inner.y0 >= outer.y0 - slack
        and inner.y1 <= outer.y1 + slack
    )


@pytest.mark.parametrize("kind", FLOWS)
@pytest.mark.parametrize("dpi", [100, 220])
def test_texts_fit_their_boxes_and_boxes_the_axes(kind, dpi):
    optimizer = FLOWS[kind]
    with figure(height=flow_height(optimizer)) as (canvas, (axes,)):
        canvas.set_dpi(dpi)
        draw_flow(axes, optimizer)
        canvas.canvas.draw()
        shapes = [patch for patch in axes.patches if isinstance(patch, FancyBboxPatch | Polygon)]
        boxes = {patch.get_gid(): patch.get_window_extent() for patch in shapes}
        texts = {text.get_gid(): text for text in axes.texts if text.get_gid()}
        expected = [*optimizer.steps, QUESTION, *AFTER]
        assert len(boxes) == len(texts) == len(expected)
        for k, words in enumerate(expected):
            text = texts[f"text-{k}"]
            assert text.get_text().split() == words.split()
            assert inside(text.get_window_extent(), boxes[f"box-{k}"], slack=0.0)
            assert inside(boxes[f"box-{k}"], axes.get_window_extent(), slack=1.0)
        for one, other in itertools.combinations(boxes.values(), 2):
            assert not one.overlaps(other)


def test_axes_that_are_too_low_are_refused():
    with figure(height=2.0) as (_, (axes,)), pytest.raises(InvalidInputError, match="inch too low"):
        draw_flow(axes, PSO)


@pytest.mark.parametrize("kind", FLOWS)
def test_the_docs_show_it(kind, tmp_path):
    docs = Path(__file__).parents[2] / "docs"
    assert f"(_generated/flow_{kind}.svg)" in (docs / "optimizers.md").read_text(encoding="utf-8")
    sys.path.insert(0, str(docs))
    try:
        from figures import write_flows
    finally:
        sys.path.remove(str(docs))
    write_flows(tmp_path)
    assert (tmp_path / f"flow_{kind}.svg").stat().st_size > 1000
