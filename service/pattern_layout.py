"""From the four kinds of requested patterns to developed patterns."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from planners.errors import InvalidSetting
from planners.rivets.patch import Crack, Patch, patch_repair, rivet_strength
from planners.rivets.pattern import (
    DoesNotFit,
    Pattern,
    end_shortfall,
    lap_joint,
    sheet_pattern,
    stringer_rows,
)
from planners.rivets.placement import RowsAlong
from robots.errors import InputProblem, InvalidInput
from service.pattern_arcs import MM, Arcs
from service.pattern_schemas import (
    Force,
    LapJoint,
    Length,
    PatchRepair,
    PatternOrder,
    SheetRows,
    StringerRows,
)


@dataclass(frozen=True, eq=False)
class Laid:
    """A pattern, the way its rows go, and what it covers along and across them [m].

    crack, patch: of a repair. notes: what the designer should know.
    """

    pattern: Pattern
    rows_along: RowsAlong
    extent: tuple[float, float]
    crack: Crack | None = None
    patch: Patch | None = None
    notes: tuple[str, ...] = ()


def laid_out(order: PatternOrder, skin: float, diameter: float, arcs: Arcs) -> Laid | DoesNotFit:
    """Return the developed pattern for rivets of `diameter`; skin: thickness of the first sheet; [m].

    Raises InvalidInput.
    """
    with _too_large():
        if isinstance(order, SheetRows):
            return _sheet(order, diameter, arcs)
        if isinstance(order, LapJoint):
            return _lap_joint(order, diameter, arcs)
        if isinstance(order, StringerRows):
            return _stringers(order, diameter, arcs)
        return _patch(order, skin, diameter)


def _sheet(order: SheetRows, diameter: float, arcs: Arcs) -> Laid | DoesNotFit:
    length = _arc_length(order.length, "x", arcs, "length")
    width = _arc_length(order.width, "y", arcs, "width")
    longer: RowsAlong = "x" if length >= width else "y"
    rows_along = longer if order.rows_along == "longer" else order.rows_along
    extent = (length, width) if rows_along == "x" else (width, length)
    pattern = sheet_pattern(*extent, diameter, order.layout, order.row_placement)
    return pattern if isinstance(pattern, DoesNotFit) else Laid(pattern, rows_along, extent)


def _lap_joint(order: LapJoint, diameter: float, arcs: Arcs) -> Laid | DoesNotFit:
    length = _arc_length(order.row_length, order.rows_along, arcs, "row_length")
    overlap = None if order.overlap is None else order.overlap.metres
    pattern = lap_joint(length, overlap, diameter, order.rows, order.layout)
    if isinstance(pattern, DoesNotFit):
        return pattern
    needs = order.rows * pattern.spacing.pitch
    note = f"the overlap must be at least {MM * needs:.6g} mm"
    return Laid(pattern, order.rows_along, (length, needs if overlap is None else overlap), notes=(note,))


def _stringers(order: StringerRows, diameter: float, arcs: Arcs) -> Laid | DoesNotFit:
    length = _arc_length(order.row_length, order.rows_along, arcs, "row_length")
    flange, offsets = order.flange.metres, [offset / MM for offset in order.offsets_mm]
    pattern = stringer_rows(length, flange, diameter, order.material, order.layout, offsets)
    if isinstance(pattern, DoesNotFit):
        return pattern
    reach = 2.0 * max(*np.abs(offsets), *np.abs(np.add(offsets, flange)))
    short = end_shortfall(pattern, diameter, order.material)
    note = (
        f"the first and last rivet are {MM * pattern.spacing.side:.6g} mm from the ends of the stringer, "
        f"{MM * short:.3g} mm less than the edge distance of its flange"
    )
    return Laid(pattern, order.rows_along, (length, reach), notes=(note,) if short > 0.0 else ())


def _patch(order: PatchRepair, skin: float, diameter: float) -> Laid | DoesNotFit:
    given = order.rivet_shear_strength
    force = given.N if isinstance(given, Force) else rivet_strength(1e6 * given.MPa, diameter)
    crack = Crack(order.crack_length.metres, skin, 1e6 * order.skin_strength.MPa, force)
    room = None if order.room is None else (order.room.along.metres, order.room.across.metres)
    patch = patch_repair(crack, diameter, order.rows, room)
    if isinstance(patch, DoesNotFit):
        return patch
    along, across = 2.0 * patch.outline.max(axis=0)
    return Laid(patch.pattern, order.rows_along, (float(along), float(across)), crack, patch)


def _arc_length(given: Length | None, way: RowsAlong, arcs: Arcs, field: str) -> float:
    """Return a length as given, or as measured on the arc that goes this way [m]."""
    if given is not None:
        return given.metres
    curve = arcs.length if way == "x" else arcs.section
    if curve is not None and curve.length is not None:
        return curve.length
    name = "length" if way == "x" else "section"
    message = f"the {field} is not given, and the surface's {name} not by points"
    remedy = f"Add it, or give /surface/{name} by points."
    raise InvalidInput([InputProblem(f"/pattern/{field}", "not_given", message, None, remedy)])


@contextmanager
def _too_large() -> Iterator[None]:
    """Name the one thing that a request within its schema can still have too much of."""
    try:
        yield
    except InvalidSetting as error:
        code = "too_many_rivets" if error.field == "rivets" else "out_of_range"
        remedy = "Check the lengths and their units, or divide the pattern."
        raise InvalidInput([InputProblem("/pattern", code, str(error), None, remedy)]) from None
