"""Distances of segments from shapes against what does not share their formulas: dense sampling, shapely, coal, laws."""

import math

import numpy as np
import pytest

from selfmotion.scene._distance_kernels import segment_distance, segments_distance
from selfmotion.scene.kinds import (
    BOX,
    CAPSULE,
    HALF_SPACE,
    POLYGON,
    SPHERE,
)

SCALES = (1e-9, 1e-3, 1.0, 1e9)
L_SHAPE = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]], dtype=float)
SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)


def star(rng, corners=None):
    """Return a polygon that a point sees all of, counter-clockwise; seldom convex."""
    corners = corners or rng.integers(3, 12)
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
    while np.diff(angles, append=angles[0] + 2 * np.pi).max() > 3.0:
        angles = np.sort(rng.uniform(0, 2 * np.pi, corners))
    return rng.uniform(0.3, 2, (corners, 1)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def polygon(corners):
    return POLYGON, np.array([len(corners), *np.ravel(corners)], dtype=float)


def turned(rng):
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def shapes(rng):
    """Return one of each, of about the size one, those of the plane last."""
    direction = rng.normal(size=3)
    return {
        "sphere": (SPHERE, np.array([*rng.normal(size=3), rng.uniform(0, 1)])),
        "half space": (HALF_SPACE, np.array([*direction / np.linalg.norm(direction), rng.normal()])),
        "box": (BOX, np.array([*rng.normal(size=3), *rng.uniform(0.01, 1, 3), *turned(rng).ravel()])),
        "capsule": (CAPSULE, np.array([*rng.normal(size=6), rng.uniform(0, 0.5)])),
        "polygon": polygon(star(rng)),
    }


def scaled(shape, by):
    kind, numbers = shape
    numbers = numbers.copy()
    if kind == HALF_SPACE:
        numbers[3] *= by
    elif kind == BOX:
        numbers[:6] *= by
    elif kind == POLYGON:
        numbers[1:] *= by
    else:
        numbers *= by
    return kind, numbers


def asked(shape, p, q):
    """Return distance, the point of the segment, and the direction."""
    kind, numbers = shape
    at, normal = np.full(3, np.nan), np.full(3, np.nan)
    p, q = (np.append(x, np.zeros(3 - len(x))).astype(float) for x in (p, q))
    return segment_distance(kind, numbers, 0, p, q, at, normal), at, normal


def signed(shape, points):
    """Return the signed distances of points (k, 3) from a shape by formulas of one point, in numpy."""
    kind, x = shape
    if kind == SPHERE:
        return np.linalg.norm(points - x[:3], axis=1) - x[3]
    if kind == HALF_SPACE:
        return points @ x[:3] - x[3]
    if kind == BOX:
        beyond = np.abs((points - x[:3]) @ x[6:].reshape(3, 3)) - x[3:6]
        return np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
    if kind == CAPSULE:
        return np.linalg.norm(points - nearest(points, x[:3], x[3:6]), axis=1) - x[6]
    corners = x[1:].reshape(-1, 2)
    least, winding = np.full(len(points), np.inf), np.zeros(len(points))
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        least = np.minimum(least, np.linalg.norm(points[:, :2] - nearest(points[:, :2], a, b), axis=1))
        u, v = (a - points[:, :2]).T, (b - points[:, :2]).T
        winding += np.arctan2(u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1])
    return np.where(winding > np.pi, -least, least)


def nearest(points, a, b):
    t = np.clip((points - a) @ (b - a) / max((b - a) @ (b - a), 1e-300), 0, 1)
    return a + t[:, None] * (b - a)


def segment(rng, plane):
    """Return ends at random: long, short, a point, along an axis."""
    p = rng.normal(size=3) * rng.choice([0.3, 1, 3])
    d = rng.normal(size=3) * rng.choice([0, 1e-6, 0.1, 1, 5], p=[0.1, 0.1, 0.2, 0.4, 0.2])
    if rng.random() < 0.2:
        d *= np.eye(3)[rng.integers(2 if plane else 3)]
    if plane:
        p[2] = d[2] = 0
    return p, p + d


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", ["sphere", "half space", "box", "capsule", "polygon"])
def test_against_dense_points_of_the_segment(name, scale):
    rng = np.random.default_rng(7)
    t = np.linspace(0, 1, 2001)[:, None]
    seen = set()
    for _ in range(400):
        shape = shapes(rng)[name]
        p, q = segment(rng, name == "polygon")
        points = p + t * (q - p)
        truth = signed(shape, points)
        found, at, normal = asked(scaled(shape, scale), p * scale, q * scale)
        found, at = found / scale, at / scale
        seen.add(found > 0)
        step = np.linalg.norm(q - p) / 4000
        assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-12)
        on = nearest(at[None], p, q)[0]
        assert np.linalg.norm(on - at) < 1e-14 * (1 + np.abs([p, q]).max())
        assert signed(shape, at[None])[0] == pytest.approx(found, abs=1e-13)
        if found > 0:
            assert truth.min() - step <= found + 1e-13
            assert found <= truth.min() + 1e-13
        else:
            assert truth.min() <= step
            if name != "polygon":
                assert found <= truth.min() + 1e-13
            else:
                assert found <= min(truth[0], truth[-1]) + 1e-13
        # The way out: a small step along it raises the distance by as much, where the distance is smooth.
        if abs(found) > 1e-3 and name != "polygon":
            moved = signed(shape, at[None] + 1e-7 * normal)[0]
            assert moved - found == pytest.approx(1e-7, abs=1e-10)
    assert seen == {True, False}


def pair_distance(p, q, u, v):
    """Return the least distance of two segments by projection of dense points and local refinement."""
    low, high, t = 0.0, 1.0, np.linspace(0, 1, 200)
    for _ in range(12):
        s = low + (high - low) * t
        points = p + s[:, None] * (q - p)
        found = np.linalg.norm(points - nearest(points, u, v), axis=1)
        k = found.argmin()
        low, high = s[max(k - 1, 0)], s[min(k + 1, len(s) - 1)]
    return found.min()


def link_pair(p, q, u, v):
    at, other, normal = np.empty(3), np.empty(3), np.empty(3)
    return segments_distance(p, q, u, v, at, other, normal), at, other, normal


@pytest.mark.parametrize("scale", SCALES)
def test_two_segments_at_any_angle(scale):
    rng = np.random.default_rng(3)
    for k in range(600):
        p, q, u, v = rng.normal(size=(4, 3))
        if k % 3 == 1:  # nearly parallel, crossing
            tilt = 10.0 ** rng.uniform(-17, -1)
            a, b = rng.uniform(0, 1, 2)
            d = q - p
            e = d * rng.uniform(0.5, 2) + tilt * rng.normal(size=3)
            u = p + a * d - b * e + rng.choice([0, 1e-9, 0.1]) * rng.normal(size=3)
            v = u + e
        if k % 3 == 2:  # parallel, on one line, points
            e = (q - p) * rng.choice([-1.0, 0.0, 0.5, 1.0, 2.0])
            u = p + rng.choice([0, 1, 0.5]) * (q - p) + rng.choice([0, 0.3]) * rng.normal(size=3)
            v = u + e
            if rng.random() < 0.2:
                q = p
        found, at, other, normal = link_pair(p * scale, q * scale, u * scale, v * scale)
        found = found / scale
        size = np.abs([p, q, u, v]).max()
        assert found == pytest.approx(pair_distance(p, q, u, v), abs=1e-14 * size)
        assert np.linalg.norm(at - other) / scale == pytest.approx(found, abs=2e-15 * size)
        assert np.linalg.norm(normal) == pytest.approx(1, abs=1e-12)
        assert link_pair(u * scale, v * scale, p * scale, q * scale)[0] / scale == pytest.approx(
            found, abs=1e-15 * size
        )


@pytest.mark.parametrize("y", [0.3, -0.3, 0.9])
def test_links_of_the_plane_that_cross_part_in_the_plane(y):
    u, v = np.array([-1.0, 0, 0]), np.array([1.0, 0, 0])
    p, q = np.array([0.1, y, 0]), np.array([0.1, y - 1.0 if y > 0 else y + 1.0, 0])
    found, at, other, normal = link_pair(p, q, u, v)
    assert found == 0
    assert at == pytest.approx([0.1, 0, 0])
    assert other == pytest.approx([0.1, 0, 0])
    more_of_it_is_above = max(p[1], q[1]) > -min(p[1], q[1])
    assert normal == pytest.approx([0, 1 if more_of_it_is_above else -1, 0])


def test_links_in_space_that_cross_part_across_both():
    p, q, u, v = np.array([[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0.5, 1, 0.0]])
    p[2] = q[2] = u[2] = v[2] = 0.25
    tilt = np.array([[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]])
    *_, normal = link_pair(*(tilt @ x for x in (p, q, u, v)))
    assert abs(normal @ tilt[:, 2]) == pytest.approx(1)


DIAGONAL = [[-1, -1], [2, 2]]
IN_SQUARE = {
    "through two corners": (DIAGONAL, -0.5),
    "from a corner to a corner": ([[0, 0], [1, 1]], -0.5),
    "from the middle": ([[0.5, 0.5], [3, 0.5]], -0.5),
    "a point inside": ([[0.25, 0.5], [0.25, 0.5]], -0.25),
    "across": ([[-1, 0.25], [2, 0.25]], -0.25),
    "along an edge": ([[-1, 0], [2, 0]], 0.0),
    "part of an edge": ([[0.2, 1], [0.4, 1]], 0.0),
    "ends on an edge": ([[0.2, 1], [0.4, 2]], 0.0),
    "touches a corner": ([[-1, 1], [1, -1]], 0.0),
    "ends at a corner": ([[1, 1], [2, 2]], 0.0),
    "a point on an edge": ([[1, 0.3], [1, 0.3]], 0.0),
    "a point at a corner": ([[1, 0], [1, 0]], 0.0),
    "beside an edge": ([[-1, -0.1], [2, -0.1]], 0.1),
    "beside a corner": ([[1.3, 1.4], [2, 2]], 0.5),
    "a point outside": ([[-0.5, 0.5], [-0.5, 0.5]], 0.5),
    "level with edges": ([[2, 0], [3, 0]], 1.0),
}


@pytest.mark.parametrize("turns", range(4))
@pytest.mark.parametrize("case", IN_SQUARE)
def test_where_a_segment_and_a_square_meet(case, turns):
    (p, q), truth = IN_SQUARE[case]
    for first, last in ((p, q), (q, p)):
        found, at, normal = asked(polygon(np.roll(SQUARE, turns, axis=0)), np.array(first), np.array(last))
        assert found == pytest.approx(truth, abs=1e-15)
        assert np.linalg.norm(normal) == pytest.approx(1)
        if truth <= 0:
            moved = signed(polygon(SQUARE), at[None] + 0.01 * normal)[0]
            assert moved == pytest.approx(truth + 0.01, abs=1e-9) or case in ("through two corners", "from the middle")


def test_the_notch_of_a_polygon_that_is_not_convex_is_free():
    assert asked(polygon(L_SHAPE), [2, 2], [2.5, 2.5])[0] == 1.0
    assert asked(polygon(L_SHAPE), [0.5, 2.9], [2.9, 0.5])[0] == pytest.approx(-0.3)  # in both arms of the L


def test_polygons_against_shapely():
    shapely = pytest.importorskip("shapely")
    rng = np.random.default_rng(11)
    count = 100_000
    kinds = [star(rng) for _ in range(500)]
    kinds[:3] = [SQUARE, L_SHAPE, np.array([[0, 0], [4, 0], [4, 1e-9]])]
    oracles = np.array([shapely.Polygon(corners) for corners in kinds])
    ours = [polygon(corners) for corners in kinds]
    which = rng.integers(len(kinds), size=count)
    ends = np.zeros((count, 2, 2))
    for k in range(count):
        p, q = segment(rng, plane=True)
        corners = kinds[which[k]]
        match k % 6:  # onto corners and edges, along edges
            case 1:
                p[:2] = corners[k % len(corners)]
            case 2:
                a, b = corners[k % len(corners)], corners[k % len(corners) - 1]
                p[:2] = a + rng.choice([0.0, 0.25, 0.5, 1.0, 2.0]) * (b - a)
                q[:2] = a + rng.choice([-1.0, 0.0, 0.5, 1.0]) * (b - a)
            case 3:
                a = corners[k % len(corners)]
                p[:2], q[:2] = a - q[:2], a + q[:2]  # through a corner
        ends[k] = p[:2], q[:2]
    truth = shapely.distance(shapely.linestrings(ends), oracles[which])
    found = np.empty(count)
    at, at3, normal, p3, q3 = np.empty((count, 2)), np.empty(3), np.empty(3), np.zeros(3), np.zeros(3)
    for k in range(count):
        p3[:2], q3[:2] = ends[k]
        found[k] = segment_distance(*ours[which[k]], 0, p3, q3, at3, normal)
        at[k] = at3[:2]
    size = 1e-14 * (1 + np.abs(ends).max(axis=(1, 2)))
    assert (np.abs(np.maximum(found, 0) - truth) <= size).all()
    free = found > 0
    assert 0.3 < free.mean() < 0.7
    points = shapely.points(at[~free])
    depth = shapely.distance(points, shapely.boundary(oracles[which[~free]]))
    assert np.abs(depth + found[~free]).max() < 1e-13
    deep = depth > 1e-13
    assert shapely.contains(oracles[which[~free]][deep], points[deep]).all()
    # No segment that is deep inside is said to be free, or to touch only.
    shrunk = shapely.buffer(oracles, -1e-9)
    through = shapely.length(shapely.intersection(shapely.linestrings(ends), shrunk[which])) > 1e-6
    assert through.mean() > 0.3
    along_an_edge = np.arange(count) % 6 == 2  # whose middle may be on the edge, and nothing deeper looked at
    assert (found[through & along_an_edge] < 1e-14).all()
    assert (found[through & ~along_an_edge] < -1e-10).all()


def test_the_deepest_of_a_convex_polygon_is_found():
    rng = np.random.default_rng(5)
    t = np.linspace(0, 1, 5001)[:, None]
    for _ in range(200):
        corners = np.stack([np.cos(a := np.sort(rng.uniform(0, 2 * np.pi, 7))), np.sin(a)], axis=1)
        p, q = rng.normal(size=(2, 2))
        found, *_ = asked(polygon(corners), p, q)
        points = np.pad(p + t * (q - p), ((0, 0), (0, 1)))
        truth = signed(polygon(corners), points).min()
        if truth < 0:
            assert found <= truth + 1e-3 * np.linalg.norm(q - p)
            assert found >= truth - np.linalg.norm(q - p) / 5000


@pytest.mark.parametrize("name", ["sphere", "half space", "box", "capsule", "polygon"])
def test_no_two_answers_contradict_each_other(name):
    """The signed distance is 1-Lipschitz: what is free here is not blocked deeper there than it moved."""
    rng = np.random.default_rng(9)
    for _ in range(3000):
        shape = shapes(rng)[name]
        p, q = segment(rng, name == "polygon")
        move = rng.normal(size=(2, 3)) * 10.0 ** rng.uniform(-8, 0)
        if name == "polygon":
            move[:, 2] = 0
        here, *_ = asked(shape, p, q)
        there, *_ = asked(shape, p + move[0], q + move[1])
        far = np.linalg.norm(move, axis=1).max() + 1e-13
        if here > 0 or there > 0:
            assert abs(there - here) <= far
        part = np.sort(rng.uniform(0, 1, 2))  # a part of a free segment is as free
        some, *_ = asked(shape, p + part[0] * (q - p), p + part[1] * (q - p))
        assert some >= here - 1e-13 or here <= 0
        if name != "polygon":
            assert abs(there - here) <= far
            assert some >= here - 1e-13


def test_boxes_and_capsules_against_coal():
    coal = pytest.importorskip("coal")
    rng = np.random.default_rng(13)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for _ in range(3000):
        p, q, c = rng.normal(size=(3, 3)) * [[1], [1], [2]]
        r = 0.05
        length = np.linalg.norm(q - p)
        z = (q - p) / length
        x = np.cross(z, [0, 0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0, 0])
        x /= np.linalg.norm(x)
        link = coal.CollisionObject(
            coal.Capsule(r, length), coal.Transform3s(np.stack([x, np.cross(z, x), z], axis=1), (p + q) / 2)
        )
        half, turn = rng.uniform(0.1, 1, 3), turned(rng)
        box = coal.CollisionObject(coal.Box(2 * half), coal.Transform3s(turn, c))
        result.clear()
        truth = coal.distance(link, box, request, result)
        found, *_ = asked((BOX, np.array([*c, *half, *turn.ravel()])), p, q)
        if truth > 1e-3:
            assert found - r == pytest.approx(truth, abs=2e-6)
        else:
            assert found - r < 1e-3 + 2e-6


def test_a_shape_is_read_where_it_begins_among_others():
    numbers = np.array([9.0, 9, 9, 0, 0, 0, 1, 4, 0, 0, 1, 0, 1, 1, 0, 1, 7, 7])
    at, normal = np.empty(3), np.empty(3)
    p, q = np.array([2.0, 0, 0]), np.array([3.0, 0, 0])
    assert segment_distance(SPHERE, numbers, 3, p, q, at, normal) == 1.0
    assert segment_distance(POLYGON, numbers, 7, p, q, at, normal) == 1.0
    assert at.tolist() == [2, 0, 0]
    assert normal.tolist() == [1, 0, 0]


def test_a_link_through_the_centre_of_a_circle_is_pushed_out_in_the_plane():
    found, at, normal = asked((SPHERE, np.array([0.0, 0, 0, 2])), [-1, -1], [1, 1])
    assert found == -2
    assert at == pytest.approx([0, 0, 0])
    assert normal == pytest.approx([-math.sqrt(0.5), math.sqrt(0.5), 0])
