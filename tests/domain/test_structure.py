"""Events, cells and connected parts of the angle domain, against inverse kinematics that shares no formula."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy import ndimage
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import selfmotion as sm
from oracle import Arms, as_complex, column_of, random_arm, random_path
from selfmotion.arms.event_circles import event_circles
from selfmotion.domain import AngleDomain
from selfmotion.domain.fibre import fibres

PROBLEMS = 2_000
PARTS = 4
NEAR = 1e-8  # how near the oracle looks on both sides of an event


@dataclass
class Case:
    arm: sm.PlanarArm
    path: sm.paths.Path
    domain: AngleDomain

    @property
    def structure(self):
        return self.domain.structure

    def fibres(self, r):
        return fibres(self.domain.self_motion, self.path(np.asarray(r)))


@pytest.fixture(scope="module", params=range(PARTS))
def cases(request):
    rng = np.random.default_rng(500 + request.param)
    made = []
    for _ in range(PROBLEMS // PARTS):
        arm = random_arm(rng)
        path = random_path(rng, arm)
        made.append(Case(arm, path, sm.angle_domain(arm, path)))
    return made


class Batch:
    """Events of many problems side by side, and the oracle at r ± NEAR."""

    def __init__(self, pairs):
        self.events = [event for _, event in pairs]
        self.arms = Arms([case.arm for case, _ in pairs], [1.0 - 2.0 * event.branch for _, event in pairs])
        self.u = np.array([event.u for _, event in pairs])
        at = {side: [case.path(event.r + side * NEAR) for case, event in pairs] for side in (-1, 0, 1)}
        self.x = {side: as_complex(np.array(points)) for side, points in at.items()}
        self.rows = np.arange(len(pairs))

    def extreme(self, side, window, sign):
        """The largest (sign 1) or smallest (−1) least margin near the event, zoomed into."""
        offsets = np.concatenate([-np.logspace(0, -11, 100), [0], np.logspace(-11, 0, 100)])
        grid = self.u[:, None] + window[:, None] * offsets
        best = np.full(len(self.u), -np.inf)
        for _ in range(7):
            margin = sign * self.arms.margin(self.x[side], grid)
            k = np.argmax(margin, axis=1)
            best = np.maximum(best, margin[self.rows, k])
            low, high = grid[self.rows, np.maximum(k - 1, 0)], grid[self.rows, np.minimum(k + 1, grid.shape[1] - 1)]
            grid = low[:, None] + (high - low)[:, None] * np.linspace(0, 1, 15)
        return sign * best

    def limit_at_fold(self, side):
        """The margin of the event's limit at its fold's posture."""
        fold = np.array([next(c.value for c in causes(event) if c.kind == "fold") for event in self.events])
        limit = np.array([next(column_of(c) for c in causes(event) if c.kind != "fold") for event in self.events])
        both = [self.arms.limit_margins(self.arms.at_fold(self.x[0], fold, s)[0][:, None])[:, 0] for s in (1, -1)]
        off = [np.abs(margins[self.rows, limit - 2]) for margins in both]
        q, _ = self.arms.at_fold(self.x[side], fold, np.where(off[0] < off[1], 1, -1))
        return self.arms.limit_margins(q[:, None])[self.rows, 0, limit - 2]

    def other_where_one_binds(self, side, one, other):
        """The margin of constraint `other` where, near the event, that of `one` vanishes."""
        x = self.x[side]

        def margin(u, column):
            return self.arms.margins(x, u[:, None])[self.rows, 0, column]

        width = np.full(len(self.u), 1e-9)
        for _ in range(40):
            open_ = np.sign(margin(self.u - width, one)) == np.sign(margin(self.u + width, one))
            width = np.where(open_, 1.7 * width, width)
        low, high = self.u - width, self.u + width
        at_low = np.sign(margin(low, one))
        for _ in range(60):
            middle = 0.5 * (low + high)
            same = np.sign(margin(middle, one)) == at_low
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return margin(0.5 * (low + high), other)


def causes(event):
    return (*event.causes, *event.instead_of)


def at_a_fold(event):
    return any(c.kind == "fold" for c in causes(event)) and any(c.kind != "fold" for c in causes(event))


def events_of(cases, *kinds, fold):
    """Events of some kinds, at folds or not; none where w = 0, where joints swing within no distance of r."""
    return [
        (case, e)
        for case in cases
        for e in case.structure.events
        if e.kind in kinds
        and at_a_fold(e) == fold
        and not any(o.kind == "singular" and o.r == e.r for o in case.structure.events)
    ]


def windows(pairs):
    """Half-widths in u around the events that no end of another interval comes into."""
    result = []
    for case, event in pairs:
        whole, parted = case.fibres([event.r - NEAR, event.r + NEAR])
        if event.kind in ("closes", "merges"):
            whole, parted = parted, whole
        others = [off(u, event) for i in on(whole, event) if not i.is_circle for u in (i.low, i.high)]
        if event.kind in ("splits", "merges"):
            ends = [off(u, event) for i in on(parted, event) if not i.is_circle for u in (i.low, i.high)]
            others += sorted(ends)[2:]
        else:
            nearest = sorted(on(parted, event), key=lambda i: off(0.5 * (i.low + i.high), event))
            others += [off(u, event) for i in nearest[1:] for u in (i.low, i.high)]
        result.append(0.5 * min([0.2, *others]))
    return np.array(result)


def on(fibre, event):
    return [interval for interval in fibre.intervals if interval.branch == event.branch]


def off(u, event):
    return abs(np.angle(np.exp(1j * (u - event.u))))


def test_intervals_open_and_close_where_dense_inverse_kinematics_says_so(cases):
    for kind, before, after in (("opens", -1, 1), ("closes", 1, -1)):
        pairs = events_of(cases, kind, fold=False)
        batch, window = Batch(pairs), windows(pairs)
        assert len(pairs) > len(cases)
        np.testing.assert_array_less(batch.extreme(before, window, 1), 0)
        np.testing.assert_array_less(0, batch.extreme(after, window, 1))
        batch = Batch(events_of(cases, kind, fold=True))
        np.testing.assert_array_less(batch.limit_at_fold(before), 0)
        np.testing.assert_array_less(0, batch.limit_at_fold(after))


def test_intervals_split_and_merge_where_dense_inverse_kinematics_says_so(cases):
    for kind, whole, parted in (("splits", -1, 1), ("merges", 1, -1)):
        pairs = events_of(cases, kind, fold=False)
        batch, window = Batch(pairs), windows(pairs)
        assert len(pairs) > 0.6 * len(cases)
        np.testing.assert_array_less(0, batch.extreme(whole, window, -1))
        np.testing.assert_array_less(batch.extreme(parted, window, -1), 0)


def test_limits_and_folds_take_over_where_dense_inverse_kinematics_says_so(cases):
    for kind, apart, together in (("branches meet", -1, 1), ("branches part", 1, -1)):
        batch = Batch(events_of(cases, kind, fold=True))
        assert len(batch.events) > 0.3 * len(cases)
        np.testing.assert_array_less(batch.limit_at_fold(apart), 0)
        np.testing.assert_array_less(0, batch.limit_at_fold(together))
    pairs = events_of(cases, "takes over", fold=False)
    batch = Batch(pairs)
    assert len(batch.events) > len(cases)
    old = np.array([column_of(event.instead_of[0]) for event in batch.events])
    new = np.array([column_of(event.causes[0]) for event in batch.events])
    np.testing.assert_array_less(0, batch.other_where_one_binds(-1, old, new))
    np.testing.assert_array_less(batch.other_where_one_binds(1, old, new), 0)
    np.testing.assert_array_less(batch.other_where_one_binds(-1, new, old), 0)
    np.testing.assert_array_less(0, batch.other_where_one_binds(1, new, old))


def test_between_events_the_structure_is_what_dense_inverse_kinematics_sees(cases):
    """Number of intervals per branch, and that the constraint named at each end vanishes there."""
    rng = np.random.default_rng(1)
    for case in cases:
        looks = [(cell, r) for cell in case.structure.cells for r in rng.uniform(*cell.r, 2) if inside(cell, r)]
        if not looks:
            continue
        for (cell, r), fibre in zip(looks, case.fibres([r for _, r in looks]), strict=True):
            assert fibre.names == cell.fibre.names, (case.arm, case.path, r)
        for branch in (0, 1):
            rows = [[i for i in fibre.intervals if i.branch == branch] for fibre in case.fibres([r for _, r in looks])]
            arms = Arms([case.arm] * len(looks), [1.0 - 2.0 * branch] * len(looks))
            x = as_complex(case.path([r for _, r in looks]))
            assert_runs(arms, x, rows, (case.arm, case.path, branch))
            assert_causes(arms, x, rows, fibre.causes)


def inside(cell, r):
    return min(r - cell.r[0], cell.r[1] - r) > 2e-7


def assert_runs(arms, x, rows, context):
    places = [
        np.array([v for i in row for v in (0.5 * (i.low + i.high), i.high + 0.5 * gap_after(i, row))]) for row in rows
    ]
    most = max(len(p) for p in places)
    u = np.array([np.concatenate([np.linspace(-np.pi, np.pi, 240, False), np.resize(p, most)]) if len(p) else
                  np.resize(np.linspace(-np.pi, np.pi, 240, False), 240 + most) for p in places])  # fmt: skip
    u = np.sort(np.angle(np.exp(1j * u)), axis=1)
    margin = arms.margin(x, u)
    for row, mine in zip(rows, margin, strict=True):
        feasible = mine[np.abs(mine) > 1e-12] > 0
        runs = int((feasible & ~np.roll(feasible, 1)).sum()) + int(feasible.all())
        # An interval at a fold may be narrower in u than rounding: the oracle need not see it.
        assert sum(i.high - i.low > 1e-9 for i in row) <= runs <= len(row), context


def gap_after(interval, row):
    return min((np.mod(other.low - interval.high, 2 * np.pi) for other in row), default=0.0)


def assert_causes(arms, x, rows, all_causes):
    places = [(k, u, end) for k, row in enumerate(rows) for i in row if not i.is_circle
              for u, end in ((i.low, i.ends[0]), (i.high, i.ends[1]))]  # fmt: skip
    if places:
        which = [k for k, _, _ in places]
        margins = arms[which].margins(x[which], np.array([[u] for _, u, _ in places]))[:, 0]
        for mine, (_, _, end) in zip(margins, places, strict=True):
            assert all(abs(mine[column_of(all_causes[c])]) < 1e-7 for c in end)


def test_no_event_that_lasts_longer_than_1e_6_is_missed():
    """Lines that just touch an event circle: what happens inside it lasts as long as asked for, and is seen."""
    rng = np.random.default_rng(3)
    seen, decided = {}, 0
    for _ in range(3000):
        arm = random_arm(rng)
        circle = event_circles(arm)[rng.integers(len(event_circles(arm)))]
        lasting = 10.0 ** rng.uniform(-5.9, -3)
        angle, length, at = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 1.0), rng.uniform(0.2, 0.8)
        half = 0.5 * lasting * length
        if circle.radius < 2 * half or arm.links.max() > 20 * arm.links.min():
            continue
        normal, along = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        foot = circle.center + np.sqrt(circle.radius**2 - half**2) * normal
        path = sm.Line(foot - at * length * along, foot + (1 - at) * length * along)
        domain = sm.angle_domain(arm, path)
        looks = [at, at - 0.7 * lasting, at + 0.7 * lasting]
        within, before, after = (f.names for f in fibres(domain.self_motion, path(looks)))
        must = only_this_limit_decides_at_the_fold(arm, circle, path(at))
        assert not must or within != before, (arm, path, lasting, circle)
        decided += must
        if before != after or within == before:
            continue
        kind = (*sorted({c.kind.split()[-1] for c in circle.causes}), len(circle.causes))
        seen[kind] = seen.get(kind, 0) + 1
        r = np.array([event.r for event in domain.structure.events])
        # Rounding the path's points moves two crossings that are so near: the slope of |x − c|² there is about this.
        rounding = 4e-16 * (circle.radius + np.abs(circle.center).max()) ** 2 / (length**2 * lasting)
        for expected in (at - lasting / 2, at + lasting / 2):
            assert np.abs(r - expected).min() < max(NEAR, 8 * rounding), (arm, path, lasting, circle)
    assert min(seen[kind] for kind in (("fold", 1), ("limit", 1), ("fold", "limit", 2), ("limit", 2))) > 20
    assert decided > 100


def only_this_limit_decides_at_the_fold(arm, circle, x):
    """Whether, by the law of cosines, the posture at a fold is in reach and clear of all limits but the circle's."""
    if {c.kind == "fold" for c in circle.causes} != {True, False}:
        return False
    limit, fold = sorted(circle.causes, key=lambda cause: cause.kind == "fold")
    arms, column = Arms([arm], [1.0]), column_of(limit) - 2
    for side in (1, -1):
        q, _ = arms.at_fold(np.array([complex(*x)]), np.array([fold.value]), side)
        margins = arms.limit_margins(q[:, None])[0, 0]
        reached = np.linalg.norm(arm.forward(q[0, : arm.n]) - x) < 1e-6 * arm.reach
        if reached and abs(margins[column]) < 1e-4 and np.delete(margins, column).min() > 0.01:
            return True
    return False


def test_the_rim_touched_by_a_curved_path_is_left_for_as_long_as_it_is():
    """Links a little too short for the farthest point of a Bezier path: out of reach for as long as planted."""
    rng = np.random.default_rng(12)
    for _ in range(100):
        path = sm.Bezier(np.array([2.0, 0.5]) + rng.uniform(-1, 1, (rng.integers(4, 9), 2)))
        r = np.linspace(0, 1, 2001)
        k = int(np.argmax(np.linalg.norm(path(r), axis=1)))
        if not 20 < k < 1980:
            continue
        low, high = r[k - 1], r[k + 1]
        for _ in range(200):  # the farthest point, by thirds
            a, b = low + (high - low) / 3, high - (high - low) / 3
            low, high = (a, high) if np.hypot(*path(a)) < np.hypot(*path(b)) else (low, b)
        x, v, bend = path(low), path(low, 1), path(low, 2)
        farthest = np.hypot(*x)
        curvature = (v @ v + x @ bend) / farthest
        lasting = 10.0 ** rng.uniform(-5.5, -4)
        reach = farthest + curvature * lasting**2 / 8
        if curvature > -0.5 or (np.linalg.norm(path(np.delete(r, slice(k - 40, k + 40))), axis=1) > reach - 1e-3).any():
            continue
        links = np.array([0.4, 0.35, 0.25]) * reach
        links[2] = reach - links[0] - links[1]
        events = sm.angle_domain(sm.PlanarArm(links), path).structure.events
        ends = [
            event.r
            for event in events
            if event.kind in ("component dies", "component appears") and abs(event.r - low) < 1e-2
        ]
        # The maximum is known to about 1e-8, and where the path is flat rounding of R moves the ends.
        assert len(ends) == 2, (path, lasting)
        assert ends[1] - ends[0] == pytest.approx(lasting, rel=0.02, abs=1e-16 / lasting * 50)


@pytest.mark.parametrize("part", range(PARTS))
def test_connected_parts_agree_with_flood_fill(part):
    rng = np.random.default_rng(40 + part)
    compared, parts = 0, []
    while compared < 300 // PARTS:
        arm = random_arm(rng)
        path = random_path(rng, arm)
        structure = sm.angle_domain(arm, path).structure
        if len(structure.sheets) < 2:
            continue
        for r, angles in grids(structure):
            flood = Flood(arm, path, r, angles)
            pairs = flood.sample(structure, np.random.default_rng(compared))
            if pairs is None or is_bijection(pairs):
                break
        if pairs is None:
            continue
        assert is_bijection(pairs), (arm, path, pairs)
        compared += 1
        parts.append(len({mine for mine, _ in pairs}))
    assert np.mean(np.array(parts) > 1) > 0.2


def grids(structure):
    """Grids in r and in angles, coarse first; the later ones with lines close to the events, where necks are thin."""
    for count, fine in ((180, 0), (360, 10), (1000, 30)):
        aside = np.concatenate([-np.logspace(-1, -8, fine), np.logspace(-8, -1, fine)])
        lines = []
        for low, high, marks in (
            (0, 1, {e.r for e in structure.events}),
            (-np.pi, np.pi, {e.u for e in structure.events}),
        ):
            line = (np.arange(count) + 0.5) / count * (high - low) + low
            line = np.unique(np.concatenate([line, *(mark + aside for mark in marks)]))
            lines.append(line[(line > low) & (line < high)])
        yield lines


def is_bijection(pairs):
    return len({a for a, _ in pairs}) == len({b for _, b in pairs}) == len(set(pairs))


class Flood:
    """Connected parts of the feasible cells of two charts: (r, u, sign of θ2) and (r, θ1, sign of θ3).

    Where one chart folds the other is regular; cells of both that hold the same posture are one.
    """

    def __init__(self, arm, path, r, angles):
        self.r, self.angles = r, angles
        x, grid = as_complex(path(r)), np.broadcast_to(angles, (len(r), len(angles)))
        plus, minus = (Arms([arm] * len(r), [sign] * len(r)) for sign in (1.0, -1.0))
        # Where two links fold onto a joint, the angles of a chart swing faster than any grid: the other has them all.
        near = 0.03 * arm.links[:3].min()
        swing = np.abs((x - plus.shift)[:, None] - arm.links[2] * np.exp(1j * angles)) < near
        self.margin = np.where(swing, -1.0, np.stack([plus.margin(x, grid), minus.margin(x, grid)]))
        labels, links, count = [], [], 0
        for feasible in [self.margin[0] > 0, self.margin[1] > 0, *(self.by_theta1(plus, x, grid, s) for s in (1, -1))]:
            mine, found = ndimage.label(feasible)
            labels.append(np.where(mine > 0, mine + count, 0))
            links.append(labels[-1][:, [0, -1]])
            count += found
        for chart, sign in ((2, 1), (3, -1)):
            q, _ = plus.joints_by_theta1(x, grid, sign)
            u = np.angle(np.exp(1j * q[..., :3].sum(axis=-1)))
            column = np.clip(np.searchsorted(0.5 * (angles[1:] + angles[:-1]), u), 0, len(angles) - 1)
            row = np.arange(len(r))[:, None]
            for branch, here in ((0, np.sin(q[..., 1]) >= 0), (1, np.sin(q[..., 1]) < 0)):
                links.append(np.stack([labels[chart], labels[branch][row, column]], axis=-1)[here])
        pairs = np.concatenate(links)
        pairs = np.unique(pairs[(pairs > 0).all(axis=1)], axis=0)
        graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count + 1, count + 1))
        self.part = connected_components(graph, directed=False)[1][np.stack(labels[:2])]

    @staticmethod
    def by_theta1(arms, x, grid, sign):
        q, ok = arms.joints_by_theta1(x, grid, sign)
        swing = np.abs((x - arms.shift)[:, None] - arms.links[:, :1] * np.exp(1j * grid)) < 0.03 * arms.links[0].min()
        return ok & ~swing & (arms.limit_margins(q).min(axis=-1) > 0)

    def sample(self, structure, rng):
        """Pairs (part by flood fill, component) at places well inside; None if there are none."""
        sure = np.argwhere(self.margin > 0.03)
        if not len(sure):
            return None
        pairs = []
        for b, i, j in sure[rng.integers(len(sure), size=40)]:
            found = structure.sheet_at(self.r[i], self.angles[j], b)
            assert len(found) == 1
            pairs.append((int(self.part[b, i, j]), structure.sheets[found[0]].component))
        return pairs


def unit_arm(limit):
    return sm.PlanarArm([1, 1, 1], [(-limit, limit)] * 3)


def test_every_point_in_reach_and_yet_no_continuous_motion():
    """Unit 3R, |θ| ≤ 1.45, x = 1.5: blocked near y = 0.41, where the last sheet that begins at the start dies."""
    line = sm.Line([1.5, -2.5], [1.5, 2.5])
    domain = sm.angle_domain(unit_arm(1.45), line)
    assert not domain.empty_stretches(1000, (0, 1))
    structure = domain.structure
    assert not structure.is_connected
    from_start = set().union(*(structure.reachable[k] for k, s in enumerate(structure.sheets) if s.r[0] == 0))
    r = max(structure.sheets[k].r[1] for k in from_start)
    assert line(r)[1] == pytest.approx(0.41, abs=5e-3)
    (death,) = [e for e in structure.events if e.r == r and e.kind == "component dies"]
    assert {(c.kind, c.joint) for c in death.causes} == {("upper limit", 0), ("lower limit", 2)}
    assert sm.angle_domain(unit_arm(2.2), line).structure.is_connected


def test_partly_out_of_reach_dies_at_the_rim_of_the_workspace():
    structure = sm.angle_domain(unit_arm(2.0), sm.Line([1.5, -3], [1.5, 3.5])).structure
    rim = (3 + np.array([-1, 1]) * np.sqrt(9 - 1.5**2)) / 6.5
    ends = [
        e for e in structure.events if e.kind in ("component appears", "component dies") and "fold" in str(e.causes)
    ]
    np.testing.assert_allclose([ends[0].r, ends[-1].r], rim, atol=1e-10)
    assert ends[0].text(("positive", "negative")).startswith("r = 0.0618")


def test_an_arm_without_separators_is_compared_along_the_path():
    class Plain:
        """A planar arm that does not know where its structure changes."""

        def __init__(self, motion):
            self._motion, self.singular = motion, np.zeros(0, bool)

        def separators(self, pose):
            return np.empty((len(pose), 0))

        def __getattr__(self, name):
            return getattr(self._motion, name)

    rng = np.random.default_rng(6)
    compared = 0
    while compared < 12:
        arm = random_arm(rng)
        path = sm.Line(*(arm.annulus[0] + rng.uniform(-0.9, 0.9, (2, 2)) * arm.reach))
        known = sm.angle_domain(arm, path).structure
        if (
            not known.events
            or arm.links[0] == arm.links[1]
            or np.diff([0, *sorted(e.r for e in known.events), 1]).max() < 0.01
        ):
            continue
        found = AngleDomain(Plain(arm.self_motion()), path).structure
        assert [(e.kind, e.branch) for e in found.events] == [(e.kind, e.branch) for e in known.events]
        np.testing.assert_allclose([e.r for e in found.events], [e.r for e in known.events], atol=1e-9)
        compared += 1


def test_where_the_wrist_folds_onto_the_base_a_joint_is_free():
    """Links 1, 1, ½ at R = ½: both elbows are joined there by turning θ1 while the last link stands still."""
    structure = sm.angle_domain(sm.PlanarArm([1, 1, 0.5]), sm.Line([0.2, 0.1], [0.9, 0.1])).structure
    (event,) = [e for e in structure.events if e.kind == "singular"]
    r = (np.sqrt(0.25 - 0.01) - 0.2) / 0.7
    assert event.r == pytest.approx(r, abs=1e-12)
    assert event.u == pytest.approx(np.arcsin(0.2), abs=1e-9)
    assert structure.n_components == 1
    limited = sm.angle_domain(sm.PlanarArm([1, 1, 0.5], [None, (-2.5, 2.5), None]), structure.path).structure
    assert not [e for e in limited.events if e.kind == "singular"]


@pytest.mark.parametrize("limits", [None, [None, (0, np.pi), None], [(-np.pi, np.pi)] * 3])
@pytest.mark.parametrize("links", [[1, 1, 1], [1, 1, 0.5], [1, 0.8, 0.5], [30, 30, 20]])
def test_a_path_that_only_touches_what_it_might_cross(links, limits):
    """Lines whose middle touches an event circle about the base look like their neighbours a little aside."""
    arm = sm.PlanarArm(links, limits)
    for circle in event_circles(arm):
        if circle.center.any() or not 0.1 < circle.radius < 0.9 * arm.reach:
            continue
        half = np.sqrt((0.95 * arm.reach) ** 2 - circle.radius**2)
        touching, beyond = (
            sm.angle_domain(arm, sm.Line([-half, y], [half, y])).structure
            for y in (circle.radius, circle.radius * (1 + 1e-5))
        )
        assert touching.is_connected == beyond.is_connected, circle
        for cell in touching.cells:
            if cell.r[1] - cell.r[0] < 1e-6:
                continue  # touches are known to the square root of rounding
            r = np.linspace(*cell.r, 9)[1:-1]
            r = r[np.abs(r - 0.5) > 1e-6]
            assert all(f.names == cell.fibre.names for f in fibres(touching.self_motion, touching.path(r)))


@pytest.mark.parametrize("limits", [None, [(-np.pi, np.pi)] * 3, [(-1, 1), None, None]])
def test_a_path_that_stays_on_an_event_circle(limits):
    """There the separators are rounding all along: nothing is crossed, and it takes no time to say so."""
    arm = sm.PlanarArm([1, 0.8, 0.5], limits)
    for circle in event_circles(arm):
        if circle.radius > 0.05 and np.linalg.norm(circle.center) + circle.radius < arm.reach * 1.001:
            structure = sm.angle_domain(arm, sm.Circle(circle.center, circle.radius)).structure
            assert len(structure.cells) < 40
