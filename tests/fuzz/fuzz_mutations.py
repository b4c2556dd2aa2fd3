"""Valid inputs made wrong: plain data by its structure, text by its tokens, anything by its bytes.

All choices are those of a ``random.Random``, which may be hypothesis's, so that what it finds shrinks, or `Drawn` from
the bytes of a fuzzer that is guided by coverage.
"""

import copy
import random
import re

DEEPEST = 3000
LONGEST = 3000
NUMBERS = [
    0, -0.0, 1, -1, 2, 3, 0.5, 1e-9, 1e-17, 1e-100, 1e-160, 1e-300, 5e-324, 1e3, 1e6, 1e9, 1e16, 1e50, 1e99, 1e100,
    1.0001e100, 1e150, 1e200, 1.7976931348623157e308, float("inf"), float("-inf"), float("nan"), 3.141592653589793,
    6.283185307179586, 1.5707963267948966, 2**31, 2**53 + 1, 2**63, 2**64, -(2**63), 10**30, 10**400,
]  # fmt: skip
AWKWARD = [
    None, True, False, "", "0", "1e3", "nan", "x", "\0", "\ud800", "é\u0301", "経路", "\u202e",
    "🦾" * 50, "a" * 5000, "\n",
    "..", "/", "/dev/zero", "points.csv", "letter.svg", "arm.urdf", [], {}, [[]], [{}], {"": None}, {"kind": "line"},
    {"kind": None}, {"float": "inf"}, {"float": "nan"}, {"float": 1},
]  # fmt: skip
TEXT_NUMBERS = [
    "0", "-0", "1e-320", "1e308", "1e309", "-1e400", "nan", "inf", "1e100", "1e99", "1e-99", "1e16",
    "99999999999999999999",
    "9" * 400, "9" * 5000, "1.2.3", "--1", "1e", "1e-9", "1e9", "0x10", "1_000", "١", "-1", "2", "360", "90",
]  # fmt: skip
PLAIN_NUMBERS = [
    "0", "1", "-1", "2", "3", "4", "5", "0.5", "-0.001", "90", "180", "360", "-360", "10000", "1000000", "0.000000001",
    "100000000000000000", "123456789.123456789", "70", "100", "8", "-7",
]  # fmt: skip
_TOKEN = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[A-Za-z_$:]+|\s+|.", re.DOTALL)
_NUMBER = re.compile(r"[-+]?(?:\d|\.\d)")


class Drawn(random.Random):
    """Choices read off bytes: the same bytes make the same choices, and a changed byte changes few of them."""

    def __init__(self, data):
        super().__init__(0)
        self._data, self._at = data, 0

    def random(self):
        return self.getrandbits(16) / 65536.0

    def getrandbits(self, k):
        size = (k + 7) // 8
        piece = self._data[self._at : self._at + size]
        self._at += size
        return int.from_bytes(piece.ljust(size, b"\0"), "little") >> (8 * size - k)

    def choice(self, options):
        return options[self.getrandbits(16) % len(options)]

    def randrange(self, stop):
        return self.getrandbits(24) % stop


def places(data):
    """Return the place of every part of plain data down to a depth that nobody means, that of all of it first."""
    found, left = [], [((), data)]
    while left and len(found) < 20_000:
        place, value = left.pop()
        found.append(place)
        if len(place) < 20:
            items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
            left.extend(((*place, key), item) for key, item in items)
    return found


def part(data, place):
    for key in place:
        data = data[key]
    return data


def _put(data, place, value):
    """Return data with another value in one place."""
    if not place:
        return value
    part(data, place[:-1])[place[-1]] = value
    return data


def mutated(dice, data, others):
    """Return plain data with one to five parts of it made wrong; `others` give parts to put into it."""
    data = copy.deepcopy(data)
    for _ in range(1 + min(dice.randrange(5), dice.randrange(5))):
        place = dice.choice(places(data))
        data = dice.choice(_CHANGES)(dice, data, place, others)
    return data


def _dropped(dice, data, place, others):
    if place:
        del part(data, place[:-1])[place[-1]]
    return data


def _replaced(dice, data, place, others):
    return _put(data, place, copy.deepcopy(dice.choice(AWKWARD)))


def _number(dice, data, place, others):
    return _put(data, place, dice.choice(NUMBERS))


def _nudged(dice, data, place, others):
    """Change one number by a little or a lot, keeping its type if that can be."""
    numbers = [p for p in places(data) if type(part(data, p)) in (int, float)]
    if not numbers:
        return data
    place = dice.choice(numbers)
    value = part(data, place)
    try:
        changed = dice.choice(
            [-value, value * 1e-9, value * 1e9, value + 1, value * 1e-200, value * (1 + 1e-15), 2 * value]
        )
        return _put(data, place, type(value)(changed) if dice.randrange(2) else changed)
    except (OverflowError, ValueError):
        return data


def _repeated(dice, data, place, others):
    """Make the items of a list many, or double one of them."""
    value = part(data, place)
    if isinstance(value, list) and value:
        times = dice.choice([2, 2, 10, LONGEST // len(value)])
        return _put(
            data, place, (value * max(1, times))[:LONGEST] if dice.randrange(2) else [*value, dice.choice(value)]
        )
    return data


def _nested(dice, data, place, others):
    value = part(data, place)
    key = dice.choice(["", "path", "a"])
    for _ in range(dice.choice([1, 1, 2, 30, 300, DEEPEST])):
        value = {key: value} if key else [value]
    return _put(data, place, value)


def _chained(dice, data, place, others):
    """Put a part of kind reversed, placed or transformed around itself: data that is deep and yet makes sense."""
    mappings = [p for p in places(data) if isinstance(part(data, p), dict) and "kind" in part(data, p)]
    if not mappings:
        return data
    place = dice.choice(mappings)
    value, kind = part(data, place), dice.choice(["reversed", "arc_length", "transformed", "placed", "concatenation"])
    for _ in range(dice.choice([1, 2, 3, 40])):
        value = {"kind": kind, "parts": [value]} if kind == "concatenation" else {"kind": kind, "path": value}
    return _put(data, place, value)


def _grafted(dice, data, place, others):
    """Put a part of other data into a place."""
    source = dice.choice(others)
    return _put(data, place, copy.deepcopy(part(source, dice.choice(places(source)))))


def _renamed(dice, data, place, others):
    mappings = [p for p in places(data) if isinstance(part(data, p), dict) and part(data, p)]
    if not mappings:
        return data
    mapping = part(data, dice.choice(mappings))
    name = dice.choice(list(mapping))
    mapping[dice.choice(["", "kind", "x", "経", f"{name}s", "path"])] = mapping[name]
    return data


_CHANGES = [
    _dropped, _replaced, _replaced, _number, _number, _nudged, _nudged, _nudged, _repeated, _nested, _chained, _grafted,
    _grafted, _renamed,
]  # fmt: skip


def altered(dice, data, others=(), tokens=True):
    """Return bytes with one to six places of them made wrong, mostly by tokens where `tokens` and they are text."""
    for _ in range(1 + min(dice.randrange(6), dice.randrange(6), dice.randrange(6))):
        data = _by_token(dice, data, others) if tokens and dice.randrange(8) else _by_byte(dice, data, others)
    return data[:400_000]


def _by_byte(dice, data, others):
    at, end = sorted((dice.randrange(len(data) + 1), dice.randrange(len(data) + 1)))
    end = min(end, at + 1 + dice.randrange(40))
    other = dice.choice([data, *others])
    start = dice.randrange(len(other) + 1)
    junk = [
        b"",
        b"\0",
        b"\xff",
        b"\xef\xbb\xbf",
        b"\x80",
        b"\n",
        b"\r",
        bytes([dice.randrange(256)]),
        b"(" * 300,
        b"<g>" * 250,
    ]
    if not dice.randrange(12):
        return data[:at]
    change = [
        junk[dice.randrange(len(junk))],
        other[start : start + dice.randrange(200)],
        data[at:end] * dice.choice([2, 2, 30]),
    ]
    return data[:at] + change[dice.randrange(3)] + data[end:]


def _by_token(dice, data, others):
    text = data.decode("utf-8", "surrogateescape")
    tokens = _TOKEN.findall(text) if len(text) <= 60_000 else []
    if not tokens:
        return data
    way = dice.randrange(12)
    if way >= 11:
        return _by_line(dice, text).encode("utf-8", "surrogateescape")
    at = dice.randrange(len(tokens))
    if way < 6:
        numbers = [k for k, token in enumerate(tokens) if _NUMBER.match(token)] or [at]
        tokens[dice.choice(numbers)] = dice.choice(PLAIN_NUMBERS if dice.randrange(3) else TEXT_NUMBERS)
    elif way < 9:  # one word for another
        words = [k for k, token in enumerate(tokens) if token[0].isalpha()] or [at]
        source = dice.choice([data, data, *others]).decode("utf-8", "surrogateescape")[:60_000]
        tokens[dice.choice(words)] = dice.choice([w for w in _TOKEN.findall(source) if w[0].isalpha()] or [""])
    elif way == 9:
        tokens[at] = dice.choice(tokens)
    else:
        end = at + 1 + dice.randrange(8)
        tokens[at:end] = tokens[at:end] * dice.choice([0, 2, 2, 100])
    return "".join(tokens).encode("utf-8", "surrogateescape")


def _by_line(dice, text):
    """Move, double or multiply a few lines: two are a tag of DXF, one is an element of most XML."""
    lines = text.splitlines(keepends=True)
    at, to = dice.randrange(len(lines)), dice.randrange(len(lines))
    end = at + dice.choice([1, 2, 4, 10])
    taken = lines[at:end]
    if dice.randrange(2):
        del lines[at:end]
    lines[to:to] = taken * dice.choice([0, 1, 1, 2, 200])
    return "".join(lines)
