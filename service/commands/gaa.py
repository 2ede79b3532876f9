"""`rivetplan gaa` and `rivetplan gav`: which rivets a tool reaches among boxes, in the plane and in space."""

from collections.abc import Iterator
from pathlib import Path

from service.area_answer import areas_of, volumes_of
from service.area_inputs import access_inputs
from service.area_schemas import (
    AccessibilityAreas,
    AccessibilityVolumes,
    AccessTotals,
    AreaRequest,
    BlockedBy,
    RivetAccess,
    VolumeRequest,
)
from service.canonical import canonical_json
from service.commands.plan import check_target, write
from service.commands.reading import as_lines, read_request
from service.summary import ACCESS_CLASSES, Row
from service.terminal import print_rows, print_table

_HEAD = ("rivet", "x mm", "y mm", "status", "angle", "blocked by")


def gaa(file: Path, out: Path | None, *, quiet: bool) -> bool:
    """Print, and write to `out`, what the tool of a request file reaches in the plane.

    Returns whether tool and rows fit at all; single rivets out of reach are in the table. Raises Unusable.
    """
    _refuse_target(file, out)
    request = read_request(file, AreaRequest)
    with as_lines(f"{file}#"):
        found = areas_of(access_inputs(request))
    return _publish(file, found, out, quiet=quiet)


def gav(file: Path, out: Path | None, *, quiet: bool) -> bool:
    """The same in space."""
    _refuse_target(file, out)
    request = read_request(file, VolumeRequest)
    with as_lines(f"{file}#"):
        found = volumes_of(access_inputs(request))
    return _publish(file, found, out, quiet=quiet)


def _refuse_target(file: Path, out: Path | None) -> None:
    if out is not None:
        check_target(out, {file: "the request"}, "the answer")


def _publish(
    file: Path, found: AccessibilityAreas | AccessibilityVolumes, out: Path | None, *, quiet: bool
) -> bool:
    if out is not None:
        write(out, canonical_json(found))
    if not quiet:
        print_table(f"{file}", _HEAD, [_rivet_row(rivet) for rivet in found.rivets])
        print_rows("accessibility", [*_total_rows(found.summary), *_area_rows(found)])
        for finding in found.findings:
            print(f"{finding.code}: {finding.text} {finding.remedy}")
    return not found.findings


def _rivet_row(rivet: RivetAccess) -> tuple[str, ...]:
    angle = "-" if rivet.angle_deg is None else f"{rivet.angle_deg:g}"
    return rivet.id, f"{rivet.x_mm:.2f}", f"{rivet.y_mm:.2f}", rivet.status, angle, _in_the_way(rivet)


def _in_the_way(rivet: RivetAccess) -> str:
    """What blocks the tip, or else the default angle; and every angle tried after it, by the same words."""
    if rivet.tip_blocked_by:
        return f"tip: {_names(rivet.tip_blocked_by)}"
    spans: list[tuple[str, float, float]] = []
    for attempt in rivet.attempts:
        names = _names(attempt.blocked_by)
        first = spans.pop()[1] if spans and spans[-1][0] == names else attempt.angle_deg
        spans.append((names, first, attempt.angle_deg))
    return "; ".join(
        f"{first:g}: {names}" if first == last else f"{first:g}-{last:g}: {names}"
        for names, first, last in spans
        if names
    )


def _names(blockers: list[BlockedBy]) -> str:
    return ", ".join(blocker.obstacle for blocker in blockers)


def _total_rows(totals: AccessTotals) -> Iterator[Row]:
    yield "rivets", f"{totals.total}"
    yield "  accomplished", f"{totals.accomplished}"
    yield "    direct", f"{totals.direct}"
    yield "    at another angle", f"{totals.rotated}"
    yield "  inaccessible", f"{totals.inaccessible}"
    yield "percentage", "-" if totals.percent is None else f"{totals.percent:.2f} %"
    yield "status", totals.status
    yield "class", ACCESS_CLASSES[totals.access_class]


def _area_rows(found: AccessibilityAreas | AccessibilityVolumes) -> Iterator[Row]:
    if isinstance(found, AccessibilityAreas):
        yield "areas in mm2, default orientation", ""
        for name in ("space", "obstacles", "safety", "inaccessible", "accessible"):
            yield f"  {name}", f"{getattr(found.default, name).area_mm2:.1f}"
        yield "  accessible at any angle", f"{found.any_angle.accessible.area_mm2:.1f}"
