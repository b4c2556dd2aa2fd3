"""Problem files as text: what is written reads back equal, and what is no problem is refused by line."""

import json
import time

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from selfmotion.errors import InvalidInputError
from selfmotion.exchange.yaml_text import parse_yaml, yaml_text
from selfmotion.studio.answers import ANSWERS
from selfmotion.studio.cases import CASES
from selfmotion.studio.place import Place


def ask(task, **payload):
    return ANSWERS[task](payload, lambda *_: None, Place())


numbers = st.integers(-(2**60), 2**60) | st.floats(allow_nan=False, allow_infinity=False)
words = st.text() | st.sampled_from(
    ["", "~", "null", "yes", "No", "1e5", "1.5", "0x1F", "1_000", "12:30:45", "-", "- a", "a: b", "#", " x ", "'", "\\",
     "2020-01-01", "é", "\t", "a\nb", "<<", "=", "True", ".inf", ".5", "\x85", "\u2028", "\ufeff", "[1, 2]", "@", "%"]
)  # fmt: skip
values = st.recursive(
    st.none() | st.booleans() | numbers | words,
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(words, inner, max_size=5),
    max_leaves=25,
)


@given(st.dictionaries(words, values, max_size=5))
def test_whatever_is_written_reads_back_equal(data):
    back = parse_yaml(yaml_text(data), "")
    assert back == data
    assert json.dumps(back) == json.dumps(data)  # whole numbers stay whole, true stays true, keys in their order


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_examples_are_written_for_people_and_read_back(case):
    text = ask("write", problem=case.problem)["text"]
    assert ask("read", text=text)["problem"] == case.problem
    lines = text.splitlines()
    assert 3 <= len(lines) <= 20
    assert max(map(len, lines)) <= 130
    assert text.startswith("arm:")


def test_points_stand_one_below_the_other_where_they_are_many():
    text = yaml_text({"path": {"kind": "waypoints", "points": [[k, 2.5 * k] for k in range(40)]}})
    assert "    - [7, 17.5]\n" in text or "  - [7, 17.5]\n" in text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("arm: {kind: planar\npath: 3", "line 2"), ("arm: 1\narm: 2", "line 2"), ("- 1", "not a mapping"),
        ("path: {kind: line}", "arm"), ("arm: {kind: planar}\npath: 3", "path"),
        ("arm: &a {b: *a}\npath: {}", "line 1"),
        ("arm: {x: .inf}\npath: {}", "arm.x"), ("arm: {x: [1, {y: .nan}]}\npath: {}", "arm.x.1.y"),
        ("arm: {x: !!set {1}}\npath: {}", "arm.x"), ("arm: {x: !!binary aGk=}\npath: {}", "arm.x"),
        ("arm: {1: 2}\npath: {}", "arm"), ("arm: !!python/object:os.system {}\npath: {}", "line 1"),
        ('{"selfmotion_plan": 1}', "stored plan"), ("", "mapping"), ("[" * 3000, ""),
    ],
)  # fmt: skip
def test_what_is_no_problem_is_refused_and_says_where(text, said):
    with pytest.raises(InvalidInputError) as found:
        ask("read", text=text)
    assert said in str(found.value)


def test_texts_of_very_many_points_are_written_and_read_at_once():
    points = np.random.default_rng(0).uniform(-50, 50, (100_000, 2)).tolist()
    data = {"arm": {"kind": "planar", "links": [30, 30, 20]}, "path": {"kind": "waypoints", "points": points}}
    began = time.process_time()
    text = ask("write", problem=data)["text"]
    assert ask("read", text=text)["problem"] == data
    assert time.process_time() - began < 5


@pytest.mark.parametrize(
    "text",
    ['{"arm": {"a": 1, "a": 2}, "path": {}}', '{"arm": {}, "path": {"x": NaN}}', '{"arm": {"x": 1e999}, "path": {}}'],
)
def test_json_has_the_same_rules(text):
    with pytest.raises(InvalidInputError):
        ask("read", text=text)


def test_text_must_be_text_and_problems_mappings():
    with pytest.raises(InvalidInputError):
        ask("read", text=3)
    with pytest.raises(InvalidInputError):
        ask("write", problem=[1])
    with pytest.raises(InvalidInputError):
        ask("write", problem={"a": float("nan")})


def test_the_schema_accepts_what_the_examples_say():
    import jsonschema

    validator = jsonschema.Draft202012Validator(ask("schema"))
    for case in CASES:
        validator.validate(case.problem)
        validator.validate(yaml.safe_load(yaml_text(case.problem)))
