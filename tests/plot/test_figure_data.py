"""What is read back from a figure is what was drawn."""

import json

import numpy as np
import pytest

from selfmotion.plot import figure, figure_data, image_files


def drawn(axes, y=2.0):
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Rectangle

    axes.plot([0, 1, 2], [1.0, np.nan, y], label="a line")
    axes.plot([0], [0], ".")
    axes.fill_between([0, 1], [0, 0], [1, 3], label="an area")
    axes.add_collection(LineCollection([[(0, 0), (1, 1)], [(2, 2), (3, 4)]]))
    axes.scatter([0.5, 0.6], [7, 8], c=[1.0, 2.0])
    axes.add_patch(Rectangle((1, 2), 0.5, 0.25))
    axes.imshow([[1, 2], [3, 4]], extent=(0, 1, 0, 1), aspect="auto")
    axes.text(0.1, 0.2, "words")
    axes.annotate("there", (1, 1), xytext=(3, 4), textcoords="offset points")
    axes.inset_axes([0.5, 0.5, 0.4, 0.4]).plot([5, 6], [7, 8])
    axes.set_xlim(-1, 4)
    axes.set_yscale("log")
    axes.set_ylim(0.1, 10)
    axes.set_xticks([0, 2], ["zero", "two"])
    axes.set_xlabel("across")
    axes.set_title("a title")
    axes.legend()


@pytest.fixture
def data():
    with figure(height=3.0) as (canvas, (axes,)):
        drawn(axes)
        canvas.text(0.5, 0.99, "above")
        canvas.canvas.draw()
        return figure_data(canvas)


def test_lines(data):
    one, two = data["axes"][0]["lines"]
    assert one == {"label": "a line", "x": [0.0, 1.0, 2.0], "y": [1.0, None, 2.0]}
    assert two == {"label": "", "x": [0.0], "y": [0.0]}


def test_collections(data):
    area, lines, marks = data["axes"][0]["collections"]
    assert area["label"] == "an area"
    assert {tuple(vertex) for vertex in area["vertices"][0]} == {(0, 0), (1, 0), (1, 3), (0, 1)}
    assert lines["kind"] == "LineCollection"
    assert lines["vertices"] == [[[0, 0], [1, 1]], [[2, 2], [3, 4]]]
    assert marks["offsets"] == [[0.5, 7.0], [0.6, 8.0]]
    assert marks["values"] == [1.0, 2.0]


def test_patches_images_and_texts(data):
    axes = data["axes"][0]
    corners = np.array(axes["patches"][0]["vertices"])
    np.testing.assert_array_equal([corners.min(axis=0), corners.max(axis=0)], [[1, 2], [1.5, 2.25]])
    assert axes["images"][0]["values"] == [[1, 2], [3, 4]]
    assert axes["images"][0]["extent"] == [0, 1, 0, 1]
    assert axes["texts"] == [
        {"text": "words", "position": [0.1, 0.2]},
        {"text": "there", "position": [3.0, 4.0], "at": [1.0, 1.0]},
    ]
    assert axes["legend"] == ["a line", "an area"]
    assert axes["insets"][0]["lines"][0]["y"] == [7.0, 8.0]


def test_axes_and_figure(data):
    axes = data["axes"][0]
    assert data["size"] == [3.5, 3.0]
    assert [text["text"] for text in data["texts"]] == ["above"]
    assert axes["title"] == "a title"
    assert axes["x"] == {
        "label": "across",
        "scale": "linear",
        "limits": [-1.0, 4.0],
        "ticks": [0.0, 2.0],
        "tick_labels": ["zero", "two"],
    }
    assert axes["y"]["scale"] == "log"
    assert axes["y"]["limits"] == [0.1, 10.0]


def test_the_file_is_the_data_and_tells_one_bit_from_another():
    def file(y):
        with figure(height=3.0) as (canvas, (axes,)):
            drawn(axes, y)
            files = image_files("name", canvas, data=True)
            assert list(files) == ["name.png", "name.svg", "name.json"]
            assert json.loads(files["name.json"]) == figure_data(canvas)
            return files["name.json"]

    assert file(2.0) == file(2.0)
    assert file(2.0) != file(np.nextafter(2.0, 3.0))


def test_pictures_come_without_it_unless_asked():
    with figure() as (canvas, _):
        assert list(image_files("name", canvas)) == ["name.png", "name.svg"]
