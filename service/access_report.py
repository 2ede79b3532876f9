"""The accessibility of a panel as a report: status, die, free angles and reason of every fastener."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import cast

from planners.arrays import Array
from robots.access.panel_access import FastenerAccess, Hindrance, PanelAccess, joining, part_of
from robots.access.reach import DieReach
from robots.access.remedy import Remedies
from robots.nc_codec import rounded
from robots.panel import Fastener
from robots.stations import Refusal
from service import __version__
from service.access_overview import overview
from service.access_schemas import (
    AccessReason,
    CheckInputs,
    DieAccess,
    DiesIdentity,
    FastenerAccessibility,
    InputIdentity,
    PanelAccessibility,
    ReasonCode,
    RemedySearch,
)
from service.reasons import reason_for
from service.remedy_report import remedies_told
from service.report_digits import degrees


def accessibility_report(access: PanelAccess, remedies: Mapping[str, Remedies]) -> PanelAccessibility:
    """What was found, in mm and degrees with the digits of a program.

    remedies: those that were searched, by the fastener's id.
    """
    panel, machine = access.panel, access.machine
    return PanelAccessibility(
        planner_version=__version__,
        inputs=CheckInputs(
            panel=InputIdentity(id=panel.id, sha256=panel.sha256),
            machine=InputIdentity(id=machine.id, sha256=machine.sha256),
            dies=DiesIdentity(ids=[die.id for die in access.dies], sha256=machine.dies.sha256),
        ),
        summary=overview(access),
        remedies=RemedySearch(
            searched=len(remedies),
            inaccessible=sum(each.status == "inaccessible" for each in access.fasteners),
        ),
        fasteners=[_fastener(each, access, remedies.get(each.fastener.id)) for each in access.fasteners],
    )


def _fastener(found: FastenerAccess, access: PanelAccess, remedies: Remedies | None) -> FastenerAccessibility:
    fastener, chosen = found.fastener, found.chosen
    any_angle = {die.id for die in access.dies if die.axisymmetric}
    refusals = {
        die_id: _refusal(die_id, each, any_angle=die_id in any_angle) for die_id, each in found.hindrances
    }
    least = min(refusals.values(), key=lambda refusal: refusal.lack, default=None)
    return FastenerAccessibility(
        id=fastener.id,
        part=part_of(found, access.panel),
        joining=joining(found, access.panel),
        status=found.status,
        die=None if chosen is None else chosen.angles.die_id,
        angle_deg=None if chosen is None else _angle(chosen),
        turned_deg=None if chosen is None else degrees(chosen.turned),
        reason=_reason(fastener, least) if chosen is None else None,
        dies=[_die(fastener, reach, refusals.get(reach.angles.die_id)) for reach in found.reaches],
        remedies=None if remedies is None else remedies_told(remedies),
    )


def _die(fastener: Fastener, reach: DieReach, refusal: Refusal | None) -> DieAccess:
    return DieAccess(
        die=reach.angles.die_id,
        default_deg=degrees(math.remainder(reach.default, 2.0 * math.pi)),
        fits_deg=_intervals(reach.angles.fits),
        roomy_deg=_intervals(reach.angles.roomy),
        reached=reach.ok,
        angle_deg=_angle(reach),
        turned_deg=degrees(reach.turned) if reach.ok else None,
        reason=None if refusal is None else _reason(fastener, refusal),
    )


def _refusal(die_id: str, hindrance: Hindrance, *, any_angle: bool) -> Refusal:
    """The hindrance as a program knows it, so that both tell it in the same words."""
    return Refusal(
        die_id,
        out_of_limits=hindrance.out_of_limits,
        blockage=hindrance.blockage,
        die_angle=None if any_angle else hindrance.angle,
        no_path=hindrance.no_path,
    )


def _reason(fastener: Fastener, refusal: Refusal | None) -> AccessReason:
    """The reason in words; without a refusal none of the dies may be used there."""
    told = rounded(reason_for(fastener, [] if refusal is None else [refusal])[1])
    angle = None if refusal is None else refusal.die_angle
    beyond = None if told.value is None or told.limit is None else round(abs(told.value - told.limit), 6)
    return AccessReason(
        code=cast("ReasonCode", told.code),
        text=told.text,
        die=None if refusal is None else refusal.die_id,
        solid=told.solid,
        part=told.part,
        gap_mm=told.clearance_mm,
        needs_mm=told.needs_mm,
        angle_deg=None if angle is None else degrees(angle),
        axis=told.axis,
        value=told.value,
        limit=told.limit,
        beyond=beyond,
    )


def _angle(reach: DieReach) -> float | None:
    return None if reach.station is None else degrees(reach.station.die_angle)


def _intervals(intervals: Array) -> list[list[float]]:
    return [[degrees(low), degrees(high)] for low, high in intervals.tolist()]
