"""Remedies at the fastener itself: its axis tilted, or its place moved along its row."""

from __future__ import annotations

import math
from functools import partial
from itertools import product

from robots.access.remedy import Remedy, Tried
from robots.access.remedy_case import COARSE, PER_MM, ROUNDING, Case, first_success
from robots.access.smallest import Outcome, Patience, Success, smallest
from robots.access.trials import Trial
from robots.definition_file import meters
from robots.dies import Die
from robots.panel import Fastener, Panel, Stack

_PER_DEGREE = 20
"""Amounts of a degree that are told apart."""

_ROWS_RUN: dict[str, tuple[str, ...]] = {"stringer": ("x",), "frame": ("arc",), "clip": ("arc",)}
"""Where the rows of a kind of part run; those of sheets and of other parts run both ways."""

Direction = tuple[int, int]
"""Senses along x and arc, each -1, 0 or 1."""

_TOWARDS: tuple[Direction, ...] = tuple(each for each in product((0, 1, -1), (0, 1, -1)) if any(each))


def tilts(case: Case) -> tuple[list[Remedy], Tried]:
    """The smallest tilt, towards the axes of the skin or between them, for each die."""
    limit = math.radians(case.shop.limits.tilt_deg)
    most = int(case.shop.limits.tilt_deg * _PER_DEGREE + ROUNDING)
    found = []
    for die in case.usable:
        each: list[tuple[float, Direction, int, Success]] = []
        patience = Patience()
        for towards in _TOWARDS:
            tilted = smallest(partial(_tilted, case, die, towards), 1, most, patience)
            if tilted is not None:
                each.append((_lean(towards, tilted[0]), towards, *tilted))
        if each:
            lean, towards, amount, success = min(each, key=lambda one: one[0])
            trial = _tilt(case, towards, amount)
            if trial is not None:
                found.append(case.remedy("tilt", case.fastener.id, _told(towards), lean, success, trial.edit))
    return found, Tried("tilt", tuple(die.id for die in case.usable), limit, len(found))


def _tilted(case: Case, die: Die, towards: Direction, amount: int) -> Outcome:
    trial, trials = _tilt(case, towards, amount), case.shop.trials
    limit = math.radians(case.shop.limits.tilt_deg)
    # One that leans farther already, as the document has it, may lean less.
    if trial is None or trials.lean(trial.fastener) > max(limit, trials.lean(case.fastener)) + ROUNDING:
        return Outcome()
    return case.asked(case.shop.desk.at(die)[0], trial.fastener, trial.stack)


def _tilt(case: Case, towards: Direction, amount: int) -> Trial | None:
    x, arc = (sense * amount / _PER_DEGREE for sense in towards)
    return case.shop.trials.trial(case.index, tilt_x_deg=x, tilt_arc_deg=arc)


def _lean(towards: Direction, amount: int) -> float:
    """How far the axis is turned by both tilts together [rad]."""
    return math.atan(math.hypot(*towards) * math.tan(math.radians(amount / _PER_DEGREE)))


def moves(case: Case) -> tuple[list[Remedy], Tried]:
    """The smallest move each way along the row after which one of the dies reaches the fastener."""
    limit_mm = case.shop.limits.move_mm
    found = []
    for towards in ways(case.fastener, case.access.stack, case.shop.desk.panel):
        moved = smallest(partial(_moved, case, towards), COARSE, int(limit_mm * PER_MM + ROUNDING))
        trial = None if moved is None else _move(case, towards, moved[0])
        if moved is not None and trial is not None:
            amount, success = moved
            by = meters(amount / PER_MM)
            found.append(
                case.remedy("move_fastener", case.fastener.id, _told(towards), by, success, trial.edit)
            )
    dies = tuple(die.id for die in case.usable)
    return found, Tried("move_fastener", dies, meters(limit_mm), len(found))


def ways(fastener: Fastener, stack: Stack, panel: Panel) -> list[Direction]:
    """Where a fastener may be moved: along the rows of its row's member, else of the innermost part that it
    joins.
    """
    axes = _ROWS_RUN.get(panel.part(fastener.member or stack.parts[-1]).kind, ("x", "arc"))
    return [(sense, 0) if axis == "x" else (0, sense) for axis in axes for sense in (1, -1)]


def _moved(case: Case, towards: Direction, amount: int) -> Outcome:
    trial = _move(case, towards, amount)
    if trial is None:
        return Outcome()
    return first_success(
        case.asked(case.shop.desk.at(die)[0], trial.fastener, trial.stack) for die in case.usable
    )


def _move(case: Case, towards: Direction, amount: int) -> Trial | None:
    x, arc = (sense * amount / PER_MM for sense in towards)
    return case.shop.trials.trial(case.index, x_mm=x, arc_mm=arc)


def _told(towards: Direction) -> str:
    return "".join(
        f"{'+' if sense > 0 else '-'}{axis}"
        for sense, axis in zip(towards, ("x", "arc"), strict=True)
        if sense
    )
