"""Plans on disk: what is loaded is what was stored, and what is no plan file is refused."""

import dataclasses
import json

import numpy as np
import pytest

import robots
import selfmotion as sm
from selfmotion.exchange import plan_file, plan_parts
from selfmotion.exchange.plan_file import FORMAT, MIGRATIONS, VERSION, plan_bytes
from selfmotion.exchange.schema import build
from selfmotion.exchange.waypoint_file import FilePath
from selfmotion.motion import Motion
from selfmotion.paths import PATHS, Section

R = np.random.default_rng(7).random(1000)
PSO = sm.PSO(population=8, iterations=4, bounds=(0, 2), seed=1)
SPANNED = sm.PSO(population=8, iterations=4, seed=1)
SIX = [30, 30, 20, 15, 15, 10]


def seed_problem(**options):
    points = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]
    arm = sm.PlanarArm([30, 30, 20], [None, (0, np.pi), None])
    return sm.Problem(arm, sm.Bezier(points), samples=200, **options)


def panda(name="panda", **options):
    """A short line in front of an arm in space."""
    position = sm.Line([0.45, -0.1, 0.4], [0.5, 0.1, 0.45])
    return sm.Problem(sm.named_arm(name), sm.PosePath(position, orientation=[0, 1, 0, 0]), samples=100, **options)


def rough(problem):
    return sm.plan(problem, sm.Global(gap=0.5, time_limit=5))


def refined(problem):
    return sm.plan(problem, sm.Refine(starts=2, time_limit=5, tolerance=1e-3))


def modules():
    bases = [sm.Line([55, 5], [50, 20])]
    problem = sm.Problem(sm.PlanarArm(SIX), sm.Line([75, 10], [70, 30]), samples=100)
    optimizer = sm.PSO(population=8, iterations=4, bounds=(0, 1), seed=1)
    return sm.plan(problem, sm.Modules(bases, offset=[0.4, 0.5], amplitude=[0.1, 0.1], optimizer=optimizer))


def moving_base():
    problem = sm.Problem(sm.PlanarArm(SIX), sm.Line([75, 10], [70, 30]), samples=100)
    return sm.plan(problem, sm.MovingBase(optimizer=sm.PSO(population=30, iterations=30, seed=1)))


def section():
    whole = seed_problem()
    return refined(sm.Problem(whole.arm, Section(whole.path, (0.1, 0.7)), samples=100))


def locked():
    """An arm that is solved with one joint locked, on a short line from a posture of its own."""
    arm = sm.LockedArm(robots.chain("xarm7"))
    start = arm.forward(np.array([0.3, -0.4, 0.2, 1.0, 0.1, 0.9, 0.2]))
    end = start + np.array([0.0, 0.05, 0.02, 0.0, 0.0, 0.0, 0.0])
    return refined(sm.Problem(arm, sm.PoseWaypoints(np.array([start, end])), samples=50))


def railed():
    """Six axes on a rail of their own, on a seam as long as it."""
    arm = sm.named_arm("irb120", rail={"axis": [0.1, 1, 0], "limits": [-0.5, 0.5]})
    path = sm.PosePath(sm.Line([0.4, -0.4, 0.3], [0.4, 0.4, 0.3]), orientation=[0, 1, 0, 0])
    return rough(sm.Problem(arm, path, objective="l2", weights=[0.5, 1, 1, 1, 1, 1, 1], samples=100))


def searched(planner):
    return lambda: sm.plan(seed_problem(), planner)


PLANS = {
    "sinusoid": searched(sm.Sinusoid([0.3], amplitude=[0.4], optimizer=PSO)),
    "harmonics": searched(sm.Harmonics([0.3], span=[0.5], harmonics=2, optimizer=SPANNED)),
    "bspline": searched(sm.BSpline([0.3], span=[0.5], coefficients=5, optimizer=SPANNED)),
    "global": lambda: rough(seed_problem()),
    "refine": lambda: refined(seed_problem(start={"u": [0.3]}, weights=[1, 2, 0.5], objective="l2")),
    "direction": lambda: refined(sm.Problem(sm.PlanarArm([30, 30, 20, 5], direction=0.3), sm.Line([50, 0], [40, 30]))),
    "modules": modules,
    "moving_base": moving_base,
    "section": section,
    "panda": lambda: rough(panda(objective="l2")),
    "locked": locked,
    "roll": lambda: refined(panda("ur10e")),
    "rail": railed,
}


@pytest.fixture(scope="module")
def sinusoid():
    return PLANS["sinusoid"]()


@pytest.mark.parametrize("name", PLANS)
def test_a_stored_plan_comes_back_equal(name, tmp_path):
    plan = PLANS[name]()
    file = tmp_path / "plan.json"
    plan.save(file)
    again = sm.load_plan(file)
    assert_equal(again, plan)
    assert plan_bytes(again) == file.read_bytes()


def assert_equal(again, plan):
    assert type(again.problem.arm) is type(plan.problem.arm)
    assert again.problem.arm.limits.units == plan.problem.arm.limits.units
    assert np.array_equal(again(R), plan(R))
    assert np.array_equal(again.u(R), plan.u(R))
    assert np.array_equal(again.rates(R), plan.rates(R))
    for field in ("cost", "cost_error", "gap", "lower_bound", "estimated_gap", "parameters", "planner"):
        assert getattr(again, field) == json_form(getattr(plan, field)), field
    assert repr(again.history) == repr(plan.history)  # in which NaN is one
    assert again.verification == plan.verification
    assert again.summary() == json_form(plan.summary())
    assert (again.certificate is None) == (plan.certificate is None)
    if plan.certificate is not None:
        for field in ("bound", "argument", "levels", "rigorous"):
            assert getattr(again.certificate, field) == getattr(plan.certificate, field)
        for one, two in zip(again.certificate.tube, plan.certificate.tube, strict=True):
            assert all(np.array_equal(a, b) for a, b in zip(one, two, strict=True))


def json_form(value):
    return json.loads(json.dumps(value)) if isinstance(value, dict) else value


def test_a_loaded_plan_can_be_compared_and_stored_elsewhere(sinusoid, tmp_path):
    sinusoid.save(tmp_path / "a.json")
    sm.load_plan(tmp_path / "a.json").save(tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_files_that_a_problem_was_made_from_are_not_needed_again(tmp_path):
    rows = tmp_path / "points.csv"
    rows.write_text("x,y\n500,0\n480,100\n450,200\n")
    plan = refined(sm.Problem(sm.PlanarArm([0.3, 0.3, 0.2]), FilePath(str(rows), unit="mm")))
    plan.save(tmp_path / "plan.json")
    rows.unlink()
    again = sm.load_plan(tmp_path / "plan.json")
    assert np.array_equal(again(R), plan(R))
    assert np.array_equal(again.problem.path.waypoints, plan.problem.path.waypoints)


DRAWN = {
    "gcode": ("a.nc", "G21 G17 G90\nG0 X500 Y0\nG1 X500 Y50\nG3 X480 Y70 I-20 J0\nG1 X400 Y100\nM30\n", {}),
    "svg": (
        "a.svg",
        '<svg xmlns="http://www.w3.org/2000/svg"><path d="M500,0 L500,50 A 20 30 10 0 1 480,90 C 470,95 450,80 400,100"'
        "/></svg>",
        {"unit": "mm"},
    ),
    "dxf": ("a.dxf", None, {}),
}


def drawn(kind, folder):
    """A path of a problem file that a drawing describes; returns the drawing too."""
    name, text, options = DRAWN[kind]
    file = folder / name
    if kind == "svg":
        pytest.importorskip("svgpathtools")
    if kind == "dxf":
        ezdxf = pytest.importorskip("ezdxf")
        page = ezdxf.new(units=ezdxf.units.MM)
        page.modelspace().add_line((500, 0), (500, 50))
        page.modelspace().add_arc((480, 50), 20, 0, 90)
        page.saveas(file)
    else:
        file.write_text(text)
    return {"kind": kind, "file": name, **options}, file


@pytest.mark.parametrize("kind", DRAWN)
@pytest.mark.parametrize("around", ["alone", "transformed", "reversed", "placed"])
def test_a_drawing_is_stored_as_what_it_shows(kind, around, tmp_path):
    path, file = drawn(kind, tmp_path)
    if around == "transformed":
        path = {"kind": "transformed", "path": path, "rotation": 0.3, "scale": 0.9}
    if around == "reversed":
        path = {"kind": "reversed", "path": path}
    if around == "placed":
        path = {"kind": "placed", "path": path, "frame": {"translation": [0.1, 0.0, 0.2], "rpy": [0.1, 0.2, 0.3]}}
    found = build("path", path, str(tmp_path))
    text = json.dumps(plan_file._plain("path", plan_parts._path_object(found)))
    file.unlink()
    again = plan_parts._path_from(json.loads(text))
    assert all(np.array_equal(again(R, order), found(R, order)) for order in (0, 1, 2))
    assert np.array_equal(again.breaks, found.breaks)
    assert np.array_equal(again.waypoints, found.waypoints)
    assert "file" not in text


@pytest.mark.parametrize("inside", [False, True])
def test_a_plan_along_a_drawing_comes_back_without_it(inside, tmp_path):
    path, file = drawn("gcode", tmp_path)
    task = {"kind": "pose", "position": {"kind": "placed", "path": path}, "orientation": [0, 1, 0, 0]}
    found = build("path", task if inside else path, str(tmp_path))
    plan = rough(sm.Problem(sm.named_arm("panda"), found, samples=50)) if inside else planar_plan(found)
    plan.save(tmp_path / "plan.json")
    file.unlink()
    assert_equal(sm.load_plan(tmp_path / "plan.json"), plan)


def planar_plan(path):
    return refined(sm.Problem(sm.PlanarArm([0.3, 0.3, 0.2]), path, samples=100))


def test_paths_remember_what_they_were_made_from_whatever_becomes_of_it():
    points = np.array([[50.0, 0.0], [40.0, 30.0]])
    path = sm.Reversed(sm.Waypoints(points))
    points[:] = 0.0
    assert path.path.made_from["points"].tolist() == [[50.0, 0.0], [40.0, 30.0]]
    assert path.made_from["path"] is path.path
    assert all(made.kind == kind for kind, made in PATHS.items())


def test_a_motion_by_anybody_s_function_is_refused(tmp_path):
    problem = seed_problem()
    motion = Motion(problem.arm, problem.path, lambda r, order: np.full((len(r), 1), 0.3 * (1 - order)), 0, 100)
    with pytest.raises(sm.InvalidInputError, match="function of u, which a plan file cannot hold"):
        sm.Plan(problem, motion, "mine", {}).save(tmp_path / "plan.json")
    assert not list(tmp_path.iterdir())


def test_arms_paths_and_parameters_of_other_classes_are_refused(sinusoid, tmp_path):
    class Mine(sm.PlanarArm):
        pass

    class Own(sm.Line):
        pass

    problem = sinusoid.problem
    for other, what in (
        (sm.Problem(Mine([30, 30, 20]), problem.path), "arm: is a Mine"),
        (sm.Problem(problem.arm, Own([50, 0], [40, 30])), "path: is a Own"),
    ):
        with pytest.raises(sm.InvalidInputError, match=what):
            sm.Plan(other, sinusoid.motion, "sinusoid", {}).save(tmp_path / "plan.json")
    with pytest.raises(sm.InvalidInputError, match=r"plan.parameters.x: is a set"):
        sm.Plan(problem, sinusoid.motion, "sinusoid", {"x": {1}}).save(tmp_path / "plan.json")


def test_costs_that_are_not_finite_come_back(sinusoid, tmp_path):
    plan = sm.Plan(sinusoid.problem, sinusoid.motion, "sinusoid", {"limit": np.inf, "no": np.nan})
    plan.gap = np.inf
    plan.save(tmp_path / "plan.json")
    again = sm.load_plan(tmp_path / "plan.json")
    assert again.gap == np.inf
    assert again.parameters["limit"] == np.inf
    assert np.isnan(again.parameters["no"])


def test_a_file_of_someone_else_is_replaced_only_with_force(sinusoid, tmp_path):
    file = tmp_path / "plan.json"
    file.write_text("mine")
    with pytest.raises(sm.InvalidInputError, match="--force"):
        sinusoid.save(file)
    sinusoid.save(file, force=True)
    sinusoid.save(file)
    with pytest.raises(sm.InvalidInputError, match="is no name of a file"):
        sinusoid.save(tmp_path / "..")
    with pytest.raises(sm.InvalidInputError, match=r"not a folder|cannot be written"):
        sinusoid.save(file / "plan.json")


def edited(sinusoid, change, sign=True):
    """Return the text of a plan file that was changed, by someone who knows of the checksum."""
    data = json.loads(plan_bytes(sinusoid))
    change(data)
    if sign:
        data.pop("checksum", None)
        data["checksum"] = plan_file._checksum(data)
    return json.dumps(data)


def put(*keys, value):
    def change(data):
        for key in keys[:-1]:
            data = data[key]
        data[keys[-1]] = value

    return change


def test_a_file_that_was_cut_short_or_changed_is_refused(sinusoid, tmp_path):
    text = plan_bytes(sinusoid).decode()
    file = tmp_path / "plan.json"
    for cut in (0, 1, 30, len(text) // 2, len(text) - 3):
        file.write_text(text[:cut])
        with pytest.raises(sm.InvalidInputError, match=r"plan\.json"):
            sm.load_plan(file)
    file.write_text(edited(sinusoid, put("lower_bound", value=1.0), sign=False))
    with pytest.raises(sm.InvalidInputError, match="was changed since it was written"):
        sm.load_plan(file)
    with pytest.raises(sm.InvalidInputError, match="does not exist"):
        sm.load_plan(tmp_path / "no.json")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (put(FORMAT, value=VERSION + 1), "reads up to"),
        (put(FORMAT, value="1"), "not a whole number"),
        (put(FORMAT, value=-3), "never was"),
        (lambda data: data.pop(FORMAT), "is not a plan file"),
        (lambda data: data.pop("motion"), "motion: is missing"),
        (put("wall_time_s", value="long"), "wall_time_s: is not a number"),
        (put("motion", value=3), "motion: is not a mapping"),
        (put("motion", "kind", value="dance"), "motion.kind"),
        (put("motion", "kind", value=[]), "motion.kind"),
        (put("motion", "branch", value=7), "motion.branch"),
        (put("motion", "nodes", value=0), "motion.nodes"),
        (put("motion", "start", value=[1.0]), "motion.start"),
        (put("motion", "curve", "kind", value="ball"), "motion.curve.kind"),
        (put("motion", "curve", "family", value="ball"), "motion.curve.family"),
        (put("motion", "curve", "a", value=[1.0, 2.0]), "motion.curve.a"),
        (put("motion", "curve", "settings", value={"x": 1}), "motion.curve.settings"),
        (put("motion", "curve", "settings", "offset", value=[1.0, 2.0]), "motion.curve"),
        (put("problem", "arm", "kind", value="humanoid"), "problem.arm.kind"),
        (put("problem", "arm", value={"kind": "chain"}), "problem.arm"),
        (put("problem", "arm", "links", value=[1.0, -1.0, 2.0]), "problem.arm.links.1"),
        (put("problem", "path", "control_points", value=[[0.0]]), "problem.path.control_points"),
        (put("problem", "samples", value=1), "problem.samples"),
        (put("problem", "weights", value=[1.0]), "problem.weights"),
        (put("certificate", value={"bound": 1.0}), "certificate"),
    ],
)
def test_what_makes_no_sense_is_refused_even_if_it_is_signed(sinusoid, change, says, tmp_path):
    file = tmp_path / "plan.json"
    file.write_text(edited(sinusoid, change))
    with pytest.raises(sm.InvalidInputError, match=says) as caught:
        sm.load_plan(file)
    assert str(file) in str(caught.value)


def test_splines_that_are_none_are_refused(tmp_path):
    plan, file = refined(seed_problem()), tmp_path / "plan.json"
    for change, says in (
        (put("motion", "knots", 5, value=0.9), "motion.knots"),
        (put("motion", "knots", value=[0.0]), "motion.knots"),
        (put("motion", "coefficients", 0, value=[1.0]), "motion.coefficients"),
        (put("motion", "lower", value=[1.0]), "motion.lower"),
    ):
        file.write_text(edited(plan, change))
        with pytest.raises(sm.InvalidInputError, match=says):
            sm.load_plan(file)


def test_a_file_of_an_older_version_is_made_a_newer_one(sinusoid, tmp_path, monkeypatch):
    """A version 0 that called the planner its method, as some day version 1 will be the older one."""

    def older(data):
        data[FORMAT] = 0
        data["method"] = data.pop("planner")

    def newer(data):
        return {FORMAT: 1, "planner": data.pop("method"), **{k: v for k, v in data.items() if k != FORMAT}}

    file = tmp_path / "plan.json"
    file.write_text(edited(sinusoid, older))
    with pytest.raises(sm.InvalidInputError, match="never was"):
        sm.load_plan(file)
    monkeypatch.setitem(MIGRATIONS, 0, newer)
    again = sm.load_plan(file)
    assert again.planner == "sinusoid"
    assert np.array_equal(again(R), sinusoid(R))


def test_every_field_of_a_history_is_stored():
    assert {field.name for field in dataclasses.fields(sm.optimizers.History)} == set(
        plan_file.PlanForm.model_fields["history"].annotation.__args__[0].model_fields
    )
