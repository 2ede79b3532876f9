"""Accessibility areas and volumes as answers in mm and degrees: the same bytes for the same content."""

import math
from collections.abc import Sequence
from typing import get_args

import shapely

from planners.accessibility.areas import AccessAreas
from planners.accessibility.curved import CurvedScene
from planners.accessibility.flat import FlatScene, is_larger_than
from planners.accessibility.gaa import accessibility_area
from planners.accessibility.obstacles import Box
from planners.accessibility.projection import View, outline
from planners.accessibility.reach import Blocker, RivetReach, reach_of
from planners.accessibility.summary import AccessSummary
from planners.rivets.pattern import DoesNotFit, Pattern
from service.area_inputs import AccessInputs, Rivets
from service.area_schemas import (
    AccessFinding,
    AccessibilityAreas,
    AccessibilityVolumes,
    AccessTotals,
    AngleTried,
    AreaDivision,
    AreaPolygon,
    AreaRegion,
    BlockedBy,
    RivetAccess,
    RowPattern,
    SolidOutlines,
)

_MM = 1000.0  # [mm / m]


def areas_of(inputs: AccessInputs) -> AccessibilityAreas:
    """Return what the tool reaches in the plane."""
    report = accessibility_area(
        inputs.rivets.points,
        inputs.obstacles,
        inputs.tool,
        inputs.rules,
        part=inputs.part,
        space=inputs.space,
    )
    return AccessibilityAreas(
        summary=_totals(AccessSummary.of(report.rivets)),
        findings=_findings(inputs),
        pattern=_pattern(inputs.rivets),
        rivets=_rivets(inputs.rivets.ids, report.rivets),
        default=_division(report.default),
        any_angle=_division(report.turned),
    )


def volumes_of(inputs: AccessInputs) -> AccessibilityVolumes:
    """Return what the tool reaches in space."""
    scene: FlatScene | CurvedScene
    if inputs.curvature is None:
        scene = FlatScene(inputs.obstacles, inputs.tool, inputs.rules, inputs.space)
    else:
        scene = CurvedScene(inputs.obstacles, inputs.tool, inputs.rules, inputs.curvature)
    reached = reach_of(inputs.rivets.points, scene, inputs.rules)
    return AccessibilityVolumes(
        summary=_totals(AccessSummary.of(reached)),
        findings=_findings(inputs),
        pattern=_pattern(inputs.rivets),
        rivets=_rivets(inputs.rivets.ids, reached),
        projections=_projections(inputs),
    )


def _findings(inputs: AccessInputs) -> list[AccessFinding]:
    found = []
    if inputs.space is not None and is_larger_than(inputs.space, inputs.tool, inputs.rules):
        found.append(
            AccessFinding(
                code="tool_larger_than_space",
                text="The tool fits nowhere in the space, at none of the angles.",
                remedy="Take a smaller tool or safety zone, or correct the space.",
            )
        )
    misfit = inputs.rivets.pattern
    if isinstance(misfit, DoesNotFit):
        lengths = f"{_mm(misfit.needs):g} mm are needed, {_mm(misfit.has):g} mm are there"
        found.append(
            AccessFinding(
                code="rows_do_not_fit",
                text=f"No row fits: {misfit.reason}; {lengths}.",
                remedy="Make the part wider, or give the rivets one by one.",
            )
        )
    return found


def _totals(summary: AccessSummary) -> AccessTotals:
    percent = summary.percent
    return AccessTotals(
        direct=summary.direct,
        rotated=summary.rotated,
        inaccessible=summary.inaccessible,
        accomplished=summary.accomplished,
        total=summary.total,
        percent=None if percent is None else round(percent, 4),
        status=summary.status,
        access_class=summary.access_class,
    )


def _pattern(rivets: Rivets) -> RowPattern | None:
    size, pattern = rivets.size, rivets.pattern
    if size is None or not isinstance(pattern, Pattern):
        return None
    return RowPattern(
        diameter_mm=_mm(size.diameter),
        needed_length_mm=_mm(size.length_raw),
        length_mm=_mm(size.length),
        rows=pattern.row_count,
        per_row=pattern.spacing.count,
        side_mm=_mm(pattern.spacing.side),
        pitch_mm=_mm(pattern.spacing.pitch),
    )


def _rivets(ids: Sequence[str], reached: Sequence[RivetReach]) -> list[RivetAccess]:
    return [
        RivetAccess(
            id=name,
            x_mm=_mm(rivet.x),
            y_mm=_mm(rivet.y),
            status=rivet.status,
            angle_deg=None if rivet.angle is None else _degrees(rivet.angle),
            tip_blocked_by=_blocked_by(rivet.tip_blockers),
            attempts=[
                AngleTried(angle_deg=_degrees(each.angle), blocked_by=_blocked_by(each.blockers))
                for each in rivet.attempts
            ],
        )
        for name, rivet in zip(ids, reached, strict=True)
    ]


def _blocked_by(blockers: Sequence[Blocker]) -> list[BlockedBy]:
    return [BlockedBy(obstacle=name, gap_mm=math.floor(gap * _MM * 1e4) / 1e4) for name, gap in blockers]


def _division(areas: AccessAreas) -> AreaDivision:
    return AreaDivision(
        space=_region(areas.space),
        obstacles=_region(areas.obstacles),
        safety=_region(areas.safety),
        inaccessible=_region(areas.inaccessible),
        accessible=_region(areas.accessible),
        positions=_region(areas.positions),
    )


def _region(geometry: shapely.Geometry) -> AreaRegion:
    return AreaRegion(area_mm2=round(geometry.area * _MM**2, 3), polygons=_polygons(geometry))


def _polygons(geometry: shapely.Geometry) -> list[AreaPolygon]:
    """The polygons of a region in an order that hangs on nothing but their places."""
    parts = shapely.get_parts(shapely.normalize(geometry))
    return [
        AreaPolygon(outer_mm=_ring(part.exterior), holes_mm=[_ring(hole) for hole in part.interiors])
        for part in parts
        if part.geom_type == "Polygon" and not part.is_empty
    ]


def _ring(ring: shapely.LinearRing) -> list[list[float]]:
    return [[_mm(x), _mm(y)] for x, y in shapely.get_coordinates(ring)[:-1]]


def _projections(inputs: AccessInputs) -> list[SolidOutlines]:
    assert inputs.part is not None
    solids = [("part", (inputs.part,)), *((each.name, each.boxes) for each in inputs.obstacles)]
    solids += [("tool", (inputs.tool.body_at(rivet),)) for rivet in inputs.rivets.points[:1]]
    return [
        SolidOutlines(id=name, **{view: _seen(boxes, view) for view in get_args(View)})
        for name, boxes in solids
    ]


def _seen(boxes: Sequence[Box], view: View) -> list[AreaPolygon]:
    return _polygons(shapely.union_all([outline(box, view) for box in boxes]))


def _mm(length: float) -> float:
    """In mm, to 1 nm; never -0.0."""
    return round(float(length) * _MM, 6) + 0.0


def _degrees(angle: float) -> float:
    return round(math.degrees(angle), 6)
