"""Remedies in words, in mm and degrees, and as changes of the input documents."""

from __future__ import annotations

from robots.access.remedy import Remedies, Remedy, RemedyKind, Tried
from robots.access.remedy_edits import AddDie, Adjust, Edit, ShiftClip, UseDie, told_unbind
from service.access_schemas import AccessRemedy, FastenerRemedies, RemedyEdit, RemedyTried
from service.report_digits import clearance_mm, degrees, millimetres

_WORDS: dict[RemedyKind, str] = {
    "other_die": "use die {subject}",
    "tilt": "tilt the axis of {subject} by {amount} towards {direction}",
    "move_fastener": "move {subject} by {amount} towards {direction}",
    "shift_clip": "shift clip {subject} by {amount} towards {direction}",
    "lower_die": "make die {subject} {amount} lower under its tip",
    "narrower_die": "make {subject} {amount} narrower",
}


def remedies_told(remedies: Remedies) -> FastenerRemedies:
    """What would help at one fastener, and what was looked through, in the order it was found."""
    return FastenerRemedies(
        found=[_remedy(each) for each in remedies.found], tried=[_tried(each) for each in remedies.tried]
    )


def _remedy(remedy: Remedy) -> AccessRemedy:
    gap = remedy.clearance
    return AccessRemedy(
        kind=remedy.kind,
        text=_text(remedy),
        subject=remedy.subject,
        direction=remedy.direction,
        amount_mm=_length(remedy.kind, remedy.amount),
        amount_deg=_tilt(remedy.kind, remedy.amount),
        die=remedy.die_id,
        angle_deg=degrees(remedy.die_angle),
        solid=gap.solid,
        part=gap.other,
        clearance_mm=clearance_mm(gap.gap),
        needs_mm=millimetres(gap.needed),
        edit=_edit(remedy.edit),
    )


def _tried(tried: Tried) -> RemedyTried:
    return RemedyTried(
        kind=tried.kind,
        subjects=list(tried.subjects),
        limit_mm=_length(tried.kind, tried.limit),
        limit_deg=_tilt(tried.kind, tried.limit),
        found=tried.found,
        skipped=tried.skipped,
    )


def _length(kind: RemedyKind, amount: float) -> float | None:
    return None if kind in ("other_die", "tilt") else millimetres(amount)


def _tilt(kind: RemedyKind, amount: float) -> float | None:
    return degrees(amount) if kind == "tilt" else None


def _text(remedy: Remedy) -> str:
    amount = (
        f"{degrees(remedy.amount):g} deg" if remedy.kind == "tilt" else f"{millimetres(remedy.amount):g} mm"
    )
    angle = f"{degrees(remedy.die_angle):.0f} deg"
    change = _WORDS[remedy.kind].format(subject=remedy.subject, amount=amount, direction=remedy.direction)
    gap = remedy.clearance
    with_die = "" if isinstance(remedy.edit, UseDie | AddDie) else f" with die {remedy.die_id}"
    return (
        f"{change}: reached{with_die} at {angle}; then {gap.solid} and {gap.other} are "
        f"{clearance_mm(gap.gap):.2f} mm apart, {millimetres(gap.needed):.2f} mm are needed"
    )


def _edit(edit: Edit) -> RemedyEdit:
    match edit:
        case Adjust():
            return RemedyEdit(adjustment=edit.entry())
        case ShiftClip():
            return RemedyEdit(clip=edit.clip, arc_mm=edit.arc_mm)
        case UseDie():
            return RemedyEdit(die=edit.die_id, unbind=told_unbind(edit.unbind) or None)
        case AddDie():
            return RemedyEdit(new_die=dict(edit.definition), unbind=told_unbind(edit.unbind) or None)
