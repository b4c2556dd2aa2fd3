"""What a proof tells of itself: figures that add up, and that JSON can hold."""

import json
import math

import numpy as np

from selfmotion.certificate._arrays import Values
from selfmotion.certificate.result import Certificate, Level, TubeSlice


def test_a_summary_counts_what_is_left_and_says_what_became_better():
    tube = tuple(TubeSlice(r, np.zeros((m, 3)), np.ones((m, 3))) for r, m in ((0.0, 1), (0.5, 4), (1.0, 2)))
    levels = (Level(9, 800, 4.1, math.inf, 0.2), Level(17, 300, 4.7, 4.9, 0.5))
    summary = json.loads(json.dumps(Certificate(4.7, "cells", levels, tube).summary(), allow_nan=False))
    assert summary["argument"] == "cells"
    assert summary["tube"] == {"slices": 3, "cells": 7}
    assert [level["cost"] for level in summary["levels"]] == [None, 4.9]  # no motion was known in the first round
    assert summary["levels"][1] == {"slices": 17, "cells": 300, "bound": 4.7, "cost": 4.9, "seconds": 0.5}


def test_a_bound_is_a_proof_where_nothing_else_is_said():
    assert Certificate(1.0, "cells", (), ()).rigorous


def test_values_on_some_cells_are_theirs():
    values = Values(np.arange(8.0).reshape(4, 2), np.arange(4.0), np.arange(12.0).reshape(4, 3), np.arange(4.0) + 9)
    some = values.of(np.array([2, 0]))
    for part, whole in zip(some, values, strict=True):
        np.testing.assert_array_equal(part, whole[[2, 0]])
