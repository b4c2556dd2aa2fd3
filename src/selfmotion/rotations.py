"""Rotations of space as unit quaternions (w, x, y, z): their algebra, on stacked arrays.

A quaternion q turns v into the vector part of ``q ⊗ (0, v) ⊗ q*``; q and −q are the same rotation. Rotation vectors
are axis times angle [rad].
"""

from __future__ import annotations

from typing import Any

import numpy as np

from selfmotion._checks import contains_text, finite_array
from selfmotion._types import FloatArray
from selfmotion.errors import InvalidInputError

TOLERANCE = 1e-6
"""How far from a rotation, in its norm or its entries, an input may be that still means one."""
# Below this cosine two quaternions lie on different hemispheres; between, they are a half turn apart either way.
_HALF_TURN = -1e-9


def product(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the Hamilton products ``a ⊗ b``, shapes (..., 4): first b turns, then a.

    Parameters
    ----------
    a, b : array, shape (..., 4)
        Quaternions (w, x, y, z).

    Returns
    -------
    array, shape (..., 4)
    """
    aw, ax, ay, az = np.moveaxis(a, -1, 0)
    bw, bx, by, bz = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ],
        axis=-1,
    )


def conjugate(q: FloatArray) -> FloatArray:
    """Return the conjugates, the inverse rotations of unit quaternions, shape (..., 4).

    Parameters
    ----------
    q : array, shape (..., 4)
        Quaternions (w, x, y, z).

    Returns
    -------
    array, shape (..., 4)
    """
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def pure(v: FloatArray) -> FloatArray:
    """Return the quaternions (0, v) of vectors, shape (..., 4).

    Parameters
    ----------
    v : array, shape (..., 3)

    Returns
    -------
    array, shape (..., 4)
    """
    return np.concatenate([np.zeros((*v.shape[:-1], 1)), v], axis=-1)


def rotate(q: FloatArray, v: FloatArray) -> FloatArray:
    """Return vectors (..., 3) turned by unit quaternions (..., 4).

    Parameters
    ----------
    q : array, shape (..., 4)
        Unit quaternions (w, x, y, z).
    v : array, shape (..., 3)

    Returns
    -------
    array, shape (..., 3)
    """
    return product(product(q, pure(v)), conjugate(q))[..., 1:]


def matrix(q: FloatArray) -> FloatArray:
    """Return the rotation matrices of unit quaternions (..., 4), shape (..., 3, 3).

    Parameters
    ----------
    q : array, shape (..., 4)
        Unit quaternions (w, x, y, z).

    Returns
    -------
    array, shape (..., 3, 3)
    """
    w, x, y, z = np.moveaxis(q, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def from_matrix(rotation: FloatArray) -> FloatArray:
    """Return the quaternions of rotation matrices (..., 3, 3), of :func:`upper` sign.

    ``4 q qᵀ`` is linear in the matrix; its column with the largest diagonal entry is free of cancellation
    (Shepperd 1978).

    Parameters
    ----------
    rotation : array, shape (..., 3, 3)

    Returns
    -------
    array, shape (..., 4)
    """
    m = np.moveaxis(rotation, (-2, -1), (0, 1))
    wx, wy, wz = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    xy, xz, yz = m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[1, 2] + m[2, 1]
    square = np.stack(
        [
            np.stack([1 + m[0, 0] + m[1, 1] + m[2, 2], wx, wy, wz], axis=-1),
            np.stack([wx, 1 + m[0, 0] - m[1, 1] - m[2, 2], xy, xz], axis=-1),
            np.stack([wy, xy, 1 - m[0, 0] + m[1, 1] - m[2, 2], yz], axis=-1),
            np.stack([wz, xz, yz, 1 - m[0, 0] - m[1, 1] + m[2, 2]], axis=-1),
        ],
        axis=-2,
    )
    largest = np.argmax(np.diagonal(square, axis1=-2, axis2=-1), axis=-1)
    column = np.take_along_axis(square, largest[..., None, None], axis=-2)[..., 0, :]
    return upper(column / np.linalg.norm(column, axis=-1, keepdims=True))


def upper(q: FloatArray) -> FloatArray:
    """Return each quaternion or its negative: the one with w > 0, or with its first other entry positive if w is 0.

    Parameters
    ----------
    q : array, shape (..., 4)

    Returns
    -------
    array, shape (..., 4)
    """
    large = np.abs(q) > 1e-12
    first = np.take_along_axis(q, np.argmax(large, axis=-1)[..., None], axis=-1)
    return np.where(first < 0, -q, q)


def exponential(v: FloatArray) -> FloatArray:
    """Return the unit quaternions of rotation vectors (..., 3).

    Parameters
    ----------
    v : array, shape (..., 3)
        Axis times angle [rad].

    Returns
    -------
    array, shape (..., 4)
    """
    half = 0.5 * np.linalg.norm(v, axis=-1, keepdims=True)
    # numpy's sinc is that of π x.
    return np.concatenate([np.cos(half), 0.5 * v * np.sinc(half / np.pi)], axis=-1)


def logarithm(q: FloatArray) -> FloatArray:
    """Return the rotation vectors of unit quaternions (..., 4): angles up to π if w ≥ 0, beyond if it is not.

    Parameters
    ----------
    q : array, shape (..., 4)
        Unit quaternions (w, x, y, z).

    Returns
    -------
    array, shape (..., 3)
        Axis times angle [rad].
    """
    size = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(size, q[..., :1])
    return np.where(size > 0, angle * q[..., 1:] / np.where(size > 0, size, 1.0), 0.0)


def turn(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the rotation vectors from a to b on the way that their signs say, in a's own frame, shape (..., 3).

    Parameters
    ----------
    a, b : array, shape (..., 4)
        Unit quaternions (w, x, y, z).

    Returns
    -------
    array, shape (..., 3)
        Axis times angle [rad].
    """
    return logarithm(product(conjugate(a), b))


def apart(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the angles between rotations a and b (..., 4), in [0, π].

    Parameters
    ----------
    a, b : array, shape (..., 4)
        Unit quaternions (w, x, y, z).

    Returns
    -------
    array, shape (...)
        [rad].
    """
    return np.asarray(np.linalg.norm(turn(a, np.where((a * b).sum(axis=-1, keepdims=True) < 0, -b, b)), axis=-1))


def slerp(a: FloatArray, b: FloatArray, t: FloatArray) -> FloatArray:
    """Return the rotations at the fractions t (k,) of the turn from a to b, (4,) each, on the way their signs say.

    Parameters
    ----------
    a, b : array, shape (4,)
        Unit quaternions (w, x, y, z).
    t : array, shape (k,)
        0 is at a, 1 at b.

    Returns
    -------
    array, shape (k, 4)
    """
    return product(a, exponential(np.asarray(t)[..., None] * turn(a, b)))


def continuous(q: FloatArray) -> FloatArray:
    """Return rotations (k, 4) with the signs that make every turn to the next the shorter one.

    Half turns are equally short both ways; there the signs decide as they were given.

    Parameters
    ----------
    q : array, shape (k, 4)
        Unit quaternions (w, x, y, z).

    Returns
    -------
    array, shape (k, 4)
        The first as given.
    """
    flips = np.where((q[:-1] * q[1:]).sum(axis=-1) < _HALF_TURN, -1.0, 1.0)
    return q * np.concatenate([[1.0], np.cumprod(flips)])[:, None]


def unit_quaternions(field: str, value: Any, ndim: int = 2) -> FloatArray:
    """Return `value` as unit quaternions (k, 4), or (4,) if `ndim` is 1.

    Parameters
    ----------
    field : str
        What it is called in an error.
    value : array_like, shape (k, 4) or (4,)
        (w, x, y, z).
    ndim : int
        2, or 1 for a single one.

    Returns
    -------
    array, shape (k, 4) or (4,)

    Raises
    ------
    InvalidInputError
        Naming the norm, if it is off by more than 1e-6.
    """
    q = finite_array(field, value, ndim, 4)
    norms = np.linalg.norm(q, axis=-1, keepdims=True)
    wrong = np.flatnonzero(np.abs(norms - 1.0) > TOLERANCE)
    if len(wrong):
        where = f"{field}.{wrong[0]}" if ndim > 1 else field
        norm = float(norms.reshape(-1)[wrong[0]])
        raise InvalidInputError(
            where,
            f"is no unit quaternion: its norm is {norm:.9g}",
            "divide it by its norm; the order is w, x, y, z",
            q.reshape(-1, 4)[wrong[0]].tolist(),
        )
    return q / norms


def rotation(field: str, value: Any) -> FloatArray:
    """Return a quaternion (4,) or a rotation matrix (3, 3) as a unit quaternion.

    Parameters
    ----------
    field : str
        What it is called in an error.
    value : array_like, shape (4,) or (3, 3)
        Quaternions are (w, x, y, z).

    Returns
    -------
    array, shape (4,)

    Raises
    ------
    InvalidInputError
        If it is neither, saying why: its norm, its scale, a reflection.
    """
    if not contains_text(value) and np.ndim(_rows(value)) == 2:
        return from_rotation_matrix(field, value)
    return unit_quaternions(field, value, 1)


def from_rotation_matrix(field: str, value: Any) -> FloatArray:
    """Return the unit quaternion of a matrix (3, 3), refused with the reason if it is no rotation.

    Parameters
    ----------
    field : str
        What it is called in an error.
    value : array_like, shape (3, 3)

    Returns
    -------
    array, shape (4,)

    Raises
    ------
    InvalidInputError
        Saying why: the shape, the angles between columns, their length, a reflection.
    """
    m = finite_array(field, value, 2, 3)
    remedy = "give three orthogonal unit columns, right-handed"
    if m.shape != (3, 3):
        raise InvalidInputError(field, f"has shape {m.shape}", "give a 3×3 matrix, or a quaternion w, x, y, z", value)
    square = m.T @ m
    scale = float(np.sqrt(np.trace(square) / 3))
    if not np.abs(square - scale**2 * np.eye(3)).max() <= 2 * TOLERANCE * max(scale**2, 1e-300):
        raise InvalidInputError(field, "is no rotation: its columns are not orthogonal and equally long", remedy, value)
    if abs(scale - 1.0) > TOLERANCE:
        raise InvalidInputError(field, f"is no rotation: it is scaled by {scale:.9g}", remedy, value)
    if np.linalg.det(m) < 0:
        raise InvalidInputError(field, "is no rotation: it is a reflection, its columns are left-handed", remedy, value)
    return from_matrix(m)


def from_rpy(field: str, value: Any) -> FloatArray:
    """Return the unit quaternion of roll, pitch, yaw [rad]: about the fixed x, then y, then z axis.

    Parameters
    ----------
    field : str
        What it is called in an error.
    value : array_like, shape (3,)

    Returns
    -------
    array, shape (4,)

    Raises
    ------
    InvalidInputError
        If there are not three finite numbers.
    """
    roll, pitch, yaw = exponential(np.diag(finite_array(field, value, 1, 3)))
    return upper(product(yaw, product(pitch, roll)))


def unlikely_rpy(rpy: FloatArray) -> str | None:
    """Return what is to be said of roll, pitch and yaw that may be in degrees.

    Parameters
    ----------
    rpy : array, shape (3,)
        [rad]

    Returns
    -------
    str or None
        None if there is nothing to be said.
    """
    largest = float(np.abs(rpy).max())
    if largest <= 2 * np.pi:
        return None
    return f"rpy turns by {largest:g} rad, more than a full turn: is it in degrees? it is in radians"


def _rows(value: Any) -> Any:
    """Return `value` as an array, or nothing that has rows if it is ragged."""
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        return 0.0
