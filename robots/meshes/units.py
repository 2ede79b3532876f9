"""What the numbers of a file are taken as: told by the file or by whoever brings it, never guessed."""

from __future__ import annotations

import numpy as np

from planners.arrays import Array
from robots.errors import InvalidInput
from robots.meshes.model import METERS, Unit
from robots.meshes.refusals import refused

SMALLEST = 0.005
"""[m] A part that carries one fastener is larger: two edge distances of 2 D, with D = 2.4 mm, are 9.6 mm.
Metres taken as millimetres fall below this for every part under 5 m."""

LARGEST = 20.0
"""[m] No panel is longer. Millimetres taken as metres are above this for every part over 20 mm; taken as
inches for those over 0.79 m."""


def box_text(sizes: Array) -> str:
    """Sizes (3,) [m] for a person, in millimetres."""
    return " x ".join(f"{each * 1000.0:.6g}" for each in np.asarray(sizes, dtype=np.float64)) + " mm"


def taken_as(sizes: Array, units: tuple[Unit, ...]) -> str:
    """What a box of `sizes` (3,), in the unit of a file, is in each of `units`."""
    return "; ".join(f"in {unit}: {box_text(sizes * METERS[unit])}" for unit in units)


def unit_missing(sizes: Array) -> InvalidInput:
    """The file does not tell its unit, and nobody else did."""
    message = (
        f"the file does not tell its unit; its bounding box is, taken {taken_as(sizes, ('mm', 'inch', 'm'))}"
    )
    remedy = "State the unit: mm, cm, m or inch."
    return refused("unit_missing", message, remedy, value=None, pointer="/unit")


def check_told(told: Unit, stated: Unit | None, sizes: Array) -> None:
    """Raise InvalidInput where a file tells its unit and another is stated; sizes (3,) in the file's."""
    if stated is None or stated == told:
        return
    message = f"the file is in {told}, and {stated} is stated; taken {taken_as(sizes, (told, stated))}"
    remedy = f"Leave the unit out, or state {told}; if the file is wrong, export it again."
    raise refused("unit_contradicted", message, remedy, value=stated, pointer="/unit")


def check_plausible(sizes: Array, unit: Unit) -> None:
    """Raise InvalidInput where a box of `sizes` (3,) in `unit` is no part of a panel."""
    if _is_plausible(sizes, unit):
        return
    others = tuple(each for each in METERS if each != unit and _is_plausible(sizes, each))
    which = "smaller" if float(sizes.max()) * METERS[unit] < SMALLEST else "larger"
    limit = f"{SMALLEST * 1000.0:g} mm" if which == "smaller" else f"{LARGEST:g} m"
    message = f"taken {taken_as(sizes, (unit,))}: {which} than {limit}"
    if others:
        message += f"; plausible would be {taken_as(sizes, others)}"
    remedy = "State the unit that the part was drawn in, or export it again in that."
    raise refused("implausible_size", message, remedy, value=unit, pointer="/unit")


def _is_plausible(sizes: Array, unit: Unit) -> bool:
    return SMALLEST <= float(sizes.max()) * METERS[unit] <= LARGEST
