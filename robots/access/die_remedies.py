"""Remedies at the die: another one of the library, or one that is made of those there are."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from robots.access.die_changes import Definition
from robots.access.remedy import Remedy, RemedyKind, Tried
from robots.access.remedy_case import COARSE, PER_MM, ROUNDING, Case
from robots.access.remedy_edits import AddDie, UseDie
from robots.access.smallest import Outcome, Success, smallest, smallest_of_easing
from robots.cell import Cell
from robots.definition_file import meters
from robots.shape_file import SMALLEST_MM

Change = Callable[[float], Definition]
"""A die's definition, changed by an amount [mm]."""


def other_dies(case: Case) -> tuple[list[Remedy], Tried]:
    """Every other die of the library that reaches the fastener."""
    usable = {die.id for die in case.usable}
    others = [die for die in case.shop.desk.machine.dies if die.id not in usable]
    found = []
    for die in others:
        success = case.asked(case.shop.desk.at(die)[0]).success
        if success is not None:
            unbind = () if case.fastener.die == die.id else case.shop.binding(case.fastener)
            found.append(case.remedy("other_die", die.id, "", 0.0, success, UseDie(die.id, unbind)))
    skipped = "" if others else "every die of the library was asked about"
    return found, Tried("other_die", tuple(die.id for die in others), 0.0, len(found), skipped)


def lower(case: Case) -> tuple[list[Remedy], Tried]:
    """Each die with the longer tip that it needs, all else of it lower."""
    limit_mm, changes = case.shop.limits.lower_mm, case.shop.changes
    found = []
    for die in case.usable:
        change = partial(changes.lowered, die.id)
        changed = smallest(partial(_asked, case, change), COARSE, int(limit_mm * PER_MM + ROUNDING))
        if changed is not None:
            found.append(_remedy(case, "lower_die", die.id, change, *changed))
    return found, Tried("lower_die", tuple(die.id for die in case.usable), meters(limit_mm), len(found))


def narrower(case: Case) -> tuple[list[Remedy], Tried]:
    """Each die with one solid narrower: the one of which least must be taken off."""
    share, changes = case.shop.limits.narrower, case.shop.changes
    found, subjects, widest = [], [], 0.0
    for die in case.usable:
        each: list[tuple[int, str, Change, Success]] = []
        for solid, width_mm in changes.widths(die.id).items():
            subjects.append(f"{die.id}.{solid}")
            most_mm = min(share * width_mm, width_mm - 2.0 * SMALLEST_MM)
            widest = max(widest, most_mm)
            change: Change = partial(changes.narrowed, die.id, solid)
            # What is left of the die is a part of what it was: it fits wherever the die did.
            most = int(most_mm * PER_MM + ROUNDING)
            changed = smallest_of_easing(partial(_asked, case, change), most)
            if changed is not None:
                each.append((changed[0], subjects[-1], change, changed[1]))
        if each:
            amount, subject, change, success = min(each, key=lambda one: one[0])
            found.append(_remedy(case, "narrower_die", subject, change, amount, success))
    return found, Tried("narrower_die", tuple(subjects), meters(widest), len(found))


def _asked(case: Case, change: Change, amount: int) -> Outcome:
    desk = case.shop.desk
    die = case.shop.changes.built(change(amount / PER_MM))
    return Outcome() if die is None else case.asked(Cell(desk.machine, die, desk.panel))


def _remedy(
    case: Case, kind: RemedyKind, subject: str, change: Change, amount: int, success: Success
) -> Remedy:
    mm = amount / PER_MM
    edit = AddDie(change(mm), case.shop.binding(case.fastener))
    return case.remedy(kind, subject, "", meters(mm), success, edit)
