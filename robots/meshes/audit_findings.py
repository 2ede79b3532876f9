"""What the figures of an audit mean, and what to do about it; why which is an error is said in `audit`."""

from __future__ import annotations

from collections.abc import Iterator

from robots.meshes.audit_record import Audit, Finding

_FOIL = 1e-4
"""[m] Walls thinner than this are no sheet metal, rather a wrong unit or a folded surface."""

_RANK = {"error": 0, "warning": 1, "note": 2}


def findings_of(audit: Audit) -> tuple[Finding, ...]:
    """Everything against a body, errors first."""
    found = [*_edges(audit), *_triangles(audit), *_crossings(audit), *_sizes(audit), *_skin(audit)]
    return tuple(sorted(found, key=lambda finding: _RANK[finding.severity]))  # stable


def _edges(audit: Audit) -> Iterator[Finding]:
    rim = audit.boundary
    if rim.edges:
        rims = "one rim" if rim.rims == 1 else f"{rim.rims} rims, the longest {_mm(rim.longest)}"
        message = f"it is not closed: {counted(rim.edges, 'open edge')}, {_mm(rim.length)} in all, in {rims}"
        if rim.split:
            what = "corner lies" if rim.split == 1 else "corners lie"
            message += f"; {rim.split} {what} upon another open edge"
        remedy = "Export a closed solid; or --fix merge where gaps are tiny, --fix fill where holes are flat."
        yield Finding("open_edges", "error", message, rim.edges, rim.where, remedy)
    if audit.crowded:
        message = f"more than two triangles meet at {counted(audit.crowded.count, 'edge')}"
        remedy = "Export each solid as a body of its own, with a gap or united."
        if audit.duplicates:
            remedy = "Use --fix drop, which drops faces that are there twice."
        yield Finding("crowded_edges", "error", message, audit.crowded.count, audit.crowded.where, remedy)
    if audit.twisted:
        message = f"triangles face opposite ways at {counted(audit.twisted.count, 'edge')}"
        remedy = "Use --fix orient."
        if audit.one_sided:
            message += ", and the surface has one side only, as a Mobius strip"
            remedy = "Export a solid: no turning of triangles gives this surface an inside."
        yield Finding("twisted_edges", "error", message, audit.twisted.count, audit.twisted.where, remedy)
    if audit.volume is not None and audit.volume < 0.0:
        message = "it is inside out: its triangles face inwards"
        yield Finding("inside_out", "error", message, audit.triangles, None, "Use --fix orient.")
    elif audit.inverted:
        message = f"{counted(audit.inverted.count, 'closed piece')} inside out, and no cavity of another"
        place = audit.inverted.where
        yield Finding("piece_inside_out", "error", message, audit.inverted.count, place, "Use --fix orient.")


def _triangles(audit: Audit) -> Iterator[Finding]:
    if audit.repeated:
        message = f"{counted(audit.repeated.count, 'triangle')} with a corner twice"
        place = audit.repeated.where
        yield Finding("repeated_corner", "error", message, audit.repeated.count, place, "Use --fix drop.")
    if audit.flat:
        message = f"{counted(audit.flat.count, 'triangle')} without area"
        remedy = "Use --fix drop, which drops those that close nothing; the others do no harm."
        yield Finding("flat_triangles", "warning", message, audit.flat.count, audit.flat.where, remedy)
    if audit.slivers:
        message = f"{counted(audit.slivers.count, 'triangle')} lower than a micrometre"
        remedy = "Nothing need be done: they are collided with as they are."
        yield Finding("slivers", "note", message, audit.slivers.count, audit.slivers.where, remedy)
    if audit.duplicates:
        message = f"{counted(audit.duplicates.count, 'triangle')} on the corners of another"
        remedy = "Use --fix drop, which drops those that face the same way."
        place = audit.duplicates.where
        yield Finding("duplicate_triangles", "warning", message, audit.duplicates.count, place, remedy)


def _crossings(audit: Audit) -> Iterator[Finding]:
    if audit.crossing:
        message = f"{counted(audit.crossing.count, 'pair')} of crossing triangles, {_mm(audit.depth)} deep"
        remedy = "Unite the solids, or export them as bodies of their own. Collisions are right as it is."
        place = audit.crossing.where
        yield Finding("self_intersections", "warning", message, audit.crossing.count, place, remedy)
    upon = audit.overlapping
    if upon and not audit.duplicates:
        message = f"{counted(upon.count, 'pair')} of triangles upon each other in one plane"
        remedy = "Unite solids that touch. Collisions are right as it is."
        yield Finding("overlapping_triangles", "warning", message, upon.count, upon.where, remedy)
    if not audit.searched or (audit.skin is not None and not audit.skin.searched):
        message = "so many triangles lie in one place that not all were searched for passing through others"
        remedy = "Export with a coarser tolerance, or divide the body."
        yield Finding("too_crowded", "warning", message, audit.triangles, None, remedy)


def _sizes(audit: Audit) -> Iterator[Finding]:
    thick = audit.thickness
    if thick is not None and thick.least < _FOIL:
        message = f"its wall is {_mm(thick.least)} thick at the thinnest place found"
        remedy = "See whether the unit is right, and whether the wall is modelled as a solid."
        yield Finding("thin_wall", "warning", message, 1, thick.where, remedy)
    if audit.pieces > 1:
        message = f"it is {audit.pieces} pieces that have no edge in common"
        remedy = "Nothing need be done where they are meant to be one part."
        yield Finding("several_pieces", "note", message, audit.pieces, None, remedy)


def _skin(audit: Audit) -> Iterator[Finding]:
    near = audit.skin
    if near is None:
        return
    if near.crossing:
        message = f"{counted(near.crossing, 'triangle')} through the skin, up to {_mm(near.depth)} deep"
        remedy = "See whether the part is where it belongs."
        if near.depth <= audit.deviation:
            remedy = f"Nothing need be done: both surfaces are only true to {_mm(audit.deviation)}."
        yield Finding("through_skin", "warning", message, near.crossing, near.where, remedy)
    elif near.inside:
        message, remedy = "it is within the skin's material", "See whether the part is where it belongs."
        yield Finding("within_skin", "warning", message, 1, near.where, remedy)
    elif near.distance > audit.deviation + _FOIL:
        message = f"it does not touch the skin: it is {_mm(near.distance)} away at the nearest place"
        remedy = "Nothing need be done where it stands on another part."
        yield Finding("off_skin", "note", message, 1, near.where, remedy)


def counted(count: int, what: str, many: str = "") -> str:
    """A number and what it counts: `many` where that is not `what` with an s."""
    return f"{count} {what}" if count == 1 else f"{count} {many or what + 's'}"


def _mm(length: float) -> str:
    return f"{1000.0 * length:.4g} mm"
