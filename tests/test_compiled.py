"""Kernels that are handed kernels."""

import numpy as np
from numba import types

from selfmotion._compiled import Handed, kernel

NUMBER = types.float64(types.float64)


@kernel
def twice(x):
    return 2.0 * x


@kernel
def squared(x):
    return x * x


def _total(function, values):
    found = 0.0
    for k in range(len(values)):
        found += function(values[k])
    return found


total = Handed(_total, [NUMBER])


def test_a_kernel_is_compiled_once_for_all_that_it_is_handed():
    values = np.array([1.0, 2.0, 3.0])
    assert total(twice, values) == 12.0
    assert total(squared, values) == 14.0
    assert len(total._compiled) == 1
    assert total(squared, values[::2]) == 10.0  # another layout is another type
    assert len(total._compiled) == 2
