"""How accessibility is judged: safety zone, what a contact is, which angles are tried."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, get_args

from planners.errors import InvalidSetting

RowPlacement = Literal["from_far_edge", "centred"]

#: Two solids nearer than this touch, and two that overlap by less only touch [m]. Preset B puts a rivet of
#: Table 6-1 exactly on a contact; without a width the answer would hang on the last bit.
CONTACT = 1e-9

#: A full turn in steps of 0.1 degree; finer ones are the work of certified rotation, not of samples.
_MOST_STEPS = 3600


@dataclass(frozen=True)
class AccessRules:
    """The semantics of GAA and GAV that the thesis leaves open, and its safety zone.

    safety: width of the zone around obstacles [m], Euclidean; the tool stays out of it.
    contact_is_collision: whether touching an obstacle, or its safety zone, is a collision (Dakdouk 2016,
        3.3.2 and 3.4.2 say that it is).
    row_placement: where rows stand across the part. "from_far_edge": the last one at the side distance from
        the far edge, the others towards the near edge; "centred": as many on either side of the middle.
    step, rotation: the tool is turned anticlockwise by `step` [rad] at a time, up to `rotation` [rad] in all
        (Dakdouk 2016, 6.1: 10 degrees up to 90).
    """

    safety: float = 0.0
    contact_is_collision: bool = True
    row_placement: RowPlacement = "from_far_edge"
    step: float = math.radians(10.0)
    rotation: float = math.radians(90.0)

    def __post_init__(self) -> None:
        for field, lowest in (("safety", 0.0), ("rotation", 0.0)):
            value = getattr(self, field)
            if not (math.isfinite(value) and value >= lowest):
                raise InvalidSetting(field, value, "finite and 0 or more")
        if not (math.isfinite(self.step) and self.step > 0.0):
            raise InvalidSetting("step", self.step, "finite and above 0")
        if self._steps > _MOST_STEPS:
            raise InvalidSetting("step", self.step, f"the rotation divided by {_MOST_STEPS}, or more")
        if self.row_placement not in get_args(RowPlacement):
            raise InvalidSetting("row_placement", self.row_placement, "from_far_edge or centred")

    @property
    def angles(self) -> tuple[float, ...]:
        """The angles that are tried, in this order [rad]; the default orientation, 0, is the first."""
        return tuple(k * self.step for k in range(self._steps + 1))

    @property
    def _steps(self) -> int:
        return math.floor(self.rotation / self.step + 1e-9)

    @property
    def reach(self) -> float:
        """An obstacle blocks when its gap to the tool (shrunk by `shrink`) is not above this [m]."""
        return self.safety + (CONTACT if self.contact_is_collision else 0.0)

    @property
    def shrink(self) -> float:
        """What is taken off every side of the tool before gaps are measured [m].

        Where touching is allowed, a tool that touches thus has a gap, and one that overlaps by more than the
        width of a contact has none; a distance alone could not tell the two apart.
        """
        return 0.0 if self.contact_is_collision else CONTACT


#: Reproduces Tables 6-1 and 6-2 and honours every explicit statement of the text.
PRESET_A = AccessRules()
#: Reproduces them too, and is symmetric under mirroring; only without a safety zone.
PRESET_B = AccessRules(contact_is_collision=False, row_placement="centred")
