"""What a remedy is: one change, how far it goes, and what was looked through to find it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from robots.access.remedy_edits import Edit
from robots.cell import Blockage

RemedyKind = Literal["other_die", "tilt", "move_fastener", "shift_clip", "lower_die", "narrower_die"]


@dataclass(frozen=True)
class Limits:
    """How far a remedy may go, in the units of the documents.

    tilt_deg: between tool axis and skin normal, the normality that machines keep (Electroimpact: 0.4 after
    correction). move_mm: of the fastener along its row. clip_mm: of the clip along its frame. lower_mm: of
    what is under the die's tip. narrower: share of a die solid's width.
    """

    tilt_deg: float = 0.4
    move_mm: float = 25.0
    clip_mm: float = 30.0
    lower_mm: float = 20.0
    narrower: float = 0.5


@dataclass(frozen=True)
class Remedy:
    """One change after which the fastener is reached.

    subject: what changes: the fastener, the clip, the die, or "<die>.<solid>". direction: "+x", "-x", "+arc",
    "-arc" or two of them; empty for dies. amount: [m] or, of a tilt, the angle of the axis [rad]; 0 for
    another die. die_id, die_angle [rad]: with which it is then reached. clearance: of the pair that has least
    to spare in the process there. edit: how to apply it (`remedy_edits`).
    """

    kind: RemedyKind
    subject: str
    direction: str
    amount: float
    die_id: str
    die_angle: float
    clearance: Blockage
    edit: Edit


@dataclass(frozen=True)
class Tried:
    """What was looked through for one kind of remedy.

    subjects: with which dies, of which clip, or of which solids. limit: up to what amount [m] or [rad].
    found: how many remedies came of it. skipped: why nothing of the kind was tried, empty where it was.
    """

    kind: RemedyKind
    subjects: tuple[str, ...]
    limit: float
    found: int = 0
    skipped: str = ""


@dataclass(frozen=True)
class Remedies:
    """All remedies of one fastener, the cheapest for a shop first, and what was tried for them, by kind."""

    fastener: str
    found: tuple[Remedy, ...]
    tried: tuple[Tried, ...]
