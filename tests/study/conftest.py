"""A study file of seconds, and a way to change it."""

import json

import pytest

SMALL = {
    "study": "small",
    "problems": {
        "arms": {"three": {"kind": "planar", "links": [30, 30, 20], "limits": [None, [0, 3.141592653589793], None]}},
        "paths": {
            "curve": {
                "kind": "bezier",
                "control_points": [[50, -10], [85, 30], [50, 50], [60, -10], [58, 30], [70, -10]],
            },
            "line": {"kind": "line", "start": [50, -10], "end": [60, 20]},
        },
    },
    "options": {"samples": 200, "elbow": "positive"},
    "planners": {
        "sinusoid": {"kind": "sinusoid", "offset": [0.3], "amplitude": [0.4]},
        "proof": {"kind": "global", "gap": 1e-2},
    },
    "optimizers": {
        "PSO": {"kind": "pso", "population": 8, "iterations": 10, "bounds": [0, 5]},
        "GWO": {"kind": "gwo", "population": 8, "iterations": 10, "bounds": [0, 5]},
    },
    "seeds": {"first": 1, "count": 3},
}


@pytest.fixture
def study_file(tmp_path):
    """Writes a study file; keywords replace parts of it, None leaves them out."""

    def write(name="study.yaml", **changes):
        data = {key: value for key, value in {**SMALL, **changes}.items() if value is not None}
        file = tmp_path / name
        file.write_text(json.dumps(data))
        return str(file)

    return write
