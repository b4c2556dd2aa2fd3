"""One studio and one browser for all tests of a process; a fresh context of the browser for each of them."""

import asyncio
import copy
import warnings

import browser
import pytest
import served

LINKS = {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3.141592653589793], None]}
POINTS = [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]]


@pytest.fixture(scope="session")
def chromium():
    """A browser, and the event loop that drives it."""
    if browser.missing():
        pytest.skip(browser.missing())
    with browser.browsing() as running:
        yield running


@pytest.fixture
def contexts(chromium):
    """Make contexts of the browser, of which nothing is left afterwards, and which are watched."""
    running, loop = chromium
    asyncio._set_running_loop(loop)
    made = []

    def make(homes=(), **settings):
        context = running.new_context(**{"viewport": {"width": 1280, "height": 800}, **settings})
        watch = browser.Watch(context, homes)
        made.append((context, watch))
        return context, watch

    try:
        yield make
        for _, watch in made:
            watch.check()
    finally:
        for context, _ in made:
            context.close()
        asyncio._set_running_loop(None)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """The folder that the studio works in."""
    return tmp_path_factory.mktemp("studio")


@pytest.fixture(scope="session")
def server(folder):
    """A studio that runs; it must not have said anything when it ends."""
    with served.Studio("--folder", str(folder)) as running:
        assert running.address.startswith("http://127.0.0.1:"), running.end()
        yield running
        code, said, complained = running.end()
    assert (code, said, complained) == (0, "", "")


@pytest.fixture
def tab(contexts, server):
    """A page that is not yet open, in a context of its own."""
    context, watch = contexts([server.home])
    return browser.Tab(context.new_page(), server.address, watch)


@pytest.fixture
def seed():
    """The data of the seed's problem, with a small search."""
    return {
        "arm": copy.deepcopy(LINKS),
        "path": {"kind": "bezier", "control_points": [list(point) for point in POINTS]},
        "planner": {
            "kind": "sinusoid", "offset": [0.3], "amplitude": [0.4],
            "optimizer": {"kind": "pso", "population": 8, "iterations": 5, "bounds": [0, 2], "seed": 1},
        },
    }  # fmt: skip


def pytest_runtest_logreport(report):
    """Note on each process that tests were skipped for want of a browser."""
    if report.skipped and "NOT TESTED IN A BROWSER" in str(report.longrepr):
        _skipped.append(report.nodeid)


_skipped = []


def pytest_sessionfinish(session):
    """Under xdist this file is unknown to the process that sums up: a warning reaches it all the same."""
    if _skipped and hasattr(session.config, "workerinput"):
        said = warnings.WarningMessage(pytest.PytestWarning(browser.missing()), pytest.PytestWarning, __file__, 1)
        told = {"warning_message": said, "when": "config", "nodeid": "", "location": None}
        session.config.hook.pytest_warning_recorded.call_historic(kwargs=told)


def pytest_terminal_summary(terminalreporter):
    """Say loudly what was not tested."""
    if _skipped:
        terminalreporter.write_sep("=", browser.missing(), red=True, bold=True)
