"""The verifier's own rest-to-rest profile: jerk-limited, over the unit distance, in closed form.

Seven phases of constant jerk j, 0, -j, 0, -j, 0, j (Biagiotti and Melchiorri 2008, section 3.4). With limits
v, a, j: acceleration lasts tj + ta + tj, cruising tv, braking mirrors acceleration. Which limits are reached
decides the case.
"""

from dataclasses import dataclass
from math import cbrt, sqrt

_TIME_RESOLUTION = 1e-7  # [s] a tenth of the program's digit


@dataclass(frozen=True)
class Profile:
    """Times of the phases [s]: each jerk phase, constant acceleration, cruise; and the jerk [1/s^3]."""

    jerk_time: float
    acceleration_time: float
    cruise_time: float
    jerk: float

    @property
    def duration(self) -> float:
        return 4.0 * self.jerk_time + 2.0 * self.acceleration_time + self.cruise_time

    def position(self, t: float) -> float:
        """s(t), rising from 0 to 1, for t in [s]."""
        ramp = 2.0 * self.jerk_time + self.acceleration_time
        if t <= ramp:
            return self._ramp(max(t, 0.0))
        if t >= self.duration - ramp:
            return 1.0 - self._ramp(max(self.duration - t, 0.0))
        return self._ramp(ramp) + self._speed * (t - ramp)

    def time(self, s: float) -> float:
        """The time at which s is reached, by bisection; [s]."""
        low, high = 0.0, self.duration
        if s <= 0.0 or s >= 1.0:
            return low if s <= 0.0 else high
        while high - low > _TIME_RESOLUTION:
            middle = 0.5 * (low + high)
            if self.position(middle) < s:
                low = middle
            else:
                high = middle
        return high

    @property
    def _speed(self) -> float:
        return self.jerk * self.jerk_time * (self.jerk_time + self.acceleration_time)

    def _ramp(self, t: float) -> float:
        """Distance covered from rest, within the acceleration ramp."""
        tj, ta, j = self.jerk_time, self.acceleration_time, self.jerk
        a = j * tj
        if t <= tj:
            return j * t**3 / 6.0
        distance, speed = j * tj**3 / 6.0, 0.5 * a * tj
        t -= tj
        if t <= ta:
            return distance + speed * t + 0.5 * a * t * t
        distance, speed = distance + speed * ta + 0.5 * a * ta * ta, speed + a * ta
        t -= ta
        return distance + speed * t + 0.5 * a * t * t - j * t**3 / 6.0


def rest_to_rest(v: float, a: float, j: float) -> Profile:
    """The fastest profile over the unit distance within speed v, acceleration a and jerk j (all positive)."""
    tj = min(a / j, sqrt(v / j))  # the shorter: acceleration limit reached, or speed first
    ta = v / (j * tj) - tj
    if v * (2.0 * tj + ta) <= 1.0:
        return Profile(tj, max(ta, 0.0), 1.0 / v - 2.0 * tj - ta, j)
    tj = a / j
    # Speed limit not reached: (tj + ta)(2 tj + ta) a = 1, as long as that leaves ta >= 0.
    ta = 0.5 * (-3.0 * tj + sqrt(tj * tj + 4.0 / a))
    if ta >= 0.0:
        return Profile(tj, ta, 0.0, j)
    return Profile(cbrt(0.5 / j), 0.0, 0.0, j)
