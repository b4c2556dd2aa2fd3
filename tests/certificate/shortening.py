"""Shortening a motion locally: postures slide along their self-motion, on windows and by Newton's method."""

import numpy as np
from curves import Curve
from scipy.linalg import solve_banded

_WINDOW = 3  # candidates on each side of a posture
_GAIN = 1e-6  # part of the cost that another round with the same window must gain
_NARROWER = 0.35
_FARTHEST = 0.3  # of a shift [rad]
# Widest slab, largest joint step [rad] and first window of each level that a motion is shortened on.
LEVELS = ((1 / 32, 0.15, 0.05), (1 / 64, 0.07, 0.01), (1 / 128, 0.035, 0.002))
_ROUNDS = 30
_DIVISIONS = 10
_MOST_POSTURES = 500


class Shortener:
    """Shortens a motion given by postures: each slides along its self-motion, on a window that moves and shrinks."""

    def __init__(self, task, r, q, longest):
        self.task, self.r, self.q, self.longest = task, r, q, longest
        self.steep = float(task.weights.sum())
        curve = Curve(task, r, q)
        self.lower, self.upper, self.offset = curve.lower, curve.upper, curve.offset
        if task.cyclic:
            self.turns = q[-1] - q[0]

    def run(self, width, least, rounds):
        """Shorten until the window is as narrow as `least` and nothing is gained, in at most `rounds` rounds."""
        before = np.inf
        for _ in range(rounds):
            self._round(width)
            now = self.cost() + float(self._surcharge(np.diff(self.q, axis=0)).sum())
            if before - now <= _GAIN * now:
                if width < least:
                    break
                width *= _NARROWER
            before = now
        return self.q

    def _round(self, width):
        """Choose for each posture the best of a window around it and of where Newton's method would put it."""
        task = self.task
        p = task.directions(self.q)[0]
        t = task.tangents(p)
        t = t * np.cumprod(np.concatenate([[1.0], np.where((t[1:] * t[:-1]).sum(axis=-1) < 0, -1.0, 1.0)]))[:, None]
        t /= np.maximum(np.abs(t @ task.to_joints.T).max(axis=1)[:, None], 1e-300)  # zero where all links are one line
        window = np.linspace(-1, 1, 2 * _WINDOW + 1)
        window = width * np.sign(window) * np.abs(window) ** 1.5
        shifts = [np.clip(shift, -_FARTHEST, _FARTHEST) for shift in self._shifts(t @ task.to_joints.T, width)]
        shifts = np.stack([part * shift for shift in shifts for part in (1.0, 0.5)], axis=1)
        offsets = np.concatenate([np.broadcast_to(window, (len(p), len(window))), shifts], axis=1)
        guess = p[:, None] + offsets[..., None] * t[:, None]
        x = np.broadcast_to(task.target(self.r)[:, None], offsets.shape)
        gauge = np.broadcast_to(t[:, None], guess.shape)
        found, ok = task.closed(guess, x, gauge, (gauge * guess).sum(axis=-1))
        found, ok = self._inside(found, ok, x)
        q = task.joints(found, self.offset)
        ok &= np.isfinite(q).all(axis=-1)
        ok &= np.abs(q - self.q[:, None]).max(axis=-1) <= 3 * np.maximum(width, np.abs(offsets))
        for given, k in ((task.start_u, 0), (task.end_u, -1)):
            if given is not None:
                ok[k] = False
        ok[:, _WINDOW] = True
        q[:, _WINDOW] = self.q
        value = np.where(ok, 0.0, np.inf)
        q = np.where(ok[..., None], q, self.q[:, None])
        dq = q[1:, None, :, :] - q[:-1, :, None, :]
        costs = task.cost_of(dq, np.diff(self.r)[:, None, None])
        costs += value[1:, None, :] + self._surcharge(dq)
        chosen = self._closed_choice(q, ok, costs) if task.cyclic else self._choice(value[0], costs)[1]
        self.q = q[np.arange(len(q)), chosen]

    def _shifts(self, d, width):
        """Shifts along d (k, n) that minimise second-order models of the cost: its own, and one that lies above it."""
        task, dq, dr = self.task, np.diff(self.q, axis=0), np.diff(self.r)[:, None]
        if task.kind == "joint_travel":
            size = np.maximum(np.hypot(dq, dr), 1e-12)
            slope, models = task.weights * dq / size, (task.weights * dr**2 / size**3, task.weights / size)
        elif task.kind == "l1":
            size = np.hypot(dq, 0.03 * width)
            slope, models = task.weights * dq / size, (task.weights / size,)
        else:
            size = np.sqrt((dq * dq) @ task.weights**2 + 1e-20)[:, None]
            slope, models = task.weights**2 * dq / size, (task.weights**2 / size,)
        return [self._least(d, slope, np.maximum(model, 1e-9)) for model in models]

    def _least(self, d, slope, stiff):
        """Minimise one model, postures on a limit that would leave it held fast."""
        low, high = self.q - self.lower < 1e-9, self.upper - self.q < 1e-9
        fixed = np.zeros(len(d), bool)
        fixed[0], fixed[-1] = (
            self.task.start_u is not None or self.task.cyclic,
            self.task.end_u is not None or self.task.cyclic,
        )
        pull = np.zeros(len(d))
        pull[1:] -= (slope * d[1:]).sum(axis=1)
        pull[:-1] += (slope * d[:-1]).sum(axis=1)
        diagonal = np.full(len(d), 1e-9)
        diagonal[1:] += (stiff * d[1:] ** 2).sum(axis=1)
        diagonal[:-1] += (stiff * d[:-1] ** 2).sum(axis=1)
        beside = -(stiff * d[1:] * d[:-1]).sum(axis=1)
        for _ in range(4):
            bands = np.stack([np.append(beside, 0.0), diagonal, np.append(beside, 0.0)])
            bands[0] = np.concatenate([[0.0], beside * ~(fixed[1:] | fixed[:-1])])
            bands[2] = np.append(bands[0, 1:], 0.0)
            try:  # beside singular postures stiffness is beyond all bounds
                shift = solve_banded((1, 1), bands, np.where(fixed, 0.0, pull))
            except (np.linalg.LinAlgError, ValueError):
                return np.zeros(len(d))
            moves = shift[:, None] * d
            leaving = ((low & (moves < 0)) | (high & (moves > 0))).any(axis=1) & ~fixed
            if not leaving.any():
                break
            fixed |= leaving
        return shift

    def _inside(self, p, ok, x):
        """Candidates outside a limit, moved on to it."""
        for _ in range(2):
            q = self.task.joints(p, self.offset)
            over = np.maximum(self.lower - q, q - self.upper)
            j = np.argmax(over, axis=-1)
            outside = np.take_along_axis(over, j[..., None], axis=-1)[..., 0] > 0
            at = np.nonzero(outside & ok)
            if not len(at[0]):
                return p, ok
            joint = j[at]
            limit = np.where(q[(*at, joint)] > self.upper[joint], self.upper[joint], self.lower[joint])
            moved, good = self.task.closed(p[at], x[at], self.task.to_joints[joint], limit - self.offset[joint])
            p[at], ok[at] = moved, good
        q = self.task.joints(p, self.offset)
        return p, ok & (np.maximum(self.lower - q, q - self.upper).max(axis=-1) <= 1e-14)

    @staticmethod
    def _choice(value, costs):
        """The cheapest candidates in turn, from costs of the first ones, and their cost."""
        back = np.empty((len(costs), costs.shape[1]), int)
        columns = np.arange(costs.shape[1])
        for k, cost in enumerate(costs):
            sums = value[:, None] + cost
            back[k] = sums.argmin(axis=0)
            value = sums[back[k], columns]
        node = int(np.argmin(value))
        total, chosen = float(value[node]), [node]
        for row in back[::-1]:
            chosen.append(int(row[chosen[-1]]))
        return total, chosen[::-1]

    def _closed_choice(self, q, ok, costs):
        """The same for a motion that must close: each candidate at the start with its own at the end."""
        best = (np.inf, None)
        apart = np.abs(q[-1][None, :] - q[0][:, None] - self.turns).max(axis=-1)
        for k in np.flatnonzero(ok[0]):
            same = np.where(apart[k] < 1e-12, 0.0, np.inf)
            if not np.isfinite(same).any():
                continue
            first = np.full(len(ok[0]), np.inf)
            first[k] = 0.0
            tied = np.concatenate([costs[:-1], costs[-1:] + same])
            best = min(best, self._choice(first, tied), key=lambda pair: pair[0])
        return np.full(len(q), _WINDOW) if best[1] is None else best[1]

    def _surcharge(self, dq):
        """What long steps cost more: straight ones cut corners that the motion cannot."""
        return self.steep * np.maximum(np.abs(dq).max(axis=-1) - self.longest, 0.0)

    def cost(self):
        """The cost of straight steps, without any surcharge."""
        return float(self.task.cost_of(np.diff(self.q, axis=0), np.diff(self.r)).sum())


def divided(task, r, q, widest, largest):
    """The postures of the motion through r and q, and more until slabs and joint steps are no larger than this."""
    for _ in range(_DIVISIONS):
        curve = Curve(task, r, q)
        large = ~curve.still & ((np.diff(r) > widest) | (np.abs(np.diff(q, axis=0)).max(axis=1) > largest))
        more = np.flatnonzero(large)
        if not len(more) or len(r) + len(more) > _MOST_POSTURES:
            break
        new_r, new_q = curve(0.5 * (curve.tau[more] + curve.tau[more + 1]))
        r, q = np.insert(r, more + 1, new_r), np.insert(q, more + 1, new_q, axis=0)
    return r, q


def shortened(task, r, q, levels):
    """Postures of a motion shortened on more and more of them; as many levels as the motion lasts."""
    found = []
    for widest, largest, width in levels:
        r, q = divided(task, r, q, widest, largest)
        if not np.isfinite(q).all():
            break
        shortener = Shortener(task, r, q, 2 * largest)
        if np.maximum(shortener.lower - q, q - shortener.upper).max() > 1e-12:
            break
        q = shortener.run(width, 1e-5, _ROUNDS)
        found.append((r, q))
    return found
