"""Discs against the links of a planar arm, in plain numpy: constraints on postures to try the refinement on."""

import numpy as np


class Discs:
    """Links as capsules keep clear of discs.

    Parameters
    ----------
    arm : PlanarArm
    centers : array, shape (m, 2)
    radii : array, shape (m,)
        Those of the links included.
    """

    def __init__(self, arm, centers, radii):
        self.arm, self.scale = arm, arm.reach
        self.centers, self.radii = np.reshape(centers, (-1, 2)).astype(float), np.broadcast_to(radii, (len(centers),))

    def margins(self, q):
        """Distances of every link to every disc, shape (k, links · discs)."""
        return self._nearest(np.asarray(q))[0]

    def least_margins(self, q):
        """The least of them and which it is, shapes (k,)."""
        margins = self.margins(q)
        return margins.min(axis=1), margins.argmin(axis=1)

    def gradients(self, q):
        """The same, and how they change with the joints."""
        q = np.asarray(q)
        margins, at, normal = self._nearest(q)
        joints = self.arm.joint_positions(q)
        gradient = np.zeros((*margins.shape, self.arm.n))
        discs = len(self.radii)
        for link in range(self.arm.n):
            part = slice(link * discs, (link + 1) * discs)
            for j in range(link + 1):
                lever = at[:, part] - joints[:, j, None]
                gradient[:, part, j] = lever[..., 0] * normal[:, part, 1] - lever[..., 1] * normal[:, part, 0]
        return margins, gradient

    def _nearest(self, q):
        points = self.arm.joint_positions(q)
        start, along = points[:, :-1, None], np.diff(points, axis=1)[:, :, None]
        square = np.maximum((along * along).sum(-1), 1e-300)
        t = np.clip(((self.centers - start) * along).sum(-1) / square, 0.0, 1.0)
        at = start + t[..., None] * along
        away = at - self.centers
        distance = np.linalg.norm(away, axis=-1)
        normal = away / np.maximum(distance, 1e-300)[..., None]
        k = len(q)
        return (distance - self.radii).reshape(k, -1), at.reshape(k, -1, 2), normal.reshape(k, -1, 2)


def with_discs(arm, centers, radii):
    """Return the arm, told of discs that its links must not touch."""
    arm.constraints = (Discs(arm, centers, radii),)
    return arm


def least_margin(plan, samples=20_001):
    """Return the least margin of a plan's motion, as a part of the reach, at many samples."""
    r = np.linspace(0.0, 1.0, samples)
    arm = plan.problem.arm
    return min(float(c.margins(plan.motion(r)).min()) / c.scale for c in arm.constraints)
