"""`rivetplan pattern` and `rivetplan calibrate`: a request in, a table out, and files where asked for."""

import csv
import io
from pathlib import Path

from service.calibration import calibrated
from service.canonical import canonical_json
from service.commands.plan import check_target, write
from service.commands.reading import as_lines, read_request
from service.pattern_schemas import Calibrated, CalibrationRequest, RivetPattern, RivetPatternRequest
from service.rivet_pattern import rivet_pattern
from service.summary import Row
from service.terminal import print_rows


def pattern(file: Path, *, out: Path | None, points: Path | None, quiet: bool) -> bool:
    """Print a rivet pattern and write what is asked for; return whether it fits.

    out: the whole answer as JSON. points: its rivets as CSV. Raises Unusable.
    """
    _check_targets(file, (out, "the answer"), (points, "the table of rivets"))
    request = read_request(file, RivetPatternRequest)
    with as_lines(f"{file}#"):
        found = rivet_pattern(request)
    if out is not None:
        write(out, canonical_json(found))
    if points is not None:
        write(points, _csv(found))
    if not quiet:
        print_rows(f"{file}", _pattern_rows(found))
    return found.status == "ok"


def calibrate(file: Path, *, out: Path | None, quiet: bool) -> bool:
    """Print a calibration, and write it to `out`; return whether every point fits. Raises Unusable."""
    _check_targets(file, (out, "the answer"))
    request = read_request(file, CalibrationRequest)
    with as_lines(f"{file}#"):
        found = calibrated(request)
    if out is not None:
        write(out, canonical_json(found))
    if not quiet:
        print_rows(f"{file}", _calibration_rows(found))
    return found.status == "ok"


def _check_targets(request_file: Path, *targets: tuple[Path | None, str]) -> None:
    taken = {request_file: "the request"}
    for target, what in targets:
        if target is not None:
            check_target(target, taken, what)
            taken[target] = what


def _pattern_rows(found: RivetPattern) -> list[Row]:
    size, lack, spacing, patch = found.size, found.lack, found.spacing, found.patch
    rows = [
        ("status", found.status),
        ("designation", size.designation or "none: not rounded to the standard's grid"),
        ("diameter", _sized(size.diameter_mm, size.diameter_raw_mm, size.diameter_32nds_in, 32)),
        ("length", _sized(size.length_mm, size.length_raw_mm, size.length_16ths_in, 16)),
    ]
    arcs = (("section", found.curvature.section), ("length", found.curvature.length))
    rows += [(f"radius of the {name}", f"{arc.radius_mm:.3f} mm") for name, arc in arcs if arc is not None]
    if lack is not None:
        rows += [
            ("reason", lack.reason),
            ("  needs", f"{lack.needs_mm:.3f} mm"),
            ("  has", f"{lack.has_mm:.3f} mm"),
        ]
    if spacing is not None:
        rows += [
            ("rivets", f"{found.total} in {spacing.rows} row(s) of up to {spacing.per_row}"),
            ("side distance", f"{spacing.side_mm:.3f} mm"),
            ("pitch", f"{spacing.pitch_mm:.3f} mm"),
        ]
        if spacing.least_row_distance_mm is not None:
            rows.append(("row distance", f"{spacing.least_row_distance_mm:.3f} mm"))
    if patch is not None:
        each = f"{patch.per_side}: {patch.load_bearing} load-bearing, {patch.redundant} redundant"
        rows += [("required a side", f"{patch.required}"), ("rivets a side", each)]
    return rows + [("note", note) for note in found.notes]


def _sized(value_mm: float, raw_mm: float, steps: int | None, parts: int) -> str:
    """Say a size and where it comes from: nothing is rounded silently."""
    if steps is None:
        return f"{value_mm:.4f} mm, not rounded"
    return f"{steps}/{parts} in = {value_mm:.4f} mm, up from {raw_mm:.4f} mm"


def _calibration_rows(found: Calibrated) -> list[Row]:
    euler = found.euler
    angles = f"{euler.A_deg:.6f}, {euler.B_deg:.6f}, {euler.C_deg:.6f} deg"
    gimbal = " (gimbal: C put to 0)" if euler.gimbal else ""
    return [
        ("status", found.status),
        ("translation", ", ".join(f"{part:.4f}" for part in found.translation_mm) + " mm"),
        ("A, B, C about x, y, z", angles + gimbal),
        ("quaternion", ", ".join(f"{part:.9f}" for part in found.quaternion)),
        ("largest residual", f"{found.largest_residual_mm:.6f} mm, {found.tolerance_mm:g} mm allowed"),
        *((f"  point {n}", f"{each:.6f} mm") for n, each in enumerate(found.residuals_mm, 1)),
    ]


def _csv(found: RivetPattern) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["id", "row", "x_mm", "y_mm", "z_mm", "nx", "ny", "nz"])
    for rivet in found.rivets:
        places = [f"{part:.6f}" for part in rivet.position_mm]
        writer.writerow([rivet.id, rivet.row, *places, *(f"{part:.9f}" for part in rivet.tool_normal)])
    return text.getvalue().encode()
