"""The whole report, made once with few seeds."""

import json

import pytest

from selfmotion.report import Study, reproduce


@pytest.fixture(scope="session")
def options():
    return "--out out --seed 1 --seeds 3"


@pytest.fixture(scope="session")
def study():
    return Study(seed=1, seeds=3)


@pytest.fixture(scope="session")
def files(study, options):
    return reproduce(study, options)


@pytest.fixture
def results(files):
    return json.loads(files["results.json"])
