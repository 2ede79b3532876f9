"""An integrator of straight blocks that shares nothing with the planners' timing: jerks in, motion out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array

SIGNS = (1, 0, -1, 0, -1, 0, 1)


@dataclass(frozen=True, eq=False)
class Motion:
    """Times (k,) at which some jerk changes; there q, v, a (k, n); the jerk (k - 1, n) between them."""

    t: Array
    q: Array
    v: Array
    a: Array
    j: Array

    def at(self, t: float) -> Array:
        """q at time `t` [s], (n,)."""
        i = min(max(int(np.searchsorted(self.t, t, side="right")) - 1, 0), len(self.j) - 1)
        h = t - self.t[i]
        found: Array = self.q[i] + h * self.v[i] + h**2 * self.a[i] / 2 + h**3 * self.j[i] / 6
        return found

    def excess(self, limits: Array) -> float:
        """Largest velocity, acceleration or jerk over its limit (3, n) at any instant.

        Pieces shorter than 1e-9 s are rounding and have no jerk.
        """
        h = np.diff(self.t)[:, np.newaxis]
        turns = np.clip(np.divide(-self.a[:-1], self.j, out=np.zeros_like(self.j), where=self.j != 0), 0.0, h)
        turning = self.v[:-1] + turns * self.a[:-1] + turns**2 * self.j / 2
        largest = [
            np.abs(np.vstack([self.v, turning])) / limits[0],
            np.abs(self.a) / limits[1],
            np.abs(self.j[h[:, 0] > 1e-9]) / limits[2],
        ]
        return max(float(each.max(initial=0.0)) for each in largest)


def integrated(
    start: Array,
    moves: Sequence[Array],
    phases: Sequence[Sequence[float]],
    jerks: Sequence[float],
    starts: Sequence[float],
) -> Motion:
    """Blocks `moves` (n,) with the durations of their seven phases [s], their jerks [1/s^3], and when they
    start [s].
    """
    ends = [at + np.cumsum([0.0, *p]) for at, p in zip(starts, phases, strict=True)]
    t = np.unique(np.concatenate(ends))
    middle = 0.5 * (t[1:] + t[:-1])
    j = np.zeros((len(middle), len(start)))
    for move, end, jerk in zip(moves, ends, jerks, strict=True):
        for i, sign in enumerate(SIGNS):
            j[(end[i] < middle) & (middle < end[i + 1])] += sign * jerk * move
    q, v, a = [np.array(start, dtype=np.float64)], [np.zeros(len(start))], [np.zeros(len(start))]
    for h, jerks_then in zip(np.diff(t), j, strict=True):
        q.append(q[-1] + h * v[-1] + h**2 * a[-1] / 2 + h**3 * jerks_then / 6)
        v.append(v[-1] + h * a[-1] + h**2 * jerks_then / 2)
        a.append(a[-1] + h * jerks_then)
    return Motion(t, np.array(q), np.array(v), np.array(a), j)
