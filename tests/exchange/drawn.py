"""What the tests of drawings share: files to read, and circles to compare with."""

import numpy as np

RADIUS = 25.0
CENTER = np.array([50.0, 50.0])


def svg(body, page='width="100mm" height="100mm" viewBox="0 0 100 100"'):
    return f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" {page}>\n{body}\n</svg>'


def off_circle(path, center=CENTER, radius=RADIUS):
    """Return the largest distance of a path from a circle."""
    x = path(np.linspace(0, 1, 4001))
    return np.abs(np.hypot(*(x[:, :2] - center).T) - radius).max()


def assert_circle(drawing, tolerance=1e-12, parts=1):
    """The whole circle, exactly: nothing flattened, closed, of the right length."""
    path = drawing.path
    assert off_circle(path) <= max(tolerance * RADIUS, drawing.chord_error)
    assert abs(path.length - 2 * np.pi * RADIUS) <= 1e-6
    assert abs(drawing.length - 2 * np.pi * RADIUS) <= 1e-6
    assert path.is_closed
    assert drawing.subpaths[0].closed
    np.testing.assert_allclose(drawing.bounds, [CENTER - RADIUS, CENTER + RADIUS], atol=1e-9)
    assert drawing.chord_error == 0
    assert drawing.segments == {"arc": parts}
    assert path.fastest(0, 1) >= path.length * (1 - 1e-12)


def turning(path):
    """Return the signed area that a closed path runs round: positive counter-clockwise."""
    x = path(np.linspace(0, 1, 2001))
    return 0.5 * float(np.sum(x[:-1, 0] * x[1:, 1] - x[1:, 0] * x[:-1, 1]))
