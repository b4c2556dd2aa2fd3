"""The kinds of shapes by number, for kernels and for what makes their numbers."""

SPHERE, HALF_SPACE, BOX, CAPSULE, POLYGON, MESH = 0, 1, 2, 3, 4, 5
