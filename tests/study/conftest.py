"""A study file of seconds, and a way to change it."""

import json

import pytest
from study_tasks import SMALL


@pytest.fixture
def study_file(tmp_path):
    """Writes a study file; keywords replace parts of it, None leaves them out."""

    def write(name="study.yaml", **changes):
        data = {key: value for key, value in {**SMALL, **changes}.items() if value is not None}
        file = tmp_path / name
        file.write_text(json.dumps(data))
        return str(file)

    return write
