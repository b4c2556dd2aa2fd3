"""What optima are compared by."""

from types import SimpleNamespace

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.refinement import Optima, SplineSpace


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_a_start_as_steep_as_a_square_root_costs_what_it_does(tolerance):
    """Four nodes a span take 0.7 % less: as singular postures are left."""
    arm = sm.PlanarArm([1.0, 1.0, 1.0])
    problem = sm.Problem(arm, sm.Line([1.0, 1.0], [1.5, 1.0]), objective="l1")
    space = SplineSpace.with_spans(48, np.empty(0))
    motion = SimpleNamespace(
        space=space, correction=np.zeros_like, rates=lambda r: np.column_stack([0.5 / np.sqrt(r), 0 * r, 0 * r])
    )
    cost = Optima(problem, tolerance, np.inf).cost_of(motion)
    assert cost == pytest.approx(1.0, rel=2e-2 * tolerance)
    plain = space.weights @ motion.rates(space.nodes)[:, 0]
    assert plain < 0.995


def test_a_motion_that_cannot_be_measured_costs_more_than_any_other():
    arm = sm.PlanarArm([1.0, 1.0, 1.0])
    problem = sm.Problem(arm, sm.Line([1.0, 1.0], [1.5, 1.0]), objective="l1")
    space = SplineSpace.with_spans(48, np.empty(0))
    motion = SimpleNamespace(
        space=space,
        correction=np.zeros_like,
        rates=lambda r: np.column_stack([np.abs(np.sin(1e7 * r)) * 1e3, 0 * r, 0 * r]),
    )
    assert Optima(problem, 1e-6, np.inf).cost_of(motion) == np.inf
