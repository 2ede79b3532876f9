"""Cross-sections of members as exact thin plates.

Section coordinates [m]: `s` lateral, `h` inwards from the outer face of the attach flange. A plate is a
rectangle [[s0, h0], [s1, h1]]; the plates of a section touch and never overlap, so areas add up exactly.
The mid-plane of the web is s = 0 (for U and hat: the plane of symmetry). Unmirrored, the attach flange of
L, Z and C points to +s. Seen with the skin below (h = 0 at the bottom)::

           _      _       _     ___                        ___
    L |   Z |   C |     J |    I |     T |    U |  |   hat | |
      |_    |_    |_     _|_    _|_     _|_     |__|      _| |_
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from planners.arrays import Array

Profile = Literal["Z", "L", "C", "I", "J", "U", "T", "hat"]
PROFILES: tuple[Profile, ...] = get_args(Profile)

#: Profiles with a free flange (for a hat: the crown), so with a `top` width.
TOPPED: frozenset[Profile] = frozenset({"Z", "C", "I", "J", "hat"})
#: Profiles whose foot reaches to both sides of one web.
_BOTH_SIDES: frozenset[Profile] = frozenset({"I", "J", "T"})
#: Profiles with one web, to which a clip can be fixed.
WEBBED: frozenset[Profile] = frozenset({"Z", "L", "C", "I", "J", "T"})


@dataclass(frozen=True)
class Section:
    """A section of constant thickness, lengths in [m].

    height: whole, across both flanges. foot: whole width of the attach flange, web included (I, J, T: both
    sides; U: the base; hat: of one foot). top: whole width of the free flange, web included (hat: of the
    crown). line: distance of the rivet line from the face of the web; None is the middle of the free part
    of the foot. mirrored: s turned round.
    """

    profile: Profile
    height: float
    foot: float
    thickness: float
    top: float | None = None
    line: float | None = None
    mirrored: bool = False

    def faults(self) -> list[tuple[str, str]]:
        """What makes the section impossible: pairs (field, sentence); empty when it can be built."""
        faults = []
        t, narrow = self.thickness, self._narrowest_foot()
        if self.height <= (2.0 if self.profile in TOPPED else 1.0) * t:
            faults.append(("height", "is not larger than the thickness of its flanges"))
        if self.foot <= narrow:
            faults.append(("foot", "leaves no room beside the web"))
        if self.profile in TOPPED and self.top is None:
            faults.append(("top", f"is missing: a {self.profile} has a free flange"))
        if self.profile not in TOPPED and self.top is not None:
            faults.append(("top", f"must be absent: a {self.profile} has no free flange"))
        if self.top is not None and self.top < (2.0 if self.profile == "hat" else 1.0) * t:
            faults.append(("top", "is narrower than the web"))
        if self.line is not None and self.profile == "U":
            faults.append(("line", "must be absent: a U is riveted along the middle of its base"))
        elif self.line is not None and not 0.0 < self.line < self._free_foot():
            faults.append(("line", "is not on the foot"))
        return faults

    def plates(self) -> Array:
        """The rectangles (k, 2, 2), each [[s0, h0], [s1, h1]] with s0 < s1, h0 < h1; foot plates first."""
        plates = np.array(self._plates(), dtype=np.float64)
        if self.mirrored:
            plates[:, :, 0] = -plates[:, ::-1, 0]
        return plates

    def lines(self) -> tuple[float, ...]:
        """The s of each rivet line; of two, line 0 is at +s (mirrored: at -s)."""
        a = 0.5 * self.thickness
        d = 0.5 * self._free_foot() if self.line is None else self.line
        if self.profile == "U":
            lines: tuple[float, ...] = (0.0,)
        elif self.profile == "hat":
            edge = 0.5 * (self.top or 0.0)
            lines = (edge + d, -edge - d)
        elif self.profile in _BOTH_SIDES:
            lines = (a + d, -a - d)
        else:
            lines = (a + d,)
        return tuple(-s for s in lines) if self.mirrored else lines

    def feet(self) -> list[tuple[float, Array]]:
        """The plates on the skin as (rivet line, plate (2, 2)); a foot with a line on each side is cut at s
        = 0.

        So each foot can lie tangent to a curved skin at its own rivet line.
        """
        feet = []
        for plate in self._on_skin():
            lines = [s for s in self.lines() if plate[0, 0] < s < plate[1, 0]]
            for s in lines:
                part = plate.copy()
                if len(lines) == 2:
                    part[0 if s > 0.0 else 1, 0] = 0.0
                feet.append((s, part))
        return feet

    def uprights(self) -> Array:
        """The plates that are not feet (k, 2, 2)."""
        plates = self.plates()
        uprights: Array = plates[plates[:, 0, 1] > 0.0]
        return uprights

    def foot_edges(self) -> Array:
        """Smallest and largest s (2,) of the plates that lie on the skin."""
        on_skin = self._on_skin()
        return np.array([on_skin[..., 0].min(), on_skin[..., 0].max()])

    def _on_skin(self) -> Array:
        plates = self.plates()
        on_skin: Array = plates[plates[:, 0, 1] == 0.0]
        return on_skin

    @property
    def line_centre(self) -> float:
        """Mean s of the rivet lines: where the section is tangent to the skin."""
        lines = self.lines()
        return sum(lines) / len(lines)

    def _narrowest_foot(self) -> float:
        return 2.0 * self.thickness if self.profile == "U" else self.thickness

    def _free_foot(self) -> float:
        t = self.thickness
        return 0.5 * (self.foot - t) if self.profile in _BOTH_SIDES else self.foot - t

    def _plates(self) -> list[list[list[float]]]:
        t, height, foot = self.thickness, self.height, self.foot
        a, top = 0.5 * t, self.top or 0.0
        one_foot = [[-a, 0.0], [foot - a, t]]
        wide_foot = [[-0.5 * foot, 0.0], [0.5 * foot, t]]
        web, short_web = [[-a, t], [a, height]], [[-a, t], [a, height - t]]
        c_top = [[-a, height - t], [top - a, height]]
        if self.profile == "L":
            return [one_foot, web]
        if self.profile == "T":
            return [wide_foot, web]
        if self.profile == "Z":
            return [one_foot, short_web, [[a - top, height - t], [a, height]]]
        if self.profile == "C":
            return [one_foot, short_web, c_top]
        if self.profile == "I":
            return [wide_foot, short_web, [[-0.5 * top, height - t], [0.5 * top, height]]]
        if self.profile == "J":
            return [wide_foot, short_web, c_top]
        if self.profile == "U":
            b = 0.5 * foot
            return [wide_foot, [[-b, t], [t - b, height]], [[b - t, t], [b, height]]]
        b = 0.5 * top
        return [
            [[b - t, 0.0], [b - t + foot, t]],
            [[t - b - foot, 0.0], [t - b, t]],
            [[b - t, t], [b, height - t]],
            [[-b, t], [t - b, height - t]],
            [[-b, height - t], [b, height]],
        ]
