"""From a request for a rivet pattern to its answer: sizes, spacing, and every rivet with its tool normal."""

from collections.abc import Sequence

import numpy as np

from planners.arrays import Array
from planners.rivets.designation import designation_of
from planners.rivets.patch import STOP_HOLE
from planners.rivets.pattern import DoesNotFit
from planners.rivets.placement import Placed, place
from planners.rivets.sizing import INCH, THICKEST, THINNEST, RivetSize, rivet_size
from robots.errors import InputProblem, InvalidInput
from service.pattern_arcs import MM, Arcs, measured
from service.pattern_layout import Laid, laid_out
from service.pattern_schemas import (
    Inches,
    Lack,
    Length,
    PatchDetail,
    Rivet,
    RivetCode,
    RivetPattern,
    RivetPatternRequest,
    Size,
    Spacing,
)

Triple = tuple[float, float, float]


def rivet_pattern(request: RivetPatternRequest) -> RivetPattern:
    """Return the pattern, or in it the reason why there is none. Raises InvalidInput."""
    _check_thicknesses(request.sheets)
    thicknesses = [sheet.metres for sheet in request.sheets]
    size = rivet_size(thicknesses, request.rounding)
    arcs = measured(request.surface)
    laid = laid_out(request.pattern, thicknesses[0], size.diameter, arcs)
    placed = laid if isinstance(laid, DoesNotFit) else _place(laid, laid.pattern.points, arcs)
    if isinstance(laid, DoesNotFit) or isinstance(placed, DoesNotFit):
        lack = laid if isinstance(laid, DoesNotFit) else placed
        assert isinstance(lack, DoesNotFit)
        return _refused(lack, _size(size, request.rivet), arcs)
    return RivetPattern(
        status="ok",
        lack=None,
        size=_size(size, request.rivet),
        curvature=arcs.answer(),
        spacing=_spacing(laid, arcs),
        patch=_patch(laid, arcs),
        notes=list(laid.notes),
        total=len(placed.positions),
        rivets=_rivets(laid, placed),
    )


def _check_thicknesses(sheets: Sequence[Length]) -> None:
    """Refuse sheets nobody rivets; where another unit would fit, say so."""
    problems = []
    for index, sheet in enumerate(sheets):
        if THINNEST <= sheet.metres <= THICKEST:
            continue
        in_inches = isinstance(sheet, Inches)
        value, unit = (sheet.inches, "in") if isinstance(sheet, Inches) else (sheet.mm, "mm")
        others = {"mm": 0.001} if in_inches else {"in": INCH}
        fits = [other for other, metres in others.items() if THINNEST <= value * metres <= THICKEST]
        remedy = "".join(f'It would fit as {{"{other}": {value:g}}}. ' for other in fits)
        problems.append(
            InputProblem(
                f"/sheets/{index}/{unit}",
                "thickness_out_of_range",
                f"a sheet of {MM * sheet.metres:.6g} mm is not riveted; "
                f"{MM * THINNEST:g} mm to {MM * THICKEST:g} mm are",
                value,
                f"{remedy}Check the thickness and its unit.",
            )
        )
    if problems:
        raise InvalidInput(problems)


def _place(laid: Laid, points: Array, arcs: Arcs) -> Placed | DoesNotFit:
    return place(points, arcs.surface, laid.rows_along, laid.extent)


def _refused(lack: DoesNotFit, size: Size, arcs: Arcs) -> RivetPattern:
    return RivetPattern(
        status="does_not_fit",
        lack=Lack(reason=lack.reason, needs_mm=_mm(lack.needs), has_mm=_mm(lack.has)),
        size=size,
        curvature=arcs.answer(),
        spacing=None,
        patch=None,
        notes=[],
        total=0,
        rivets=[],
    )


def _size(size: RivetSize, rivet: RivetCode) -> Size:
    designation = designation_of(size, rivet.standard, rivet.head, rivet.alloy)
    return Size(
        grip_mm=_mm(size.grip),
        diameter_raw_mm=_mm(size.diameter_raw),
        diameter_mm=_mm(size.diameter),
        diameter_32nds_in=size.diameter_32nds,
        length_raw_mm=_mm(size.length_raw),
        length_mm=_mm(size.length),
        length_16ths_in=size.length_16ths,
        rounding=size.rounding,
        designation=None if designation is None else str(designation),
    )


def _spacing(laid: Laid, arcs: Arcs) -> Spacing:
    pattern = laid.pattern
    distance = _row_distance(laid, arcs)
    return Spacing(
        rows=pattern.row_count,
        per_row=pattern.spacing.count,
        side_mm=_mm(pattern.spacing.side),
        pitch_mm=_mm(pattern.spacing.pitch),
        least_row_distance_mm=None if distance is None else _mm(distance),
    )


def _row_distance(laid: Laid, arcs: Arcs) -> float | None:
    """Return the least distance of neighbouring rows along the surface [m].

    Rows around the section of a twice curved surface draw nearer to each other off the crown.
    """
    across = np.unique(laid.pattern.points[:, 1])
    if laid.pattern.row_count == 1 or len(across) != laid.pattern.row_count:  # zigzags on stringers' flanges
        return None
    least = float(np.diff(across).min())
    if laid.rows_along == "y":
        least *= arcs.surface.arc_scale(float(np.abs(laid.pattern.points[:, 0]).max()))
    return least


def _patch(laid: Laid, arcs: Arcs) -> PatchDetail | None:
    if laid.patch is None or laid.crack is None:
        return None
    outline, holes = (_place(laid, points, arcs) for points in (laid.patch.outline, laid.patch.stop_holes))
    assert isinstance(outline, Placed)
    assert isinstance(holes, Placed)
    return PatchDetail(
        required_raw=round(laid.crack.rivets_raw, 9),
        required=laid.patch.required,
        per_side=laid.patch.per_side,
        load_bearing=laid.patch.load_bearing,
        redundant=laid.patch.redundant,
        outline_mm=[_triple(point, MM, 6) for point in outline.positions],
        stop_holes_mm=[_triple(point, MM, 6) for point in holes.positions],
        stop_hole_diameter_mm=_mm(STOP_HOLE),
    )


def _rivets(laid: Laid, placed: Placed) -> list[Rivet]:
    rows = laid.pattern.rows
    first = np.searchsorted(rows, rows)  # index of the first rivet of each one's row
    return [
        Rivet(
            id=f"{row + 1}.{index - start + 1:03d}",
            row=int(row) + 1,
            position_mm=_triple(position, MM, 6),
            tool_normal=_triple(normal, 1.0, 9),
        )
        for index, (row, start, position, normal) in enumerate(
            zip(rows, first, placed.positions, placed.normals, strict=True)
        )
    ]


def _triple(vector: Array, scale: float, digits: int) -> Triple:
    x, y, z = (round(scale * float(part), digits) + 0.0 for part in vector)
    return x, y, z


def _mm(metres: float) -> float:
    return round(MM * metres, 6) + 0.0
