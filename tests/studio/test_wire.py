import base64
import json
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

from selfmotion.errors import InvalidInputError
from selfmotion.studio.wire import packed, unpacked


@given(arrays(np.float64, array_shapes(min_dims=1, max_dims=3, min_side=0), elements=st.floats(width=64)))
def test_arrays_of_eight_bytes_come_back_bit_by_bit(array):
    back = unpacked("a", json.loads(json.dumps(packed(array), allow_nan=False)))
    assert back.shape == array.shape
    np.testing.assert_array_equal(back.view(np.uint64), array.view(np.uint64))


@given(arrays(np.float32, array_shapes(min_dims=1, max_dims=3, min_side=0), elements=st.floats(width=32)))
def test_arrays_of_four_bytes_come_back_bit_by_bit(array):
    back = unpacked("a", packed(array, "f4")).astype(np.float32)
    quiet = np.isnan(array)
    np.testing.assert_array_equal(np.isnan(back), quiet)
    np.testing.assert_array_equal(back[~quiet].view(np.uint32), array[~quiet].view(np.uint32))


def test_bytes_are_little_endian_rows_after_each_other():
    sent = packed(np.array([[1.0, 2.0], [3.0, np.nan]], order="F"), "f8")
    assert sent["shape"] == [2, 2]
    numbers = struct.unpack("<4d", base64.b64decode(sent["f8"]))
    assert numbers[:3] == (1.0, 2.0, 3.0)
    assert np.isnan(numbers[3])


@pytest.mark.parametrize(
    "sent",
    [
        {"f8": "AAAA", "shape": [1]}, {"f2": "", "shape": [0]}, {"f8": "", "shape": [3]}, {"f8": "!", "shape": [0]},
        {"shape": [1]}, [[1, 2], [3]], "text", None, {"f8": 3, "shape": [1]}, {"f8": "", "f4": "", "shape": [0]},
    ],
)  # fmt: skip
def test_what_is_no_array_is_refused_by_the_name_of_its_field(sent):
    with pytest.raises(InvalidInputError) as found:
        unpacked("hand.coefficients", sent)
    assert found.value.field == "hand.coefficients"
