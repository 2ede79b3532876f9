"""Patch repair of a cracked skin: octagon, rows beside the crack, stop holes (Dakdouk 2016, A.7 - A.10).

What the thesis leaves to its figure is read on the safe side: the n of (A.7) are the load-bearing three
quarters of the rivets on *each* side of the crack, since each side passes the whole load on; the rows nearest
to the crack span it from end to end; every row outwards has one rivet less and stands midway, which is what
makes the patch an octagon.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from planners.arrays import Array, frozen
from planners.errors import InvalidSetting
from planners.rivets.pattern import MOST_RIVETS, DoesNotFit, Pattern
from planners.rivets.sizing import INCH, LONGEST, THICKEST, THINNEST, RowSpacing

SIDE, PITCH, ROW_SPACING = 3.0, 6.0, 4.5  # S, B and psi [D], (A.8) - (A.10)
FEWEST_ROWS, MOST_ROWS = 3, 4  # on each side of the crack
LOAD_BEARING = 0.75  # of the rivets of one side; the others are redundant
#: Drilled at both ends of the crack before it is cleaned [m]; the thesis gives no size, this is our
#: convention.
STOP_HOLE = 3.0 / 32.0 * INCH

_EPS = 1e-9


@dataclass(frozen=True)
class Crack:
    """What the patch has to carry.

    length: of the damage, l [m]. thickness: of the damaged skin, t [m]. stress: nominal tensile strength of
    the skin with its factor of safety, sigma [Pa]. rivet_strength: shear strength of one rivet as a force,
    tau [N].
    """

    length: float
    thickness: float
    stress: float
    rivet_strength: float

    def __post_init__(self) -> None:
        if not 1e-6 <= self.length <= LONGEST:
            raise InvalidSetting("length", self.length, f"a length of at most {LONGEST:g} m")
        if not THINNEST <= self.thickness <= THICKEST:
            raise InvalidSetting("thickness", self.thickness, f"from {THINNEST} to {THICKEST} m")
        for field in ("stress", "rivet_strength"):
            if not 0.0 < getattr(self, field) < math.inf:
                raise InvalidSetting(field, getattr(self, field), "finite and above 0")

    @property
    def rivets_raw(self) -> float:
        """l t sigma / tau (A.7), not yet rounded up."""
        return self.length * self.thickness * self.stress / self.rivet_strength


@dataclass(frozen=True, eq=False)
class Patch:
    """A patch about the middle of its crack, which lies along the rows.

    pattern: all rivets, rows from the negative to the positive side of the crack. required: n of (A.7), on
    each side. per_side: rivets on each side; `load_bearing` of them are three quarters, at least n. outline:
    (8, 2) corners of the patch, anticlockwise [m]. stop_holes: (2, 2) their middles [m].
    """

    pattern: Pattern
    required: int
    per_side: int
    outline: Array
    stop_holes: Array

    @property
    def load_bearing(self) -> int:
        """Rivets of one side that carry the load."""
        return math.floor(LOAD_BEARING * self.per_side)

    @property
    def redundant(self) -> int:
        """Rivets of one side that are there for safety."""
        return self.per_side - self.load_bearing


def rivet_strength(shear_stress: float, diameter: float) -> float:
    """Return the force [N] that one rivet of `diameter` [m] bears at a shear stress [Pa]."""
    return 0.25 * math.pi * diameter**2 * shear_stress


def required_rivets(crack: Crack) -> int:
    """Return n (A.7), rounded up."""
    if not crack.rivets_raw <= MOST_RIVETS:
        raise InvalidSetting("rivets", crack.rivets_raw, f"at most {MOST_RIVETS}")
    return max(1, math.ceil(crack.rivets_raw - _EPS))


def patch_repair(
    crack: Crack, diameter: float, rows: int, room: tuple[float, float] | None
) -> Patch | DoesNotFit:
    """Return the patch over a crack.

    diameter: of the rivets, D [m]. rows: on each side, 3 or 4. room: along and across the crack, about its
    middle, what the patch may cover [m]; None where there is room enough. Raises InvalidSetting.
    """
    if not FEWEST_ROWS <= rows <= MOST_ROWS:
        raise InvalidSetting("rows", rows, f"{FEWEST_ROWS} or {MOST_ROWS}")
    if not 0.0 < diameter <= LONGEST:
        raise InvalidSetting("diameter", diameter, "above 0")
    required = required_rivets(crack)
    first = _first_row(crack.length, diameter, rows, required)
    per_side = rows * first - rows * (rows - 1) // 2
    if 2 * per_side > MOST_RIVETS:
        raise InvalidSetting("rivets", 2 * per_side, f"at most {MOST_RIVETS}")
    outline = _octagon(first, diameter, rows)
    extent = 2.0 * outline.max(axis=0)
    for size, has, way in zip(extent, room or extent, ("along", "across"), strict=True):
        if size > has + _EPS:
            return DoesNotFit(f"the patch is larger than its room {way} the crack", float(size), has)
    half = 0.5 * crack.length
    holes = frozen([[-half, 0.0], [half, 0.0]])
    return Patch(_pattern(first, diameter, rows), required, per_side, frozen(outline), holes)


def _first_row(length: float, diameter: float, rows: int, required: int) -> int:
    """Return how many rivets stand in each row next to the crack: rivets enough, and the crack spanned."""
    enough = math.ceil(required / LOAD_BEARING - _EPS)
    for_load = math.ceil((enough + rows * (rows - 1) // 2) / rows)
    for_crack = math.ceil(length / (PITCH * diameter) - _EPS) + 1
    return max(rows, for_load, for_crack)


def _pattern(first: int, diameter: float, rows: int) -> Pattern:
    pitch, side = PITCH * diameter, SIDE * diameter
    counts = [first - k for k in range(rows)]
    outwards = [side + k * ROW_SPACING * diameter for k in range(rows)]
    stands = list(zip(counts[::-1] + counts, [-y for y in outwards[::-1]] + outwards, strict=True))
    points = [[pitch * (i - 0.5 * (count - 1)), y] for count, y in stands for i in range(count)]
    index = np.repeat(np.arange(2 * rows), [count for count, _ in stands])
    spacing = RowSpacing((first - 1) * pitch + 2.0 * side, first, side, pitch)
    return Pattern(frozen(points), index, spacing)


def _octagon(first: int, diameter: float, rows: int) -> Array:
    """Corners (8, 2), S outside the outermost rivets: ends, outer rows, and the slopes between them."""
    side = SIDE * diameter
    x = 0.5 * (first - 1) * PITCH * diameter  # end of the row next to the crack, at the height `side`
    end, top = x + side, side + (rows - 1) * ROW_SPACING * diameter + side
    slope = np.array([ROW_SPACING, 0.5 * PITCH]) / math.hypot(ROW_SPACING, 0.5 * PITCH)  # its normal
    reach = float(slope @ [x, side]) + side
    low = (reach - slope[0] * end) / slope[1]  # where the slope begins at the end
    short = (reach - slope[1] * top) / slope[0]  # and where it arrives at the outer edge
    quarter = [(end, low), (short, top)]
    upper = quarter + [(-a, b) for a, b in reversed(quarter)]
    return np.array(upper + [(-a, -b) for a, b in upper])
