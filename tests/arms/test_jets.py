"""Jets: what comes out holds every value and derivative, whatever goes in; NaN never comes out."""

import mpmath
import numpy as np
import pytest

from selfmotion.arms import _jet_kernels as jets

UNARY = ["square", "sqrt", "cos", "sin", "minus"]
BINARY = ["add", "sub", "mul", "div", "atan2"]
INF = np.inf


def exact(name, *x):
    """The function that a jet operation stands for, in many digits."""
    f = {
        "square": lambda a: a * a,
        "sqrt": lambda a: mpmath.sqrt(max(a, mpmath.mpf(0))),
        "cos": mpmath.cos,
        "sin": mpmath.sin,
        "minus": lambda a: -a,
        "add": lambda a, b: a + b,
        "sub": lambda a, b: a - b,
        "mul": lambda a, b: a * b,
        "div": lambda a, b: a / b,
        "atan2": mpmath.atan2,
    }
    return f[name](*x)


class Tree:
    """A random expression in u: a jet over an interval, or a number in many digits."""

    def __init__(self, rng, depth):
        self.parts = []
        if depth == 0:
            self.name = str(rng.choice(["u", "c"], p=[0.7, 0.3]))
            self.number = float(rng.choice([0.0, 1.0, -2.5, rng.normal(), 1e-8 * rng.normal(), 1e6 * rng.normal()]))
        else:
            self.name = str(rng.choice([*UNARY, *BINARY, "scale"]))
            self.number = float(rng.normal())
            count = 2 if self.name in BINARY else 1
            self.parts = [Tree(rng, int(rng.integers(0, depth))) for _ in range(count)]

    def jet(self, low, high):
        if self.name == "u":
            return jets.variable(low, high)
        if self.name == "c":
            return jets.constant(self.number)
        parts = [part.jet(low, high) for part in self.parts]
        if self.name == "scale":
            return jets.scale(self.number, *parts)
        return getattr(jets, self.name)(*parts)

    def __call__(self, u):
        if self.name == "u":
            return u
        if self.name == "c":
            return mpmath.mpf(self.number)
        parts = [part(u) for part in self.parts]
        return mpmath.mpf(self.number) * parts[0] if self.name == "scale" else exact(self.name, *parts)

    def has_angle(self):
        return self.name == "atan2" or any(part.has_angle() for part in self.parts)


def holds(jet, value, angle):
    """Whether a value is in the jet; an angle modulo 2π."""
    turns = range(-2, 3) if angle else [0]
    return any(jet[0] <= value + 2 * mpmath.pi * k <= jet[1] for k in turns)


def random_interval(rng):
    width = rng.choice([0.0, 10.0 ** rng.uniform(-12, 0.7)])
    low = rng.choice([0.0, -width, -0.5 * width, rng.normal(), -rng.random() * width, 10.0 ** rng.uniform(-9, 4)])
    return float(low), float(low + width)


def points(rng, low, high):
    return [mpmath.mpf(x) for x in {low, high, *np.clip(rng.uniform(low, high, 3), low, high).tolist()}]


@pytest.mark.parametrize("part", range(4))
def test_random_expressions_lie_in_their_jets(part):
    rng, checked, informative = np.random.default_rng(part), 0, 0
    with mpmath.workdps(40):
        for _ in range(250):
            tree, (low, high) = Tree(rng, int(rng.integers(1, 5))), random_interval(rng)
            # An angle counts modulo 2π, so that nothing may be done to it afterwards.
            if any(part.has_angle() for part in tree.parts):
                continue
            jet = tree.jet(low, high)
            assert not np.isnan(jet).any()
            assert jet[0] <= jet[1]
            assert jet[2] <= jet[3]
            informative += np.isfinite(jet).all() and (jet[0] > -1e5) and (jet[1] < 1e5)
            for u in points(rng, low, high):
                try:
                    value = tree(u)
                except ZeroDivisionError:
                    continue
                assert holds(jet, value, tree.name == "atan2"), (tree.name, low, high, u)
                step = mpmath.mpf(10) ** -15 * max(abs(u), mpmath.mpf(10) ** -3)
                try:
                    ahead, behind = tree(u + step), tree(u - step)
                except ZeroDivisionError:
                    continue
                # The step leaves the interval only at its ends, where a few digits are left to it.
                rate = (ahead - behind) / (2 * step)
                if tree.name == "atan2" and abs(ahead - behind) > 3:
                    continue
                if np.isfinite(jet[2:]).all():
                    room = 1e-7 * (1 + abs(rate) + abs(jet[2]) + abs(jet[3]))
                    assert jet[2] - room <= rate <= jet[3] + room, (tree.name, low, high, u)
                checked += 1
    assert checked > 300
    assert informative > 80


@pytest.mark.parametrize("name", [*UNARY, *BINARY])
def test_single_operations_are_right_and_sharp_in_value_and_derivative(name):
    """With independent arguments the range over a box is known by its corners, turning points and the axes."""
    rng = np.random.default_rng(5)
    with mpmath.workdps(60):
        for _ in range(80):
            scale = 10.0 ** rng.uniform(-3, 3)
            boxes = [np.sort(scale * rng.normal(size=2)) for _ in range(1 + (name in BINARY))]
            if rng.random() < 0.5:
                boxes = [box + 5 * scale * rng.choice([-1, 0, 1]) for box in boxes]
            rates = rng.normal(size=len(boxes))
            arguments = [(*box.tolist(), float(rate), float(rate)) for box, rate in zip(boxes, rates, strict=True)]
            jet = getattr(jets, name)(*arguments)
            fractions = [np.append(np.linspace(0, 1, 9), -box[0] / (box[1] - box[0])) for box in boxes]
            grids = [
                box[0] + (box[1] - box[0]) * np.clip(part, 0, 1) for box, part in zip(boxes, fractions, strict=True)
            ]
            values = []
            for x in np.stack(np.meshgrid(*grids), -1).reshape(-1, len(boxes)):
                numbers = [mpmath.mpf(float(v)) for v in np.clip(x, *np.transpose(boxes))]
                if (name == "div" and numbers[1] == 0) or (name == "atan2" and numbers == [0, 0]):
                    continue
                value = exact(name, *numbers)
                assert holds(jet, value, name == "atan2")
                values.append(float(value))
                if not np.isfinite(jet[2:]).all():
                    continue
                d = mpmath.mpf(10) ** -20 * scale
                moved = [[n + s * d * float(r) for n, r in zip(numbers, rates, strict=True)] for s in (1, -1)]
                rate = (exact(name, *moved[0]) - exact(name, *moved[1])) / (2 * d)
                if abs(rate) * d < 1:  # not over the cut
                    room = 1e-9 * (abs(rate) + abs(jet[2]) + abs(jet[3]))
                    assert jet[2] - room <= rate <= jet[3] + room
            if name not in ("cos", "sin") and np.isfinite(jet[:2]).all():
                values = np.array(values)
                if name == "atan2":
                    values = np.where(values < jet[0] - 1e-9, values + 2 * np.pi, values)
                    if jet[1] - jet[0] > 6.2:  # around the origin
                        continue
                assert jet[1] - jet[0] <= (values.max() - values.min()) * (1 + 1e-9) + 1e-14 * max(abs(values)) + 1e-290


def test_cosine_and_sine_are_sharp():
    rng = np.random.default_rng(6)
    for _ in range(300):
        low = 10.0 ** rng.uniform(-3, 3) * rng.choice([-1, 1])
        high = low + 10.0 ** rng.uniform(-6, 1)
        for function, operation in ((np.cos, jets.cos), (np.sin, jets.sin)):
            values = function(np.linspace(low, high, 2001))
            jet = operation(jets.variable(low, high))
            assert jet[0] <= values.min()
            assert jet[1] >= values.max()
            assert jet[1] - jet[0] <= np.ptp(values) + 1e-5 * min(high - low, 1.0) + 1e-15


def test_angles_go_on_over_the_cut():
    rng = np.random.default_rng(7)
    for _ in range(500):
        x, y = -(10.0 ** rng.uniform(-8, 3)), 10.0 ** rng.uniform(-9, 3)
        jet = jets.atan2(jets.unknown(-y * rng.random(), y * rng.random()), jets.unknown(10 * x, x))
        assert np.pi / 2 < jet[0] < np.pi < jet[1] < 1.5 * np.pi
    assert jets.atan2(jets.held(-0.0, 0.0), jets.held(-1.0, -1.0))[:2] == pytest.approx([np.pi, np.pi], abs=1e-14)
    assert jets.atan2(jets.held(-1e-300, 1.0), jets.held(-1.0, 0.0))[:2] == pytest.approx([-np.pi, np.pi], abs=1e-14)


def test_degenerate_intervals_stay_narrow():
    for u in (0.0, 1e-200, 1e-9, 0.7, np.pi / 2, np.pi, 1e4):
        x = jets.variable(u, u)
        for jet in (jets.cos(x), jets.sin(x), jets.square(x), jets.add(x, x), jets.atan2(x, jets.constant(1.0))):
            assert jet[1] - jet[0] <= 2e-15 * abs(jet[0]) + 1e-290
            assert jet[3] - jet[2] <= 5e-15 * max(abs(jet[2]), 1.0)


def test_nothing_but_numbers_comes_out():
    """Zeros, the smallest and the largest numbers, and unknown derivatives, in every combination."""
    ends = [-1e308, -1.0, -1e-300, -5e-324, 0.0, 5e-324, 1e-160, 1.0, 1e200, 1.7e308]
    slopes = [(0.0, 0.0), (-INF, INF), (0.0, INF), (-1e308, 1e308), (-INF, -1.0)]
    rng = np.random.default_rng(8)
    for _ in range(4000):
        first, second = ((*sorted(rng.choice(ends, 2).tolist()), *slopes[rng.integers(len(slopes))]) for _ in range(2))
        results = [getattr(jets, name)(first) for name in UNARY]
        results += [getattr(jets, name)(first, second) for name in BINARY]
        results += [jets.scale(c, first) for c in (0.0, -2.0, 1e300)] + [jets.hull(first, second)]
        for jet in results:
            assert not np.isnan(jet).any()
            assert jet[0] <= jet[1]
            assert jet[2] <= jet[3]
            assert jet[0] < INF
            assert jet[1] > -INF


def test_unknown_derivatives_stay_unknown_but_for_exact_zero():
    wild, zero, one = jets.unknown(1.0, 2.0), jets.constant(0.0), jets.variable(1.0, 2.0)
    assert jets.mul(wild, one)[2:] == (-INF, INF)
    assert jets.add(wild, one)[2:] == (-INF, INF)
    assert max(np.abs(jets.mul(wild, zero)[:2])) < 1e-290
    assert jets.sqrt(jets.variable(0.0, 1.0))[2:] == (-INF, INF)
    assert jets.sqrt(jets.variable(-3.0, -1.0))[0] == 0.0
    assert jets.div(one, jets.variable(-1.0, 1.0)) == (-INF, INF, -INF, INF)


def test_common_part_and_hull():
    f, g = (0.0, 2.0, -1.0, 1.0), (1.0, 3.0, -INF, 0.5)
    assert jets.intersect(f, g) == (1.0, 2.0, -1.0, 0.5)
    assert jets.hull(f, g) == (0.0, 3.0, -INF, 1.0)
    assert jets.intersect((0.0, 1.0, 0.0, 0.0), (2.0, 3.0, 0.0, 0.0))[0] == 2.0
