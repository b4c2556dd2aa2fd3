"""Links: levers never below what postures show, capsules where the chain takes them, pairs that may meet."""

import numpy as np
import pytest

import selfmotion as sm
from selfmotion.arms.catalogue import CATALOGUE
from selfmotion.arms.chain import Chain
from selfmotion.arms.shapes import Capsule, Shapes
from selfmotion.errors import InvalidInputError
from selfmotion.scene.links import Links, segment_distances

RNG = np.random.default_rng(5)
