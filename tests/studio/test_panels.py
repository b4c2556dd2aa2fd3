"""Panels of the angle domain: what they show is what the library says, at any r."""

import numpy as np
import pytest
from scipy.optimize import brentq

import selfmotion as sm
from selfmotion.angles import TAU, wrap
from selfmotion.plot.window import Window
from selfmotion.studio.panels import Around, PanelChart, branch_window, component_field, domain
from selfmotion.studio.wire import unpacked

ARM = {"links": [30, 30, 20], "limits": [None, (0, np.pi), None]}
TIGHT = {"links": [30, 30, 20], "limits": [(-0.6, 0.9), (-2.4, 2.5), (-1.6, 1.9)]}
PATH = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]


def arrays(part, *names):
    return [unpacked(name, part[name]) for name in names]


def shown_at(panel, r):
    """The feasible intervals of a panel at r, by its strips."""
    found = []
    for strip in panel["strips"]:
        at, low, high = arrays(strip, "r", "low", "high")
        if at[0] <= r <= at[-1]:
            found.append((np.interp(r, at, low), np.interp(r, at, high)))
    return [(low, high) for low, high in sorted(found) if high > low]


def contains(intervals, u, tolerance):
    """Whether u is inside, None where that is too near to an end to be told."""
    inside = any(low - tolerance < u + turn < high + tolerance for low, high in intervals for turn in (-TAU, 0, TAU))
    surely = any(low + tolerance < u + turn < high - tolerance for low, high in intervals for turn in (-TAU, 0, TAU))
    return inside if inside == surely else None


@pytest.mark.parametrize(
    ("arm", "path"),
    [
        (ARM, sm.Bezier(PATH)),
        (TIGHT, sm.Bezier(PATH)),
        ({"links": [30, 30, 20]}, sm.Line([70, -10], [5, 15])),
        ({"links": [7, 7, 4, 1.5], "direction": -1.0}, sm.Circle([6, 4], 4)),
    ],
)
def test_strips_of_an_exact_panel_are_the_angle_domain(arm, path):
    problem = sm.Problem(sm.PlanarArm(**arm), path)
    found, told = domain(problem), sm.angle_domain(problem.arm, path)
    assert found["kind"] == "exact"
    rng = np.random.default_rng(5)
    seen = 0
    for panel in found["panels"]:
        for r in rng.uniform(0, 1, 60):
            exact = told(r, panel["branch"]).intervals
            drawn = shown_at(panel, r)
            for u in rng.uniform(*panel["period"], 40):
                one, other = contains(drawn, u, 2e-3), contains(exact, u, 2e-3)
                if one is not None and other is not None:
                    assert one == other, (r, u, panel["branch"])
                    seen += other
    assert seen > 100
    empty = set(range(2)) - {panel["branch"] for panel in found["panels"]}
    assert all(told(r, branch).measure < 1e-6 for branch in empty for r in rng.uniform(0, 1, 20))


def test_an_edge_is_where_its_constraint_is_met():
    problem = sm.Problem(sm.PlanarArm(**TIGHT), sm.Bezier(PATH))
    kinds = set()
    for panel in domain(problem)["panels"]:
        for edge in panel["edges"]:
            r, u = arrays(edge, "r", "u")
            there = np.isfinite(u) & (r > 1e-6) & (r < 1 - 1e-6)
            q, _ = problem.arm.solve(problem.path(r[there]), u[there, None], panel["branch"])
            joint, value = edge["cause"]["joint"], edge["cause"]["value"]
            off = np.abs(wrap(q[:, joint] - value))
            assert np.median(off) < 1e-6
            assert off.max() < (1e-3 if edge["cause"]["kind"] == "fold" else 1e-5)
            kinds.add(edge["cause"]["kind"])
            assert panel["range"][0] <= np.nanmin(u) <= np.nanmax(u) <= panel["range"][1]
    assert {"lower limit", "upper limit"} <= kinds


def test_events_are_those_of_the_structure_in_the_window():
    problem = sm.Problem(sm.PlanarArm([30, 30, 20], [None, (-2.0, 2.6), (-1.0, 2.0)]), sm.Line([70, -10], [5, 15]))
    found, told = domain(problem), problem.structure.events
    counts = []
    for panel in found["panels"]:
        mine = [event for event in told if event.branch == panel["branch"]]
        counts.append([(event.r, event.kind) for event in mine])
        for event in mine:
            near = [e for e in panel["events"] if e["r"] == event.r and e["kind"] == event.kind]
            assert any(abs(wrap(e["u"] - event.u)) < 1e-12 for e in near)
        assert all(panel["period"][0] <= e["u"] <= panel["period"][1] for e in panel["events"])
        texts = {event.text(problem.arm.branches) for event in told if event.branch in (None, panel["branch"])}
        assert {e["text"] for e in panel["events"]} <= texts
    assert len(counts) == 2
    assert counts[0]
    assert counts[0] != counts[1]
    assert any("connected part" in line for line in found["structure"])


def test_a_branch_that_is_not_allowed_has_no_panel():
    problem = sm.Problem(sm.PlanarArm([30, 30, 20]), sm.Line([70, -10], [5, 15]), elbow="negative")
    assert [panel["branch"] for panel in domain(problem)["panels"]] == [1]


def test_of_very_many_pieces_samples_are_shown_and_agree():
    t = np.linspace(0, 1, 3001)
    path = sm.Waypoints(sm.Bezier(PATH)(t))
    problem = sm.Problem(sm.PlanarArm(**ARM), path)
    found, told = domain(problem), sm.angle_domain(problem.arm, path)
    assert found["kind"] == "sampled"
    (panel,) = found["panels"]
    for r in np.random.default_rng(2).uniform(0.01, 0.99, 50):
        (drawn,), exact = shown_at(panel, r), told(r, 0).intervals
        assert any(abs(drawn[0] - low) < 0.02 and abs(drawn[1] - high) < 0.02 for low, high in exact)


@pytest.fixture(scope="module")
def four():
    return sm.Problem(sm.PlanarArm([7, 7, 4, 1.5], [(-1.0, 2.0), (-2.0, 2.5), None, (-1.5, 1.5)]), sm.Circle([6, 4], 4))


def around_of(problem, branch=0):
    r = np.linspace(0, 1, 101)
    u = np.stack([0.6 + 0.4 * np.sin(5 * r), 0.3 - 0.5 * r], axis=1)
    return Around(r, u, branch)


@pytest.mark.parametrize("branch", [0, 1])
def test_signs_of_a_field_are_what_the_arm_says(four, branch):
    around = around_of(four, branch)
    found = domain(four, around)
    assert found["kind"] == "component"
    assert [panel["component"] for panel in found["panels"]] == [0, 1]
    both = set()
    for panel in found["panels"]:
        (margin,), j = arrays(panel["field"], "margin"), panel["component"]
        u = np.linspace(*panel["field"]["u"], margin.shape[0])
        r = np.linspace(*panel["field"]["r"], margin.shape[1])
        rng = np.random.default_rng(j)
        for row, column in zip(rng.integers(0, len(u), 500), rng.integers(0, len(r), 500), strict=True):
            here = around.at(r[column : column + 1])[0]
            here[j] = u[row]
            q, ok = four.arm.solve(four.path(r[column]), here, branch)
            inside = bool(ok) and bool((four.arm.limits.excess(q) <= 0).all())
            if abs(margin[row, column]) > 1e-6:
                assert (margin[row, column] > 0) == inside
                both.add(inside)
    assert both == {True, False}


def test_strips_of_a_component_end_where_a_constraint_is_met(four):
    around = around_of(four)
    off = []
    for panel in domain(four, around)["panels"]:
        j, step = panel["component"], TAU / 159

        def inside(u, r, j=j):
            here = around.at(np.array([r]))[0]
            here[j] = u
            q, ok = four.arm.solve(four.path(r), here, 0)
            return 1.0 if ok and (four.arm.limits.excess(q) <= 0).all() else -1.0

        for edge in panel["edges"]:
            r, u = arrays(edge, "r", "u")
            for k in np.flatnonzero(np.isfinite(u))[::7]:
                if inside(u[k] - step, r[k]) != inside(u[k] + step, r[k]):
                    exact = brentq(lambda v, at=r[k]: inside(v, at), u[k] - step, u[k] + step, xtol=1e-6)
                    off.append(abs(exact - u[k]) / step)
    assert len(off) > 30
    assert np.median(off) < 0.02


def test_the_least_constraint_of_a_column_names_its_end(four):
    around = around_of(four)
    r = np.linspace(0, 1, 60)
    field = component_field(four.arm, four.path(r), around.at(r), 0, 0, Window(0.0), 700)
    named = 0
    for k, runs in enumerate(field.runs()):
        for run in runs:
            for end, causes in zip((run.low, run.high), run.causes, strict=True):
                for cause in causes:
                    here = around.at(r[k : k + 1])[0]
                    here[0] = end
                    q, _ = four.arm.solve(four.path(r[k]), here, 0)
                    assert abs(wrap(q[cause.joint] - cause.value)) < (0.3 if cause.kind == "fold" else 0.02)
                    named += 1
    assert named > 40


def test_without_a_curve_the_components_stand_at_zero(four):
    found = domain(four)
    ours = domain(four, Around(np.array([0.0, 1.0]), np.zeros((2, 2)), 0))
    assert found == ours


def test_a_tube_over_the_seam_is_cut_there():
    chart = PanelChart(Window(1.0))
    bottom, top = 1.0 - np.pi, 1.0 + np.pi
    pieces = chart.cut(np.array([[0.2, 0.1], [top - 0.1, bottom + 0.2]]))
    assert sorted(map(tuple, np.sort(pieces, axis=1).tolist())) == sorted(
        [(0.1, 0.2), (bottom, bottom + 0.2), (top - 0.1, top)]
    )


def test_windows_of_panels_and_tubes_are_the_same():
    problem = sm.Problem(sm.PlanarArm([30, 30, 20]), sm.Line([70, -10], [5, 15]))
    for panel in domain(problem)["panels"]:
        window = branch_window(problem, panel["branch"])
        assert panel["period"] == [window.center - np.pi, window.center + np.pi]
